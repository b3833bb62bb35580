#include "scene/expression/reduce.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "math/exact_sum.h"
#include "scene/run/lookup.h"

namespace insitu::scene {

namespace {

constexpr std::int64_t grain = 1 << 14;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

double magnitude(const mesh::FieldPieceView& values, int components, std::int64_t item) {
  if (components == 1)
    return values.load(item, 0);
  double sum = 0.0;
  for (int c = 0; c < components; ++c) {
    const double v = values.load(item, c);
    sum += v * v;
  }
  return std::sqrt(sum);
}

struct Extremes {
  double least = infinity, greatest = -infinity;

  void add(double v) { // neither holds for NaN
    least = v < least ? v : least;
    greatest = v > greatest ? v : greatest;
  }
  void add(const Extremes& other) {
    least = std::min(least, other.least);
    greatest = std::max(greatest, other.greatest);
  }
};

struct Sum {
  math::ExactSum sum;
  std::int64_t count = 0;

  void add(double v) {
    if (std::isnan(v))
      return;
    sum.add(v);
    ++count;
  }
  void add(const Sum& other) {
    sum.add(other.sum);
    count += other.count;
  }
};

/// Of what counts of a field here, in parts that do not depend on threads.
template <class Part>
Part part_of(const mesh::FieldView& field, const mesh::MeshView& view,
             const CountedVertices& counted, const core::Threads& threads) {
  Part all;
  const bool cells = field.association == INSITU_CELL;
  for (std::int32_t p = 0; p < view.piece_count && field.pieces; ++p) {
    const mesh::PieceView& piece = view.pieces[p];
    const std::int64_t count = cells ? piece.cell_count : piece.vertex_count;
    std::vector<Part> parts(std::size_t((count + grain - 1) / grain));
    threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
      Part& part = parts[std::size_t(begin / grain)];
      for (std::int64_t i = begin; i < end; ++i)
        if (cells ? piece.owns(i) : counted.counts(p, i))
          part.add(magnitude(field.pieces[p], field.components, i));
    });
    for (const Part& part : parts)
      all.add(part);
  }
  return all;
}

} // namespace

double FieldReductions::operator()(const commit::CommittedMesh& mesh, const Name& name,
                                   const std::string& scene_file, Reduction reduction) {
  const mesh::FieldView field =
      find_fields(mesh, {&name, 1}, scene_file, world_, CellsOf::own_view).front();
  CountedVertices& counted = counted_[mesh.mesh().name()];
  if (field.association == INSITU_VERTEX)
    counted.update(mesh, world_, threads_);
  const mesh::MeshView& view = mesh.mesh().own_view();
  if (reduction == Reduction::mean) {
    Sum all;
    world_.agree_after([&] { all = part_of<Sum>(field, view, counted, threads_); });
    world_.reduce(std::span(&all.count, 1), parallel::Reduction::sum);
    world_.reduce(all.sum.words(), parallel::Reduction::sum);
    return all.count > 0 ? all.sum.mean(all.count) : no_value;
  }
  double least_and_least_of_negative[2] = {no_value, no_value};
  world_.agree_after([&] {
    const auto all = part_of<Extremes>(field, view, counted, threads_);
    if (all.least > all.greatest) // no value
      return;
    least_and_least_of_negative[0] = all.least + 0.0; // 0 rather than -0
    least_and_least_of_negative[1] = -(all.greatest + 0.0);
  });
  world_.reduce(least_and_least_of_negative, parallel::Reduction::least); // NaN comes last
  return reduction == Reduction::min ? least_and_least_of_negative[0]
                                     : -least_and_least_of_negative[1];
}

double reduce_field(const commit::CommittedMesh& mesh, const Name& field,
                    const std::string& scene_file, Reduction reduction,
                    const core::Threads& threads) {
  parallel::SerialWorld alone;
  return FieldReductions(alone, threads)(mesh, field, scene_file, reduction);
}

} // namespace insitu::scene
