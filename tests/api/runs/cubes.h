#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <insitu/insitu.hpp>
#include <memory>
#include <vector>

#include "fixtures/arrays.h"
#include "fixtures/polyhedra.h"
#include "numerics/exact/cases.h"

/// The unit cube in cells of every kind, with uniform flows.
namespace runs {

using Point = std::array<double, 3>;
constexpr double speed = 0.2; ///< of the flow, along x

/// A way to give the cube with its fields to a mesh, at each step.
struct Cells {
  const char* name;
  std::function<void(insitu::Mesh&, int step)> give;
  bool by_cells;      ///< fields are constant in cells
  bool moves = false; ///< the vertices
};

/// What a solver keeps of an unstructured cube, or of one of its pieces.
struct Arrays {
  insitu::fixtures::SolverArrays mesh;
  std::vector<double> velocity, wind, rest, sinking, spread, salt;

  explicit Arrays(const insitu::test::TestMesh& from) : mesh(from) {}
  void put(const Point& x) {
    velocity.insert(velocity.end(), {speed, 0, 0});
    wind.insert(wind.end(), {0, 0.1, 0});
    rest.insert(rest.end(), {0, 0, 0});
    sinking.push_back(0.03);
    spread.push_back(0.0005);
    salt.push_back(x[0]);
  }
  template <class To> // a mesh or a piece
  void give_fields(To& to, bool cells) {
    const auto give = [&](const char* name, std::vector<double>& values, int components) {
      const insitu::Array array = insitu::Array(values).components(components);
      cells ? to.cell_field(name, array) : to.vertex_field(name, array);
    };
    give("velocity", velocity, 3);
    give("wind", wind, 3);
    give("rest", rest, 3);
    give("sinking", sinking, 1);
    give("spread", spread, 1);
    give("salt", salt, 1);
  }
  template <class To>
  void give(To& to, bool cells) {
    to.points(insitu::Array(mesh.points).components(3));
    to.mixed_cells(mesh.types, mesh.offsets, mesh.ids);
    const std::size_t n = mesh.points.size() / 3;
    if (cells)
      for (std::size_t c = 0; c < mesh.types.size(); ++c) {
        const auto first = std::size_t(mesh.offsets[c]), end = std::size_t(mesh.offsets[c + 1]);
        double x = 0;
        for (std::size_t v = first; v < end; ++v)
          x += mesh.points[3 * std::size_t(mesh.ids[v])] / double(end - first);
        put({x, 0, 0});
      }
    else
      for (std::size_t v = 0; v < n; ++v)
        put({mesh.points[3 * v], 0, 0});
    give_fields(to, cells);
  }
};

inline insitu::test::TestMesh cube(insitu::test::MeshKind kind, int size, std::uint64_t seed) {
  insitu::test::TestMesh mesh = insitu::test::make_mesh({.kind = kind, .size = size}, seed);
  for (auto& p : mesh.vertices)
    p = p / double(size);
  return mesh;
}

/// The same of hexahedra cut at planes, by their faces.
struct CutCube {
  insitu::fixtures::FaceArrays<> faces;
  Arrays fields;

  CutCube() : faces(unit()), fields(insitu::test::TestMesh{}) {
    for (std::size_t v = 0; v < faces.points.size(); v += 3)
      fields.put({faces.points[v], 0, 0});
  }
  static insitu::fixtures::FaceMesh unit() {
    insitu::fixtures::FaceMesh mesh = insitu::fixtures::cut_hexahedra(4, 4);
    for (auto& p : mesh.vertices)
      p = p / 4.0;
    return mesh;
  }
  void give(insitu::Mesh& mesh) {
    mesh.points(insitu::Array(faces.points).components(3));
    mesh.faces(faces.by_owner());
    fields.give_fields(mesh, false);
  }
  void set_salt() {
    for (std::size_t v = 0; v < fields.salt.size(); ++v)
      fields.salt[v] = faces.points[3 * v];
  }
};

/// The kinds of cells, for a run of so many cycles.
inline std::vector<Cells> all_cells(int cycles) {
  using insitu::test::MeshKind;
  std::vector<Cells> all;
  const auto keep = [](auto arrays) { return std::make_shared<decltype(arrays)>(arrays); };
  const auto once = [&](const char* name, MeshKind kind, bool by_cells) {
    const auto arrays = keep(Arrays(cube(kind, 4, 3)));
    all.push_back({name,
                   [arrays, by_cells](insitu::Mesh& mesh, int step) {
                     step ? mesh.changed(insitu::fields) : arrays->give(mesh, by_cells);
                   },
                   by_cells});
  };
  once("hexahedra", MeshKind::hexahedra, false);
  once("voxels", MeshKind::voxels, false);
  once("wedges", MeshKind::wedges, false);
  once("pyramids", MeshKind::pyramids, false);
  once("tetrahedra", MeshKind::tetrahedra, false);
  once("mixed cells", MeshKind::mixed, false);
  once("mixed cells, fields of cells", MeshKind::mixed, true);
  { // inner vertices go to and fro
    const auto still = keep(CutCube()), moving = keep(CutCube());
    const auto give = [](CutCube& cube, insitu::Mesh& mesh, int step) {
      if (!step)
        cube.give(mesh);
      else
        mesh.changed(insitu::geometry | insitu::fields);
    };
    all.push_back({"cut hexahedra",
                   [still, give](insitu::Mesh& mesh, int step) { give(*still, mesh, step); },
                   false});
    all.push_back({"moving cut hexahedra",
                   [still, moving, give](insitu::Mesh& mesh, int step) {
                     for (std::size_t v = 0; v < moving->faces.points.size(); v += 3) {
                       const double* const x = &still->faces.points[v];
                       const double bump = 16 * x[0] * (1 - x[0]) * x[1] * (1 - x[1]);
                       moving->faces.points[v] = x[0] + (step % 2 ? 0.02 : -0.02) * bump;
                     }
                     moving->set_salt();
                     give(*moving, mesh, step);
                   },
                   false, true});
  }
  { // the same in two pieces
    insitu::test::TestMesh halves[2] = {cube(MeshKind::hexahedra, 4, 3), {}};
    halves[1] = halves[0];
    for (int h = 0; h < 2; ++h)
      std::erase_if(halves[h].cells, [&](const auto& c) {
        int at = c.vertices[0] % 5;
        return (at < 2) == (h == 1);
      });
    const auto a = keep(Arrays(halves[0])), b = keep(Arrays(halves[1]));
    all.push_back({"two pieces",
                   [a, b](insitu::Mesh& mesh, int step) {
                     if (step) {
                       mesh.changed(insitu::fields);
                       return;
                     }
                     insitu::Piece first = mesh.piece(0), second = mesh.piece(1);
                     a->give(first, false);
                     b->give(second, false);
                   },
                   false});
  }
  { // inner vertices go to and fro
    const auto arrays = keep(Arrays(cube(MeshKind::wedges, 4, 3)));
    const auto other = keep(Arrays(cube(MeshKind::wedges, 4, 4)));
    all.push_back({"moving wedges",
                   [arrays, other](insitu::Mesh& mesh, int step) {
                     if (!step)
                       arrays->give(mesh, false);
                     else
                       std::swap_ranges(arrays->mesh.points.begin(), arrays->mesh.points.end(),
                                        other->mesh.points.begin());
                     for (std::size_t v = 0; v < arrays->salt.size(); ++v)
                       arrays->salt[v] = arrays->mesh.points[3 * v];
                     if (step)
                       mesh.changed(insitu::geometry | insitu::fields);
                   },
                   false, true});
  }
  { // other cells at every step
    const auto all_steps = std::make_shared<std::vector<Arrays>>();
    for (int s = 0; s <= cycles; ++s)
      all_steps->push_back(
          Arrays(cube(s % 2 ? MeshKind::tetrahedra : MeshKind::mixed, 4 + s % 3, 7)));
    all.push_back({"other cells at every step",
                   [all_steps](insitu::Mesh& mesh, int step) {
                     Arrays now = (*all_steps)[std::size_t(step)];
                     std::swap((*all_steps)[std::size_t(step)], now);
                     (*all_steps)[std::size_t(step)].give(mesh, false);
                   },
                   false});
  }
  for (const auto reconstruction :
       {insitu::Reconstruction::dual, insitu::Reconstruction::nearest}) {
    // A patch of 4^3 cells, a finer one over its middle.
    const auto patches = keep(std::array<Arrays, 2>{Arrays({}), Arrays({})});
    const bool nearest = reconstruction == insitu::Reconstruction::nearest;
    all.push_back({nearest ? "patches, nearest" : "patches, dual",
                   [patches, reconstruction](insitu::Mesh& mesh, int step) {
                     if (step) {
                       mesh.changed(insitu::fields);
                       return;
                     }
                     insitu::AmrLevels levels;
                     levels.count = 2;
                     levels.spacing = {0.25, 0.25, 0.25};
                     levels.reconstruction = reconstruction;
                     mesh.adaptive(levels);
                     for (int p = 0; p < 2; ++p) {
                       Arrays& a = (*patches)[std::size_t(p)];
                       const std::int64_t low = p ? 2 : 0;
                       for (int c = 0; c < 64; ++c)
                         a.put({(double(low + c % 4) + 0.5) * (p ? 0.125 : 0.25), 0, 0});
                       insitu::Piece piece = mesh.piece(p);
                       piece.patch(p, {low, low, low}, {4, 4, 4});
                       a.give_fields(piece, true);
                     }
                   },
                   nearest});
  }
  return all;
}

} // namespace runs
