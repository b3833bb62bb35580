// Blueprint's unstructured topologies: cells of one shape, of several, and polyhedra.
#include <algorithm>
#include <string>
#include <vector>

#include "blueprint.h"
#include "glued.h"

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

class BlueprintPolyhedra : public Blueprint {
protected:
  TestNode node_of(Glued& glued) {
    TestNode node = explicit_box(glued.box, "unstructured");
    glued.add_to(node);
    return node;
  }
  void expect_glued(const Glued& glued) {
    Mesh mesh = session_.mesh("mesh");
    const std::vector<double> points = points_of(glued.box);
    const Samples f = mesh.sample("f", points), n = mesh.sample("number", points);
    for (std::size_t p = 0; p < f.size(); ++p) {
      // Roundings of eight products and sums of numbers below 32.
      EXPECT_NEAR(f(p), points[3 * p] + 2 * points[3 * p + 1] + 3 * points[3 * p + 2], 1e-12);
      EXPECT_EQ(n(p), double(std::min<std::size_t>(p, 22)));
    }
  }
  void be_strict() {
    Options strict = options_;
    strict.strict = true;
    session_ = Session(strict);
  }
};

TEST_F(BlueprintPolyhedra, BySizes) {
  Glued glued;
  TestNode node = node_of(glued);
  expect_attached(node);
  expect_glued(glued);
  Mesh mesh = session_.mesh("mesh");
  ASSERT_EQ(attach(node), INSITU_OK);
  EXPECT_EQ(mesh.commit().action, INSITU_KEEP);
  glued.cell_sizes.back() = 9; // a face is missing
  glued.cell_faces.pop_back();
  ASSERT_EQ(attach(node.set(std::string(Glued::e) + "connectivity", glued.cell_faces)), INSITU_OK);
  try {
    mesh.commit();
    ADD_FAILURE() << "an open cell was taken";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("cell 22: is not closed"), std::string::npos)
        << error.what();
  }
}

/// Offsets are read where they are, with the last item's end or without it, beside sizes or alone;
/// sums of sizes would be copies, which a strict session refuses.
TEST_F(BlueprintPolyhedra, ByOffsetsInAStrictSession) {
  be_strict();
  Glued glued;
  const std::string e = Glued::e, s = Glued::s;
  for (const bool with_end : {false, true})
    for (const bool with_sizes : {true, false}) {
      TestNode node = node_of(glued);
      std::vector<std::int64_t> starts = Glued::offsets_of(glued.sizes, with_end);
      const std::vector<std::int64_t> long_starts = Glued::offsets_of(glued.cell_sizes, with_end);
      std::vector<std::int32_t> cell_starts(long_starts.begin(), long_starts.end());
      node.set(s + "offsets", starts).set(e + "offsets", cell_starts);
      if (!with_sizes)
        node.remove(s + "sizes").remove(e + "sizes");
      expect_attached(node);
      expect_glued(glued);
      EXPECT_EQ(copies(), 1u); // what the glued cell is cut into
      ASSERT_EQ(attach(node), INSITU_OK);
      EXPECT_EQ(session_.mesh("mesh").commit().action, INSITU_KEEP);
    }
  ASSERT_EQ(attach(node_of(glued)), INSITU_OK);
  try {
    session_.mesh("mesh").commit();
    ADD_FAILURE() << "sums were made";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), INSITU_ERROR_CONVERSION) << error.what();
  }
}

/// Ids may go on behind the last item's, where offsets alone do not tell its end.
TEST_F(BlueprintPolyhedra, ByOffsetsAndSizesWithinMoreIds) {
  Glued glued;
  const std::string e = Glued::e, s = Glued::s;
  TestNode node = node_of(glued);
  std::vector<std::int64_t> starts = Glued::offsets_of(glued.sizes, false),
                            cell_starts = Glued::offsets_of(glued.cell_sizes, false);
  glued.vertices.insert(glued.vertices.begin(), 3, 0);
  glued.vertices.insert(glued.vertices.end(), 4, 0);
  for (std::int64_t& start : starts)
    start += 3;
  node.set(s + "connectivity", glued.vertices).set(s + "offsets", starts);
  node.set(e + "offsets", cell_starts);
  expect_attached(node);
  expect_glued(glued);
  EXPECT_EQ(copies(), 2u); // the faces' offsets, and what the glued cell is cut into
}

TEST_F(BlueprintPolyhedra, OffsetsThatDoNotFitAreNamed) {
  Glued glued;
  const std::string e = Glued::e, s = Glued::s;
  const auto with = [&](std::vector<std::int64_t>& offsets) {
    TestNode node = node_of(glued);
    node.set(e + "offsets", offsets);
    return node;
  };
  std::vector<std::int64_t> cell_starts = Glued::offsets_of(glued.cell_sizes, true);
  ++cell_starts[2];
  expect_refused(with(cell_starts), INSITU_ERROR_UNSUPPORTED,
                 "elements/offsets of item 2 is 13; packed items are supported, of which this one "
                 "begins at 12");
  cell_starts[2] = -1;
  expect_refused(with(cell_starts), INSITU_ERROR_ARGUMENT, "elements/offsets of item 2 is -1");
  std::vector<std::int64_t> few = {0, 6};
  expect_refused(with(few), INSITU_ERROR_ARGUMENT, "elements/offsets has 2 numbers, sizes has 23");
  std::vector<std::int32_t> negative = glued.cell_sizes;
  negative[1] = -6;
  expect_refused(node_of(glued).set(e + "sizes", negative), INSITU_ERROR_ARGUMENT,
                 "elements/sizes of item 1 is -6");
  expect_refused(node_of(glued).remove(s + "sizes"), INSITU_ERROR_ARGUMENT,
                 "topologies/topo/subelements/sizes is missing");
  // Without sizes the library finds what lies nowhere.
  cell_starts = Glued::offsets_of(glued.cell_sizes, false);
  cell_starts.back() = 1000;
  ASSERT_EQ(attach(with(cell_starts).remove(e + "sizes")), INSITU_OK);
  EXPECT_THROW(session_.mesh("mesh").commit(), Error);
}

/// The glued cell as a polyhedron among hexahedra, wedges and a quad of the boundary: VTK's numbers
/// of shapes, or others; faces that are all quads, or of shapes that are told.
TEST_F(BlueprintPolyhedra, AmongCellsOfOtherShapes) {
  Glued glued;
  const std::string e = Glued::e, s = Glued::s;
  std::vector<std::int32_t> sizes, shapes, ids;
  std::vector<double> number;
  const auto add = [&](int shape, const std::vector<std::int64_t>& of_cell, double value) {
    shapes.push_back(shape);
    sizes.push_back(int(of_cell.size()));
    ids.insert(ids.end(), of_cell.begin(), of_cell.end());
    number.push_back(value);
  };
  for (std::size_t c = 0; c < 22; ++c) {
    const std::int64_t* v = &glued.box.hexahedra[8 * c];
    if (c == 0) // both of its sides stay whole
      add(9, {v[0], v[1], v[2], v[3]}, -1);
    if (c % 4 == 0) {
      add(13, {v[0], v[2], v[1], v[4], v[6], v[5]}, double(c));
      add(13, {v[0], v[3], v[2], v[4], v[7], v[6]}, double(c));
    } else {
      add(12, {v, v + 8}, double(c));
    }
  }
  add(42, {glued.cell_faces.end() - 10, glued.cell_faces.end()}, 22);
  const auto mixed = [&] {
    TestNode node = node_of(glued);
    node.set(e + "shape", "mixed").set(e + "shapes", shapes).set(e + "sizes", sizes);
    node.set(e + "connectivity", ids).set("fields/number/values", number);
    for (const auto& [name, code] :
         {std::pair{"quad", 9}, {"hex", 12}, {"wedge", 13}, {"polyhedral", 42}})
      node.set(e + "shape_map/" + name, code);
    return node;
  };
  TestNode node = mixed();
  expect_attached(node);
  expect_glued(glued);
  EXPECT_NE(std::string(insitu_blueprint_left_out(blueprint_)).find("1 cells of shape quad"),
            std::string::npos)
      << insitu_blueprint_left_out(blueprint_);
  ASSERT_EQ(attach(node), INSITU_OK);
  EXPECT_EQ(session_.mesh("mesh").commit().action, INSITU_KEEP);
  // Every point of a side between two cells has the lower one of both.
  const std::vector<double> sides{2.0, 2.2, 3.1, 3.0, 2.2, 3.1, 2.5, 2.5, 3.1, 4.0, 3.2, 3.3};
  EXPECT_EQ(session_.mesh("mesh").sample("number", sides).values,
            (std::vector<double>{0, 1, 1, 22}));
  node.set(s + "shape", "quad").remove(s + "sizes"); // which quads need not
  expect_attached(node);
  expect_glued(glued);
  std::vector<std::int32_t> face_shapes(glued.sizes.size(), 9);
  node = mixed();
  node.set(s + "shape", "mixed").set(s + "shapes", face_shapes).set(s + "shape_map/quad", 9);
  expect_attached(node);
  expect_glued(glued);
  ids.back() = 500;
  expect_refused(mixed(), INSITU_ERROR_ARGUMENT,
                 "elements/connectivity of cell 29 has the face 500, 0 to ");
  ids.back() = glued.cell_faces.back();
  sizes[2] = 5;
  expect_refused(mixed(), INSITU_ERROR_ARGUMENT, "elements has 5 ids of cell 2, which is a wedge");
  sizes[2] = 6;
  expect_refused(mixed().remove("topologies/topo/subelements"), INSITU_ERROR_ARGUMENT,
                 "topologies/topo/subelements is missing");
  expect_refused(mixed().set(s + "shape", "hex"), INSITU_ERROR_UNSUPPORTED,
                 "subelements/shape is 'hex'; faces are tri, quad, polygonal or mixed");
}

/// Elements that are a list of topologies of one shape each: their cells follow each other.
TEST_F(Blueprint, ListsOfTopologiesOfOneShape) {
  Box box;
  std::vector<std::int32_t> hexahedra(box.hexahedra.begin(), box.hexahedra.begin() + 8 * 10),
      wedges, quads;
  std::vector<double> number(box.number.begin(), box.number.begin() + 10);
  for (std::size_t c = 10; c < std::size_t(box.own_cells()); ++c) {
    const std::int64_t* v = &box.hexahedra[8 * c];
    for (const int i : {0, 2, 1, 4, 6, 5, 0, 3, 2, 4, 7, 6})
      wedges.push_back(std::int32_t(v[i]));
    number.insert(number.end(), 2, double(c));
  }
  for (const int i : {0, 1, 2, 3})
    quads.push_back(std::int32_t(box.hexahedra[std::size_t(i)]));
  number.push_back(-1);
  TestNode node = explicit_box(box, "unstructured");
  const std::string e = "topologies/topo/elements/";
  node.set(e + "a/shape", "hex").set(e + "a/connectivity", hexahedra);
  node.set(e + "b/shape", "wedge").set(e + "b/connectivity", wedges);
  node.set(e + "c/shape", "quad").set(e + "c/connectivity", quads);
  node.set("fields/number/values", number);
  expect_attached(node);
  expect_box(box);
  EXPECT_NE(std::string(insitu_blueprint_left_out(blueprint_)).find("1 cells of shape quad"),
            std::string::npos)
      << insitu_blueprint_left_out(blueprint_);
  ASSERT_EQ(attach(node), INSITU_OK);
  EXPECT_EQ(session_.mesh("mesh").commit().action, INSITU_KEEP);
  expect_refused(node.remove(e + "b/shape"), INSITU_ERROR_ARGUMENT,
                 "topologies/topo/elements/b/shape is missing");
  wedges.pop_back();
  node.set(e + "b/shape", "wedge").set(e + "b/connectivity", wedges);
  expect_refused(node, INSITU_ERROR_ARGUMENT,
                 "elements/b/connectivity has 167 ids, which are not whole cells of 6");
}

} // namespace
