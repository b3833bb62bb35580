#include "cells/polyhedra/made_points.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "mesh/registered/copy_items.h"

namespace insitu::cells {

using math::Vec3d;
using mesh::Shape;

namespace {

constexpr std::int64_t centres_grain = 1 << 10;

/// Of points: from the first on, so that rounding is that of the cell's size.
template <class At>
Vec3d mean_of(std::int64_t count, const At& at) {
  const Vec3d first = at(0);
  Vec3d sum{};
  for (std::int64_t i = 1; i < count; ++i)
    sum += at(i) - first;
  return first + sum / double(count);
}

/// The solution of a symmetric system, by elimination with the largest pivots.
Vec3d solve(const Vec3d* rows, Vec3d right) {
  Vec3d m[3] = {rows[0], rows[1], rows[2]};
  int order[3] = {0, 1, 2};
  for (int k = 0; k < 3; ++k) {
    for (int i = k + 1; i < 3; ++i)
      if (std::abs(m[order[i]][k]) > std::abs(m[order[k]][k]))
        std::swap(order[i], order[k]);
    for (int i = k + 1; i < 3; ++i) {
      const double f = m[order[i]][k] / m[order[k]][k];
      m[order[i]] -= f * m[order[k]];
      right[order[i]] -= f * right[order[k]];
    }
  }
  Vec3d x{};
  for (int k = 2; k >= 0; --k) {
    double rest = right[order[k]];
    for (int j = k + 1; j < 3; ++j)
      rest -= m[order[k]][j] * x[j];
    x[k] = rest / m[order[k]][k];
  }
  return x;
}

} // namespace

/// Looks for the centre of one cell, about which its parts lie.
class MadePoints::CellCentre {
public:
  /// points: of the parts, but for the centre.
  void gather(const mesh::PieceView& parts, std::int64_t begin, std::int64_t end,
              const Vec3d* points, const Vec3d& mean) {
    planes_.clear();
    corners_.clear();
    Vec3d low = mean, high = mean;
    std::int64_t ids[8];
    for (std::int64_t part = begin; part < end; ++part) {
      const int n = parts.vertex_ids(part, ids) - 1; // the last is the centre
      Vec3d x[4];
      for (int v = 0; v < n; ++v) {
        x[v] = points[ids[v]];
        for (int a = 0; a < 3; ++a) {
          low[a] = std::min(low[a], x[v][a]);
          high[a] = std::max(high[a], x[v][a]);
        }
      }
      // The determinant of a pyramid's map has its least value at a corner of the base.
      for (int v = 0; v < (n == 4 ? 4 : 1); ++v)
        planes_.push_back({x[v], cross(x[(v + 1) % n] - x[v], x[(v + n - 1) % n] - x[v])});
      for (int v = 2; v < n; ++v)
        corners_.push_back({x[0], x[v - 1], x[v]});
    }
    const Vec3d extent = high - low;
    size_ = std::sqrt(dot(extent, extent));
  }

  /// Whether every part has a volume; parts over faces without an area have none to have.
  bool sees_all(const Vec3d& c) const { return depth(c, nullptr) > 1e-12 * size_; }

  Vec3d centroid(const Vec3d& from) const {
    double volume = 0.0;
    Vec3d moment{};
    for (const Corner& k : corners_) {
      const Vec3d a = k.x[0] - from, b = k.x[1] - from, c = k.x[2] - from;
      const double v = dot(cross(a, b), c);
      volume += v;
      moment += v * (a + b + c);
    }
    return volume == 0.0 ? from : from + moment / (4.0 * volume);
  }

  /// Climbs from a point to a deeper one, in steps that shrink.
  Vec3d deepest(Vec3d c) const {
    constexpr int steps = 400;
    Vec3d best = c;
    double best_depth = depth(c, nullptr);
    for (int k = 1; k <= steps; ++k) {
      Vec3d inward{};
      depth(c, &inward);
      c += (size_ / double(2 * k + 2)) * inward;
      if (const double d = depth(c, nullptr); d > best_depth) {
        best_depth = d;
        best = c;
      }
    }
    return best;
  }

private:
  struct Plane {
    Vec3d at, normal; ///< inward
  };
  struct Corner {
    Vec3d x[3];
  };

  /// The least distance from a plane, negative outside; and the direction away from that one.
  double depth(const Vec3d& c, Vec3d* inward) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Plane& p : planes_) {
      const double length = std::sqrt(dot(p.normal, p.normal));
      if (length <= 1e-14 * size_ * size_)
        continue;
      const double d = dot(p.normal, c - p.at) / length;
      if (d >= least)
        continue;
      least = d;
      if (inward)
        *inward = p.normal / length;
    }
    return least;
  }

  std::vector<Plane> planes_;
  std::vector<Corner> corners_;
  double size_ = 0.0;
};

void MadePoints::place(const mesh::PieceView& own, Parts& parts, const core::Threads& threads) {
  beside_.clear();
  without_centre_.clear();
  solvers_ = own.vertex_count;
  const std::int64_t made = parts.made_count();
  if (made == 0) {
    points_.release();
    return;
  }
  points_.resize_discard(std::size_t(solvers_ + made));
  threads.parallel_for(solvers_, 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    mesh::copy_points(own, begin, end, points_.data() + begin);
  });
  Vec3d* const points = points_.data();
  Ids& sources = parts.sources();
  const auto mean = [&](std::int64_t k, std::vector<std::int64_t>& ids) {
    const std::int64_t first = parts.place_of_sources(k), end = parts.place_of_sources(k + 1);
    ids.clear();
    for (std::int64_t i = first; i < end; ++i)
      ids.push_back(sources[i]);
    std::ranges::sort(ids, {}, [&](std::int64_t id) {
      return std::tuple(points[id].x, points[id].y, points[id].z);
    });
    for (std::int64_t i = first; i < end; ++i)
      sources.set(i, ids[std::size_t(i - first)]);
    return mean_of(end - first, [&](std::int64_t i) { return points[ids[std::size_t(i)]]; });
  };
  const std::int64_t faces = parts.face_centre_count();
  threads.parallel_for(faces, centres_grain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<std::int64_t> ids;
    for (std::int64_t k = begin; k < end; ++k)
      points[solvers_ + k] = mean(k, ids);
  });

  struct Chunk {
    std::vector<Beside> beside;
    std::vector<std::uint32_t> without;
  };
  std::vector<Chunk> chunks(std::size_t((made - faces + centres_grain - 1) / centres_grain));
  const mesh::PieceView view = parts.view(own);
  threads.parallel_for(made - faces, centres_grain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<std::int64_t> ids;
    CellCentre centre;
    Chunk& chunk = chunks[std::size_t(begin / centres_grain)];
    for (std::int64_t k = faces + begin; k < faces + end; ++k) {
      const Vec3d at = mean(k, ids);
      const std::int64_t cell = parts.cut_cell(k);
      Vec3d chosen = at;
      centre.gather(view, parts.first()[cell], parts.first()[cell + 1], points, at);
      if (!centre.sees_all(chosen))
        chosen = centre.centroid(at);
      if (!centre.sees_all(chosen))
        chosen = centre.deepest(chosen);
      if (!centre.sees_all(chosen)) {
        chosen = at;
        chunk.without.push_back(std::uint32_t(cell));
      }
      points[solvers_ + k] = chosen;
      if (chosen == at)
        continue;
      Vec3d spread[3] = {};
      for (const std::int64_t id : ids)
        for (int a = 0; a < 3; ++a)
          spread[a] += (points[id] - at)[a] * (points[id] - at);
      chunk.beside.push_back({k, solve(spread, chosen - at), at});
    }
  });
  for (const Chunk& chunk : chunks) {
    beside_.insert(beside_.end(), chunk.beside.begin(), chunk.beside.end());
    without_centre_.insert(without_centre_.end(), chunk.without.begin(), chunk.without.end());
  }
}

void MadePoints::put_in(mesh::PieceView& view) const {
  if (points_.empty())
    return;
  for (int a = 0; a < 3; ++a)
    view.points.component[a] = reinterpret_cast<const std::byte*>(points_.data()) + 8 * a;
  view.points.layout = {view.vertex_count, {view.vertex_count, 1}, {sizeof(Vec3d), 0, 0}, true};
  view.points.is_float32 = false;
}

template <class T>
void MadePoints::extend(const mesh::FieldPieceView& own, int components, const Parts& parts,
                        const core::Threads& threads, T* to) const {
  const int n = components;
  threads.parallel_for(solvers_, 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
      for (int c = 0; c < n; ++c)
        to[v * n + c] = T(own.load(v, c));
  });
  threads.parallel_for(
      parts.made_count(), centres_grain, [&](std::int64_t begin, std::int64_t end) {
        auto beside = std::ranges::lower_bound(beside_, begin, {}, &Beside::made);
        for (std::int64_t k = begin; k < end; ++k) {
          const std::int64_t first = parts.place_of_sources(k),
                             last = parts.place_of_sources(k + 1);
          const bool is_mean = beside == beside_.end() || beside->made != k;
          for (int c = 0; c < n; ++c) {
            const double base = own.load(parts.sources()[first], c);
            double sum = 0.0, off = 0.0;
            for (std::int64_t i = first; i < last; ++i) {
              const std::int64_t id = parts.sources()[i];
              const double difference = own.load(id, c) - base;
              sum += difference;
              if (!is_mean)
                off += dot(points_[std::size_t(id)] - beside->mean, beside->gradient) * difference;
            }
            to[(solvers_ + k) * n + c] = T(base + sum / double(last - first) + off);
          }
          beside += !is_mean;
        }
      });
}

template void MadePoints::extend(const mesh::FieldPieceView&, int, const Parts&,
                                 const core::Threads&, float*) const;
template void MadePoints::extend(const mesh::FieldPieceView&, int, const Parts&,
                                 const core::Threads&, double*) const;

} // namespace insitu::cells
