/// What exact containment costs: per call, by where the points are.

#include <benchmark/benchmark.h>

#include "cases.h"
#include "cells/exact/contain_exact.h"
#include "cells/kernels/contain_filter.h"
#include "lanes.h"
#include "math/predicates_exact.h"

namespace insitu::test {
namespace {

struct Sample {
  Vertices vertices;
  Vec3d point;
};

enum class Where { anywhere, near, on_planar_face, on_twisted_face, on_edge, on_vertex, centre };

std::vector<Sample> samples(Where place, double jitter) {
  Random random(501);
  std::vector<Sample> result(1024);
  const cells::FaceTable table = cells::face_table(Shape::hexahedron);
  for (Sample& s : result) {
    s.vertices = unit_cell(Shape::hexahedron);
    Vec3d centre{};
    for (Vec3d& p : s.vertices) {
      for (int axis = 0; axis < 3; ++axis) {
        p[axis] += random.uniform(-jitter, jitter);
        if (place >= Where::on_planar_face)
          p[axis] = std::round(p[axis] * 64) / 64;
      }
      centre += p / 8.0;
    }
    const cells::Face& face = table.faces[random.below(6)];
    const double u = (1 + random.below(7)) / 8.0, v = (1 + random.below(7)) / 8.0;
    switch (place) {
    case Where::anywhere:
      s.point = random.uniform({0, 0, 0}, {1, 1, 1});
      break;
    case Where::near:
      s.point = random.uniform({-1, -1, -1}, {2, 2, 2});
      break;
    case Where::on_planar_face:
    case Where::on_twisted_face:
      s.point = face_point(face, s.vertices.data(), u, v);
      break;
    case Where::on_edge:
      s.point = face_point(face, s.vertices.data(), u, 0);
      break;
    case Where::on_vertex:
      s.point = s.vertices[random.below(8)];
      break;
    case Where::centre:
      s.point = centre;
      break;
    }
  }
  return result;
}

void contain(benchmark::State& state, Where place, double jitter) {
  const auto cases = samples(place, jitter);
  std::size_t i = 0, exact = 0, held = 0, calls = 0;
  for (auto _ : state) {
    const Sample& s = cases[i++ % cases.size()];
    const auto answer = cells::contain_exact(Shape::hexahedron, s.vertices.data(), s.point);
    exact += answer.exact_used;
    held += holds(answer.where);
    ++calls;
  }
  state.counters["beyond_filter"] = static_cast<double>(exact) / static_cast<double>(calls);
  state.counters["held"] = static_cast<double>(held) / static_cast<double>(calls);
}

void filter_only(benchmark::State& state, Where place, double jitter) {
  const auto cases = samples(place, jitter);
  std::size_t i = 0, undecided = 0, calls = 0;
  for (auto _ : state) {
    const Sample& s = cases[i++ % cases.size()];
    const auto answer = cells::contain_filter<Shape::hexahedron>(s.vertices.data(), s.point);
    undecided += answer == cells::FilterResult::undecided;
    ++calls;
  }
  state.counters["undecided"] = static_cast<double>(undecided) / static_cast<double>(calls);
}

BENCHMARK_CAPTURE(filter_only, anywhere, Where::anywhere, 0.25);
BENCHMARK_CAPTURE(filter_only, near, Where::near, 0.25);
BENCHMARK_CAPTURE(contain, aligned_anywhere, Where::anywhere, 0.0);
BENCHMARK_CAPTURE(contain, aligned_centre, Where::centre, 0.0);
BENCHMARK_CAPTURE(contain, anywhere, Where::anywhere, 0.25);
BENCHMARK_CAPTURE(contain, near, Where::near, 0.25);
BENCHMARK_CAPTURE(contain, on_planar_face, Where::on_planar_face, 0.0);
BENCHMARK_CAPTURE(contain, on_twisted_face, Where::on_twisted_face, 0.25);
BENCHMARK_CAPTURE(contain, on_edge, Where::on_edge, 0.25);
BENCHMARK_CAPTURE(contain, on_vertex, Where::on_vertex, 0.25);

/// Blocks of (cell, point) pairs, points anywhere in the cells' boxes, through a kernel over packs
/// on the best target; time per pair.
template <class Out>
void over_packs(benchmark::State& state, Shape shape, double jitter,
                void (*kernel)(Shape, const LaneBlock&, Out*)) {
  Random random(502);
  std::vector<LaneBlock> blocks(32);
  for (LaneBlock& block : blocks)
    while (block.count < LaneBlock::size) {
      Vertices v = unit_cell(shape);
      for (Vec3d& p : v)
        p += random.uniform({-jitter, -jitter, -jitter}, {jitter, jitter, jitter});
      const auto [low, high] = bounds_of(shape, v.data());
      block.add(shape, v.data(), random.uniform(low, high));
    }
  Out out[LaneBlock::size];
  std::int64_t pairs = 0;
  for (auto _ : state)
    for (const LaneBlock& block : blocks) {
      kernel(shape, block, out);
      benchmark::DoNotOptimize(out[0]);
      pairs += block.count;
    }
  state.counters["per_pair"] =
      benchmark::Counter(double(pairs), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

const bool over_packs_registered = [] {
  for (const Shape shape : all_shapes)
    for (const double jitter : {0.0, 0.2, 0.4}) {
      char name[64];
      std::snprintf(name, sizeof name, "/%s/jitter:%.1f", mesh::shape_name(shape), jitter);
      benchmark::RegisterBenchmark((std::string("filter_packs") + name).c_str(),
                                   over_packs<cells::FilterResult>, shape, jitter, filter_lanes);
      benchmark::RegisterBenchmark((std::string("invert_packs") + name).c_str(),
                                   over_packs<cells::InverseMap<double>>, shape, jitter,
                                   invert_lanes);
    }
  return true;
}();

template <class Predicate>
void predicate(benchmark::State& state, Predicate stage) {
  const auto cases = samples(Where::anywhere, 0.25);
  std::size_t i = 0;
  for (auto _ : state) {
    const Sample& s = cases[i++ % cases.size()];
    benchmark::DoNotOptimize(stage(s.vertices, s.point));
  }
}

template <class Orient>
auto volume_of(Orient orient) {
  return [orient](const Vertices& v, const Vec3d& p) { return orient(v[0], v[1], v[2], p); };
}
template <class Side>
auto side_of(Side side) {
  return [side](const Vertices& v, const Vec3d& p) { return side(v[0], v[1], v[2], v[3], p); };
}

BENCHMARK_CAPTURE(predicate, orient3d_filter, volume_of(math::orient3d_filter));
BENCHMARK_CAPTURE(predicate, orient3d_double_double, volume_of(math::orient3d_double_double));
BENCHMARK_CAPTURE(predicate, orient3d_exact, volume_of(math::orient3d_exact));
BENCHMARK_CAPTURE(predicate, bilinear_side_filter, side_of(math::bilinear_side_filter));
BENCHMARK_CAPTURE(predicate, bilinear_side_double_double,
                  side_of(math::bilinear_side_double_double));
BENCHMARK_CAPTURE(predicate, bilinear_side_exact, side_of(math::bilinear_side_exact));

} // namespace
} // namespace insitu::test

BENCHMARK_MAIN();
