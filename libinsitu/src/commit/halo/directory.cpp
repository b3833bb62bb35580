#include "commit/halo/directory.h"

#include <algorithm>
#include <cmath>

#include "parallel/bytes.h"

namespace insitu::commit {

namespace {

/// A box of the tree's frame in the mesh's, with room for the rounding of the sums.
mesh::Box in_mesh(const accel::Box& box, const math::Vec3d& origin) {
  mesh::Box out;
  for (int a = 0; a < 3; ++a) {
    const double low = double(box.lower[a]), high = double(box.upper[a]);
    out.low[a] = origin[a] + low - (std::fabs(origin[a]) + std::fabs(low)) * 0x1p-51;
    out.high[a] = origin[a] + high + (std::fabs(origin[a]) + std::fabs(high)) * 0x1p-51;
  }
  return out;
}

/// The boxes of the two uppermost levels, 8 times 8.
std::vector<mesh::Box> boxes_of(const accel::Tree& tree) {
  std::vector<mesh::Box> boxes;
  if (tree.empty())
    return boxes;
  const accel::Node& root = tree.nodes()[0];
  for (int c = 0; c < 8; ++c) {
    if (!root.meta[c])
      continue;
    if (!root.is_inner(c)) {
      boxes.push_back(in_mesh(root.child_box(c), tree.origin()));
      continue;
    }
    const accel::Node& node = tree.nodes()[root.child_node(c)];
    for (int d = 0; d < 8; ++d)
      if (node.meta[d])
        boxes.push_back(in_mesh(node.child_box(d), tree.origin()));
  }
  return boxes;
}

} // namespace

void Directory::gather(const accel::Tree& tree, parallel::World& world) {
  std::vector<parallel::Parcel> parcels;
  world.agree_after([&] {
    boxes_.assign(std::size_t(world.size()), {});
    const std::vector<mesh::Box> own = boxes_of(tree);
    const std::span<const std::byte> bytes = std::as_bytes(std::span(own));
    for (int r = 0; r < world.size() && !own.empty(); ++r)
      parcels.push_back({r, {bytes.begin(), bytes.end()}});
  });
  const std::vector<parallel::Parcel> received = world.exchange(parcels);
  world.agree_after([&] {
    for (const parallel::Parcel& p : received)
      boxes_[std::size_t(p.rank)] =
          parallel::ByteReader(p.bytes).array<mesh::Box>(p.bytes.size() / sizeof(mesh::Box));
  });
}

bool Directory::may_hold(int rank, const math::Vec3d& p) const {
  return std::ranges::any_of(boxes(rank), [&](const mesh::Box& box) { return box.holds(p); });
}

bool Directory::may_touch(int rank, int other) const {
  return std::ranges::any_of(boxes(rank), [&](const mesh::Box& a) {
    return std::ranges::any_of(boxes(other), [&](const mesh::Box& b) { return meet(a, b); });
  });
}

} // namespace insitu::commit
