// Blueprint's polygons, which are cut into triangles.
#include <string>
#include <vector>

#include "sheet.h"

namespace {

using namespace insitu;

/// The sheet's squares, bent, as polygons: two pairs of them as hexagons, one as two triangles.
struct Polygons {
  Sheet sheet;
  std::vector<std::int32_t> ids, sizes;
  std::vector<std::int64_t> starts;
  std::vector<double> number;
  explicit Polygons(double bend = 0.05) {
    for (std::size_t v = 0; v < sheet.x.size(); ++v) {
      sheet.x[v] += bend * (v % 3 == 1) - bend * (v % 4 == 2);
      sheet.y[v] += 0.5 * bend * (v % 5 == 2);
      sheet.f[v] = sheet.x[v] - 2 * sheet.y[v];
    }
    for (int j = 0; j < Sheet::nj; ++j)
      for (int i = 0; i < Sheet::ni; ++i) {
        const int v = i + 5 * j, w = v + 5;
        if (j == 1 && i == 0)
          add({v, v + 1, v + 2, w + 2, w + 1, w});
        else if (j == 2 && i == 2) // clockwise
          add({v, w, w + 1, w + 2, v + 2, v + 1});
        else if (i == 3 && j == 0)
          add({v, v + 1, w + 1}), add({v, w + 1, w});
        else if (!(j == 1 && i == 1) && !(j == 2 && i == 3))
          add({v, v + 1, w + 1, w});
      }
  }
  void add(const std::vector<std::int32_t>& ring) {
    starts.push_back(std::int64_t(ids.size()));
    ids.insert(ids.end(), ring.begin(), ring.end());
    sizes.push_back(int(ring.size()));
    number.push_back(double(number.size()));
  }
  /// The first polygon with each vertex, which owns it.
  std::vector<double> owners() const {
    std::vector<double> out(sheet.x.size(), -1);
    for (std::size_t c = sizes.size(); c-- > 0;)
      for (std::int64_t i = starts[c]; i < starts[c] + sizes[c]; ++i)
        out[std::size_t(ids[std::size_t(i)])] = double(c);
    return out;
  }
};

class PolygonsOfBlueprint : public FlatBlueprint {
protected:
  static constexpr const char* elements = "topologies/topo/elements/";
  static TestNode node_of(Polygons& p) {
    TestNode node = explicit_sheet(p.sheet, "unstructured");
    const std::string e = elements;
    node.set(e + "shape", "polygonal").set(e + "connectivity", p.ids).set(e + "sizes", p.sizes);
    node.set("fields/number/values", p.number);
    return node;
  }
  /// f is linear in every polygon, at its middle, in the middles of its sides and at its vertices,
  /// which have the lowest polygon that holds them.
  void expect_polygons(const Polygons& p) {
    Mesh mesh = session_.mesh("mesh");
    std::vector<double> points, owners;
    const auto add = [&](double x, double y, double owner) {
      points.insert(points.end(), {x, y, 0.0});
      owners.push_back(owner);
    };
    const std::vector<double> of_vertices = p.owners();
    for (std::size_t v = 0; v < of_vertices.size(); ++v)
      add(p.sheet.x[v], p.sheet.y[v], of_vertices[v]);
    for (std::size_t c = 0; c < p.sizes.size(); ++c) {
      const auto n = std::size_t(p.sizes[c]);
      double x = 0, y = 0;
      for (std::size_t i = 0; i < n; ++i) {
        const auto a = std::size_t(p.ids[std::size_t(p.starts[c]) + i]),
                   b = std::size_t(p.ids[std::size_t(p.starts[c]) + (i + 1) % n]);
        x += p.sheet.x[a] / double(n);
        y += p.sheet.y[a] / double(n);
        add((p.sheet.x[a] + p.sheet.x[b]) / 2, (p.sheet.y[a] + p.sheet.y[b]) / 2, -1);
      }
      add(x, y, double(c));
    }
    const Samples f = mesh.sample("f", points), number = mesh.sample("number", points),
                  cell = mesh.sample("blueprint_cell", points);
    for (std::size_t i = 0; i < owners.size(); ++i) {
      // The middle of a side of the boundary may lie outside by a rounding.
      if (owners[i] < 0 && !f.found[i])
        continue;
      ASSERT_TRUE(f.found[i]) << points[3 * i] << " " << points[3 * i + 1];
      // Roundings of a sum of numbers below 16, through a map that is inverted.
      EXPECT_NEAR(f(i), points[3 * i] - 2 * points[3 * i + 1], 4e-14);
      if (owners[i] >= 0) {
        EXPECT_EQ(cell(i), owners[i]);
        EXPECT_EQ(number(i), owners[i]) << points[3 * i] << " " << points[3 * i + 1];
      }
    }
  }
};

TEST_F(PolygonsOfBlueprint, AreCutAboutTheirMeans) {
  Polygons p;
  TestNode node = node_of(p);
  expect_attached(node);
  expect_polygons(p);
  Mesh mesh = session_.mesh("mesh");
  EXPECT_EQ(mesh.commit().cells, 7 + 2 + 2 * 6);
  ASSERT_EQ(attach(node), INSITU_OK); // copies of the step before stay
  EXPECT_EQ(mesh.commit().action, INSITU_KEEP);
  for (double& x : p.sheet.x)
    x += 0.25;
  for (double& f : p.sheet.f)
    f += 0.25;
  ASSERT_EQ(attach(node), INSITU_OK);
  EXPECT_EQ(mesh.commit().action, INSITU_REFIT);
  expect_polygons(p);
  // By offsets, with the end and without it, and lists that lie apart.
  node.remove(std::string(elements) + "sizes").set(std::string(elements) + "offsets", p.starts);
  expect_attached(node);
  expect_polygons(p);
  p.starts.push_back(std::int64_t(p.ids.size()));
  node.set(std::string(elements) + "offsets", p.starts);
  expect_attached(node);
  p.starts.pop_back();
  expect_polygons(p);
  p.ids.insert(p.ids.begin(), 3, -5);
  for (std::int64_t& start : p.starts)
    start += 3;
  node.set(std::string(elements) + "connectivity", p.ids)
      .set(std::string(elements) + "sizes", p.sizes);
  node.set(std::string(elements) + "offsets", p.starts);
  expect_attached(node);
  expect_polygons(p);
}

/// Ghosts and hidden vertices are those of the polygons; parts of a polygon have no global ids.
TEST_F(PolygonsOfBlueprint, WithGhosts) {
  Polygons p;
  TestNode node = node_of(p);
  std::vector<std::int32_t> ghosts(p.sizes.size(), 0);
  ghosts[5] = 1; // the first hexagon
  ASSERT_EQ(p.sizes[5], 6);
  std::vector<std::int64_t> global(p.sizes.size(), 0);
  node.set("fields/ascent_ghosts/association", "element")
      .set("fields/ascent_ghosts/values", ghosts);
  node.set("fields/gid/association", "element").set("fields/gid/values", global);
  node.set("state/metadata/vtk_fields/gid/attribute_type", "GlobalIds");
  expect_attached(node);
  const auto at = std::size_t(p.ids[std::size_t(p.starts[5])]); // in its middle, by its first side
  const std::vector<double> point{p.sheet.x[at] + 0.3, p.sheet.y[at] + 0.1, 0};
  EXPECT_FALSE(session_.mesh("mesh").sample("f", point).found[0]);
  EXPECT_NE(std::string(insitu_blueprint_left_out(blueprint_)).find("fields/gid: polygons"),
            std::string::npos)
      << insitu_blueprint_left_out(blueprint_);
}

/// A domain of float32 with hexagons, and one of quads alone, which are none of its matter.
TEST_F(PolygonsOfBlueprint, AmongMixedCellsOfOtherDomains) {
  Polygons p(0.0), q(0.0);
  std::vector<float> x(p.sheet.x.begin(), p.sheet.x.end()), y(p.sheet.y.begin(), p.sheet.y.end()),
      f(p.sheet.f.begin(), p.sheet.f.end());
  std::vector<float> other_x(x), other_f(f);
  for (std::size_t v = 0; v < x.size(); ++v)
    other_x[v] += 2, other_f[v] += 2;
  std::vector<std::int32_t> shapes, lines{0, 1};
  for (const int size : p.sizes)
    shapes.push_back(size == 6 ? 7 : size == 4 ? 9 : 5);
  shapes.push_back(3);
  p.ids.insert(p.ids.end(), lines.begin(), lines.end());
  p.sizes.push_back(2);
  p.number.push_back(-1);
  TestNode node;
  const auto add = [&](const std::string& d, std::vector<float>& xs, std::vector<float>& fs,
                       std::vector<double>& number) {
    node.set(d + "coordsets/coords/type", "explicit").set(d + "topologies/topo/coordset", "coords");
    node.set(d + "topologies/topo/type", "unstructured");
    node.set(d + "coordsets/coords/values/x", xs).set(d + "coordsets/coords/values/y", y);
    node.set(d + "fields/f/association", "vertex").set(d + "fields/f/values", fs);
    node.set(d + "fields/number/association", "element").set(d + "fields/number/values", number);
  };
  add("a/", x, f, p.number);
  add("b/", other_x, other_f, q.sheet.number);
  const std::string e = std::string("a/") + elements;
  node.set(e + "shape", "mixed").set(e + "connectivity", p.ids).set(e + "sizes", p.sizes);
  node.set(e + "shapes", shapes);
  for (const auto& [name, number] :
       {std::pair{"polygonal", 7}, {"quad", 9}, {"tri", 5}, {"line", 3}})
    node.set(e + "shape_map/" + name, number);
  node.set(std::string("b/") + elements + "shape", "quad");
  node.set(std::string("b/") + elements + "connectivity", q.sheet.quads);
  expect_attached(node);
  EXPECT_NE(std::string(insitu_blueprint_left_out(blueprint_)).find("1 cells of shape line"),
            std::string::npos)
      << insitu_blueprint_left_out(blueprint_);
  Mesh mesh = session_.mesh("mesh");
  const std::vector<double> points{1.5, 2.375, 0, 2.75, 2.625, 0, 4.75, 2.625, 0, 3.0, 2.3, 0};
  const Samples values = mesh.sample("f", points), number = mesh.sample("number", points);
  for (std::size_t i = 0; i < values.size(); ++i) {
    ASSERT_TRUE(values.found[i]) << i;
    EXPECT_NEAR(values(i), points[3 * i] - 2 * points[3 * i + 1], 4e-6); // of float32
  }
  EXPECT_EQ(number.values, (std::vector<double>{5, 10, 11, 7})); // on the seam the first domain's
}

TEST_F(PolygonsOfBlueprint, ThatCannotBeAreNamed) {
  Polygons p;
  const std::string e = elements;
  p.ids[7] = 20;
  expect_refused(node_of(p), INSITU_ERROR_ARGUMENT,
                 "elements/connectivity of cell 1 has the id 20, 0 to 19 expected");
  p.ids[7] = 7;
  p.sizes.back() = 2;
  expect_refused(node_of(p), INSITU_ERROR_ARGUMENT,
                 "of cell 10 has 2 vertices; 3 or more expected");
  p.sizes.back() = 700;
  expect_refused(node_of(p), INSITU_ERROR_ARGUMENT, "elements/sizes of item 10 is 700");
  p.sizes.back() = 6;
  std::vector<std::int64_t> starts = p.starts;
  starts[2] = -4;
  TestNode node = node_of(p);
  node.set(e + "offsets", starts);
  expect_refused(node, INSITU_ERROR_ARGUMENT, "elements/offsets of item 2 is -4");
  expect_refused(node_of(p).remove(e + "sizes"), INSITU_ERROR_ARGUMENT,
                 "elements/sizes is missing");
  std::swap(p.ids[std::size_t(p.starts[5])], p.ids[std::size_t(p.starts[5]) + 2]);
  expect_refused(node_of(p), INSITU_ERROR_MESH,
                 "elements has the cell 5 of 6 vertices, which cannot be cut into triangles");
}

/// A comb, whose mean lies between its teeth, with vertices of its neighbours on its sides; cut by
/// diagonals, so that nothing is made but triangles.
TEST_F(PolygonsOfBlueprint, ThatAreNotSeenWholeFromTheirMeans) {
  std::vector<double> x, y, f;
  const auto vertex = [&](double at_x, double at_y) {
    x.push_back(at_x), y.push_back(at_y), f.push_back(at_x - 2 * at_y);
    return std::int32_t(x.size() - 1);
  };
  constexpr int teeth = 4;
  std::vector<std::int32_t> comb, ids, sizes;
  std::vector<std::vector<std::int32_t>> gaps;
  comb.push_back(vertex(0, 0));
  comb.push_back(vertex(2 * teeth - 1, 0));
  for (int t = teeth - 1; t >= 0; --t) { // from the right, with a vertex in the middle of each side
    comb.push_back(vertex(2 * t + 1, 3));
    comb.push_back(vertex(2 * t, 3));
    if (t == 0)
      break;
    const std::int32_t high = comb.back(), middle = vertex(2 * t, 2), low = vertex(2 * t, 1),
                       other = vertex(2 * t - 1, 1), top = std::int32_t(x.size());
    comb.insert(comb.end(), {middle, low, other});
    gaps.push_back({other, low, middle, high, top}); // whose last one comes next
  }
  const auto add = [&](const std::vector<std::int32_t>& ring) {
    ids.insert(ids.end(), ring.begin(), ring.end());
    sizes.push_back(int(ring.size()));
  };
  for (const bool turned : {false, true}) {
    ids.clear(), sizes.clear();
    add(turned ? std::vector<std::int32_t>(comb.rbegin(), comb.rend()) : comb);
    for (const auto& gap : gaps)
      add(gap);
    std::vector<double> number{0, 1, 2, 3};
    TestNode node;
    add_topology(node, "explicit", "unstructured");
    node.set("coordsets/coords/values/x", x).set("coordsets/coords/values/y", y);
    const std::string e = elements;
    node.set(e + "shape", "polygonal").set(e + "connectivity", ids).set(e + "sizes", sizes);
    node.set("fields/f/association", "vertex").set("fields/f/values", f);
    node.set("fields/number/association", "element").set("fields/number/values", number);
    expect_attached(node);
    std::vector<double> points, cells;
    for (int j = 0; j <= 12; ++j)
      for (int i = 0; i <= 4 * (2 * teeth - 1); ++i) {
        points.insert(points.end(), {0.25 * i, 0.25 * j, 0});
        const bool in_gap = i / 4 % 2 == 1 && i % 4 > 0 && j > 4; // gaps lie over 1 to 2, ...
        cells.push_back(in_gap ? double(teeth - 1 - i / 8) : 0.0);
      }
    Mesh mesh = session_.mesh("mesh");
    const Samples values = mesh.sample("f", points), of_cells = mesh.sample("number", points);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      ASSERT_TRUE(values.found[i]) << points[3 * i] << " " << points[3 * i + 1];
      EXPECT_NEAR(values(i), points[3 * i] - 2 * points[3 * i + 1], 4e-14);
      EXPECT_EQ(of_cells(i), cells[i]) << points[3 * i] << " " << points[3 * i + 1];
    }
  }
}

} // namespace
