#include "render/volume/primitive_ranges.h"

#include <algorithm>
#include <limits>

#include "accel/tree/tree.h"
#include "render/structures/vertex_numbers.h"
#include "render/volume/possible_values.h"

namespace insitu::render {

namespace {

/// Vertices of no leaf belong to no cell.
void add_gridlet(const mesh::GridletsView& all, std::int64_t gridlet, const VertexNumbers& at,
                 PossibleValues& values) {
  const mesh::Gridlet& g = all.gridlets[gridlet];
  for (std::int64_t v = g.first, end = v + g.vertex_count(); v < end; ++v)
    if (all.leaves[v] != mesh::GridletsView::no_leaf)
      values.add(at(v));
}

void add_stitching(const mesh::PieceView& piece, std::int64_t cell, const VertexNumbers& at,
                   PossibleValues& values) {
  for (int v = 0; v < 8; ++v) { // without asking for the shape first
    const std::int64_t id = mesh::from_base(piece.padded_id(cell, v), piece.index_base);
    if (id < 0)
      break;
    values.add(at(id));
  }
}

constexpr double largest = std::numeric_limits<float>::max();

float lower_float(double x) {
  return x > largest ? float(largest) : accel::round_down(std::max(x, -2 * largest));
}
float upper_float(double x) {
  return x < -largest ? float(-largest) : accel::round_up(std::min(x, 2 * largest));
}

} // namespace

bool PrimitiveRanges::serve(const query::Sampler& sampler, const ScalarField& field) {
  return query::CulledCells::serves(sampler) && field.field.association == INSITU_VERTEX;
}

PrimitiveRanges::PrimitiveRanges(const query::Sampler& sampler, const ScalarField& field,
                                 const core::Threads& threads, core::Memory& memory)
    : ranges_(memory, INSITU_MEMORY_RANGES), has_nan_(memory, INSITU_MEMORY_RANGES) {
  ranges_.resize_discard(std::size_t(query::CulledCells::primitives_of(sampler)));
  has_nan_.resize_discard(ranges_.size());
  refresh(sampler, field, threads);
}

void PrimitiveRanges::refresh(const query::Sampler& sampler, const ScalarField& field,
                              const core::Threads& threads) {
  const mesh::MeshView& mesh = sampler.mesh();
  const mesh::GridletsView& gridlets = *mesh.pieces[0].gridlets;
  const auto set = [&](std::int64_t i, const PossibleValues& values) {
    ranges_[std::size_t(i)] = {lower_float(values.lower), upper_float(values.upper)};
    has_nan_[std::size_t(i)] = values.nan;
  };
  const VertexNumbers in_gridlets(field, 0), in_stitching(field, 1);
  threads.parallel_for(gridlets.count, 64, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t g = begin; g < end; ++g) {
      PossibleValues values;
      add_gridlet(gridlets, g, in_gridlets, values);
      values.finish_several();
      set(g, values);
    }
  });
  threads.parallel_for(mesh.pieces[1].cell_count, 4096, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t cell = begin; cell < end; ++cell) {
      PossibleValues values;
      add_stitching(mesh.pieces[1], cell, in_stitching, values);
      values.finish(true);
      set(gridlets.count + cell, values);
    }
  });
}

bool PrimitiveRanges::shows(std::size_t i, const TransferFunction& function) const {
  const Range& r = ranges_[i];
  return (r.lower <= r.upper &&
          function.max_opacity(r.lower, r.upper) >= TransferFunction::invisible) ||
         (function.nan_opacity() >= TransferFunction::invisible && has_nan_[i]);
}

void PrimitiveRanges::cull(const query::Sampler& sampler, const TransferFunction& function,
                           const core::Threads& threads, query::CulledCells& to) const {
  to.make(sampler, threads, [&](std::int64_t i) { return shows(std::size_t(i), function); });
}

} // namespace insitu::render
