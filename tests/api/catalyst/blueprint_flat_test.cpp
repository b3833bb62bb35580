// Blueprint's meshes of two dimensions as flat meshes.
#include <string>
#include <vector>

#include "blueprint.h"

namespace {

using namespace insitu;

/// 4 x 3 squares, with a linear field and the cells' numbers.
struct Sheet {
  static constexpr int ni = 4, nj = 3;
  std::vector<double> x, y, f, number, axes[2];
  std::vector<std::int32_t> quads, triangles;
  Sheet() {
    for (int j = 0; j <= nj; ++j)
      for (int i = 0; i <= ni; ++i) {
        x.push_back(1 + 0.5 * i);
        y.push_back(2 + 0.25 * j);
        f.push_back(x.back() - 2 * y.back());
      }
    for (int i = 0; i <= ni; ++i)
      axes[0].push_back(1 + 0.5 * i);
    for (int j = 0; j <= nj; ++j)
      axes[1].push_back(2 + 0.25 * j);
    for (int j = 0; j < nj; ++j)
      for (int i = 0; i < ni; ++i) {
        const int v = i + (ni + 1) * j, w = v + ni + 1;
        quads.insert(quads.end(), {v, v + 1, w + 1, w});
        triangles.insert(triangles.end(), {v, v + 1, w + 1, v, w + 1, w});
        number.push_back(double(number.size()));
      }
  }
};

class FlatBlueprint : public Blueprint {
protected:
  static void add_fields(TestNode& node, Sheet& sheet) {
    node.set("fields/f/association", "vertex").set("fields/f/topology", "topo");
    node.set("fields/f/values", sheet.f);
    node.set("fields/number/association", "element").set("fields/number/topology", "topo");
    node.set("fields/number/values", sheet.number);
  }
  static TestNode explicit_sheet(Sheet& sheet, const char* topology) {
    TestNode node;
    add_topology(node, "explicit", topology);
    node.set("coordsets/coords/values/x", sheet.x).set("coordsets/coords/values/y", sheet.y);
    add_fields(node, sheet);
    return node;
  }
  void expect_sheet() {
    Mesh mesh = session_.mesh("mesh");
    std::vector<double> points;
    for (int j = 0; j < Sheet::nj; ++j)
      for (int i = 0; i < Sheet::ni; ++i)
        points.insert(points.end(), {1 + 0.5 * (i + 0.3), 2 + 0.25 * (j + 0.6), 5.0 * i});
    const Samples f = mesh.sample("f", points), number = mesh.sample("number", points);
    for (std::size_t p = 0; p < f.size(); ++p) {
      ASSERT_TRUE(f.found[p]) << p;
      EXPECT_NEAR(f(p), points[3 * p] - 2 * points[3 * p + 1], 1e-14);
      EXPECT_EQ(number(p), double(p));
    }
    for (const AuditEntry& e : mesh.audit()) // nothing else is a copy
      EXPECT_TRUE(e.borrowed || std::string(e.name).find("flat cells") != std::string::npos)
          << e.name;
  }
};

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
