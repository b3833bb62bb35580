#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "api/amr_watch.h"
#include "core/parallel.h"
#include "mesh/registered/mesh.h"

namespace insitu::api {

/// Whether queries verify that the mesh is the one that was committed: the environment variable
/// INSITU_CHECKED (1 or 0) if it is set, otherwise whether the library was built with it.
bool is_checked();

/// What the coordinates, cells and ghosts of a mesh held at its commit, as a hash of every few
/// kilobytes, to tell a mesh that was changed without a commit. Of an adaptive mesh where its cells
/// lay (AmrWatch).
class ArrayWatch {
public:
  explicit ArrayWatch(core::Memory& memory) : adaptive_(memory) {}

  void remember(const mesh::Mesh& mesh, const core::Threads& threads);

  /// Throws INSITU_ERROR_ORDER, naming the mesh and the array or leaf, if one changed. said: what
  /// the solver said has changed (INSITU_CHANGED_*), and may. Reads every array whole.
  void expect_unchanged(std::uint32_t said, const core::Threads& threads) const;
  /// The same of one chunk an array, another one each time: for queries of single points.
  void expect_unchanged_chunk();

private:
  struct Array {
    std::string name;
    mesh::ExternalArray array;
    mesh::Mesh::ArrayKind kind;
    std::vector<std::uint64_t> chunks;
    std::size_t next = 0;
  };
  [[noreturn]] void refuse(const Array& a, std::size_t chunk) const;

  std::string mesh_;
  std::vector<Array> arrays_;
  AmrWatch adaptive_;
};

} // namespace insitu::api
