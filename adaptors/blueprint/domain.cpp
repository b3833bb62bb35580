#include "domain.h"

#include <algorithm>
#include <cmath>

namespace insitu::blueprint {

namespace {

constexpr const char* axes[3] = {"x", "y", "z"};
constexpr const char* counts[3] = {"i", "j", "k"};

/// The most vertices or cells along an axis, so that products of three stay in range.
constexpr std::int64_t most = std::int64_t(1) << 20;

std::int64_t count_of(const Node& node) {
  const std::int64_t n = node.integer();
  if (n < 0 || n > most)
    node.refuse(INSITU_ERROR_ARGUMENT, "is " + std::to_string(n) + "; from 0 to " +
                                           std::to_string(most) + " are supported");
  return n;
}

int dimensions_of_elements(const Node& elements) {
  const std::string shape = elements.at("shape").text();
  if (shape != "mixed")
    return blueprint::dimensions_of(shape);
  int most_dimensions = 0;
  const Node map = elements.at("shape_map");
  for (std::int64_t i = 0; i < map.size(); ++i)
    most_dimensions = std::max(most_dimensions, blueprint::dimensions_of(map.child(i).name()));
  return most_dimensions;
}

/// How many dimensions the cells of a topology have, as far as the tree tells; -1: unknown.
int dimensions_of(const Node& mesh, const Node& topology) {
  const std::string type = topology.at("type").text();
  if (type == "points")
    return 0;
  if (type == "unstructured") {
    const Node elements = topology.at("elements");
    if (elements.find("shape"))
      return dimensions_of_elements(elements);
    if (elements.size() == 0 || !elements.child(0).find("shape"))
      (void)elements.at("shape"); // is missing
    int most_dimensions = -1;     // of a list of topologies of one shape each
    for (std::int64_t i = 0; i < elements.size(); ++i)
      most_dimensions = std::max(most_dimensions, dimensions_of_elements(elements.child(i)));
    return most_dimensions;
  }
  if (type == "structured")
    return topology.find("elements/dims/k") ? 3 : 2;
  const Node coordset = mesh.at("coordsets/" + topology.at("coordset").text());
  return coordset.find("dims/k") || coordset.find("values/z") ? 3 : 2;
}

Node chosen_topology(const Node& mesh, const std::string& wanted) {
  const Node all = mesh.at("topologies");
  if (!wanted.empty())
    return all.at(wanted);
  std::string others;
  for (const int wanted_dimensions : {3, 2}) {
    others.clear();
    for (std::int64_t i = 0; i < all.size(); ++i) {
      const Node topology = all.child(i);
      const int n = dimensions_of(mesh, topology);
      if (n == wanted_dimensions)
        return topology;
      others += (others.empty() ? "" : ", ") + topology.name() + " of " +
                (n < 0 ? "an unknown shape" : std::to_string(n) + " dimensions");
    }
  }
  all.refuse(INSITU_ERROR_UNSUPPORTED, "has no topology of cells with volume or area" +
                                           (others.empty() ? "" : ": " + others));
}

bool is_named_by_field(const Node& mesh, const std::string& topology) {
  const Node fields = mesh.find("fields");
  for (std::int64_t i = 0; i < fields.size(); ++i)
    if (const Node of = fields.child(i).find("topology");
        of && of.is_text() && of.text() == topology)
      return true;
  return false;
}

/// x, y, z, or x, y.
void require_axes(const Node& values, std::size_t count) {
  for (std::size_t a = 0; a < count; ++a)
    if (!values.find(axes[a]))
      values.refuse(INSITU_ERROR_UNSUPPORTED, std::string("has no ") + axes[a] +
                                                  "; cartesian coordinates x, y" +
                                                  (count == 3 ? ", z" : "") + " are needed");
}

void set_block(const std::array<std::int64_t, 3>& vertices, Domain& d) {
  d.kind = Domain::Kind::block;
  d.extent = vertices;
  d.vertex_count = vertices[0] * vertices[1] * vertices[2];
  d.cell_count = 1;
  d.block.dimensions = d.dimensions;
  for (std::size_t a = 0; a < 3; ++a) {
    d.block.vertices[a] = vertices[a];
    if (a < std::size_t(d.dimensions))
      d.cell_count *= std::max<std::int64_t>(vertices[a] - 1, 0);
  }
}

void read_uniform(const Node& coordset, Domain& d) {
  std::array<std::int64_t, 3> vertices{1, 1, 1};
  for (std::size_t a = 0; a < std::size_t(d.dimensions); ++a) {
    vertices[a] = count_of(coordset.at(std::string("dims/") + counts[a]));
    const Node origin = coordset.find(std::string("origin/") + axes[a]);
    const Node spacing = coordset.find(std::string("spacing/d") + axes[a]);
    d.origin[a] = origin ? origin.real() : 0.0;
    d.spacing[a] = spacing ? spacing.real() : 1.0;
  }
  set_block(vertices, d);
  d.block.kind = INSITU_BLOCK_UNIFORM;
  std::copy(d.origin.begin(), d.origin.end(), d.block.origin);
  std::copy(d.spacing.begin(), d.spacing.end(), d.block.spacing);
}

void read_rectilinear(const Node& coordset, Domain& d) {
  const Node values = coordset.at("values");
  require_axes(values, std::size_t(d.dimensions));
  std::array<std::int64_t, 3> vertices{1, 1, 1};
  for (std::size_t a = 0; a < std::size_t(d.dimensions); ++a) {
    const Node axis = values.at(axes[a]);
    d.block.coordinates[a] = reals(axis.leaf(), d.copies);
    vertices[a] = d.block.coordinates[a].count;
    if (vertices[a] > most)
      axis.refuse(INSITU_ERROR_ARGUMENT, "has " + std::to_string(vertices[a]) +
                                             " values; at most " + std::to_string(most) +
                                             " are supported");
    if (d.block.coordinates[a].type != d.block.coordinates[0].type)
      axis.refuse(INSITU_ERROR_UNSUPPORTED, "has another type than x");
  }
  set_block(vertices, d);
  d.block.kind = INSITU_BLOCK_RECTILINEAR;
}

/// x, y, z as one array or three; of a flat mesh x, y too.
std::vector<insitu_array> explicit_points(const Node& coordset, Domain& d) {
  const Node values = coordset.at("values");
  const std::size_t count = d.dimensions == 3 || values.find("z") ? 3 : 2;
  require_axes(values, count);
  std::vector<insitu_array> xyz;
  for (std::size_t a = 0; a < count; ++a) {
    const Node node = values.at(axes[a]);
    xyz.push_back(reals(node.leaf(), *d.point_copies));
    if (xyz.back().count != xyz[0].count)
      node.refuse(INSITU_ERROR_ARGUMENT, "has " + std::to_string(xyz.back().count) +
                                             " values, x has " + std::to_string(xyz[0].count));
    if (xyz.back().type != xyz[0].type)
      node.refuse(INSITU_ERROR_UNSUPPORTED, "has another type than x");
  }
  d.vertex_count = xyz[0].count;
  return joined(std::move(xyz));
}

void read_structured(const Node& topology, const Node& coordset, Domain& d) {
  d.points = explicit_points(coordset, d);
  const std::int64_t items = d.vertex_count;
  const Node dims = topology.at("elements/dims");
  std::array<std::int64_t, 3> vertices{1, 1, 1};
  for (std::size_t a = 0; a < std::size_t(d.dimensions); ++a)
    vertices[a] = count_of(dims.at(counts[a])) + 1;
  const Window window = read_window(dims, vertices, items);
  set_block(vertices, d);
  d.block.kind = INSITU_BLOCK_CURVILINEAR;
  if (!window.given && items != d.vertex_count)
    dims.refuse(INSITU_ERROR_ARGUMENT, "is of " + std::to_string(d.vertex_count) +
                                           " vertices, the coordset has " + std::to_string(items));
  if (window.given)
    for (insitu_array& a : d.points)
      a = block_of(a, vertices, window.offset, window.stride);
}

void take_prints(Domain& d) {
  for (const insitu_array* a :
       {&d.cells.connectivity, &d.cells.types, &d.cells.offsets, &d.faces.vertices,
        &d.faces.offsets, &d.faces.cell_faces, &d.faces.cell_offsets})
    d.topology_print = fingerprint(*a, d.topology_print);
  for (const auto* a : {&d.ghosts, &d.hidden_points, &d.global_ids[0], &d.global_ids[1]})
    if (*a)
      d.topology_print = fingerprint(**a, d.topology_print + 1);
  for (const insitu_array& a : d.points)
    d.geometry_print = fingerprint(a, d.geometry_print);
  if (d.block.kind == INSITU_BLOCK_RECTILINEAR)
    for (const insitu_array& a : d.block.coordinates)
      d.geometry_print = fingerprint(a, d.geometry_print);
}

} // namespace

Window read_window(const Node& dims, const std::array<std::int64_t, 3>& extent,
                   std::int64_t items) {
  Window out;
  out.stride = {1, extent[0], extent[0] * extent[1]};
  const Node offsets = dims.find("offsets"), strides = dims.find("strides");
  out.given = offsets || strides;
  std::int64_t least = 0, greatest = 0;
  for (const bool stride : {false, true})
    if (const Node& node = stride ? strides : offsets) {
      const Leaf leaf = node.leaf();
      if (leaf.count != 3 && !(leaf.count == 2 && extent[2] == 1))
        node.refuse(INSITU_ERROR_ARGUMENT, "has " + std::to_string(leaf.count) +
                                               " numbers; three are needed, or two of a "
                                               "flat block");
      for (std::int64_t a = 0; a < leaf.count; ++a) {
        const std::int64_t n = leaf.integer(a);
        if (std::abs(n) > most * most || n == INT64_MIN)
          node.refuse(INSITU_ERROR_ARGUMENT, "holds " + std::to_string(n));
        (stride ? out.stride : out.offset)[static_cast<std::size_t>(a)] = n;
      }
    }
  if (!out.given)
    return out;
  bool empty = false;
  for (std::size_t a = 0; a < 3; ++a) {
    const double reach = (double(out.offset[a]) + double(extent[a] - 1)) * double(out.stride[a]);
    if (std::abs(reach) > 4e18)
      dims.refuse(INSITU_ERROR_ARGUMENT, "reaches beyond all memory");
    const std::int64_t first = out.offset[a] * out.stride[a],
                       last = first + (extent[a] - 1) * out.stride[a];
    least += std::min(first, last);
    greatest += std::max(first, last);
    empty = empty || extent[a] < 1;
  }
  if (!empty && (least < 0 || greatest >= items))
    dims.refuse(INSITU_ERROR_ARGUMENT, "reaches from item " + std::to_string(least) + " to " +
                                           std::to_string(greatest) + ", there are " +
                                           std::to_string(items));
  return out;
}

std::vector<std::string> other_topologies(const Node& mesh) {
  std::vector<std::string> out;
  const Node all = mesh.find("topologies");
  if (all.size() < 2)
    return out;
  const Node chosen = chosen_topology(mesh, "");
  for (std::int64_t i = 0; i < all.size(); ++i) {
    const Node topology = all.child(i);
    try {
      if (topology.name() != chosen.name() && is_named_by_field(mesh, topology.name()) &&
          dimensions_of(mesh, topology) == dimensions_of(mesh, chosen))
        out.push_back(topology.name());
    } catch (const Error&) { // what is wrong with a topology that is not chosen was never read
    }
  }
  return out;
}

Domain read_domain(const Node& mesh, const std::string& wanted, const Node& channel) {
  Domain d;
  d.path = mesh.path();
  const Node topology = chosen_topology(mesh, wanted);
  d.topology = topology.name();
  if (const Node id = mesh.find("state/domain_id"))
    d.id = id.integer();
  d.dimensions = dimensions_of(mesh, topology) == 2 ? 2 : 3;
  const std::string type = topology.at("type").text();
  const std::string coordset_name = topology.at("coordset").text();
  const Node coordset = mesh.at("coordsets/" + coordset_name);
  const std::string has = coordset.at("type").text();
  const auto expect = [&](const char* needed) {
    if (has != needed)
      coordset.refuse(INSITU_ERROR_ARGUMENT, "is " + has + "; topology " + topology.name() +
                                                 " needs one that is " + needed);
  };
  if (type == "uniform") {
    expect("uniform");
    read_uniform(coordset, d);
  } else if (type == "rectilinear") {
    expect("rectilinear");
    read_rectilinear(coordset, d);
  } else if (type == "structured") {
    expect("explicit");
    read_structured(topology, coordset, d);
  } else if (type == "unstructured") {
    expect("explicit");
    d.points = explicit_points(coordset, d);
    read_cells(topology, d);
  } else {
    topology.refuse(INSITU_ERROR_UNSUPPORTED, "is of type " + type +
                                                  "; uniform, rectilinear, structured and "
                                                  "unstructured ones are supported");
  }
  read_fields(mesh, topology, channel, d);
  take_prints(d);
  return d;
}

} // namespace insitu::blueprint
