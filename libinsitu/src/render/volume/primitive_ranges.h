#pragma once

#include <cstdint>

#include "core/memory.h"
#include "core/parallel.h"
#include "query/lattice/culled_cells.h"
#include "query/sampler.h"
#include "render/color/transfer_function.h"
#include "render/structures/scalar_field.h"

namespace insitu::render {

/// What samples may be in each primitive of an adaptive mesh's tree, its gridlets and stitching
/// cells: made when the field's values change, so that those that a transfer function makes
/// invisible are told without a look at values (Zellmann 2023, section 5.1). 9 bytes a primitive:
/// floats, rounded outwards, so of a field of 1e-300 nothing is culled.
class PrimitiveRanges {
public:
  /// Whether there are such primitives: query::CulledCells can be made of the sampler's mesh, and
  /// the field is one of vertices.
  static bool serve(const query::Sampler& sampler, const ScalarField& field);

  PrimitiveRanges(const query::Sampler& sampler, const ScalarField& field,
                  const core::Threads& threads, core::Memory& memory);

  /// New values on the same cells: no memory is allocated.
  void refresh(const query::Sampler& sampler, const ScalarField& field,
               const core::Threads& threads);

  /// Leaves those that the function shows of what the tree holds. Reads neither values nor cells.
  void cull(const query::Sampler& sampler, const TransferFunction& function,
            const core::Threads& threads, query::CulledCells& to) const;

  std::int64_t count() const { return std::int64_t(ranges_.size()); }
  std::int64_t bytes() const { return std::int64_t(ranges_.bytes() + has_nan_.bytes()); }

private:
  struct Range {
    float lower, upper;
  };
  bool shows(std::size_t i, const TransferFunction& function) const;

public:
  static constexpr std::int64_t bytes_a_primitive = sizeof(Range) + 1;

private:
  core::Buffer<Range> ranges_; ///< of gridlets, then of stitching cells
  core::Buffer<std::uint8_t> has_nan_;
};

} // namespace insitu::render
