#include "commit/halo/everywhere.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "commit/committed_mesh.h"
#include "commit/nearest.h"
#include "parallel/parcels.h"

namespace insitu::commit {

using math::Vec3d;
using parallel::ByteReader;
using parallel::ByteWriter;
using parallel::Parcel;
using parallel::Reduction;

namespace {

/// So many points of a process are asked at a time.
constexpr std::size_t slice_size = std::size_t(1) << 20;

std::size_t width_of(std::span<const mesh::FieldView> fields) {
  std::size_t width = 0;
  for (const mesh::FieldView& field : fields)
    width += std::size_t(field.components);
  return width;
}

/// A cell of the mesh's view as all processes know it; own: the same as the solver counts cells.
OwnerOfAll owner_of(const CommittedMesh& mesh, std::int64_t cell, const query::Location& own,
                    query::Reason reason, int rank) {
  CellName name = mesh.name(own.cell);
  if (own.cell < mesh.mesh().own_view().own_cell_count())
    name.rank = rank;
  if (const StandIn* const stand_in = mesh.stand_in())
    name.chart = stand_in->place(cell).chart;
  return {name, own.parametric, reason};
}

} // namespace

Everywhere::Everywhere(const CommittedMesh& mesh, parallel::World& world)
    : mesh_(mesh), world_(world) {
  std::vector<mesh::Box> boxes;
  world.agree_after([&] {
    mesh.require_committed();
    if (mesh.lies_on_device())
      throw core::Error(INSITU_ERROR_UNSUPPORTED,
                        "mesh '" + mesh.mesh().name() +
                            "' lies in device memory; other processes' points are answered on the "
                            "host");
    (void)mesh.tree(); // fitted before its boxes are told
    boxes = query::boxes_of(mesh.standing_tree());
  });
  directory_.gather(boxes, world);
}

std::vector<int> Everywhere::components(std::span<const std::string> fields) {
  std::vector<std::int64_t> most(fields.size());
  world_.agree_after([&] {
    for (std::size_t f = 0; f < fields.size(); ++f)
      if (mesh_.mesh().has_field(fields[f]) || mesh_.mesh().own_view().own_cell_count() > 0)
        most[f] = mesh_.mesh().field(fields[f]).components; // throws where there is none
  });
  world_.reduce(std::span(most), Reduction::greatest);
  world_.agree_after([&] {
    for (std::size_t f = 0; f < fields.size(); ++f)
      if (most[f] == 0)
        throw core::Error(INSITU_ERROR_FIELD, "mesh '" + mesh_.mesh().name() + "' has no field '" +
                                                  fields[f] + "' on any process");
  });
  return {most.begin(), most.end()};
}

/// Calls `slice` as often on all processes.
void Everywhere::for_each_slice(std::span<const Vec3d> points, Slice slice) {
  auto rounds = std::int64_t((points.size() + slice_size - 1) / slice_size);
  world_.reduce(std::span(&rounds, 1), Reduction::greatest);
  for (std::size_t first = 0; rounds-- > 0; first += slice_size) {
    const std::size_t begin = std::min(first, points.size());
    slice(begin, points.subspan(begin, std::min(slice_size, points.size() - begin)));
  }
}

void Everywhere::sample(std::span<const Vec3d> points, std::span<const std::string> fields,
                        const query::LocateOptions& options, const core::Threads& threads,
                        Put put) {
  std::size_t width = 0;
  for (const int components : this->components(fields))
    width += std::size_t(components);
  for_each_slice(points, [&](std::size_t first, std::span<const Vec3d> some) {
    sample_slice(first, some, fields, width, options, threads, put);
  });
}

/// Sends each point to the processes that are asked, and gives what they answered.
Everywhere::Answers Everywhere::ask(std::span<const Vec3d> points, RanksOf ranks_of,
                                    Answer answer) {
  const auto processes = std::size_t(world_.size());
  Answers all;
  std::vector<Parcel> questions;
  world_.agree_after([&] {
    all.items.resize(processes);
    std::vector<std::vector<Vec3d>> to(processes);
    std::vector<int> ranks;
    for (std::size_t i = 0; i < points.size(); ++i) {
      ranks.clear();
      ranks_of(points[i], ranks);
      for (const int r : ranks) {
        all.items[std::size_t(r)].push_back(std::uint32_t(i));
        to[std::size_t(r)].push_back(points[i]);
      }
    }
    questions = parallel::parcels_of(to);
  });
  questions = world_.exchange(questions);
  world_.agree_after([&] {
    for (const Parcel& question : questions)
      all.parcels.push_back({question.rank, answer(parallel::items_of<Vec3d>(question.bytes))});
    questions.clear();
  });
  all.parcels = world_.exchange(all.parcels);
  return all;
}

/// Of a process that has cells.
std::vector<mesh::FieldView> Everywhere::fields_here(std::span<const std::string> names) const {
  std::vector<mesh::FieldView> fields;
  if (mesh_.mesh().own_view().own_cell_count() > 0)
    for (const std::string& name : names)
      fields.push_back(mesh_.mesh().field(name));
  return fields;
}

/// For each point a byte that says whether it is here, then the owners and values of those that
/// are.
std::vector<std::byte> Everywhere::answer(std::span<const Vec3d> points,
                                          std::span<const std::string> names,
                                          const query::LocateOptions& options,
                                          const core::Threads& threads) {
  const query::Sampler sampler = mesh_.own_sampler();
  const std::vector<mesh::FieldView> fields = fields_here(names);
  std::vector<OwnerOfAll> owners(points.size());
  std::vector<std::vector<double>> values; // [field]
  std::vector<double*> to;
  for (const mesh::FieldView& field : fields) {
    values.emplace_back(points.size() * std::size_t(field.components));
    to.push_back(values.back().data());
  }
  sampler.visit(threads, points, options, [&](const query::Answered& answered) {
    for (std::size_t k = 0; k < answered.locations.size(); ++k) {
      const query::Location& at = answered.locations[k];
      const std::size_t i = answered.item(k);
      if (at && sampler.mesh().is_own(at.cell))
        owners[i] =
            owner_of(mesh_, at.cell, mesh_.own(at, points[i]), answered.reasons[k], world_.rank());
    }
    if (!fields.empty())
      sampler.interpolate(fields, answered, 0, to.data());
  });
  ByteWriter out;
  for (const OwnerOfAll& owner : owners)
    out.value(std::uint8_t(bool(owner)));
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!owners[i])
      continue;
    out.value(owners[i]);
    for (std::size_t f = 0; f < fields.size(); ++f) {
      const auto n = std::size_t(fields[f].components);
      out.array(std::span<const double>(values[f]).subspan(i * n, n));
    }
  }
  return out.bytes();
}

void Everywhere::sample_slice(std::size_t first, std::span<const Vec3d> points,
                              std::span<const std::string> fields, std::size_t width,
                              const query::LocateOptions& options, const core::Threads& threads,
                              Put put) {
  const query::ChartImage* const chart = mesh_.stand_in() ? mesh_.stand_in()->chart() : nullptr;
  const Answers answers = ask(
      points,
      [&](const Vec3d& p, std::vector<int>& ranks) {
        const Vec3d image = chart ? (*chart)(p) : p;
        for (int r = 0; r < world_.size(); ++r)
          if (directory_.may_hold(r, image))
            ranks.push_back(r);
      },
      [&](std::span<const Vec3d> some) { return answer(some, fields, options, threads); });
  world_.agree_after([&] {
    std::vector<OwnerOfAll> owners(points.size());
    std::vector<double> values(points.size() * width, std::numeric_limits<double>::quiet_NaN());
    std::vector<double> one(width);
    for (const Parcel& from : answers.parcels) {
      const std::vector<std::uint32_t>& items = answers.items[std::size_t(from.rank)];
      ByteReader reader(from.bytes);
      const std::vector<std::uint8_t> here = reader.array<std::uint8_t>(items.size());
      for (std::size_t k = 0; k < items.size(); ++k) {
        if (!here[k])
          continue;
        const auto owner = reader.value<OwnerOfAll>();
        reader.array(std::span<double>(one));
        const std::size_t i = items[k];
        if (owners[i] && !(owner.cell < owners[i].cell))
          continue;
        owners[i] = owner;
        std::copy(one.begin(), one.end(), values.begin() + std::ptrdiff_t(i * width));
      }
    }
    if (!points.empty())
      put(first, owners, values);
  });
}

void Everywhere::nearest(std::span<const Vec3d> points, std::span<const std::string> fields,
                         double farthest, const core::Threads& threads, PutNearest put) {
  std::size_t width = 0;
  for (const int components : this->components(fields))
    width += std::size_t(components);
  for_each_slice(points, [&](std::size_t first, std::span<const Vec3d> some) {
    nearest_slice(first, some, fields, width, farthest, threads, put);
  });
}

/// Of each point whether a cell here is near enough, and then that cell, how near it is, values.
std::vector<std::byte> Everywhere::answer_nearest(std::span<const Vec3d> points,
                                                  std::span<const std::string> names,
                                                  double farthest, const core::Threads& threads) {
  const query::Sampler sampler = mesh_.own_sampler();
  std::vector<query::NearestCell> found(points.size());
  query::NearestCells(sampler).find(threads, points, farthest, found);
  const std::vector<mesh::FieldView> fields = fields_here(names);
  std::vector<double> values(width_of(fields));
  ByteWriter to;
  for (const query::NearestCell& near : found) {
    const NearestOwn own = own_of(mesh_, near);
    to.value(std::uint8_t(bool(own.at)));
    if (!own.at)
      continue;
    sampler.interpolate(fields, near.at, values.data());
    to.value(owner_of(mesh_, near.at.cell, own.at, query::Reason::outside, world_.rank()));
    to.value(NearnessOfAll{near.squared, own.place});
    to.array(std::span<const double>(values));
  }
  return to.bytes();
}

void Everywhere::nearest_slice(std::size_t first, std::span<const Vec3d> points,
                               std::span<const std::string> fields, std::size_t width,
                               double farthest, const core::Threads& threads, PutNearest put) {
  const query::ChartImage* const chart = mesh_.stand_in() ? mesh_.stand_in()->chart() : nullptr;
  const Answers answers = ask(
      points,
      [&](const Vec3d& p, std::vector<int>& ranks) {
        query::add_ranks_near(directory_, query::Images(p, chart), farthest, true, ranks);
      },
      [&](std::span<const Vec3d> some) { return answer_nearest(some, fields, farthest, threads); });
  world_.agree_after([&] {
    std::vector<OwnerOfAll> owners(points.size());
    std::vector<NearnessOfAll> nearness(points.size());
    std::vector<double> values(points.size() * width, std::numeric_limits<double>::quiet_NaN());
    std::vector<double> one(width);
    for (const Parcel& from : answers.parcels) {
      ByteReader reader(from.bytes);
      for (const std::uint32_t i : answers.items[std::size_t(from.rank)]) {
        if (!reader.value<std::uint8_t>())
          continue;
        const auto owner = reader.value<OwnerOfAll>();
        const auto how = reader.value<NearnessOfAll>();
        reader.array(std::span<double>(one));
        if (owners[i] &&
            std::tie(nearness[i].squared, owners[i].cell) <= std::tie(how.squared, owner.cell))
          continue;
        owners[i] = owner;
        nearness[i] = how;
        std::copy(one.begin(), one.end(), values.begin() + std::ptrdiff_t(i * width));
      }
    }
    if (!points.empty())
      put(first, owners, nearness, values);
  });
}

void Everywhere::nearest_vertices(std::span<const Vec3d> points, std::size_t most, double farthest,
                                  const core::Threads& threads, VisitVertices visit) {
  const query::ChartImage* const chart = mesh_.stand_in() ? mesh_.stand_in()->chart() : nullptr;
  const auto answer = [&](std::span<const Vec3d> places) {
    std::vector<std::vector<query::NearVertex>> found(places.size());
    commit::nearest_vertices(
        mesh_, places, most, farthest, world_.rank(), threads,
        [&](std::size_t i, const query::NearVertices& near) { found[i] = near.found(); });
    ByteWriter to;
    for (const std::vector<query::NearVertex>& some : found) {
      to.value(std::uint32_t(some.size()));
      to.array(std::span<const query::NearVertex>(some));
    }
    return to.bytes();
  };
  for_each_slice(points, [&](std::size_t first, std::span<const Vec3d> some) {
    const auto ranks_of = [&](const Vec3d& p, std::vector<int>& ranks) {
      query::add_ranks_near(directory_, query::Images(p, chart), farthest, most == 1, ranks);
    };
    const Answers answers = ask(some, ranks_of, answer);
    world_.agree_after([&] {
      std::vector<query::NearVertices> found(some.size(), {most, farthest});
      for (const Parcel& from : answers.parcels) {
        ByteReader reader(from.bytes);
        for (const std::uint32_t i : answers.items[std::size_t(from.rank)])
          for (const query::NearVertex& vertex :
               reader.array<query::NearVertex>(reader.value<std::uint32_t>()))
            found[i].take(vertex);
      }
      for (std::size_t i = 0; i < some.size(); ++i)
        visit(first + i, found[i].found());
    });
  });
}

} // namespace insitu::commit
