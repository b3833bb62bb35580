#include "query/directory.h"

#include <algorithm>
#include <cmath>

#include "parallel/bytes.h"

namespace insitu::query {

/// With room for the rounding of the sums.
mesh::Box in_mesh(const accel::Box& box, const math::Vec3d& origin) {
  mesh::Box out;
  for (int a = 0; a < 3; ++a) {
    const double low = double(box.lower[a]), high = double(box.upper[a]);
    out.low[a] = origin[a] + low - (std::fabs(origin[a]) + std::fabs(low)) * 0x1p-51;
    out.high[a] = origin[a] + high + (std::fabs(origin[a]) + std::fabs(high)) * 0x1p-51;
  }
  return out;
}

accel::Box in_tree(const mesh::Box& box, const math::Vec3d& origin) {
  accel::Box out;
  for (int a = 0; a < 3; ++a) {
    out.lower[a] = accel::round_down(box.low[a] - origin[a]);
    out.upper[a] = accel::round_up(box.high[a] - origin[a]);
  }
  return out;
}

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

void Directory::gather(std::span<const mesh::Box> own, parallel::World& world) {
  std::vector<parallel::Parcel> parcels;
  world.agree_after([&] {
    of_.assign(std::size_t(world.size()), {});
    for (int r = 0; r < world.size() && !own.empty(); ++r)
      parcels.push_back({r, parallel::bytes_of(own)});
  });
  const std::vector<parallel::Parcel> received = world.exchange(parcels);
  world.agree_after([&] {
    for (const parallel::Parcel& p : received) {
      Of& of = of_[std::size_t(p.rank)];
      of.boxes = parallel::items_of<mesh::Box>(p.bytes);
      of.all = of.boxes.front();
      for (const mesh::Box& box : of.boxes)
        of.all.extend(box);
    }
  });
}

bool Directory::may_hold(int rank, const math::Vec3d& p) const {
  const Of& of = of_[std::size_t(rank)];
  return !of.boxes.empty() && of.all.holds(p) &&
         std::ranges::any_of(of.boxes, [&](const mesh::Box& box) { return box.holds(p); });
}

bool Directory::may_touch(int rank, int other) const {
  return std::ranges::any_of(boxes(rank), [&](const mesh::Box& a) {
    return std::ranges::any_of(boxes(other), [&](const mesh::Box& b) { return meet(a, b); });
  });
}

} // namespace insitu::query
