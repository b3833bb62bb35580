#include "scene/expression/reduce.h"

#include <cmath>
#include <limits>

#include "scene/run/lookup.h"

namespace insitu::scene {

namespace {

struct Partial {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
  double sum = 0.0;
  std::int64_t count = 0;

  void add(double v) {
    if (std::isnan(v))
      return;
    min = v < min ? v : min;
    max = v > max ? v : max;
    sum += v;
    ++count;
  }
};

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

} // namespace

double reduce_field(const commit::CommittedMesh& mesh, const Name& name,
                    const std::string& scene_file, Reduction reduction,
                    const core::Threads& threads) {
  constexpr std::int64_t grain = 1 << 14;
  const mesh::FieldView field = find_own_field(mesh, name, scene_file);
  const mesh::MeshView& view = mesh.mesh().own_view();
  Partial all;
  for (std::int32_t p = 0; p < view.piece_count; ++p) {
    const mesh::PieceView& piece = view.pieces[p];
    const bool cells = field.association == INSITU_CELL;
    const std::int64_t count = cells ? piece.cell_count : piece.vertex_count;
    // Vertices count if an owning cell uses them: those of ghost cells alone may hold anything.
    std::vector<bool> used;
    if (!cells && piece.ghosts) {
      used.assign(std::size_t(count), false);
      for (std::int64_t c = 0; c < piece.cell_count; ++c) {
        std::int64_t ids[8];
        if (!piece.owns(c))
          continue;
        const int n = piece.vertex_ids(c, ids);
        for (int v = 0; v < n; ++v)
          used[std::size_t(ids[v])] = true;
      }
    }
    std::vector<Partial> partials(std::size_t((count + grain - 1) / grain));
    threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
      Partial& part = partials[std::size_t(begin / grain)];
      for (std::int64_t i = begin; i < end; ++i)
        if (cells ? piece.owns(i) : (used.empty() || used[std::size_t(i)]))
          part.add(magnitude(field.pieces[p], field.components, i));
    });
    for (const Partial& part : partials) { // in order, so that the sum is the same on any threads
      all.min = part.min < all.min ? part.min : all.min;
      all.max = part.max > all.max ? part.max : all.max;
      all.sum += part.sum;
      all.count += part.count;
    }
  }
  if (all.count == 0)
    return std::numeric_limits<double>::quiet_NaN();
  switch (reduction) {
  case Reduction::min:
    return all.min;
  case Reduction::max:
    return all.max;
  case Reduction::mean:
  case Reduction::value: // of a point: not asked for here
    break;
  }
  return all.sum / double(all.count);
}

} // namespace insitu::scene
