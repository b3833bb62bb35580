#include <map>
#include <unordered_map>

#include "domain.h"
#include "lists.h"

namespace insitu::blueprint {

namespace {

using Ids = std::vector<std::int64_t>;
using Rings = std::vector<std::vector<std::size_t>>;

/// The faces of a shape with a volume by places among the cell's vertices.
const Rings& rings_of(const ShapeName& shape) {
  static const Rings none, tetrahedron{{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}},
      hexahedron{{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                 {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}},
      wedge{{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}},
      pyramid{{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  switch (shape.vtk) {
  case INSITU_TETRAHEDRON:
    return tetrahedron;
  case INSITU_HEXAHEDRON:
    return hexahedron;
  case INSITU_WEDGE:
    return wedge;
  case INSITU_PYRAMID:
    return pyramid;
  default:
    return none;
  }
}

/// Numbers faces, each by the set of its vertices, so that one between two cells is there once.
class FaceNumbers {
public:
  std::int64_t number_of(const Ids& ring) {
    Ids key = ring;
    std::sort(key.begin(), key.end());
    const auto [at, fresh] = numbers_.try_emplace(std::move(key), count());
    if (fresh) {
      vertices.insert(vertices.end(), ring.begin(), ring.end());
      offsets.push_back(static_cast<std::int64_t>(vertices.size()));
    }
    return at->second;
  }
  std::int64_t count() const { return static_cast<std::int64_t>(offsets.size()) - 1; }

  Ids vertices, offsets{0};

private:
  struct Hash {
    std::size_t operator()(const Ids& key) const {
      std::uint64_t h = key.size();
      for (const std::int64_t id : key)
        h = (h ^ static_cast<std::uint64_t>(id)) * 0x9E3779B97F4A7C15u, h ^= h >> 29;
      return static_cast<std::size_t>(h);
    }
  };
  std::unordered_map<Ids, std::int64_t, Hash> numbers_;
};

/// The faces that polyhedra list.
class Subelements {
public:
  explicit Subelements(const Node& node) : lists_(node, ids_each(node)) {}

  std::int64_t number_of(const CellLists::Cell& cell, std::int64_t face, FaceNumbers& numbers) {
    if (face < 0 || face >= lists_.count())
      cell.elements->at("connectivity")
          .refuse(INSITU_ERROR_ARGUMENT, "of cell " + std::to_string(cell.number) +
                                             " has the face " + std::to_string(face) + ", 0 to " +
                                             std::to_string(lists_.count() - 1) + " expected");
    lists_.read(face, ring_);
    return numbers.number_of(ring_);
  }

private:
  static int ids_each(const Node& node) {
    const Node shape_node = node.at("shape");
    const std::string name = shape_node.text();
    if (name == "mixed")
      return 0;
    const ShapeName* shape = shape_of(name);
    if (!shape || shape->dimensions != 2)
      shape_node.refuse(INSITU_ERROR_UNSUPPORTED,
                        "is '" + name + "'; faces are tri, quad, polygonal or mixed");
    return shape->ids;
  }

  IdLists lists_;
  Ids ring_;
};

} // namespace

void read_polyhedra_among_others(const Node& topology, Domain& d) {
  const CellLists lists(topology);
  Subelements subelements(topology.at("subelements"));
  d.kind = Domain::Kind::faces;
  d.cell_count = lists.count();
  FaceNumbers faces;
  Ids cell_faces, cell_offsets{0}, ring;
  std::vector<std::uint8_t> types;
  std::map<std::string, std::int64_t> lower;
  lists.for_each([&](const CellLists::Cell& cell) {
    types.push_back(cell.shape->vtk);
    if (cell.shape->is_polyhedron())
      for (const std::int64_t face : cell.ids)
        cell_faces.push_back(subelements.number_of(cell, face, faces));
    else if (cell.shape->dimensions < 3)
      ++lower[cell.shape->name];
    for (const auto& places : rings_of(*cell.shape)) {
      ring.clear();
      for (const std::size_t place : places)
        ring.push_back(cell.ids[place]);
      cell_faces.push_back(faces.number_of(ring));
    }
    cell_offsets.push_back(static_cast<std::int64_t>(cell_faces.size()));
  });
  d.faces.form = INSITU_FACES_CELLS;
  d.faces.face_count = faces.count();
  d.faces.cell_count = d.cell_count;
  d.faces.vertices = d.cell_copies->array(faces.vertices);
  d.faces.offsets = d.cell_copies->array(faces.offsets);
  d.faces.cell_faces = d.cell_copies->array(cell_faces);
  d.faces.cell_offsets = d.cell_copies->array(cell_offsets);
  for (insitu_array* a :
       {&d.faces.vertices, &d.faces.offsets, &d.faces.cell_faces, &d.faces.cell_offsets})
    a->converted = "cells of several shapes by their faces";
  hide_lower(topology.at("elements"), lower, types.data(), d);
}

} // namespace insitu::blueprint
