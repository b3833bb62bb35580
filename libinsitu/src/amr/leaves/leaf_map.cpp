#include "amr/leaves/leaf_map.h"

#include <atomic>
#include <cmath>

#include "amr/dual/fill.h"
#include "amr/leaves/collect_bricks.h"
#include "core/status.h"

namespace insitu::amr {

void LeafMap::build(const mesh::AmrView& mesh, const core::Threads& threads) {
  lattice_ = mesh.lattice;
  leaf_count_ = masked_count_ = 0;
  numbering_.clear();
  store_.create({}, threads);
  if (mesh.cell_count() > std::int64_t(BrickStore::most_leaves))
    throw core::Error(INSITU_ERROR_MESH,
                      "an adaptive mesh of " + std::to_string(mesh.cell_count()) +
                          " cells; at most " + std::to_string(BrickStore::most_leaves) +
                          " can be told apart");
  try {
    store_.create(collect_bricks(mesh, threads), threads);
    fill(store_, mesh, threads);
    masked_count_ = mark_refined(store_, mesh, threads);
  } catch (...) {
    store_.create({}, threads);
    throw;
  }
  leaf_count_ = mesh.cell_count() - masked_count_;
}

LeafMap::Leaf LeafMap::cover(int depth, const std::int64_t* index) const {
  Leaf leaf;
  int up = 0;
  std::uint32_t entry = at(depth, index);
  if (entry == nothing)
    entry = store_.above(depth, index, &up);
  if (!BrickStore::is_leaf(entry))
    return leaf;
  leaf.id = entry;
  leaf.cell.depth = depth - up;
  for (int a = 0; a < 3; ++a)
    leaf.cell.index[a] = index[a] >> up;
  return leaf;
}

/// The leaf that holds a cell of the finest depth.
LeafMap::Leaf LeafMap::descend(const std::int64_t* finest) const {
  Leaf leaf;
  for (int d = 0; d < depth_count(); ++d) {
    const int shift = depth_count() - 1 - d;
    const std::int64_t index[3] = {finest[0] >> shift, finest[1] >> shift, finest[2] >> shift};
    const std::uint32_t entry = at(d, index);
    if (entry == refined)
      continue;
    if (entry != nothing)
      leaf = {entry, {d, {index[0], index[1], index[2]}}};
    break;
  }
  return leaf;
}

/// The cell of the finest depth that holds a point, closed below and open above, and a bit an axis
/// along which it lies on the cell's lower face. False far outside and where it is not finite.
bool LeafMap::finest_index(const math::Vec3d& p, std::int64_t* index, int* on_face) const {
  if (depth_count() == 0)
    return false;
  const int finest = depth_count() - 1;
  *on_face = 0;
  for (int a = 0; a < 3; ++a) {
    const double t = (p[a] - lattice_.origin[a]) / lattice_.width(a, finest);
    if (!(std::abs(t) <= 2.0 * double(mesh::Lattice::largest_index)))
      return false;
    // The division rounds; faces are where the lattice says.
    std::int64_t i = std::int64_t(std::floor(t));
    while (p[a] < lattice_.place(a, finest, 2 * i))
      --i;
    while (p[a] >= lattice_.place(a, finest, 2 * i + 2))
      ++i;
    index[a] = i;
    *on_face |= p[a] == lattice_.place(a, finest, 2 * i) ? 1 << a : 0;
  }
  return true;
}

LeafMap::Leaf LeafMap::find(const math::Vec3d& p) const {
  std::int64_t index[3];
  int on_face;
  if (!finest_index(p, index, &on_face))
    return {};
  Leaf leaf = descend(index);
  for (int low = 1; !leaf && low < 8; ++low) {
    if ((low & ~on_face) != 0)
      continue;
    const std::int64_t below[3] = {index[0] - (low & 1), index[1] - (low >> 1 & 1),
                                   index[2] - (low >> 2)};
    leaf = descend(below);
  }
  return leaf;
}

LeafMap::Leaf
LeafMap::first(const math::Vec3d& p,
               core::FunctionRef<bool(std::uint32_t, std::uint32_t)> is_before) const {
  std::int64_t index[3];
  int on_face;
  if (!finest_index(p, index, &on_face))
    return {};
  Leaf leaf;
  for (int low = 0; low < 8; ++low) {
    if ((low & ~on_face) != 0)
      continue;
    const std::int64_t below[3] = {index[0] - (low & 1), index[1] - (low >> 1 & 1),
                                   index[2] - (low >> 2)};
    const Leaf other = descend(below);
    if (other && is_before(other.id, leaf.id)) // none has the highest id
      leaf = other;
  }
  return leaf;
}

} // namespace insitu::amr
