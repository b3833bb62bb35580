/// Which cells of this process touch which other process's.
#include <algorithm>
#include <functional>
#include <limits>
#include <optional>

#include "commit/committed_mesh.h"
#include "commit/halo/cells_near.h"
#include "commit/halo/halo.h"
#include "commit/halo/own_cells.h"
#include "query/batch/candidates.h"
#include "query/point_query.h"
#include "query/walk/longitudes.h"

namespace insitu::commit {

using math::Vec3d;
using parallel::ByteReader;
using parallel::ByteWriter;

namespace {

/// A box of floats in the mesh's coordinates, which holds that of a cell.
accel::Box outwards(const mesh::Box& box) {
  accel::Box out;
  for (int a = 0; a < 3; ++a) {
    out.lower[a] = accel::round_down(box.low[a]);
    out.upper[a] = accel::round_up(box.high[a]);
  }
  return out;
}

mesh::Box widened(const accel::Box& box) {
  mesh::Box out;
  for (int a = 0; a < 3; ++a) {
    out.low[a] = double(box.lower[a]);
    out.high[a] = double(box.upper[a]);
  }
  return out;
}

/// visit(flat) of this process's cells whose leaves in the tree meet a box of the mesh's
/// coordinates, until it returns true; whether it did.
template <class Visit>
bool visit_cells(const mesh::MeshView& view, const accel::Tree& tree, const mesh::Box& box,
                 Visit&& visit) {
  if (tree.empty())
    return false;
  const accel::Box local = query::in_tree(box, tree.origin());
  const query::PointQuery query{view, tree, {}};
  for (const query::Candidate& c : query.candidates_in(local.lower, local.upper)) {
    const std::int64_t flat = tree.cells()[c.slot];
    if (flat < view.own_cell_count() && visit(flat))
      return true;
  }
  return false;
}

mesh::Box box_of_cell(const mesh::MeshView& view, std::int64_t flat) {
  mesh::CellVertices cell;
  mesh::gather(view, flat, cell);
  return mesh::box_of(cell);
}

/// A way over periodic sides, or by a turn over the seam of longitude: a cell touches another one's
/// if it does so moved by that. Its box is widened by a part of its size.
struct Shift {
  Vec3d by;
  double widening = 0.0;
  /// What is moved lies between, and so does where it comes to: cells of charts turned to poles lie
  /// further east (query::ChartImage).
  double west = -std::numeric_limits<double>::infinity(),
         east = std::numeric_limits<double>::infinity();

  /// Nothing of the box is moved where its low is behind its high.
  mesh::Box operator()(const mesh::Box& box) const {
    const Vec3d wider = widening * box.size();
    mesh::Box moved{box.low + by - wider, box.high + by + wider};
    moved.low.x = std::max(moved.low.x, west);
    moved.high.x = std::min({moved.high.x, east + by.x, east});
    return moved;
  }
};

bool is_nothing(const mesh::Box& box) {
  return box.low.x > box.high.x;
}

/// The size of the box of all processes' cells. Collective.
Vec3d size_of_all(const mesh::MeshView& view, parallel::World& world) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  mesh::Box box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  for (std::int64_t flat = 0; flat < view.own_cell_count(); ++flat) {
    const std::int32_t piece = view.piece_of(flat);
    if (view.pieces[piece].exists(flat - view.first_cell[piece]))
      box.extend(box_of_cell(view, flat));
  }
  double ends[] = {box.high.x, box.high.y, box.high.z, -box.low.x, -box.low.y, -box.low.z};
  world.reduce(std::span(ends), parallel::Reduction::greatest);
  return {ends[0] + ends[3], ends[1] + ends[4], ends[2] + ends[5]};
}

/// None, and those of a period along some of the axes; on a chart by a turn, too. Collective.
std::vector<Shift> shifts_over(const PeriodicAxes& sides, const mesh::MeshView& view,
                               const query::ChartImage* chart, parallel::World& world) {
  std::vector<Shift> shifts(1);
  const auto on_chart = [&](double by, double widening) {
    const double turn = chart->units.turn();
    shifts.push_back({{by, 0, 0}, widening, chart->west - 0.5 * turn, chart->west + 1.5 * turn});
  };
  if (chart)
    for (const double turns : {1.0, -1.0})
      on_chart(turns * chart->units.turn(), 0.0);
  if (std::ranges::none_of(sides, std::identity()))
    return shifts;
  std::int64_t charts = chart != nullptr;
  world.reduce(std::span(&charts, 1), parallel::Reduction::greatest);
  if (charts) { // sides along meridians
    const auto reach = query::longitudes_of(view, chart, core::Threads(1), world);
    if (chart && reach)
      for (const double turns : {0.0, 1.0, -1.0})
        for (const double sign : {1.0, -1.0})
          on_chart(sign * (reach->high - reach->low) + turns * chart->units.turn(), 0.25);
    return shifts;
  }
  const Vec3d period = size_of_all(view, world);
  const auto steps = [&](int axis) {
    return sides[std::size_t(axis)] && period[axis] > 0.0 ? std::vector<double>{0.0, 1.0, -1.0}
                                                          : std::vector<double>{0.0};
  };
  for (const double x : steps(0))
    for (const double y : steps(1))
      for (const double z : steps(2))
        if (x != 0.0 || y != 0.0 || z != 0.0)
          shifts.push_back({{x * period.x, y * period.y, z * period.z}, 0.25});
  return shifts;
}

/// Adds those of the boxes that are something when they are moved so.
void add_moved(std::span<const mesh::Box> boxes, const Shift& shift, std::vector<mesh::Box>& to) {
  for (const mesh::Box& of : boxes)
    if (const mesh::Box box = shift(of); !is_nothing(box))
      to.push_back(box);
}

/// Where cells are that, moved so, are near another process's.
Shift back(const Shift& shift) {
  Shift back = shift;
  back.by = -shift.by;
  back.widening = 1e-6 * (shift.widening > 0.0); // a period is rounded
  return back;
}

/// The cells of this process that, moved so, are near another one's, ascending.
std::vector<std::int64_t> near(const mesh::MeshView& view, const accel::Tree& tree,
                               std::span<const mesh::Box> boxes, const Shift& shift) {
  std::vector<mesh::Box> moved;
  add_moved(boxes, back(shift), moved);
  return cells_near(view, tree, moved);
}

/// The tree of this process's cells that may touch others', as these tell their boxes.
accel::Tree tree_near_others(const OwnCells& own, const query::Directory& directory, int rank,
                             std::span<const Shift> shifts, const core::Threads& threads) {
  std::vector<mesh::Box> boxes;
  for (int r = 0; r < directory.size(); ++r)
    for (const Shift& shift : shifts)
      if (r != rank) {
        add_moved(directory.boxes(r), back(shift), boxes);
        add_moved(directory.boxes(r), shift, boxes);
      }
  for (mesh::Box& box : boxes)
    box = widened(outwards(box));
  return own.tree_of_those_in(boxes, threads);
}

/// Whether a cell of this process touches the box.
bool touches(const mesh::MeshView& view, const accel::Tree& tree, const mesh::Box& box) {
  return visit_cells(view, tree, box,
                     [&](std::int64_t flat) { return mesh::meet(box_of_cell(view, flat), box); });
}

} // namespace

std::vector<std::int64_t> cells_near(const mesh::MeshView& view, const accel::Tree& tree,
                                     std::span<const mesh::Box> boxes) {
  std::vector<std::int64_t> cells;
  for (const mesh::Box& box : boxes)
    visit_cells(view, tree, box, [&](std::int64_t flat) {
      cells.push_back(flat);
      return false;
    });
  std::ranges::sort(cells);
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

/// First each process tells the boxes of its cells that lie near another's, in each of their
/// places; this one says by a bit each which it touches. Returns, of each process, the cells that
/// it touches here.
std::vector<std::vector<std::int64_t>> Halo::touching_cells(const CommittedMesh& mesh,
                                                            const PeriodicAxes& sides,
                                                            parallel::World& world,
                                                            const core::Threads& threads) {
  const mesh::MeshView& view = mesh.mesh().view();
  std::optional<OwnCells> own;
  std::vector<mesh::Box> boxes;
  const StandIn* const stand_in = mesh.stand_in();
  const query::ChartImage* const chart = stand_in ? stand_in->chart() : nullptr;
  const SeamReach reach{mesh.seam_tolerance, chart ? &chart->units : nullptr};
  world.agree_after([&] {
    own.emplace(view, *memory_, threads);
    boxes = own->boxes(reach);
  });
  directory_.gather(boxes, world);
  std::optional<accel::Tree> tree;
  const auto processes = std::size_t(world.size());
  std::vector<std::vector<std::int64_t>> cells(processes);
  std::vector<std::vector<std::uint8_t>> wanted(processes); // of each other process's boxes
  const std::vector<Shift> shifts = shifts_over(sides, view, chart, world);
  swap(
      world,
      [&](std::vector<ByteWriter>& to) {
        tree.emplace(tree_near_others(*own, directory_, world.rank(), shifts, threads));
        own.reset();
        for (int r = 0; r < world.size(); ++r)
          for (const Shift& shift : shifts) {
            if (r == world.rank() ||
                (&shift == shifts.data() && !directory_.may_touch(world.rank(), r)))
              continue;
            for (const std::int64_t flat : near(view, *tree, directory_.boxes(r), shift)) {
              const mesh::Box cell = box_of_cell(view, flat);
              const mesh::Box box = shift(reach.widened(cell, cell.size()));
              if (is_nothing(box))
                continue;
              cells[std::size_t(r)].push_back(flat);
              to[std::size_t(r)].value(outwards(box));
            }
          }
      },
      [&](int rank, ByteReader& from) {
        std::vector<std::uint8_t>& bits = wanted[std::size_t(rank)];
        while (!from.at_end())
          bits.push_back(touches(view, *tree, widened(from.value<accel::Box>())));
      });
  swap(
      world,
      [&](std::vector<ByteWriter>& to) {
        for (std::size_t r = 0; r < processes; ++r)
          for (std::size_t i = 0; i < wanted[r].size(); i += 8) {
            std::uint8_t byte = 0;
            for (std::size_t k = i; k < std::min(i + 8, wanted[r].size()); ++k)
              byte = std::uint8_t(byte | wanted[r][k] << (k - i));
            to[r].value(byte);
          }
      },
      [&](int rank, ByteReader& from) {
        std::vector<std::int64_t>& mine = cells[std::size_t(rank)];
        const std::vector<std::uint8_t> bits = from.array<std::uint8_t>((mine.size() + 7) / 8);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < mine.size(); ++i)
          if (bits[i / 8] >> (i % 8) & 1)
            mine[kept++] = mine[i];
        mine.resize(kept);
        for (std::int64_t& flat : mine)
          flat = stand_in && !stand_in->lends_parts() ? stand_in->place(flat).own : flat;
        std::ranges::sort(mine);
        mine.erase(std::unique(mine.begin(), mine.end()), mine.end());
      });
  return cells;
}

} // namespace insitu::commit
