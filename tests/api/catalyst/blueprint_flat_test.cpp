// Blueprint's meshes of two dimensions as flat meshes.
#include <string>
#include <vector>

#include "sheet.h"

namespace {

using namespace insitu;

TEST_F(FlatBlueprint, Blocks) {
  Sheet sheet;
  TestNode uniform;
  add_topology(uniform, "uniform", "uniform");
  uniform.set("coordsets/coords/dims/i", Sheet::ni + 1)
      .set("coordsets/coords/dims/j", Sheet::nj + 1);
  uniform.set("coordsets/coords/origin/x", 1.0).set("coordsets/coords/origin/y", 2.0);
  uniform.set("coordsets/coords/spacing/dx", 0.5).set("coordsets/coords/spacing/dy", 0.25);
  add_fields(uniform, sheet);
  expect_attached(uniform);
  expect_sheet();
  TestNode rectilinear;
  add_topology(rectilinear, "rectilinear", "rectilinear");
  rectilinear.set("coordsets/coords/values/x", sheet.axes[0]);
  rectilinear.set("coordsets/coords/values/y", sheet.axes[1]);
  add_fields(rectilinear, sheet);
  expect_attached(rectilinear);
  expect_sheet();
  TestNode structured = explicit_sheet(sheet, "structured");
  structured.set("topologies/topo/elements/dims/i", Sheet::ni);
  structured.set("topologies/topo/elements/dims/j", Sheet::nj);
  expect_attached(structured);
  expect_sheet();
  std::vector<std::int32_t> strides{1, Sheet::ni + 1}, none{0, 0};
  structured.set("topologies/topo/elements/dims/offsets", none);
  structured.set("topologies/topo/elements/dims/strides", strides);
  expect_attached(structured);
  expect_sheet();
}

TEST_F(FlatBlueprint, Cells) {
  Sheet sheet;
  TestNode quads = explicit_sheet(sheet, "unstructured");
  quads.set("topologies/topo/elements/shape", "quad");
  quads.set("topologies/topo/elements/connectivity", sheet.quads);
  expect_attached(quads);
  expect_sheet();
  TestNode triangles = explicit_sheet(sheet, "unstructured");
  triangles.set("topologies/topo/elements/shape", "tri").remove("fields/number");
  triangles.set("topologies/topo/elements/connectivity", sheet.triangles);
  expect_attached(triangles);
  const Samples f = session_.mesh("mesh").sample("f", std::vector<double>{1.75, 2.5, 9});
  EXPECT_NEAR(f(0), 1.75 - 5.0, 1e-14);
}

TEST_F(FlatBlueprint, MixedWithLines) {
  Sheet sheet;
  TestNode node = explicit_sheet(sheet, "unstructured");
  std::vector<std::int32_t> ids{0, 1, 0, 1, 6, 5, 1, 2, 7}, shapes{3, 9, 5}, sizes{2, 4, 3};
  sheet.number = {0, 1, 2};
  const std::string e = "topologies/topo/elements/";
  node.set("fields/number/values", sheet.number);
  node.set(e + "shape", "mixed").set(e + "connectivity", ids).set(e + "shapes", shapes);
  node.set(e + "sizes", sizes);
  node.set(e + "shape_map/line", 3).set(e + "shape_map/quad", 9).set(e + "shape_map/tri", 5);
  expect_attached(node);
  EXPECT_NE(std::string(insitu_blueprint_left_out(blueprint_)).find("1 cells of shape line"),
            std::string::npos)
      << insitu_blueprint_left_out(blueprint_);
  const Samples s =
      session_.mesh("mesh").sample("number", std::vector<double>{1.25, 2, 0, 1.75, 2.0625, 0});
  EXPECT_EQ(s.values, (std::vector<double>{1, 2}));
}

} // namespace
