#pragma once

#include <span>
#include <vector>

#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::mesh {

/// A copy of a field's values on a piece in which items without a value hold NaN, of the field's
/// own type. An item has no value if one of its components is a blank one, or if it is hidden.
class BlankedValues {
public:
  explicit BlankedValues(core::Memory& memory, insitu_purpose purpose = INSITU_MEMORY_BLANK)
      : values_(memory, purpose) {}

  /// blanks: compared as the field's type holds them. hidden: one byte an item whose bit 2 hides
  /// it, or null. threads: or null.
  void make(const FieldPieceView& from, int components, std::span<const double> blanks,
            const std::byte* hidden, const ItemLayout& hidden_layout, const core::Threads* threads);

  /// Until the next make().
  const std::vector<const std::byte*>& components() const { return components_; }
  const ItemLayout& layout() const { return layout_; }
  bool is_float32() const { return is_float32_; }
  std::int64_t bytes() const { return std::int64_t(values_.bytes()); }

private:
  template <class Real>
  void copy(const FieldPieceView& from, std::span<const double> blanks, const std::byte* hidden,
            const ItemLayout& hidden_layout, const core::Threads* threads);

  core::Buffer<double> values_; ///< [item][component], of either type
  std::vector<const std::byte*> components_;
  ItemLayout layout_;
  bool is_float32_ = false;
};

} // namespace insitu::mesh
