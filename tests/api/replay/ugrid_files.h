// Meshes of triangles and quads as netCDF files by the UGRID conventions.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <netcdf.h>
#include <stdexcept>
#include <string>
#include <vector>

/// A netCDF file that a test writes.
class NcFile {
public:
  explicit NcFile(const std::string& path, int format = NC_64BIT_OFFSET) {
    check(nc_create(path.c_str(), NC_CLOBBER | format, &id_));
  }
  ~NcFile() { nc_close(id_); }
  NcFile(const NcFile&) = delete;
  NcFile& operator=(const NcFile&) = delete;

  int dim(const std::string& name, std::size_t length) {
    int out = 0;
    check(nc_def_dim(id_, name.c_str(), length, &out));
    return out;
  }
  int var(const std::string& name, const std::vector<int>& dims, nc_type type = NC_DOUBLE) {
    int out = 0;
    check(nc_def_var(id_, name.c_str(), type, int(dims.size()), dims.data(), &out));
    return out;
  }
  /// Attributes of text: name, value and so on.
  void say(int var, const std::vector<std::string>& pairs) {
    for (std::size_t i = 0; i + 1 < pairs.size(); i += 2)
      check(nc_put_att_text(id_, var, pairs[i].c_str(), pairs[i + 1].size(), pairs[i + 1].c_str()));
  }
  void say(int var, const char* name, double value, nc_type type = NC_INT) {
    check(nc_put_att_double(id_, var, name, type, 1, &value));
  }
  /// The last definition.
  void begin() { check(nc_enddef(id_)); }
  void put(int var, const std::vector<double>& values) {
    check(nc_put_var_double(id_, var, values.data()));
  }

private:
  static void check(int status) {
    if (status != NC_NOERR)
      throw std::runtime_error(nc_strerror(status));
  }
  int id_ = 0;
};

/// A lattice of squares of which every other is two triangles; where from and how long its sides
/// are, and how a file holds it.
struct UgridLattice {
  int nx = 4, ny = 3;
  double x0 = 0, y0 = 0, size = 1;
  int start = 0;             ///< start_index
  bool faces_second = false; ///< connectivity is [nodes of a face][faces]
  bool by_centres = false;   ///< which the dimension of the faces' coordinates tells
  bool repeats = false;      ///< a triangle's last node is there twice
  bool degrees = false;
  std::vector<std::vector<int>> faces;
  std::vector<std::array<double, 2>> nodes;

  void make() {
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        nodes.push_back({x0 + size * i, y0 + size * j});
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const int a = i + (nx + 1) * j, b = a + 1, c = b + nx + 1, d = a + nx + 1;
        if ((i + j) % 2 == 0) {
          faces.push_back({a, b, c, d});
        } else { // either way round
          faces.push_back({a, b, c});
          faces.push_back({a, d, c});
        }
      }
  }

  /// The mean of a face's nodes.
  std::array<double, 2> centre(std::size_t face) const {
    std::array<double, 2> out{};
    for (const int v : faces[face])
      for (std::size_t a = 0; a < 2; ++a)
        out[a] += nodes[std::size_t(v)][a] / double(faces[face].size());
    return out;
  }
};

/// A hexagon, counterclockwise, and beside it a quad, clockwise.
inline UgridLattice hexagon_and_quad() {
  UgridLattice out;
  out.nodes = {{1, 0}, {3, 0}, {4, 2}, {3, 4}, {1, 4}, {0, 2}, {6, 0}, {6, 2}};
  out.faces = {{0, 1, 2, 3, 4, 5}, {6, 1, 2, 7}};
  return out;
}

/// A place in a scene's list of them, to the bit.
inline std::string text_of(double x, double y, double z) {
  char text[120];
  std::snprintf(text, sizeof text, "[%.17g, %.17g, %.17g]", x, y, z);
  return text;
}

/// A field that interpolation meets to rounding.
inline double field_of(double x, double y, double z) {
  return 3 + x - 2 * y + 0.5 * z;
}

/// The radius of the ellipsoid's prime vertical (WGS 84) at a latitude in radians, in metres.
inline double prime_vertical(double latitude) {
  const double a = 6378137, f = 1 / 298.257223563, e2 = f * (2 - f), sine = std::sin(latitude);
  return a / std::sqrt(1 - e2 * sine * sine);
}

/// The file of a lattice: its topology, then what a test adds.
class UgridFile {
public:
  UgridFile(const std::string& path, const UgridLattice& lattice, std::size_t steps,
            const std::string& time_units, int format = NC_64BIT_OFFSET)
      : file(path, format), lattice_(lattice) {
    for (const auto& ring : lattice.faces)
      most_ = std::max(most_, ring.size());
    time = file.dim("time", steps);
    node = file.dim("nMesh_node", lattice.nodes.size());
    face = file.dim("nMesh_face", lattice.faces.size());
    max_ = file.dim("nMax", most_);
    time_ = file.var("time", {time});
    file.say(time_, {"units", time_units});
    mesh = file.var("Mesh", {}, NC_INT);
    file.say(mesh, {"cf_role", "mesh_topology", "node_coordinates", "Mesh_x Mesh_y",
                    "face_node_connectivity", "Mesh_nodes"});
    file.say(mesh, "topology_dimension", 2);
    if (lattice.by_centres)
      file.say(mesh, {"face_coordinates", "Mesh_xc Mesh_yc"});
    else if (lattice.faces_second)
      file.say(mesh, {"face_dimension", "nMesh_face"});
    file.var("Mesh_xc", {face});
    file.var("Mesh_yc", {face});
    x_ = file.var("Mesh_x", {node});
    y_ = file.var("Mesh_y", {node});
    file.say(x_, {"units", lattice.degrees ? "degrees_east" : "m"});
    file.say(y_, {"units", lattice.degrees ? "degrees_north" : "m"});
    connectivity =
        file.var("Mesh_nodes",
                 lattice.faces_second ? std::vector{max_, face} : std::vector{face, max_}, NC_INT);
    file.say(connectivity, "_FillValue", -999);
    if (lattice.start != 0)
      file.say(connectivity, "start_index", lattice.start);
  }

  /// A variable of nodes or faces.
  int field(const std::string& name, const std::vector<int>& dims, const char* location,
            nc_type type = NC_DOUBLE) {
    const int out = file.var(name, dims, type);
    file.say(out, {"mesh", "Mesh", "location", location});
    return out;
  }

  /// Ends definitions and writes the mesh.
  void begin(const std::vector<double>& times) {
    file.begin();
    file.put(time_, times);
    std::vector<double> x, y;
    for (const auto& p : lattice_.nodes) {
      x.push_back(p[0]);
      y.push_back(p[1]);
    }
    file.put(x_, x);
    file.put(y_, y);
    const std::size_t n = lattice_.faces.size();
    std::vector<double> ids(n * most_, -999);
    for (std::size_t f = 0; f < n; ++f)
      for (std::size_t k = 0; k < (lattice_.repeats ? most_ : lattice_.faces[f].size()); ++k)
        ids[lattice_.faces_second ? k * n + f : f * most_ + k] =
            lattice_.faces[f][std::min(k, lattice_.faces[f].size() - 1)] + lattice_.start;
    file.put(connectivity, ids);
  }

  /// [time][nodes].
  std::vector<double> of_nodes(std::size_t steps,
                               const std::function<double(double, double, double)>& f) const {
    std::vector<double> out;
    for (std::size_t t = 0; t < steps; ++t)
      for (const auto& p : lattice_.nodes)
        out.push_back(f(p[0], p[1], double(t)));
    return out;
  }

  NcFile file;
  int time = 0, node = 0, face = 0, mesh = 0, connectivity = 0;

private:
  const UgridLattice& lattice_;
  std::size_t most_ = 0;
  int max_ = 0, time_ = 0, x_ = 0, y_ = 0;
};
