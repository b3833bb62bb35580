// Blueprint nodes as meshes: every kind of coordset and topology, read in place.
#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "insitu/blueprint.h"
#include "insitu/insitu.hpp"

#include "nodes.h"

namespace {

using namespace insitu;

class Blueprint : public testing::Test {
protected:
  ~Blueprint() override { insitu_blueprint_release(&blueprint_); }

  insitu_status attach(const TestNode& node, bool adaptive = false) {
    insitu_blueprint_options options = insitu_blueprint_options_default();
    options.adaptive = adaptive;
    return insitu_blueprint_attach(session_.handle(), "mesh", node.get(), &options, &blueprint_);
  }
  void expect_attached(const TestNode& node, bool adaptive = false) {
    ASSERT_EQ(attach(node, adaptive), INSITU_OK) << insitu_blueprint_message();
    session_.mesh("mesh").commit();
  }
  /// The centres of the box's cells, shifted a little.
  static std::vector<double> points_of(const Box& box) {
    std::vector<double> out;
    for (int k = 0; k < box.n[2]; ++k)
      for (int j = 0; j < box.n[1]; ++j)
        for (int i = 0; i < box.n[0]; ++i)
          for (const double c : {Box::at(0, i) + 0.4, Box::at(1, j) + 0.3, Box::at(2, k) + 0.1})
            out.push_back(c);
    return out;
  }
  /// Every cell is found, f is linear, and the cells' numbers are theirs.
  void expect_box(const Box& box) {
    Mesh mesh = session_.mesh("mesh");
    const std::vector<double> points = points_of(box);
    const Samples f = mesh.sample("f", points), number = mesh.sample("number", points);
    ASSERT_EQ(f.size(), std::size_t(box.own_cells()));
    for (std::size_t p = 0; p < f.size(); ++p) {
      ASSERT_TRUE(f.found[p]) << "point " << p;
      // Roundings of eight products and sums of numbers below 32.
      EXPECT_NEAR(f(p), points[3 * p] + 2 * points[3 * p + 1] + 3 * points[3 * p + 2], 1e-12);
      EXPECT_EQ(number(p), double(p));
    }
  }
  void expect_in_place() {
    for (const AuditEntry& e : session_.mesh("mesh").audit())
      EXPECT_TRUE(e.borrowed) << e.name;
  }
  std::size_t copies() {
    std::size_t n = 0;
    for (const AuditEntry& e : session_.mesh("mesh").audit())
      n += !e.borrowed;
    return n;
  }
  void expect_refused(const TestNode& node, insitu_status status, const std::string& text,
                      bool adaptive = false) {
    EXPECT_EQ(attach(node, adaptive), status);
    EXPECT_NE(std::string(insitu_blueprint_message()).find(text), std::string::npos)
        << insitu_blueprint_message();
  }

  static void add_fields(TestNode& node, Box& box) {
    node.set("fields/f/association", "vertex").set("fields/f/topology", "topo");
    node.set("fields/f/values", box.f);
    node.set("fields/number/association", "element").set("fields/number/topology", "topo");
    node.set("fields/number/values", box.number);
  }
  static void add_topology(TestNode& node, const char* coordset, const char* topology) {
    node.set("coordsets/coords/type", coordset).set("topologies/topo/type", topology);
    node.set("topologies/topo/coordset", "coords");
  }
  static TestNode explicit_box(Box& box, const char* topology) {
    TestNode node;
    add_topology(node, "explicit", topology);
    node.set("coordsets/coords/values/x", box.x).set("coordsets/coords/values/y", box.y);
    node.set("coordsets/coords/values/z", box.z);
    add_fields(node, box);
    return node;
  }
  static TestNode hexahedra(Box& box) {
    TestNode node = explicit_box(box, "unstructured");
    node.set("topologies/topo/elements/shape", "hex");
    node.set("topologies/topo/elements/connectivity", box.hexahedra);
    return node;
  }
  static TestNode uniform(Box& box, std::array<double, 3> origin = {1, 2, 3}) {
    TestNode node;
    add_topology(node, "uniform", "uniform");
    for (std::size_t a = 0; a < 3; ++a) {
      node.set(std::string("coordsets/coords/dims/") + "ijk"[a], box.n[a] + 1);
      node.set(std::string("coordsets/coords/origin/") + "xyz"[a], origin[a]);
      node.set(std::string("coordsets/coords/spacing/d") + "xyz"[a], Box::at(a, 1) - Box::at(a, 0));
    }
    add_fields(node, box);
    return node;
  }

  Options options_ = [] {
    Options o;
    o.log = [](LogLevel, const char*) {};
    return o;
  }();
  Session session_{options_};
  insitu_blueprint blueprint_ = nullptr;
};

TEST_F(Blueprint, UniformBlocks) {
  Box box;
  expect_attached(uniform(box));
  expect_box(box);
  expect_in_place();
}

TEST_F(Blueprint, RectilinearBlocks) {
  Box box;
  TestNode node;
  add_topology(node, "rectilinear", "rectilinear");
  for (std::size_t a = 0; a < 3; ++a)
    node.set(std::string("coordsets/coords/values/") + "xyz"[a], box.axis[a]);
  add_fields(node, box);
  expect_attached(node);
  expect_box(box);
  expect_in_place();
}

TEST_F(Blueprint, StructuredBlocks) {
  Box box;
  TestNode node = explicit_box(box, "structured");
  for (std::size_t a = 0; a < 3; ++a)
    node.set(std::string("topologies/topo/elements/dims/") + "ijk"[a], box.n[a]);
  expect_attached(node);
  expect_box(box);
  expect_in_place();
}

/// A block within arrays that hold two layers of ghosts around it: dims, and the fields, have
/// offsets and strides.
TEST_F(Blueprint, StructuredBlocksWithinLargerArrays) {
  Box box({4, 3, 2}, 2);
  TestNode node = explicit_box(box, "structured");
  std::vector<std::int32_t> offsets = {2, 2, 2}, vertex_strides(3), cell_strides(3);
  for (int a = 0, v = 1, c = 1; a < 3; ++a) {
    node.set(std::string("topologies/topo/elements/dims/") + "ijk"[a], box.n[std::size_t(a)]);
    vertex_strides[std::size_t(a)] = v;
    cell_strides[std::size_t(a)] = c;
    v *= box.size[std::size_t(a)] + 1;
    c *= box.size[std::size_t(a)];
  }
  node.set("topologies/topo/elements/dims/offsets", offsets);
  node.set("topologies/topo/elements/dims/strides", vertex_strides);
  node.set("fields/f/offsets", offsets).set("fields/f/strides", vertex_strides);
  node.set("fields/number/offsets", offsets).set("fields/number/strides", cell_strides);
  expect_attached(node);
  expect_box(box);
  expect_in_place();
  offsets = {2, 2, 5}; // one layer too far
  expect_refused(node, INSITU_ERROR_ARGUMENT, "elements/dims reaches from item");
}

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

TEST_F(Blueprint, DomainsArePieces) {
  Box box;
  TestNode both, first = uniform(box), second = uniform(box, {5, 2, 3});
  // The trees again, under names of domains.
  const auto put = [&](const std::string& name, double x) {
    for (std::size_t a = 0; a < 3; ++a) {
      both.set(name + "coordsets/coords/dims/" + "ijk"[a], box.n[a] + 1);
      both.set(name + "coordsets/coords/origin/" + "xyz"[a], a == 0 ? x : Box::at(a, 0));
      both.set(name + "coordsets/coords/spacing/d" + "xyz"[a], Box::at(a, 1) - Box::at(a, 0));
    }
    both.set(name + "coordsets/coords/type", "uniform");
    both.set(name + "topologies/topo/type", "uniform")
        .set(name + "topologies/topo/coordset", "coords");
    both.set(name + "fields/number/association", "element");
    both.set(name + "fields/number/values", box.number);
  };
  put("domain_000000/", 1);
  put("domain_000001/", 5);
  both.set("domain_000001/fields/alone/association", "vertex");
  both.set("domain_000001/fields/alone/values", box.f);
  expect_attached(both);
  Mesh mesh = session_.mesh("mesh");
  const Locations at =
      mesh.locate(std::vector<double>{1.5, 2.1, 3.1, 5.5, 2.1, 3.1, 9.5, 2.1, 3.1});
  EXPECT_EQ(at.pieces, (std::vector<std::int32_t>{0, 1, -1}));
  EXPECT_NE(std::string(insitu_blueprint_left_out(blueprint_)).find("no field alone"),
            std::string::npos)
      << insitu_blueprint_left_out(blueprint_);
  both.remove("domain_000001"); // a piece fewer
  expect_attached(both);
  EXPECT_EQ(mesh.locate(std::vector<double>{5.5, 2.1, 3.1}).pieces[0], -1);
  expect_attached(TestNode()); // and none
  ASSERT_EQ(attach(TestNode()), INSITU_OK);
  EXPECT_EQ(mesh.commit().action, INSITU_KEEP);
  EXPECT_EQ(mesh.locate(std::vector<double>{1.5, 2.1, 3.1}).pieces[0], -1);
}

TEST_F(Blueprint, WhatDidNotChangeIsKept) {
  Box box;
  const TestNode node = hexahedra(box);
  expect_attached(node);
  ASSERT_EQ(attach(node), INSITU_OK);
  EXPECT_EQ(session_.mesh("mesh").commit().action, INSITU_KEEP);
  for (double& x : box.x)
    x += 1.0;
  ASSERT_EQ(attach(node), INSITU_OK);
  EXPECT_EQ(session_.mesh("mesh").commit().action, INSITU_REFIT);
  EXPECT_EQ(session_.mesh("mesh").locate(std::vector<double>{1.5, 2.1, 3.1}).pieces[0], -1);
  std::swap_ranges(box.hexahedra.begin(), box.hexahedra.begin() + 8, box.hexahedra.begin() + 8);
  ASSERT_EQ(attach(node), INSITU_OK);
  EXPECT_EQ(session_.mesh("mesh").commit().action, INSITU_REBUILD);
  EXPECT_EQ(session_.mesh("mesh").locate(std::vector<double>{2.5, 2.1, 3.1}).cells[0], 1);
}

TEST_F(Blueprint, GhostsByAllConventions) {
  Box box;
  std::vector<std::int32_t> ascent(box.number.size(), 0);
  std::vector<std::uint8_t> vtk(box.number.size(), 0);
  ascent[0] = vtk[0] = 1;
  const std::vector<double> point = {1.4, 2.3, 3.1};
  const auto expect_ghost = [&](const char* name, const char* metadata) {
    TestNode node = hexahedra(box);
    node.set(std::string("fields/") + name + "/association", "element");
    if (ascent.size() == vtk.size() && std::string(name) == "ascent_ghosts")
      node.set(std::string("fields/") + name + "/values", ascent);
    else
      node.set(std::string("fields/") + name + "/values", vtk);
    if (*metadata)
      node.set(std::string("state/metadata/vtk_fields/") + name + "/attribute_type", metadata);
    expect_attached(node);
    EXPECT_FALSE(session_.mesh("mesh").locate(point).found[0]) << name;
  };
  expect_attached(hexahedra(box));
  EXPECT_TRUE(session_.mesh("mesh").locate(point).found[0]);
  expect_ghost("ascent_ghosts", "");
  expect_ghost("vtkGhostType", "");
  expect_ghost("levels_of_ghosts", "Ghosts");
}

TEST_F(Blueprint, GlobalIdsByMetadata) {
  Box box;
  std::vector<std::int64_t> ids;
  for (std::int64_t c = 0; c < box.own_cells(); ++c)
    ids.push_back(1000 + 3 * c);
  TestNode node = hexahedra(box);
  node.set("fields/gid/association", "element").set("fields/gid/values", ids);
  node.set("state/metadata/vtk_fields/gid/attribute_type", "GlobalIds");
  expect_attached(node);
  LocateOptions everywhere;
  everywhere.everywhere = true;
  const Locations at =
      session_.mesh("mesh").locate(std::vector<double>{1.4, 2.3, 3.1, 2.4, 2.3, 3.1}, everywhere);
  EXPECT_EQ(at.global_cells, (std::vector<std::int64_t>{1000, 1003}));
}

TEST_F(Blueprint, VectorsOfAnyLayout) {
  Box box;
  const auto n = static_cast<std::int64_t>(box.x.size());
  TestNode node = hexahedra(box);
  node.set("fields/apart/association", "vertex").set("fields/together/association", "vertex");
  node.set("fields/apart/values/u", box.x).set("fields/apart/values/v", box.y);
  node.set("fields/apart/values/w", box.z);
  for (int a = 0; a < 3; ++a)
    node.set_strided(std::string("fields/together/values/") + "uvw"[a], box.xyz, n, a, 3);
  expect_attached(node);
  for (const char* name : {"apart", "together"}) {
    const Samples v = session_.mesh("mesh").sample(name, std::vector<double>{2.4, 2.8, 3.3});
    ASSERT_EQ(v.components, 3);
    EXPECT_NEAR(v(0, 0), 2.4, 1e-14); // roundings of numbers below 4
    EXPECT_NEAR(v(0, 1), 2.8, 1e-14);
    EXPECT_NEAR(v(0, 2), 3.3, 1e-14);
  }
  expect_in_place();
}

/// A level of one block of 4^3 cells, and one of 4^3 finer ones in its middle, with a layer of
/// duplicates around.
TEST_F(Blueprint, PatchesOfAnAdaptiveMesh) {
  TestNode node;
  std::vector<double> coarse, fine;
  std::vector<std::int32_t> ghosts;
  const auto put = [&](const std::string& name, int level, int cells, double origin, double spacing,
                       std::vector<double>& values) {
    for (int k = 0; k < cells; ++k)
      for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i)
          values.push_back(level * 1000 + i + 10 * j + 100 * k);
    for (std::size_t a = 0; a < 3; ++a) {
      node.set(name + "coordsets/coords/dims/" + "ijk"[a], cells + 1);
      node.set(name + "coordsets/coords/origin/" + "xyz"[a], origin);
      node.set(name + "coordsets/coords/spacing/d" + "xyz"[a], spacing);
    }
    node.set(name + "coordsets/coords/type", "uniform");
    node.set(name + "topologies/topo/type", "uniform");
    node.set(name + "topologies/topo/coordset", "coords").set(name + "state/level", level);
    node.set(name + "fields/v/association", "element").set(name + "fields/v/values", values);
  };
  put("a/", 0, 4, 0.0, 1.0, coarse);
  put("b/", 1, 6, 0.5, 0.5, fine); // from 1 to 3 without its layer
  for (int c = 0; c < 216; ++c) {
    const int i = c % 6, j = c / 6 % 6, k = c / 36;
    ghosts.push_back(i < 1 || i > 4 || j < 1 || j > 4 || k < 1 || k > 4);
  }
  node.set("b/fields/ascent_ghosts/association", "element");
  node.set("b/fields/ascent_ghosts/values", ghosts);
  expect_attached(node, true);
  Mesh mesh = session_.mesh("mesh");
  const std::vector<double> points = {0.5, 0.5, 0.5, 1.25, 1.25, 1.25, 2.75, 1.25, 1.25};
  const Locations at = mesh.locate(points);
  EXPECT_EQ(at.pieces, (std::vector<std::int32_t>{0, 1, 1}));
  const Samples v = mesh.sample("v", points); // cells' centres
  EXPECT_NEAR(v(0), 0, 1e-12);
  EXPECT_NEAR(v(1), 1111, 1e-9);
  EXPECT_NEAR(v(2), 1114, 1e-9);
  EXPECT_EQ(mesh.amr_info().masked, 8);

  node.set("b/coordsets/coords/origin/x", 0.6);
  expect_refused(node, INSITU_ERROR_UNSUPPORTED, "a whole cell is needed", true);
  node.set("b/coordsets/coords/origin/x", 0.5).set("b/coordsets/coords/spacing/dy", 0.25);
  expect_refused(node, INSITU_ERROR_UNSUPPORTED, "a half or a quarter a level", true);
}

TEST_F(Blueprint, WhatIsMissingIsNamedByItsPath) {
  Box box;
  expect_refused(hexahedra(box).remove("topologies/topo/coordset"), INSITU_ERROR_ARGUMENT,
                 "mesh/topologies/topo/coordset is missing");
  expect_refused(hexahedra(box).remove("coordsets/coords/values/z"), INSITU_ERROR_UNSUPPORTED,
                 "mesh/coordsets/coords/values has no z");
  expect_refused(hexahedra(box).remove("topologies/topo/elements/connectivity"),
                 INSITU_ERROR_ARGUMENT, "mesh/topologies/topo/elements/connectivity is missing");
  expect_refused(hexahedra(box).set("topologies/topo/elements/shape", "quad"),
                 INSITU_ERROR_UNSUPPORTED,
                 "no topology of cells with volume: topo of 2 dimensions");
  expect_refused(hexahedra(box).set("topologies/topo/elements/connectivity", 1.5),
                 INSITU_ERROR_ARGUMENT, "connectivity holds no integers");
  std::vector<double> few(3);
  expect_refused(hexahedra(box).set("fields/f/values", few), INSITU_ERROR_FIELD,
                 "mesh/fields/f/values has 3 items, the topology has 60 vertices");
  expect_refused(hexahedra(box).set("coordsets/coords/values/y", few), INSITU_ERROR_ARGUMENT,
                 "mesh/coordsets/coords/values/y has 3 values, x has 60");
  expect_refused(hexahedra(box).set("fields/f/association", "edge"), INSITU_ERROR_ARGUMENT,
                 "mesh/fields/f/association is 'edge'");
  EXPECT_EQ(insitu_blueprint_attach(session_.handle(), "mesh", nullptr, nullptr, &blueprint_),
            INSITU_ERROR_ARGUMENT);
  expect_attached(hexahedra(box)); // and the mesh goes on
  expect_box(box);
}

} // namespace
