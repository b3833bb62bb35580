#pragma once

#include <string>

#include "core/parallel.h"
#include "mesh/adaptive.h"
#include "mesh/registered/external_array.h"
#include "mesh/registered/flat_piece.h"

namespace insitu::mesh {

/// A checked insitu_amr.
struct AmrLevels {
  Lattice lattice;
  int level_count = 1;
  bool finest_first = false;
  std::int8_t depth_of[AmrView::most_levels] = {0}; ///< of level l, 0 the coarsest
  insitu_reconstruction reconstruction = INSITU_DUAL;

  /// As they were given: what is thick here of a flat mesh lies in its plane.
  math::Vec3d given_origin() const;
  math::Vec3d given_spacing() const;
  int dimensions() const { return lattice.is_flat != 0 ? 2 : 3; }
  /// What is known of a flat mesh of these levels, of whatever cells; of others nothing.
  FlatFacts flat_facts() const;
  /// Of a level as the solver numbers it; it must be one of level_count.
  int depth(std::int64_t level) const {
    return depth_of[finest_first ? level_count - 1 - level : level];
  }
  bool same_cells(const AmrLevels& other) const;
};

/// Throws core::Error with the numbers that are wrong; `name` is what messages call it.
AmrLevels adopt_levels(const insitu_amr* amr, const std::string& name);

/// A piece of an adaptive mesh as it was given.
struct AmrPiece {
  enum class Kind { none, patch, leaves };
  Kind kind = Kind::none;
  insitu_patch patch{};
  ExternalArray levels, corners; ///< of leaves
  int corner_bits = -1;
  std::int64_t offset[3] = {0, 0, 0};
  bool is_flat = false; ///< leaves whose third coordinate is of no account
};

/// is_flat: third numbers are of no account.
AmrPiece adopt_patch(const insitu_patch* patch, bool is_flat, const std::string& name);
AmrPiece adopt_leaves(const insitu_leaves* leaves, bool is_flat, const std::string& name);

/// The piece on these levels. Throws core::Error if it is a patch that does not fit; leaves are
/// checked by check_leaves.
AmrPieceView view_of(const AmrPiece& piece, const AmrLevels& levels, const std::string& name);

/// Why ghost layers of the patch cannot lie between the rows of a field's array; empty: they can.
std::string why_no_ghosts(const insitu_patch& patch, const ExternalArray& array);

/// Throws the first leaf whose level, corner or pointer cannot be. threads null: on the caller.
void check_leaves(const AmrPiece& piece, const AmrPieceView& view, const AmrLevels& levels,
                  const std::string& name, const core::Threads* threads);

/// The first of n for which is_bad(i), n if there is none.
std::int64_t first_bad(std::int64_t n, const core::Threads* threads,
                       core::FunctionRef<bool(std::int64_t)> is_bad);

} // namespace insitu::mesh
