#include "scaling/leaves.h"

#include <cmath>

namespace insitu::bench::scaling {

using math::Vec3d;

namespace {

// Of a box of edge 1.
constexpr double inner = 0.25, outer = 0.45;

} // namespace

LeafLayout::LeafLayout(int processes, std::int64_t leaves, bool weak)
    : coarse(make_layout(
          processes,
          std::int64_t(double(leaves) / (1 + 7 * 4.0 / 3.0 * M_PI *
                                                 (outer * outer * outer - inner * inner * inner))),
          weak, 0.0)) {}

bool LeafLayout::is_split(int i, int j, int k) const {
  Vec3d x{(i + 0.5) * coarse.width, (j + 0.5) * coarse.width, (k + 0.5) * coarse.width};
  for (int a = 0; a < 3; ++a)
    x[a] -= std::floor(x[a]) + 0.5;
  const double r = std::sqrt(dot(x, x));
  return r > inner && r < outer;
}

PartLeaves make_leaves(const LeafLayout& layout, int rank) {
  PartLeaves out;
  const Vec3d middle = 0.5 * layout.coarse.size();
  layout.for_leaves(rank, [&](int level, const std::array<int, 3>& corner) {
    out.levels.push_back(level);
    out.corners.insert(out.corners.end(), corner.begin(), corner.end());
    const double width = layout.coarse.width / (1 << level);
    const Vec3d from =
        Vec3d{(corner[0] + 0.5) * width, (corner[1] + 0.5) * width, (corner[2] + 0.5) * width} -
        middle;
    out.values.push_back(std::sqrt(dot(from, from)));
  });
  return out;
}

} // namespace insitu::bench::scaling
