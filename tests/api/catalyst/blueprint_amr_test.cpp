// Blueprint's domains of levels as patches of adaptive meshes, and nestsets.
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "blueprint.h"

namespace {

using namespace insitu;

/// A level of one block of four cells along each axis, and one of four finer ones along each in its
/// middle, with a layer of duplicates around; cells' values tell where they are.
struct TwoLevels {
  TwoLevels(std::size_t dimensions, TestNode& node) {
    const auto put = [&](const std::string& name, int level, int cells, double origin,
                         double spacing, std::vector<double>& values) {
      for_cells(dimensions, cells, [&](const std::array<int, 3>& at) {
        values.push_back(level * 1000 + at[0] + 10 * at[1] + 100 * at[2]);
      });
      add_uniform(node, name, std::vector(dimensions, cells), std::vector(dimensions, origin),
                  std::vector(dimensions, spacing));
      node.set(name + "state/level", level);
      node.set(name + "fields/v/association", "element").set(name + "fields/v/values", values);
    };
    put("a/", 0, 4, 0.0, 1.0, coarse);
    put("b/", 1, 6, 0.5, 0.5, fine); // from 1 to 3 without its layer
    for_cells(dimensions, 6, [&](const std::array<int, 3>& at) {
      ghosts.push_back(std::any_of(at.begin(), at.begin() + std::ptrdiff_t(dimensions),
                                   [](int i) { return i < 1 || i > 4; }));
    });
    node.set("b/fields/ascent_ghosts/association", "element");
    node.set("b/fields/ascent_ghosts/values", ghosts);
  }
  template <class F>
  static void for_cells(std::size_t dimensions, int cells, F&& f) {
    for (int k = 0; k < (dimensions == 3 ? cells : 1); ++k)
      for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i)
          f(std::array{i, j, k});
  }

  std::vector<double> coarse, fine;
  std::vector<std::int32_t> ghosts;
};

/// Points at the centres of a cell of the first patch and of two of the second one.
void expect_patches(Mesh mesh, const std::vector<double>& points, const std::vector<double>& values,
                    std::int64_t masked) {
  EXPECT_EQ(mesh.locate(points).pieces, (std::vector<std::int32_t>{0, 1, 1}));
  const Samples v = mesh.sample("v", points);
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(v(i), values[i], 1e-9);
  EXPECT_EQ(mesh.amr_info().masked, masked);
}

TEST_F(Blueprint, PatchesOfAnAdaptiveMesh) {
  TestNode node;
  const TwoLevels levels(3, node);
  expect_attached(node, true);
  expect_patches(session_.mesh("mesh"), {0.5, 0.5, 0.5, 1.25, 1.25, 1.25, 2.75, 1.25, 1.25},
                 {0, 1111, 1114}, 8);

  node.set("b/coordsets/coords/origin/x", 0.6);
  expect_refused(node, INSITU_ERROR_UNSUPPORTED, "a whole cell is needed", true);
  node.set("b/coordsets/coords/origin/x", 0.5).set("b/coordsets/coords/spacing/dy", 0.25);
  expect_refused(node, INSITU_ERROR_UNSUPPORTED, "a half or a quarter a level", true);
}

/// A window of a domain of TwoLevels, such as "b/", with another domain.
void add_window(TestNode& node, const std::string& domain, const char* type, int partner, int ratio,
                std::size_t dimensions) {
  const std::string set = domain + "nestsets/nest/",
                    window = set + "windows/window_" + std::to_string(partner) + "/";
  node.set(set + "association", "element").set(set + "topology", "topo");
  node.set(window + "domain_id", partner).set(window + "domain_type", type);
  for (std::size_t a = 0; a < dimensions; ++a)
    node.set(window + "ratio/" + "ijk"[a], ratio);
}

class Nestsets : public Blueprint, public testing::WithParamInterface<std::size_t> {};

TEST_P(Nestsets, AndSpacingsTellTheSame) {
  const std::size_t dimensions = GetParam();
  TestNode node;
  const TwoLevels levels(dimensions, node);
  node.set("a/state/domain_id", 0).set("b/state/domain_id", 1);
  add_window(node, "a/", "child", 1, 2, dimensions);
  add_window(node, "b/", "parent", 0, 2, dimensions);
  if (dimensions == 2) // as some solvers write of flat meshes
    node.set("b/nestsets/nest/windows/window_0/ratio/k", 1);
  expect_attached(node, true);
  Mesh mesh = session_.mesh("mesh");
  EXPECT_EQ(mesh.amr_info().masked, dimensions == 3 ? 8 : 4);
  const std::string window = "b/nestsets/nest/windows/window_0/";
  node.set(window + "ratio/i", 4).set(window + "ratio/j", 4).set(window + "ratio/k", 4);
  expect_refused(node, INSITU_ERROR_ARGUMENT,
                 "mesh/b/nestsets/nest/windows/window_0/ratio/i is 4, and "
                 "mesh/a/nestsets/nest/windows/window_1/ratio/i between the same levels is 2",
                 true);
  node.remove("a/nestsets");
  expect_refused(node, INSITU_ERROR_ARGUMENT,
                 "mesh/b/nestsets/nest/windows/window_0/ratio/i is 4, and the spacings of level "
                 "0 and level 1 make it 2",
                 true);
  node.set(window + "ratio/i", 2);
  expect_refused(node, INSITU_ERROR_UNSUPPORTED, "window_0/ratio/j is 4, and along i 2", true);
  node.set(window + "ratio/j", 3);
  expect_refused(node, INSITU_ERROR_UNSUPPORTED, "window_0/ratio/j is 3; a half or a quarter",
                 true);
  node.set("b/nestsets/nest/topology", "another"); // of which nothing is read
  expect_attached(node, true);
  node.set("b/nestsets/nest/topology", "topo").remove(window + "ratio/j");
  expect_refused(node, INSITU_ERROR_ARGUMENT, "window_0/ratio/j is missing", true);
  node.set(window + "domain_type", "sibling");
  expect_refused(node, INSITU_ERROR_ARGUMENT,
                 "window_0/domain_type is 'sibling'; parent or child is needed", true);
  node.remove(window + "ratio").set(window + "domain_type", "parent");
  expect_attached(node, true); // a window without a ratio tells none
}

INSTANTIATE_TEST_SUITE_P(OfDimensions, Nestsets, testing::Values(2, 3));

/// Between levels 1 and 3 a level lies of which no domain is here.
TEST_F(Blueprint, NestsetsOfLevelsThatAreNotHere) {
  TestNode node;
  std::vector<double> coarse(64, 1.0), fine(512, 2.0);
  add_uniform(node, "a/", {4, 4, 4}, {0.0, 0.0, 0.0}, {1.0, 1.0, 1.0});
  add_uniform(node, "b/", {8, 8, 8}, {1.0, 1.0, 1.0}, {0.125, 0.125, 0.125});
  node.set("a/state/level_id", 1).set("b/state/level_id", 3);
  node.set("a/fields/v/association", "element").set("a/fields/v/values", coarse);
  node.set("b/fields/v/association", "element").set("b/fields/v/values", fine);
  add_window(node, "a/", "parent", 7, 4, 3); // of level 0, of another process
  add_window(node, "a/", "child", 8, 2, 3);  // of level 2
  expect_attached(node, true);
  EXPECT_EQ(session_.mesh("mesh").locate(std::vector{1.3, 1.3, 1.3}).pieces[0], 1);
  add_window(node, "b/", "parent", 8, 2, 3);
  expect_refused(node, INSITU_ERROR_ARGUMENT,
                 "window_8/ratio/i is 2, and from level 1 to level 3 the spacings make 8", true);
  add_window(node, "b/", "parent", 8, 4, 3);
  expect_attached(node, true);
  add_window(node, "b/", "parent", 8, 8, 3);
  expect_refused(node, INSITU_ERROR_UNSUPPORTED,
                 "window_8/ratio/i is 8; from level to level 2 and 4 are supported", true);
  add_window(node, "b/", "parent", 8, 4, 3);
  node.set("b/state/domain_id", 3).set("a/state/domain_id", 8); // two levels apart, both here
  expect_refused(node, INSITU_ERROR_ARGUMENT,
                 "window_8/ratio/i is 4, and the spacings of level 1 and level 3 make it 8", true);
  node.remove("b/nestsets").set("a/state/level_id", 0); // whose parent is then coarser than all
  expect_refused(node, INSITU_ERROR_ARGUMENT,
                 "mesh/a/nestsets/nest/windows/window_7/domain_type is parent, and mesh/a is of "
                 "level 0, the coarsest",
                 true);
}

TEST_F(Blueprint, PatchesOfAFlatAdaptiveMesh) {
  TestNode node;
  const TwoLevels levels(2, node);
  expect_attached(node, true);
  expect_patches(session_.mesh("mesh"), {0.5, 0.5, 7, 1.25, 1.25, 0, 2.75, 1.25, -3},
                 {0, 1011, 1014}, 4);

  node.set("b/coordsets/coords/dims/k", 2).set("b/coordsets/coords/origin/z", 0.0);
  node.set("b/coordsets/coords/spacing/dz", 0.5);
  expect_refused(node, INSITU_ERROR_UNSUPPORTED, "has 3 dimensions, ", true);
}

} // namespace
