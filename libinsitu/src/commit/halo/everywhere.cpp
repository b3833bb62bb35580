#include "commit/halo/everywhere.h"

#include <algorithm>
#include <limits>

#include "commit/committed_mesh.h"

namespace insitu::commit {

using math::Vec3d;
using parallel::ByteReader;
using parallel::ByteWriter;
using parallel::Parcel;
using parallel::Reduction;

namespace {

/// So many points of a process are asked at a time.
constexpr std::size_t slice = std::size_t(1) << 20;

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

void Everywhere::sample(std::span<const Vec3d> points, std::span<const std::string> fields,
                        const query::LocateOptions& options, const core::Threads& threads,
                        Put put) {
  std::size_t width = 0;
  for (const int components : this->components(fields))
    width += std::size_t(components);
  auto rounds = std::int64_t((points.size() + slice - 1) / slice);
  world_.reduce(std::span(&rounds, 1), Reduction::greatest);
  for (std::size_t first = 0; rounds-- > 0; first += slice) {
    const std::size_t begin = std::min(first, points.size());
    sample_slice(begin, points.subspan(begin, std::min(slice, points.size() - begin)), fields,
                 width, options, threads, put);
  }
}

/// Of the points that one process asks: for each a byte that says whether it is here, then the
/// owners and values of those that are.
std::vector<std::byte> Everywhere::answer(std::span<const std::byte> question,
                                          std::span<const std::string> names,
                                          const query::LocateOptions& options,
                                          const core::Threads& threads) {
  ByteReader from(question);
  const std::vector<Vec3d> points = from.array<Vec3d>(question.size() / sizeof(Vec3d));
  std::vector<query::Location> at(points.size());
  std::vector<std::uint8_t> reasons(points.size());
  const query::Sampler sampler = mesh_.own_sampler();
  sampler.locate(threads, points, at, options, reasons);
  std::vector<mesh::FieldView> fields;
  std::size_t width = 0;
  if (mesh_.mesh().own_view().own_cell_count() > 0)
    for (const std::string& name : names) {
      fields.push_back(mesh_.mesh().field(name));
      width += std::size_t(fields.back().components);
    }
  ByteWriter to;
  const auto is_here = [&](std::size_t i) { return at[i] && sampler.mesh().is_own(at[i].cell); };
  for (std::size_t i = 0; i < points.size(); ++i)
    to.value(std::uint8_t(is_here(i)));
  std::vector<double> values(width);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_here(i))
      continue;
    sampler.interpolate(fields, at[i], values.data());
    const query::Location as_own = mesh_.own(at[i], points[i]);
    CellName name = mesh_.name(as_own.cell);
    if (as_own.cell < mesh_.mesh().own_view().own_cell_count())
      name.rank = world_.rank();
    if (const StandIn* const stand_in = mesh_.stand_in())
      name.chart = stand_in->place(at[i].cell).chart;
    to.value(OwnerOfAll{name, as_own.parametric, query::Reason(reasons[i])});
    to.array(std::span<const double>(values));
  }
  return to.bytes();
}

void Everywhere::sample_slice(std::size_t first, std::span<const Vec3d> points,
                              std::span<const std::string> fields, std::size_t width,
                              const query::LocateOptions& options, const core::Threads& threads,
                              Put put) {
  const auto processes = std::size_t(world_.size());
  std::vector<std::vector<std::uint32_t>> asked(processes);
  std::vector<Parcel> questions, answers;
  const query::ChartImage* const chart = mesh_.stand_in() ? mesh_.stand_in()->chart() : nullptr;
  world_.agree_after([&] {
    for (std::size_t r = 0; r < processes; ++r) {
      ByteWriter to;
      for (std::size_t i = 0; i < points.size(); ++i)
        if (directory_.may_hold(int(r), chart ? (*chart)(points[i]) : points[i])) {
          asked[r].push_back(std::uint32_t(i));
          to.value(points[i]);
        }
      if (!to.empty())
        questions.push_back({int(r), to.bytes()});
    }
  });
  questions = world_.exchange(questions);
  world_.agree_after([&] {
    for (const Parcel& question : questions)
      answers.push_back({question.rank, answer(question.bytes, fields, options, threads)});
    questions.clear();
  });
  answers = world_.exchange(answers);
  world_.agree_after([&] {
    std::vector<OwnerOfAll> owners(points.size());
    std::vector<double> values(points.size() * width, std::numeric_limits<double>::quiet_NaN());
    std::vector<double> one(width);
    for (const Parcel& from : answers) {
      const std::vector<std::uint32_t>& items = asked[std::size_t(from.rank)];
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

} // namespace insitu::commit
