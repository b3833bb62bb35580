// Blueprint nodes as meshes: blocks, domains, fields, ghosts, read in place.
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "blueprint.h"

namespace {

using namespace insitu;

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

TEST_F(Blueprint, DomainsArePieces) {
  Box box;
  TestNode both, first = uniform(box), second = uniform(box, {5, 2, 3});
  // The trees again, under names of domains.
  const auto put = [&](const std::string& name, double x) {
    add_uniform_box(both, name, box, {x, Box::at(1, 0), Box::at(2, 0)});
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

/// Hosts that hand domains over in another order: pieces are those of the ids, and nothing is built
/// anew. Where one domain has no id, their order is the tree's.
TEST_F(Blueprint, DomainsAreOrderedByTheirIds) {
  Box box, other;
  for (double& n : other.number)
    n += 1000;
  const auto tree_of = [&](const std::vector<std::string>& names) {
    TestNode node;
    for (const std::string& name : names) {
      const bool second = name == "west";
      add_uniform_box(node, name + "/", box, {second ? 5.0 : 1.0, 2.0, 3.0});
      node.set(name + "/fields/number/association", "element");
      node.set(name + "/fields/number/values", second ? other.number : box.number);
      node.set(name + "/state/domain_id", second ? 12 : 7);
    }
    return node;
  };
  const std::vector<double> points = {1.5, 2.1, 3.1, 5.5, 2.1, 3.1};
  expect_attached(tree_of({"east", "west"}));
  Mesh mesh = session_.mesh("mesh");
  for (const auto& names : {std::vector<std::string>{"west", "east"}, {"east", "west"}}) {
    ASSERT_EQ(attach(tree_of(names)), INSITU_OK) << insitu_blueprint_message();
    EXPECT_EQ(mesh.commit().action, INSITU_KEEP);
    EXPECT_EQ(mesh.locate(points).pieces, (std::vector<std::int32_t>{0, 1}));
    const Samples number = mesh.sample("number", points);
    EXPECT_EQ(number(0), 0);
    EXPECT_EQ(number(1), 1000);
  }
  expect_attached(tree_of({"west", "east"}).remove("west/state"));
  EXPECT_EQ(mesh.locate(points).pieces, (std::vector<std::int32_t>{1, 0}));
  expect_refused(tree_of({"west", "east"}).set("west/state/domain_id", 7), INSITU_ERROR_ARGUMENT,
                 "mesh/east/state/domain_id is 7, as mesh/west/state/domain_id is");
  expect_refused(tree_of({"west", "east"}).set("west/state/domain_id", "one"),
                 INSITU_ERROR_ARGUMENT, "mesh/west/state/domain_id holds no numbers");
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

TEST_F(Blueprint, WhatIsMissingIsNamedByItsPath) {
  Box box;
  expect_refused(hexahedra(box).remove("topologies/topo/coordset"), INSITU_ERROR_ARGUMENT,
                 "mesh/topologies/topo/coordset is missing");
  for (int again = 0; again < 2; ++again) // nothing of it is read
    try {
      session_.execute(0, 0.0);
      ADD_FAILURE() << "a mesh was executed that could not be given";
    } catch (const Error& e) {
      EXPECT_EQ(e.status(), INSITU_ERROR_MESH);
      EXPECT_NE(std::string(e.what()).find("mesh/topologies/topo/coordset is missing"),
                std::string::npos)
          << e.what();
    }
  expect_refused(hexahedra(box).remove("coordsets/coords/values/z"), INSITU_ERROR_UNSUPPORTED,
                 "mesh/coordsets/coords/values has no z");
  expect_refused(hexahedra(box).remove("topologies/topo/elements/connectivity"),
                 INSITU_ERROR_ARGUMENT, "mesh/topologies/topo/elements/connectivity is missing");
  expect_refused(hexahedra(box).set("topologies/topo/elements/shape", "line"),
                 INSITU_ERROR_UNSUPPORTED,
                 "no topology of cells with volume or area: topo of 1 dimensions");
  expect_refused(hexahedra(box).set("topologies/topo/elements/shape", "polygonal"),
                 INSITU_ERROR_ARGUMENT, "mesh/topologies/topo/elements/sizes is missing");
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
