#include "scene/probes/probe_answers.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "commit/halo/everywhere.h"
#include "mesh/box.h"
#include "scene/run/growing_table.h"

namespace insitu::scene {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The answers of this process to some points, of which the first has this number.
struct Slice {
  std::size_t first;
  std::span<const math::Vec3d> points;
  std::size_t width; ///< of a row of values
  std::vector<OwnCell> cells;
  std::vector<math::Vec3d> parametric;
  std::vector<double> values;
};

/// What the root is told of a point, before its values.
struct Told {
  std::int64_t point;
  OwnCell cell;
  math::Vec3d parametric, x;
};

/// The numbers of the points that a process of several may own; a mesh in longitude and latitude
/// has a tree in coordinates of its own.
std::vector<std::size_t> near(const commit::CommittedMesh& mesh,
                              std::span<const math::Vec3d> points) {
  std::vector<std::size_t> some;
  const bool all = mesh.reference_frame.kind == INSITU_FRAME_GEODETIC || mesh.tree().empty();
  const mesh::Box box =
      all ? mesh::Box{} : mesh::Box{mesh.tree().bounds_min(), mesh.tree().bounds_max()};
  for (std::size_t i = 0; i < points.size(); ++i)
    if (all || box.holds(points[i]))
      some.push_back(i);
  return some;
}

void answer(const ProbeQuestion& q, Slice& slice, const parallel::World& world,
            const core::Threads& threads) {
  const std::size_t n = slice.points.size();
  slice.cells.assign(n, {});
  slice.parametric.assign(n, {});
  slice.values.assign(n * slice.width, nan);
  if (world.size() > 1 && q.mesh.mesh().own_view().own_cell_count() == 0)
    return;
  // A halo, where there is one, need not be of this step; its cells are others' to answer.
  const query::Sampler sampler = q.mesh.own_sampler();
  const auto put = [&](std::size_t i, const query::Location& at) {
    if (!at || (world.size() > 1 && !sampler.owns(at.cell)))
      return;
    double* const values = slice.values.data() + i * slice.width;
    sampler.interpolate(q.fields, at, values);
    if (q.farthest)
      values[slice.width - 1] = 0.0;
    const query::Location own = q.mesh.own(at, slice.points[i]);
    slice.cells[i] = own_cell(q.mesh, at.cell, slice.points[i], world);
    if (q.mesh.stand_in())
      slice.cells[i].chart = q.mesh.stand_in()->place(at.cell).chart;
    slice.parametric[i] = own.parametric;
  };
  if (q.attached) { // their places are known, to the bit
    for (std::size_t i = 0; i < n; ++i)
      put(i, q.attached->place(slice.first + i));
    return;
  }
  if (world.size() == 1) {
    sampler.visit(threads, slice.points, q.options, [&](const query::Answered& answered) {
      for (std::size_t k = 0; k < answered.locations.size(); ++k)
        put(answered.item(k), answered.locations[k]);
    });
    return;
  }
  const std::vector<std::size_t> some = near(q.mesh, slice.points);
  std::vector<math::Vec3d> points;
  for (const std::size_t i : some)
    points.push_back(slice.points[i]);
  sampler.visit(threads, points, q.options, [&](const query::Answered& answered) {
    for (std::size_t k = 0; k < answered.locations.size(); ++k)
      put(some[answered.item(k)], answered.locations[k]);
  });
}

/// The rows of what was found.
std::vector<parallel::Parcel> pack(const Slice& slice) {
  const std::size_t row = sizeof(Told) + slice.width * sizeof(double);
  std::size_t found = 0;
  for (const OwnCell& cell : slice.cells)
    found += cell.flat >= 0;
  if (found == 0)
    return {};
  std::vector<parallel::Parcel> parcels{{0, std::vector<std::byte>(found * row)}};
  std::byte* to = parcels[0].bytes.data();
  for (std::size_t i = 0; i < slice.cells.size(); ++i) {
    if (slice.cells[i].flat < 0)
      continue;
    const Told told{std::int64_t(slice.first + i), slice.cells[i], slice.parametric[i],
                    slice.points[i]};
    std::memcpy(to, &told, sizeof told);
    if (slice.width > 0)
      std::memcpy(to + sizeof told, slice.values.data() + i * slice.width,
                  slice.width * sizeof(double));
    to += row;
  }
  return parcels;
}

/// Whether a cell owns a point before another one, of a lower process.
bool is_before(const OwnCell& a, const OwnCell& b, bool by_ids) {
  return a.chart != b.chart ? a.chart < b.chart : by_ids && a.global < b.global;
}

/// Keeps of each point the answer of the lowest cell; parcels come in the order of processes.
void merge(const std::vector<parallel::Parcel>& parcels, std::size_t width, bool by_ids,
           ProbeAnswers& all, std::vector<math::Vec3d>& points) {
  const std::size_t row = sizeof(Told) + width * sizeof(double);
  for (const parallel::Parcel& parcel : parcels)
    for (const std::byte *at = parcel.bytes.data(), *end = at + parcel.bytes.size(); at != end;
         at += row) {
      Told told;
      std::memcpy(&told, at, sizeof told);
      const auto i = std::size_t(told.point);
      if (all.found(i) && !is_before(told.cell, all.cells[i], by_ids))
        continue;
      all.cells[i] = told.cell;
      all.parametric[i] = told.parametric;
      points[i] = told.x;
      if (width > 0)
        std::memcpy(all.values.data() + i * width, at + sizeof told, width * sizeof(double));
    }
}

/// Gives points that no process's cells hold, as the root knows, the nearest cell.
void add_nearest(const ProbeQuestion& question, std::span<const math::Vec3d> points,
                 parallel::World& world, const core::Threads& threads, ProbeAnswers& all) {
  std::vector<std::size_t> outside;
  std::vector<math::Vec3d> places;
  std::vector<std::string> names;
  world.agree_after([&] {
    for (const mesh::FieldView& field : question.fields)
      names.emplace_back(field.name);
    for (std::size_t i = 0; world.is_root() && i < points.size(); ++i)
      if (!all.found(i)) {
        outside.push_back(i);
        places.push_back(points[i]);
      }
  });
  std::int64_t any = !outside.empty();
  world.reduce(std::span(&any, 1), parallel::Reduction::greatest);
  if (!any)
    return;
  const std::size_t width = all.columns.size();
  const auto put = [&](std::size_t first, std::span<const commit::OwnerOfAll> owners,
                       std::span<const commit::NearnessOfAll> nearness,
                       std::span<const double> values) {
    for (std::size_t k = 0; k < owners.size(); ++k) {
      if (!owners[k])
        continue;
      const std::size_t i = outside[first + k];
      const mesh::CellName& cell = owners[k].cell;
      // Files of several processes name the process and its piece, or there is one piece.
      const std::int64_t flat =
          cell.cell +
          (world.size() > 1 ? 0 : question.mesh.mesh().own_view().first_cell[cell.piece]);
      all.cells[i] = {cell.piece, cell.cell, flat, cell.global, cell.rank, cell.chart};
      all.parametric[i] = owners[k].parametric;
      double* const to = all.values.data() + i * width;
      std::copy_n(values.begin() + std::ptrdiff_t(k * (width - 1)), width - 1, to);
      to[width - 1] = std::sqrt(nearness[k].squared);
    }
  };
  commit::Everywhere(question.mesh, world).nearest(places, names, *question.farthest, threads, put);
}

} // namespace

ProbeAnswers answer_points(const ProbeQuestion& question, std::vector<math::Vec3d>& points,
                           parallel::World& world, const core::Threads& threads,
                           std::size_t slice) {
  const std::size_t n = points.size();
  std::size_t width = 0;
  ProbeAnswers all;
  world.agree_after([&] {
    for (const mesh::FieldView& f : question.fields)
      for (std::string& column : component_names(f))
        all.columns.push_back(std::move(column));
    if (question.farthest)
      all.columns.emplace_back("distance_to_cell");
    width = all.columns.size();
    if (world.size() == 1) {
      Slice whole{0, points, width, {}, {}, {}};
      answer(question, whole, world, threads);
      all.cells = std::move(whole.cells);
      all.parametric = std::move(whole.parametric);
      all.values = std::move(whole.values);
    } else if (world.is_root()) {
      all.cells.assign(n, {});
      all.parametric.assign(n, {});
      all.values.assign(n * width, nan);
    }
  });
  for (std::size_t first = 0; world.size() > 1 && first < n; first += slice) {
    std::vector<parallel::Parcel> mine;
    world.agree_after([&] {
      const std::size_t count = std::min(slice, n - first);
      Slice some{first, std::span(points).subspan(first, count), width, {}, {}, {}};
      answer(question, some, world, threads);
      mine = pack(some);
    });
    const std::vector<parallel::Parcel> told = world.exchange(mine);
    merge(told, width, question.by_ids, all, points);
  }
  if (question.farthest)
    add_nearest(question, points, world, threads, all);
  return all;
}

} // namespace insitu::scene
