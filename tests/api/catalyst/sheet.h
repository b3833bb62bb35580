// A flat mesh of squares, which tests of Blueprint's meshes of two dimensions share.
#pragma once

#include <string>
#include <vector>

#include "blueprint.h"

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
    insitu::Mesh mesh = session_.mesh("mesh");
    std::vector<double> points;
    for (int j = 0; j < Sheet::nj; ++j)
      for (int i = 0; i < Sheet::ni; ++i)
        points.insert(points.end(), {1 + 0.5 * (i + 0.3), 2 + 0.25 * (j + 0.6), 5.0 * i});
    const insitu::Samples f = mesh.sample("f", points), number = mesh.sample("number", points);
    for (std::size_t p = 0; p < f.size(); ++p) {
      ASSERT_TRUE(f.found[p]) << p;
      EXPECT_NEAR(f(p), points[3 * p] - 2 * points[3 * p + 1], 1e-14);
      EXPECT_EQ(number(p), double(p));
    }
    for (const insitu::AuditEntry& e : mesh.audit()) // nothing else is a copy
      EXPECT_TRUE(e.borrowed || std::string(e.name).find("flat cells") != std::string::npos)
          << e.name;
  }
};
