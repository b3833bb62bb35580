#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "commit/committed_mesh.h"
#include "workload/amr.h"

namespace insitu::bench {

/// Adaptive meshes over the arrays, which must outlive them, with the cell field "f"; not
/// committed.
std::unique_ptr<commit::CommittedMesh> register_patches(const workload::AmrMesh& blocks,
                                                        insitu_reconstruction reconstruction,
                                                        core::Memory& memory);
/// spacing: of cells of level 0, in a box from the origin.
std::unique_ptr<commit::CommittedMesh> register_leaves(const workload::AmrLeaves& leaves,
                                                       double spacing, int level_count,
                                                       insitu_reconstruction reconstruction,
                                                       core::Memory& memory);

/// Bytes of a dual mesh's cubes in the layouts of Zellmann 2023, table 2: as hexahedra with their
/// vertices, and as gridlets.
struct CubeBytes {
  double hexahedra = 0.0, gridlets = 0.0;
  double compression() const { return gridlets > 0 ? hexahedra / gridlets : 0.0; }
};
CubeBytes cube_bytes(const mesh::MeshView& dual, std::int64_t cubes);

/// What a dual mesh consists of.
struct DualStatistics {
  std::int64_t vertices = 0, tetrahedra = 0, pyramids = 0, wedges = 0,
               hexahedra = 0; ///< of stitching; collapsed hexahedra are hexahedra
  std::int64_t gridlets = 0;
  std::int64_t full_cells = 0, empty_cells = 0, full_scalars = 0, empty_scalars = 0; ///< of them
  std::int64_t folded = 0; ///< stitching cells after the repair, looked at one by one
  std::int64_t stitching() const { return tetrahedra + pyramids + wedges + hexahedra; }
};
DualStatistics statistics_of(const mesh::MeshView& dual);

/// The dual as a solver of unstructured meshes would hand it over: every cube a hexahedron.
struct PlainDual {
  std::vector<double> points, values;
  std::vector<std::int32_t> connectivity; ///< [cell][8], -1 behind the last

  std::int64_t cells() const { return std::int64_t(connectivity.size() / 8); }
  std::int64_t bytes() const { ///< without values
    return std::int64_t(8 * points.size() + 4 * connectivity.size());
  }
  std::int64_t bytes_values() const { return std::int64_t(8 * values.size()); }
};
/// Of a committed mesh whose reconstruction is the dual, and its field "f".
PlainDual plain_dual(const commit::CommittedMesh& mesh);
/// The same with vertices at one place made one, so that cells share their faces.
PlainDual welded(const PlainDual& plain);
/// Over its arrays, which must outlive it; not committed.
std::unique_ptr<commit::CommittedMesh> register_plain(const PlainDual& plain, core::Memory& memory);

} // namespace insitu::bench
