#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runs/netcdf/netcdf_file.h"

namespace insitu_replay {

/// A mesh topology of the UGRID conventions: faces (or volumes) of nodes.
struct UgridTopology {
  const NetcdfFile::Variable* mesh = nullptr;     ///< which has cf_role mesh_topology
  int dimension = 2;                              ///< 2: faces; 3: volumes
  int node_dim = -1, cell_dim = -1;               ///< dimensions of the file
  bool geodetic = false;                          ///< x and y are degrees of longitude and latitude
  std::vector<double> x, y, z;                    ///< of nodes; z of volumes alone
  std::vector<std::int64_t> offsets{0}, ids;      ///< the nodes of each face or volume, from 0 on
  std::vector<const NetcdfFile::Variable*> parts; ///< variables that the mesh is made of
  std::vector<std::string> others;                ///< meshes of the file that are not read
  std::size_t nodes() const { return x.size(); }
  std::size_t cells() const { return offsets.size() - 1; }
};

/// Whether a file has a mesh of the UGRID conventions, or data that say so.
bool is_ugrid(const NetcdfFile& file);

/// Reads the first mesh of faces or volumes. Throws FileError.
UgridTopology read_ugrid_topology(const NetcdfFile& file);

/// What the cells become: triangles and quads as they are, faces of more vertices cut into
/// triangles about the mean of their vertices, all turned counter-clockwise.
struct CutFaces {
  std::vector<std::int64_t> offsets{0}, ids; ///< ids from the nodes' number on: made vertices
  std::vector<std::int64_t> face;            ///< of each cell
  std::vector<std::int64_t> cut;             ///< faces that were cut: made vertex i is of face i
  std::size_t cells() const { return face.size(); }
};

/// Cuts faces. Throws FileError for one whose triangles would overlap.
CutFaces cut_faces(const NetcdfFile& file, const UgridTopology& topology);

/// The values of nodes with those of the made vertices behind: the means of their faces'.
/// longitudes: a step from one to the next is the short way round.
void append_means(const UgridTopology& topology, const CutFaces& faces, bool longitudes,
                  std::vector<double>& values);

} // namespace insitu_replay
