#include "runs/netcdf/ugrid_topology.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "file_error.h"
#include "runs/netcdf/units.h"

namespace insitu_replay {

namespace {

using Variable = NetcdfFile::Variable;

bool is_topology(const NetcdfFile& file, const Variable& v) {
  return file.text(v, "cf_role") == "mesh_topology";
}

/// Whether the first of two coordinates says that it is y.
bool are_swapped(const NetcdfFile& file, const Variable& first, const Variable& second) {
  const auto is = [&](const Variable& v, const char* name, const char* axis) {
    return file.text(v, "standard_name") == name || file.text(v, "axis") == axis;
  };
  return (is_latitude(file, first) || is(first, "projection_y_coordinate", "Y")) &&
         (is_longitude(file, second) || is(second, "projection_x_coordinate", "X"));
}

/// Reads the nodes' coordinates.
void read_nodes(const NetcdfFile& file, UgridTopology& t) {
  const std::vector<std::string> names = file.words(*t.mesh, "node_coordinates");
  const std::size_t needed = t.dimension == 3 ? 3 : 2;
  if (names.size() < needed)
    file.fail(*t.mesh, "node_coordinates names " + std::to_string(names.size()) + " variables, " +
                           std::to_string(needed) + " expected");
  const Variable* axes[3] = {};
  for (std::size_t a = 0; a < names.size() && a < 3; ++a)
    axes[a] = &file.require(names[a], *t.mesh, "node_coordinates");
  if (are_swapped(file, *axes[0], *axes[1]))
    std::swap(axes[0], axes[1]);
  std::vector<double>* const to[3] = {&t.x, &t.y, &t.z};
  for (std::size_t a = 0; a < needed; ++a) {
    const Variable& v = *axes[a];
    if (v.dims.size() != 1 || (a > 0 && v.dims != axes[0]->dims))
      file.fail(v, "node coordinates have one dimension, and all the same");
    *to[a] = file.values(v);
    for (std::size_t i = 0; i < to[a]->size(); ++i)
      if (!std::isfinite((*to[a])[i]))
        file.fail(v, "node " + std::to_string(i) + " has no coordinate");
    t.parts.push_back(&v);
  }
  t.node_dim = axes[0]->dims[0];
  const bool angles[] = {is_longitude(file, *axes[0]), is_latitude(file, *axes[1])};
  if (angles[0] != angles[1])
    file.fail(*axes[angles[0] ? 1 : 0], "is in other units than '" + axes[angles[0] ? 0 : 1]->name +
                                            "', which is in degrees");
  t.geodetic = angles[0];
  if (t.dimension == 3 && (file.text(*axes[2], "positive") == "down" ||
                           file.text(*axes[2], "standard_name").starts_with("depth")))
    for (double& z : t.z)
      z = -z;
}

/// The dimension along which the cells go: as the mesh says it, or that of their coordinates, or
/// the first.
int cell_dim_of(const NetcdfFile& file, const UgridTopology& t, const Variable& ids,
                const std::string& location) {
  const std::string named = file.text(*t.mesh, (location + "_dimension").c_str());
  if (!named.empty()) {
    for (const int dim : ids.dims)
      if (file.name_of_dim(dim) == named)
        return dim;
    file.fail(*t.mesh,
              location + "_dimension is '" + named + "', which '" + ids.name + "' does not have");
  }
  const std::string coordinates = location + "_coordinates";
  for (const std::string& name : file.words(*t.mesh, coordinates.c_str()))
    if (const Variable* const v = file.find(name); v && v->dims.size() == 1)
      for (const int dim : ids.dims)
        if (dim == v->dims[0])
          return dim;
  return ids.dims[0];
}

std::string text_of(double number) {
  char text[40];
  std::snprintf(text, sizeof text, "%.15g", number);
  return text;
}

/// Reads the nodes of faces or volumes.
void read_cells(const NetcdfFile& file, UgridTopology& t) {
  const std::string location = t.dimension == 3 ? "volume" : "face",
                    key = location + "_node_connectivity", name = file.text(*t.mesh, key.c_str());
  if (name.empty())
    file.fail(*t.mesh, "has no " + key);
  const Variable& v = file.require(name, *t.mesh, key.c_str());
  if (v.dims.size() != 2)
    file.fail(v, "has " + std::to_string(v.dims.size()) + " dimensions; 2 expected, those of the " +
                     location + "s and of their nodes");
  t.parts.push_back(&v);
  t.cell_dim = cell_dim_of(file, t, v, location);
  const bool second = v.dims[1] == t.cell_dim && v.dims[0] != t.cell_dim;
  const std::size_t cells = file.length(t.cell_dim), most = file.length(v.dims[second ? 0 : 1]);
  const std::vector<double> ids = file.values(v);
  const std::optional<double> said = file.number(v, "start_index");
  const double start = said.value_or(0), last = start + double(t.nodes()) - 1;
  for (std::size_t c = 0; c < cells; ++c) {
    const std::size_t first = t.ids.size();
    for (std::size_t k = 0; k < most; ++k) {
      const double id = ids[second ? k * cells + c : c * most + k];
      if (std::isnan(id))
        continue; // no node: the cell has fewer
      if (!(id >= start && id <= last && id == std::floor(id)))
        file.fail(
            v, location + " " + std::to_string(c) + ": node " + std::to_string(k) + " has the id " +
                   text_of(id) + ", " + text_of(start) + " to " + text_of(last) + " expected" +
                   (said ? " by start_index" : "; start_index is missing, so ids count from 0"));
      const auto node = static_cast<std::int64_t>(id - start);
      if (t.dimension == 3 || t.ids.size() == first || t.ids.back() != node)
        t.ids.push_back(node); // some files repeat a node in the place of one that is not there
    }
    while (t.dimension == 2 && t.ids.size() > first + 1 && t.ids.back() == t.ids[first])
      t.ids.pop_back();
    const std::size_t nodes = t.ids.size() - first;
    if (t.dimension == 2 ? nodes < 3 : nodes < 4 || nodes == 7 || nodes > 8)
      file.fail(v, location + " " + std::to_string(c) + " has " + std::to_string(nodes) +
                       " nodes; " + (t.dimension == 2 ? "3 or more" : "4, 5, 6 or 8") +
                       " expected");
    t.offsets.push_back(std::int64_t(t.ids.size()));
  }
}

/// b - a, the short way round where these are longitudes.
double step(double a, double b, bool longitudes) {
  const double d = b - a;
  return longitudes ? d - 360 * std::round(d / 360) : d;
}

/// Twice the area of a triangle, in whose corners a step along x may be one over the date line.
double twice_area(const double (&x)[3], const double (&y)[3], bool longitudes) {
  return step(x[0], x[1], longitudes) * (y[2] - y[0]) -
         step(x[0], x[2], longitudes) * (y[1] - y[0]);
}

} // namespace

bool is_ugrid(const NetcdfFile& file) {
  return std::any_of(file.variables().begin(), file.variables().end(), [&](const Variable& v) {
    return is_topology(file, v) ||
           (!file.text(v, "mesh").empty() && !file.text(v, "location").empty());
  });
}

UgridTopology read_ugrid_topology(const NetcdfFile& file) {
  UgridTopology t;
  for (const Variable& v : file.variables()) {
    if (!is_topology(file, v))
      continue;
    const double dimension = file.number(v, "topology_dimension").value_or(0);
    if (!t.mesh && (dimension == 2 || dimension == 3)) {
      t.mesh = &v;
      t.dimension = int(dimension);
    } else {
      t.others.push_back(v.name);
    }
  }
  if (!t.mesh) {
    for (const Variable& v : file.variables())
      if (const std::string mesh = file.text(v, "mesh"); !mesh.empty() && !file.find(mesh))
        file.fail(v, "mesh names the variable '" + mesh + "', which is not in the file");
    throw FileError(file.path(), t.others.empty() ? "has no variable with cf_role mesh_topology"
                                                  : "mesh '" + t.others[0] +
                                                        "': topology_dimension 2 or 3 expected");
  }
  read_nodes(file, t);
  read_cells(file, t);
  return t;
}

void append_means(const UgridTopology& t, const CutFaces& faces, bool longitudes,
                  std::vector<double>& values) {
  for (const std::int64_t f : faces.cut) {
    const std::int64_t first = t.offsets[std::size_t(f)], end = t.offsets[std::size_t(f) + 1];
    const double base = values[std::size_t(t.ids[std::size_t(first)])];
    double sum = 0;
    for (std::int64_t i = first; i < end; ++i)
      sum += step(base, values[std::size_t(t.ids[std::size_t(i)])], longitudes);
    values.push_back(base + sum / double(end - first));
  }
}

CutFaces cut_faces(const NetcdfFile& file, const UgridTopology& t) {
  CutFaces out;
  for (std::size_t f = 0; f < t.cells(); ++f)
    if (t.offsets[f + 1] - t.offsets[f] > 4)
      out.cut.push_back(std::int64_t(f));
  std::vector<double> x = t.x, y = t.y;
  append_means(t, out, t.geodetic, x);
  append_means(t, out, false, y);
  const auto area = [&](std::int64_t a, std::int64_t b, std::int64_t c) {
    const std::size_t i = std::size_t(a), j = std::size_t(b), k = std::size_t(c);
    return twice_area({x[i], x[j], x[k]}, {y[i], y[j], y[k]}, t.geodetic);
  };
  std::int64_t made = std::int64_t(t.nodes());
  const auto add = [&](std::size_t face, std::initializer_list<std::int64_t> ring) {
    out.ids.insert(out.ids.end(), ring);
    out.offsets.push_back(std::int64_t(out.ids.size()));
    out.face.push_back(std::int64_t(face));
  };
  for (std::size_t f = 0; f < t.cells(); ++f) {
    const std::int64_t* const ring = t.ids.data() + t.offsets[f];
    const std::int64_t n = t.offsets[f + 1] - t.offsets[f];
    double sum = 0;
    for (std::int64_t i = 2; i < n; ++i)
      sum += area(ring[0], ring[i - 1], ring[i]);
    const bool turned = sum < 0;
    if (n == 3) {
      add(f, {ring[0], ring[turned ? 2 : 1], ring[turned ? 1 : 2]});
    } else if (n == 4) {
      add(f, {ring[0], ring[turned ? 3 : 1], ring[2], ring[turned ? 1 : 3]});
    } else {
      for (std::int64_t i = 0; i < n; ++i) {
        const std::int64_t a = ring[turned ? (i + 1) % n : i], b = ring[turned ? i : (i + 1) % n];
        if (!(area(made, a, b) > 0))
          throw FileError(file.path(), "mesh '" + t.mesh->name + "': face " + std::to_string(f) +
                                           " of " + std::to_string(n) +
                                           " vertices is not seen whole from the mean of them, so "
                                           "it cannot be cut into triangles");
        add(f, {made, a, b});
      }
      ++made;
    }
  }
  return out;
}

} // namespace insitu_replay
