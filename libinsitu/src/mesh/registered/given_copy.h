#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/registered/dense_items.h"
#include "mesh/registered/mesh.h"

/// Copies of what a caller gave for a mesh, in the caller's types, which outlive its arrays
/// (INSITU_MEMORY_HELD).
namespace insitu::mesh {

/// Arrays whose items lie side by side.
class DenseCopies {
public:
  explicit DenseCopies(core::Memory& memory) : memory_(&memory) {}

  /// Copies arrays that together hold one quantity. The result is valid as long as this object.
  insitu_array copy(const std::vector<ExternalArray>& arrays, const core::Threads& threads);
  /// Copies rings of faces that lie behind pointers: their ids, and the places where they start,
  /// counted from `base`.
  std::pair<insitu_array, insitu_array> copy(RingsBehind rings, insitu_type type,
                                             std::int64_t base);

private:
  std::byte* room(std::int64_t bytes);

  core::Memory* memory_;
  std::vector<core::Buffer<std::byte>> arrays_;
};

/// The cells of a mesh and their places: what tells a step's geometry and topology.
class CellsGiven {
public:
  explicit CellsGiven(core::Memory& memory) : copies_(memory) {}

  /// Copies what `from` was given and gives it to a mesh that was given nothing yet, and that reads
  /// the copies from now on.
  void copy(const Mesh& from, Mesh& to, const core::Threads& threads);

private:
  void copy_piece(const GivenPiece& piece, std::int32_t p, Mesh& to, const core::Threads& threads);

  DenseCopies copies_;
};

/// What may be another at each step although cells and vertices stand: fields, hidden points, and
/// how an adaptive mesh is sampled.
class ValuesGiven {
public:
  ValuesGiven(const Mesh& from, core::Memory& memory, const core::Threads& threads);

  /// Gives them to a mesh with the same cells, in the place of those that it has, which then reads
  /// the copies.
  void give(Mesh& to) const;

private:
  struct Values {
    std::int32_t piece;
    std::string name;
    insitu_association association;
    insitu_array array;
  };
  struct HiddenPoints {
    std::int32_t piece;
    insitu_array array; ///< without items: none are hidden
  };

  DenseCopies copies_;
  std::vector<GivenMesh::Field> fields_; ///< in the order in which they were given
  std::vector<Values> values_;
  std::vector<HiddenPoints> hidden_;
  std::optional<AmrLevels> levels_;
};

} // namespace insitu::mesh
