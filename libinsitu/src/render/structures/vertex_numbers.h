#pragma once

#include <cstddef>
#include <cstdint>

#include "render/structures/scalar_field.h"

namespace insitu::render {

/// A field's numbers at the vertices of a piece.
class VertexNumbers {
public:
  VertexNumbers(const ScalarField& field, std::int32_t piece) : field_(field), piece_(piece) {
    const mesh::FieldPieceView& from = field.field.pieces[piece];
    const int c = range_component(field);
    if (c < 0 || !from.layout.linear)
      return;
    base_ = from.component[c];
    stride_ = from.layout.stride[0];
    is_float32_ = from.is_float32;
  }
  double operator()(std::int64_t vertex) const {
    return base_ ? mesh::load_real(base_ + vertex * stride_, is_float32_)
                 : field_.load(piece_, vertex);
  }

private:
  const ScalarField& field_;
  std::int32_t piece_;
  const std::byte* base_ = nullptr; ///< null: the general way
  std::int64_t stride_ = 0;
  bool is_float32_ = false;
};

} // namespace insitu::render
