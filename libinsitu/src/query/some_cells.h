#pragma once

#include <cstdint>
#include <vector>

#include "accel/tree/tree.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"
#include "query/on_demand.h"
#include "query/sampler.h"

namespace insitu::query {

/// Some of a mesh's cells under their own ids: a view of the mesh in which the others own no
/// points, and a tree. Of unstructured meshes and blocks, a byte a cell and the tree.
class SomeCells {
public:
  explicit SomeCells(core::Memory& memory) : memory_(&memory), tree_(memory) {
    on_demand_.tree = &fit_;
  }

  /// Whether a cell is one of them: piece, cell within it. Asked from any thread.
  using Takes = core::FunctionRef<bool(std::int32_t piece, std::int64_t cell)>;
  /// What changed since the last call.
  enum class Changed : std::uint8_t { nothing, geometry, topology };
  /// Asks for all cells; the tree is built anew only if others are taken, or after a change of
  /// topology. It is fitted to vertices that moved when it is first asked.
  void update(const mesh::MeshView& mesh, const core::Threads& threads, Changed changed,
              Takes takes);

  /// Cells that are taken; of those that own points in the mesh, some are not.
  std::int64_t count() const { return count_; }
  bool leaves_out_owners() const { return leaves_out_owners_; }
  /// The sampler on these cells alone: by the tree, until the next update() or commit. The mesh's
  /// is that of the last update(), or the same with its earlier coordinates.
  Sampler of(const Sampler& whole);

private:
  class Fit final : public PutOff {
  public:
    explicit Fit(SomeCells& cells) : cells_(cells) {}
    void set(bool due, int threads) {
      threads_ = threads;
      set_due(due);
    }

  private:
    void do_it() const override { cells_.tree_.refit(cells_.view_, core::Threads(threads_)); }
    SomeCells& cells_;
    int threads_ = 1;
  };

  core::Memory* memory_;
  accel::Tree tree_;
  std::vector<core::Buffer<std::uint8_t>> left_out_; ///< [piece]: 1 a cell that is not taken
  std::vector<mesh::PieceView> pieces_;
  mesh::MeshView view_;
  Fit fit_{*this};
  OnDemand on_demand_;
  std::int64_t count_ = 0;
  bool leaves_out_owners_ = false, takes_others_ = false;
};

} // namespace insitu::query
