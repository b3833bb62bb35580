#include <algorithm>
#include <cmath>

#include "query/lattice/dual_places.h"
#include "query/lattice/gridlet_query.h"
#include "query/ray_bundle/ray_bundle_scratch.h"

/// Gridlets, and uniform and rectilinear blocks, in a bundle.
namespace insitu::query {

using math::Vec3d;

/// Whether a sample's place along each axis tells its cell in the piece.
bool RayBundleLocator::has_places(const mesh::PieceView& piece) {
  return piece.layout == mesh::CellLayout::block && piece.implicit_points && piece.cell_count > 0;
}

/// A box about the wanted samples.
mesh::Box RayBundleLocator::box_of_samples() const {
  const BundleSlab& slab = s_.slab;
  mesh::Box box;
  for (int c = 0; c < 3; ++c) {
    double low = slab.middle[c], high = low, rounding = slab.rounding + 0x1p-48 * std::fabs(low);
    for (int a = 0; a < 3; ++a) {
      const double axis = slab.axes[a][c];
      const double lower = axis * double(slab.lower[a]), upper = axis * double(slab.upper[a]);
      low += std::min(lower, upper);
      high += std::max(lower, upper);
      rounding += 0x1p-20 * double(slab.reach);
    }
    box.low[c] = low - rounding;
    box.high[c] = high + rounding;
  }
  return box;
}

/// By their axes, without the tree; how many samples.
int RayBundleLocator::claim_in_blocks() {
  const mesh::MeshView& mesh = sampler_.mesh();
  const mesh::Box samples = box_of_samples();
  int count = 0;
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    LatticeCells cells{};
    std::int64_t lowest[3] = {0, 0, 0}; // vertex
    mesh::Box box;
    if (!has_places(mesh.pieces[p]) || !set_block(mesh.pieces[p], samples, cells, lowest, box))
      continue;
    cells.first_of_piece = mesh.first_cell[p];
    cells.first_cell += cells.first_of_piece;
    count += claim_in_lattice(box, cells, numbers_of(p, mesh.pieces[p].block_vertices, lowest));
  }
  return count;
}

/// The cells about the samples, from vertex `lowest` on, and their box; false if there are none, or
/// their places do not tell them.
bool RayBundleLocator::set_block(const mesh::PieceView& piece, const mesh::Box& samples,
                                 LatticeCells& cells, std::int64_t* lowest, mesh::Box& box) {
  for (int a = 0; a < 3; ++a) {
    box.low[a] = piece.block_coordinate(a, 0);
    box.high[a] = piece.block_coordinate(a, piece.block_vertices[a] - 1);
    if (!(box.low[a] <= samples.high[a] && samples.low[a] <= box.high[a]))
      return false;
  }
  cells.shape = piece.uniform_shape;
  cells.blanked = piece.may_not_exist() ? &piece : nullptr;
  std::int64_t next = 1;
  for (int a = 0; a < 3; ++a) {
    cells.next[a] = next;
    next *= piece.block_vertices[a] - 1;
    if (!(piece.axis[a] ? set_planes(piece, a, samples, lowest[a], cells)
                        : set_even_axis(piece, a, cells)))
      return false;
    cells.first_cell += lowest[a] * cells.next[a];
    if (!piece.axis[a])
      continue;
    box.low[a] = s_.planes[a].front();
    box.high[a] = s_.planes[a].back();
  }
  return true;
}

/// By places in the whole lattice, of which the block may be a part: a sample's coordinates, and
/// whether they are sure, do not hang on the part. False where the lattice's origin is so far from
/// zero that rounding shows in a cell, or coordinates descend; cells as far from the origin are
/// left out.
bool RayBundleLocator::set_even_axis(const mesh::PieceView& piece, int a, LatticeCells& cells) {
  constexpr double least = 0x1p-31, farthest = 0x1p18; // in cells; the least is 2^-49 of the other
  const double step = piece.spacing[a], begin = double(piece.block_first[a]);
  cells.start[a] = piece.origin[a];
  cells.steps_a_unit[a] = 1.0 / step;
  cells.begin[a] = begin;
  cells.least[a] = least;
  cells.most[a] = std::min(begin + double(piece.block_vertices[a] - 1), farthest) - least;
  return step > 0.0 && std::fabs(piece.origin[a]) < farthest * step && begin > -farthest;
}

/// The faces about the samples, from vertex `lowest` on. False if they are too many or do not
/// ascend.
bool RayBundleLocator::set_planes(const mesh::PieceView& piece, int a, const mesh::Box& samples,
                                  std::int64_t& lowest, LatticeCells& cells) {
  constexpr std::int64_t most = 4096;
  const auto plane = [&](std::int64_t i) {
    return mesh::load_real(piece.axis[a] + i * piece.axis_stride[a], piece.axis_is_float32);
  };
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
  lowest = std::clamp<std::int64_t>(planes_below(samples.low[a]) - 1, 0, last - 1);
  const std::int64_t highest =
      std::clamp<std::int64_t>(planes_below(samples.high[a]), lowest + 1, last);
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
    mesh::Box within;
    std::int64_t vertices[3];
    for (int a = 0; a < 3; ++a) {
      cells.start[a] = box.start[a];
      cells.steps_a_unit[a] = box.steps_a_unit[a];
      cells.begin[a] = 0.0;
      cells.least[a] = box.least[a];
      cells.most[a] = box.most[a];
      cells.next[a] = std::int64_t(1) << (3 * a);
      within.low[a] = box.start[a];
      within.high[a] = all.coordinate(g, a, g.size[a]);
      vertices[a] = g.size[a] + 1;
    }
    cells.first_cell = cells.first_of_piece = box.first_cell;
    cells.shape = mesh::Shape::voxel;
    cells.full = box.all_full ? nullptr : box.full;
    LatticeNumbers numbers = numbers_of(0, vertices, nullptr);
    if (numbers.first)
      numbers.first += std::int64_t(g.first) * numbers.next[0];
    count += claim_in_lattice(within, cells, numbers);
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
  if (out.next[1] < 0 || out.next[2] < 0)
    return {};
  const bool aligned = reinterpret_cast<std::uintptr_t>(first) % std::size_t(size) == 0 &&
                       out.next[1] % size == 0 && out.next[2] % size == 0;
  if (!aligned)
    return {};
  out.first = first;
  out.is_float32 = at.is_float32;
  return out;
}

/// box: what the cells fill.
int RayBundleLocator::claim_in_lattice(const mesh::Box& box, LatticeCells& cells,
                                       const LatticeNumbers& numbers) {
  const BundleSlab& slab = s_.slab;
  const Vec3d middle = 0.5 * (box.low + box.high) - slab.middle, half = 0.5 * (box.high - box.low);
  for (int a = 0; a < 3; ++a) {
    const Vec3d& axis = slab.axes[a];
    const double at = dot(axis, middle), reach = std::fabs(axis.x) * half.x +
                                                 std::fabs(axis.y) * half.y +
                                                 std::fabs(axis.z) * half.z;
    const double rounding =
        2.0 * slab.rounding + 0x1p-20 * (double(slab.reach) + std::fabs(at) + reach);
    const double slack =
        1e-3 * half[a] + 0x1p-45 * (std::fabs(box.low[a]) + std::fabs(box.high[a]));
    cells.low[a] = box.low[a] - slack;
    cells.high[a] = box.high[a] + slack;
    cells.lower[a][0] = float(at - reach - rounding);
    cells.upper[a][0] = float(at + reach + rounding);
  }
  return claim_lattice(cells, numbers, s_.slab, claims(),
                       [&](std::span<const std::uint16_t> places, std::span<const Location> at) {
                         answer(places, at);
                       });
}

} // namespace insitu::query
