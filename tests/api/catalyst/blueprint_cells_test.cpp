// Blueprint's unstructured topologies: cells of one shape, of several, and polyhedra.
#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "blueprint.h"

namespace {

using namespace insitu;

TEST_F(Blueprint, Hexahedra) {
  Box box;
  expect_attached(hexahedra(box));
  expect_box(box);
  expect_in_place();
}

TEST_F(Blueprint, InterleavedCoordinatesAreOneArray) {
  Box box;
  TestNode node = hexahedra(box);
  const auto n = static_cast<std::int64_t>(box.x.size());
  for (int a = 0; a < 3; ++a)
    node.set_strided(std::string("coordsets/coords/values/") + "xyz"[a], box.xyz, n, a, 3);
  expect_attached(node);
  expect_box(box);
  expect_in_place();
  std::size_t arrays = 0;
  for (const AuditEntry& e : session_.mesh("mesh").audit())
    arrays += std::string(e.name).find("points") != std::string::npos;
  EXPECT_EQ(arrays, 1u);
}

TEST_F(Blueprint, SmallIdsAreCopiedAndSaid) {
  Box box;
  std::vector<std::int16_t> ids(box.hexahedra.begin(), box.hexahedra.end());
  TestNode node = hexahedra(box);
  node.set("topologies/topo/elements/connectivity", ids);
  expect_attached(node);
  expect_box(box);
  EXPECT_EQ(copies(), 1u);
}

/// Each hexahedron as itself or as two wedges, with quads of the boundary between them, in numbers
/// of the host's own.
TEST_F(Blueprint, MixedCellsWithFlatOnes) {
  Box box;
  std::vector<std::int32_t> shapes, sizes, connectivity;
  std::vector<double> number;
  const auto add = [&](int shape, std::initializer_list<std::int64_t> ids, double value) {
    shapes.push_back(shape);
    sizes.push_back(int(ids.size()));
    for (const std::int64_t id : ids)
      connectivity.push_back(std::int32_t(id));
    number.push_back(value);
  };
  for (std::size_t c = 0; c < std::size_t(box.own_cells()); ++c) {
    const std::int64_t* v = &box.hexahedra[8 * c];
    if (c % 3 == 0)
      add(7, {v[0], v[1], v[2], v[3]}, -1);
    if (c % 2 == 0) {
      add(3, {v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7]}, double(c));
    } else {
      add(5, {v[0], v[2], v[1], v[4], v[6], v[5]}, double(c));
      add(5, {v[0], v[3], v[2], v[4], v[7], v[6]}, double(c));
    }
  }
  TestNode node = explicit_box(box, "unstructured");
  const std::string e = "topologies/topo/elements/";
  node.set(e + "shape", "mixed").set(e + "shape_map/hex", 3).set(e + "shape_map/wedge", 5);
  node.set(e + "shape_map/quad", 7).set(e + "shapes", shapes).set(e + "sizes", sizes);
  node.set(e + "connectivity", connectivity).set("fields/number/values", number);
  expect_attached(node);
  expect_box(box);
  expect_attached(node); // copies of the step before stay, and cells are not given again
  EXPECT_EQ(session_.mesh("mesh").commit().action, INSITU_KEEP);
  expect_box(box);
  EXPECT_NE(std::string(insitu_blueprint_left_out(blueprint_)).find("8 cells of shape quad"),
            std::string::npos)
      << insitu_blueprint_left_out(blueprint_);
  shapes[2] = 4;
  expect_refused(node, INSITU_ERROR_ARGUMENT,
                 "topologies/topo/elements/shapes of cell 2 is 4, which is not in shape_map");
}

/// The box by its faces, two of its cells glued to one that is no standard shape.
TEST_F(Blueprint, Polyhedra) {
  Box box;
  std::vector<std::int32_t> vertices, sizes, cell_faces, cell_sizes;
  std::map<std::set<std::int64_t>, int> known;
  constexpr int ring[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                              {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  for (std::size_t c = 0; c < std::size_t(box.own_cells()); ++c) {
    const std::int64_t* v = &box.hexahedra[8 * c];
    for (const auto& f : ring) {
      const auto [face, fresh] =
          known.try_emplace({v[f[0]], v[f[1]], v[f[2]], v[f[3]]}, int(known.size()));
      if (fresh) {
        for (const int i : f)
          vertices.push_back(std::int32_t(v[i]));
        sizes.push_back(4);
      }
      cell_faces.push_back(face->second);
    }
    cell_sizes.push_back(6);
  }
  // Cells 22 and 23, the last two, become one, without the face between them.
  const auto last = cell_faces.end() - 12;
  const std::set<int> of_first(last, last + 6);
  int between = -1;
  for (auto f = last + 6; f != cell_faces.end(); ++f)
    between = of_first.count(*f) > 0 ? *f : between;
  ASSERT_GE(between, 0);
  cell_faces.erase(std::remove(last, cell_faces.end(), between), cell_faces.end());
  cell_sizes.pop_back();
  cell_sizes.back() = 10;
  std::vector<double> number = box.number;
  number.pop_back();

  TestNode node = explicit_box(box, "unstructured");
  const std::string e = "topologies/topo/elements/", s = "topologies/topo/subelements/";
  node.set(e + "shape", "polyhedral").set(e + "connectivity", cell_faces);
  node.set(e + "sizes", cell_sizes).set(s + "shape", "polygonal");
  node.set(s + "connectivity", vertices).set(s + "sizes", sizes);
  node.set("fields/number/values", number);
  expect_attached(node);
  Mesh mesh = session_.mesh("mesh");
  const std::vector<double> points = points_of(box);
  const Samples f = mesh.sample("f", points), n = mesh.sample("number", points);
  for (std::size_t p = 0; p < f.size(); ++p) {
    EXPECT_NEAR(f(p), points[3 * p] + 2 * points[3 * p + 1] + 3 * points[3 * p + 2], 1e-12);
    EXPECT_EQ(n(p), double(std::min<std::size_t>(p, 22)));
  }
  ASSERT_EQ(attach(node), INSITU_OK);
  EXPECT_EQ(mesh.commit().action, INSITU_KEEP);
  cell_sizes.back() = 9; // a face is missing
  cell_faces.pop_back();
  ASSERT_EQ(attach(node.set(e + "connectivity", cell_faces)), INSITU_OK);
  try {
    mesh.commit();
    ADD_FAILURE() << "an open cell was taken";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("cell 22: is not closed"), std::string::npos)
        << error.what();
  }
}

} // namespace
