#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesh/registered/external_array.h"

/// Items of a caller's arrays, without gaps and in their own type.
namespace insitu::mesh {

/// The number of components of arrays that together hold one quantity.
int components_of(const std::vector<ExternalArray>& arrays);

/// Copies the items [begin, end) of such arrays; the components of an item follow each other.
void copy_dense(const std::vector<ExternalArray>& arrays, std::int64_t begin, std::int64_t end,
                std::byte* to);

/// Where the items lie, if it is side by side; else null.
const std::byte* dense_items(const std::vector<ExternalArray>& arrays);

/// A patch with the layers of ghosts that the library reads: one, where there are any.
insitu_patch as_read(insitu_patch patch);
/// Its cells and these layers, along each axis.
std::array<std::int64_t, 3> extent_with_ghosts(const insitu_patch& patch);

/// Arrays of a patch's cells with the layers of as_read().
std::vector<ExternalArray> with_read_layers(std::vector<ExternalArray> arrays,
                                            const insitu_patch& patch);

/// The rings of faces that lie behind pointers, one after the other.
class RingsBehind {
public:
  /// counts: how many ids each ring has.
  RingsBehind(const ExternalArray& rings, const ExternalArray& counts)
      : rings_(rings), counts_(counts) {}

  std::int64_t face_count() const { return rings_.layout.count; }
  /// Of a face; 0 for none.
  std::int64_t count(std::int64_t face) const;
  std::int64_t id_count() const; ///< of all
  /// Copies the ids [begin, end) of all faces. Calls come in the order of the ids.
  void copy_ids(std::int64_t begin, std::int64_t end, std::byte* to);
  /// Copies the places [begin, end) of face_count() + 1 at which rings start, counted from `base`.
  /// Calls come in the order of the places.
  void copy_places(std::int64_t begin, std::int64_t end, std::int64_t base, std::byte* to);

private:
  ExternalArray rings_, counts_;
  std::int64_t face_ = 0, within_ = 0; ///< where copy_ids() goes on
  std::int64_t passed_ = 0;            ///< ids before the place at which copy_places() goes on
};

} // namespace insitu::mesh
