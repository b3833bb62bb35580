#pragma once

#include "query/ray_bundle/ray_bundle.h"
#include "query_test.h"

/// Views of meshes in bundles of rays, against batches.
namespace insitu::test {

using query::LatticeRay;
using query::RayBundleLocator;

/// Some rays, row by row, and how far apart their samples lie.
struct View {
  std::vector<LatticeRay> rays;
  int row = 0;
  double step = 0, first = 0; ///< the distance from which on samples are asked for
};

inline Vec3d unit(const Vec3d& v) {
  return v / std::sqrt(dot(v, v));
}

/// A tile of a perspective or parallel image of the box, seen from a number of its sizes away (0:
/// within), `cell` to a step and some pixels to a cell; or, parted, rays all over.
inline View view_of(const Vec3d& low, const Vec3d& high, double cell, double away, Random& random) {
  View v;
  const Vec3d size = high - low;
  const auto inside = [&] {
    Vec3d p;
    for (int a = 0; a < 3; ++a)
      p[a] = low[a] + random.uniform(0, 1) * size[a];
    return p;
  };
  const double across = std::sqrt(dot(size, size));
  Vec3d forward = unit({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
  if (random.below(8) == 0) // along an axis, and so along faces of lattices
    forward = {0, random.below(2) ? 1.0 : -1.0, 0};
  const Vec3d target = inside();
  const Vec3d eye = target - (away * across) * forward;
  const Vec3d right =
      unit(cross(forward, std::fabs(forward.x) < 0.8 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
  const Vec3d down = cross(forward, right);
  v.row = 1 + random.below(16);
  const int rows = 1 + random.below(16);
  v.step = cell * random.uniform(0.05, 2);
  v.first = std::max(0.0, away * across - 8 * v.step);
  const double pixel = cell * random.uniform(0.02, 1.5);
  const int kind = random.below(4);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < v.row; ++x) {
      const Vec3d at =
          target + ((x - 0.5 * v.row) * pixel) * right + ((y - 0.5 * rows) * pixel) * down;
      if (kind == 0) // parallel
        v.rays.push_back({at - (away * across) * forward, forward});
      else if (kind == 1 && away < 10) { // no camera
        const Vec3d from = inside();
        v.rays.push_back(
            {from - v.first * forward,
             unit({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)})});
      } else
        v.rays.push_back({eye, unit(at - eye + 1e-9 * forward)});
    }
  return v;
}

/// Numbers that tell every vertex, or cell, from the others.
class Numbers final : public query::CellValues {
public:
  Numbers(const mesh::MeshView& mesh, bool per_cell) : mesh_(mesh), per_cell_(per_cell) {}
  bool is_per_cell() const override { return per_cell_; }
  void load(std::span<const std::int64_t> cells, query::ValueBlock& block) const override {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      double f[8];
      const int n = numbers(cells[i], f);
      for (int v = 0; v < n; ++v)
        block.vertex[v][i] = f[v];
    }
  }
  void at(std::span<const query::Location> at, double* values) const override {
    for (std::size_t i = 0; i < at.size(); ++i)
      values[i] = at[i] ? number_at(at[i]) : 0.0;
  }
  double number_at(const query::Location& at) const {
    double f[8], weight[8];
    if (numbers(at.cell, f) == 1)
      return f[0];
    mesh::CellVertices cell;
    mesh::gather(mesh_, at.cell, cell);
    cells::shape_functions(cell.shape, at.parametric, weight);
    return cells::weighted_mean(cell.count, weight, f);
  }

private:
  int numbers(std::int64_t id, double* f) const {
    if (per_cell_) {
      f[0] = std::sqrt(double(id));
      return 1;
    }
    mesh::CellVertices cell;
    mesh::gather(mesh_, id, cell);
    for (int v = 0; v < cell.count; ++v)
      f[v] = std::sqrt(double(cell.ids[v])) - double(cell.piece);
    return cell.count;
  }
  const mesh::MeshView& mesh_;
  bool per_cell_;
};

/// Newton's method may have begun elsewhere, a step of 1e-5 before the end; the next would be the
/// square of that times the second derivatives.
inline bool same_place(const query::Location& a, const query::Location& b) {
  const Vec3d off = a.parametric - b.parametric;
  return a.cell == b.cell && std::fabs(off.x) < 1e-8 && std::fabs(off.y) < 1e-8 &&
         std::fabs(off.z) < 1e-8;
}

struct Counts {
  std::int64_t samples = 0, left = 0, found = 0, differ = 0;
};

/// All samples of some stretches of a view, asked for in any order.
inline void check_view(const query::Sampler& sampler, const View& v,
                       const query::LocateOptions& options, Random& random, const std::string& what,
                       Counts& counts) {
  RayBundleLocator bundle(sampler, options);
  bundle.set_rays(v.rays, random.below(4) ? v.row : random.below(40), v.step);
  const int depth = 1 + random.below(RayBundleLocator::most_depth);
  std::int64_t first = std::int64_t(v.first / v.step);
  const std::size_t n = v.rays.size();
  for (int part = 0; part < 3; ++part, first += depth) {
    std::vector<std::uint32_t> wanted(n);
    for (std::uint32_t& w : wanted)
      w = random.below(3) == 0    ? std::uint32_t(random.below(1 << 30)) << random.below(3)
          : random.below(10) == 0 ? 0u
                                  : ~0u;
    const query::Location untouched{-7, {7, 7, 7}};
    std::vector<query::Location> found(n * std::size_t(depth), untouched);
    std::vector<query::ValueSample> values(found.size(), {untouched.cell, -7});
    const Numbers numbers(sampler.mesh(), part == 1);
    if (part < 2)
      bundle.locate(first, depth, wanted, numbers, values, found);
    else
      bundle.locate(first, depth, wanted, found);
    std::vector<Vec3d> points;
    for (const LatticeRay& ray : v.rays)
      for (int k = 0; k < depth; ++k)
        points.push_back(ray.origin + ((double(first + k) + 0.5) * v.step) * ray.direction);
    std::vector<query::Location> truth(points.size());
    sampler.locate_serial(points, truth, options);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const bool asked = (wanted[i / std::size_t(depth)] >> (i % std::size_t(depth))) & 1;
      if (!asked) {
        ASSERT_EQ(found[i].cell, untouched.cell) << what << ", sample " << i;
        ASSERT_EQ(values[i].cell, untouched.cell) << what << ", sample " << i;
        continue;
      }
      counts.found += bool(truth[i]);
      ASSERT_TRUE(same_place(found[i], truth[i]))
          << what << ", sample " << i << " " << text(points[i]) << ": cell " << found[i].cell
          << ", by a batch " << truth[i].cell;
      if (part == 2)
        continue;
      ASSERT_EQ(values[i].cell, truth[i].cell) << what << ", sample " << i;
      if (truth[i]) {
        ASSERT_EQ(values[i].value, numbers.number_at(found[i])) << what << ", sample " << i;
      }
    }
  }
  counts.samples += bundle.samples();
  counts.left += bundle.left();
}

inline Counts check_views(const query::Sampler& sampler, double cell, int views, double away,
                          std::uint64_t seed, const std::string& what,
                          const query::LocateOptions& options = {}) {
  Random random(seed);
  Counts counts;
  for (int i = 0; i < views && !testing::Test::HasFatalFailure(); ++i) {
    const View v = view_of(sampler.tree().bounds_min(), sampler.tree().bounds_max(), cell,
                           away * random.uniform(0, 1), random);
    check_view(sampler, v, options, random,
               what + ", seed " + std::to_string(seed) + ", view " + std::to_string(i), counts);
  }
  return counts;
}

} // namespace insitu::test
