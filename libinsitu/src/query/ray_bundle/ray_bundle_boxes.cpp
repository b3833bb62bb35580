#include <algorithm>
#include <cmath>

#include "query/lattice/gridlet_query.h"
#include "query/ray_bundle/ray_bundle_scratch.h"

/// Gridlets, and uniform and rectilinear blocks, in a bundle.
namespace insitu::query {

using math::Vec3d;

/// By their axes, without the tree; how many samples.
int RayBundleLocator::claim_in_blocks() {
  const mesh::MeshView& mesh = sampler_.mesh();
  int count = 0;
  for (std::int32_t p = 0; p < mesh.piece_count && has_blocks_; ++p) {
    const mesh::PieceView& piece = mesh.pieces[p];
    if (piece.layout != mesh::CellLayout::block || !piece.implicit_points || piece.cell_count == 0)
      continue;
    LatticeCells cells{};
    std::int64_t lowest[3] = {0, 0, 0}; // vertex
    Vec3d low, high;
    cells.first_of_piece = mesh.first_cell[p];
    cells.first_cell = cells.first_of_piece;
    cells.shape = piece.uniform_shape;
    cells.blanked = piece.may_not_exist() ? &piece : nullptr;
    std::int64_t next = 1;
    bool usable = true;
    for (int a = 0; a < 3 && usable; ++a) {
      cells.next[a] = next;
      next *= piece.block_vertices[a] - 1;
      usable =
          piece.axis[a] ? set_planes(piece, a, lowest[a], cells) : set_even_axis(piece, a, cells);
      cells.first_cell += lowest[a] * cells.next[a];
      low[a] = piece.axis[a] ? cells.planes[a][0] : cells.start[a];
      high[a] = piece.axis[a]
                    ? cells.planes[a][cells.plane_count[a] - 1]
                    : cells.start[a] + (double(piece.block_vertices[a]) - 1) * piece.spacing[a];
    }
    if (usable)
      count += claim_in_lattice(low, high, cells, numbers_of(p, piece.block_vertices, lowest));
  }
  return count;
}

/// False where coordinates are so far from zero that their rounding shows in a cell, or descend.
bool RayBundleLocator::set_even_axis(const mesh::PieceView& piece, int a, LatticeCells& cells) {
  const double start = piece.origin[a], step = piece.spacing[a];
  const double count = double(piece.block_vertices[a]) - 1.0;
  const double end = start + count * step, per_unit = 1.0 / step;
  const double farthest = std::max(std::fabs(start), std::fabs(end) + std::fabs(end - start));
  const double rounding = 0x1p-49 * (farthest * per_unit + 16.0); // some units in the last place
  cells.start[a] = start;
  cells.steps_a_unit[a] = per_unit;
  cells.least[a] = rounding;
  cells.most[a] = count - rounding;
  return step > 0.0 && rounding < 1e-10;
}

/// The faces about the stretch, from vertex `lowest` on. False if they are too many or do not
/// ascend.
bool RayBundleLocator::set_planes(const mesh::PieceView& piece, int a, std::int64_t& lowest,
                                  LatticeCells& cells) {
  constexpr std::int64_t most = 4096;
  const auto plane = [&](std::int64_t i) {
    return mesh::load_real(piece.axis[a] + i * piece.axis_stride[a], piece.axis_is_float32);
  };
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (int r = 0; r < rays_; ++r)
    for (const int k : {0, depth_ - 1}) {
      const double x = point(place_of(k, s_.slot[r]))[a];
      low = std::min(low, x);
      high = std::max(high, x);
    }
  const auto planes_below = [&](double x) {
    std::int64_t from = 0, to = piece.block_vertices[a];
    while (from < to) {
      const std::int64_t middle = (from + to) / 2;
      if (plane(middle) < x)
        from = middle + 1;
      else
        to = middle;
    }
    return from;
  };
  const std::int64_t last = piece.block_vertices[a] - 1;
  lowest = std::clamp<std::int64_t>(planes_below(low) - 1, 0, last - 1);
  const std::int64_t highest = std::clamp<std::int64_t>(planes_below(high), lowest + 1, last);
  if (highest - lowest >= most)
    return false;
  std::vector<double>& planes = s_.planes[a];
  planes.clear();
  for (std::int64_t i = lowest; i <= highest; ++i)
    planes.push_back(plane(i));
  cells.planes[a] = planes.data();
  cells.plane_count[a] = std::int64_t(planes.size());
  for (std::size_t i = 1; i < planes.size(); ++i)
    if (!(planes[i - 1] < planes[i]))
      return false;
  return true;
}

/// Those among the stretch's cells, which then are left out of these; how many samples.
int RayBundleLocator::claim_in_gridlets(std::size_t& found) {
  const mesh::MeshView& mesh = sampler_.mesh();
  const DualPlaces* const dual = sampler_.locator().dual();
  if (!dual)
    return 0;
  const std::int64_t first_single = mesh.first_single_cell();
  const mesh::GridletsView& all = dual->gridlets->gridlets();
  int count = 0;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < found; ++i) {
    const std::int64_t flat = sampler_.tree().cells()[s_.found[i]];
    if (flat >= first_single) {
      s_.found[kept++] = s_.found[i];
      continue;
    }
    const std::int64_t gridlet = flat >> mesh::Gridlet::cell_bits;
    const mesh::Gridlet& g = all.gridlets[gridlet];
    const GridletBox box = box_of(*dual->gridlets, gridlet);
    LatticeCells cells{};
    Vec3d low, high;
    std::int64_t vertices[3];
    for (int a = 0; a < 3; ++a) {
      cells.start[a] = box.start[a];
      cells.steps_a_unit[a] = box.steps_a_unit[a];
      cells.least[a] = box.least[a];
      cells.most[a] = box.most[a];
      cells.next[a] = std::int64_t(1) << (3 * a);
      low[a] = box.start[a];
      high[a] = all.coordinate(g, a, g.size[a]);
      vertices[a] = g.size[a] + 1;
    }
    cells.first_cell = cells.first_of_piece = box.first_cell;
    cells.shape = mesh::Shape::voxel;
    cells.full = box.all_full ? nullptr : box.full;
    LatticeNumbers numbers = numbers_of(0, vertices, nullptr);
    if (numbers.first)
      numbers.first += std::int64_t(g.first) * numbers.next[0];
    count += claim_in_lattice(low, high, cells, numbers);
  }
  found = kept;
  return count;
}

/// Of a lattice of so many vertices along each axis, from vertex `lowest` on; lowest: null for one
/// whose vertices are among others', one after the other.
LatticeNumbers RayBundleLocator::numbers_of(std::int32_t piece, const std::int64_t* vertices,
                                            const std::int64_t* lowest) const {
  LatticeNumbers out;
  if (!from_ || from_->is_per_cell())
    return out;
  const CellValues::AtVertices at = from_->at_vertices(piece);
  const std::int64_t size = at.is_float32 ? sizeof(float) : sizeof(double);
  if (!at.first || at.layout.stride[0] != size)
    return out;
  if (at.layout.linear) {
    out.next[1] = size * vertices[0];
    out.next[2] = out.next[1] * vertices[1];
  } else if (lowest && at.layout.extent[0] == vertices[0] && at.layout.extent[1] == vertices[1]) {
    out.next[1] = at.layout.stride[1];
    out.next[2] = at.layout.stride[2];
  } else {
    return out;
  }
  out.next[0] = size;
  const std::byte* first = at.first;
  for (int a = 0; a < 3 && lowest; ++a)
    first += lowest[a] * out.next[a];
  const bool aligned = reinterpret_cast<std::uintptr_t>(first) % std::size_t(size) == 0 &&
                       out.next[1] % size == 0 && out.next[2] % size == 0;
  if (!aligned)
    return {};
  out.first = first;
  out.is_float32 = at.is_float32;
  return out;
}

/// low, high: the box that the cells fill.
int RayBundleLocator::claim_in_lattice(const Vec3d& low, const Vec3d& high, LatticeCells& cells,
                                       const LatticeNumbers& numbers) {
  const BundleSlab& slab = s_.slab;
  const Vec3d middle = 0.5 * (low + high) - slab.middle, half = 0.5 * (high - low);
  for (int a = 0; a < 3; ++a) {
    const Vec3d& axis = slab.axes[a];
    const double at = dot(axis, middle), reach = std::fabs(axis.x) * half.x +
                                                 std::fabs(axis.y) * half.y +
                                                 std::fabs(axis.z) * half.z;
    const double rounding =
        2.0 * slab.rounding + 0x1p-20 * (double(slab.reach) + std::fabs(at) + reach);
    const double slack = 1e-3 * half[a] + 0x1p-45 * (std::fabs(low[a]) + std::fabs(high[a]));
    cells.low[a] = low[a] - slack;
    cells.high[a] = high[a] + slack;
    cells.lower[a][0] = float(at - reach - rounding);
    cells.upper[a][0] = float(at + reach + rounding);
  }
  return claim_lattice(cells, numbers, s_.slab, claims(),
                       [&](std::span<const std::uint16_t> places, std::span<const Location> at) {
                         answer(places, at);
                       });
}

} // namespace insitu::query
