// insitu-replay on netCDF by the UGRID conventions: flat meshes and volumes.
#include "replay.h"
#include "ugrid_files.h"

namespace {

struct Ugrid : Replay {
  void probes(const std::string& points, const std::string& more = "") const {
    put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: [" + points + "]}\n" + more);
  }
  std::vector<Row> replay(const std::string& arguments) const {
    const Outcome o = run("--scene scene.yaml --out out " + arguments);
    EXPECT_EQ(o.code, 0) << o.err;
    return rows("out/g.csv");
  }
  /// A lattice with the field temp = 1 + 2 x - 3 y + 100 t of nodes and, of faces, number = face +
  /// 1000 t.
  void write_lattice(const std::string& name, const UgridLattice& lattice, int format) const {
    UgridFile out(path(name), lattice, 2, "hours since 2001-02-03 04:00", format);
    const int temp = out.field("temp", {out.time, out.node}, "node", NC_FLOAT),
              number = out.field("number", {out.time, out.face}, "face", NC_INT),
              depth = out.field("depth", {out.node}, "node");
    out.begin({0, 3});
    out.file.put(temp, out.of_nodes(2, [](double x, double y, double t) {
      return 1 + 2 * x - 3 * y + 100 * t;
    }));
    std::vector<double> numbers;
    for (std::size_t i = 0; i < 2 * lattice.faces.size(); ++i)
      numbers.push_back(double(i % lattice.faces.size()) + (i < lattice.faces.size() ? 0 : 1000));
    out.file.put(number, numbers);
    out.file.put(depth, out.of_nodes(1, [](double x, double y, double) { return x + y; }));
  }
};

} // namespace

/// Coordinates and values of the lattice are floats without rounding, so linear fields are met to
/// the rounding of doubles.
TEST_F(Ugrid, TrianglesAndQuads) {
  for (const int start : {0, 1})
    for (const bool second : {false, true}) {
      UgridLattice lattice;
      lattice.start = start;
      lattice.faces_second = second;
      lattice.by_centres = start == 1;
      lattice.repeats = start == 1;
      lattice.make();
      write_lattice("mesh.nc", lattice, second ? NC_NETCDF4 : NC_64BIT_OFFSET);
      std::string points;
      for (std::size_t f = 0; f < lattice.faces.size(); ++f)
        points += (f ? ", " : "") + text_of(lattice.centre(f)[0], lattice.centre(f)[1], 0);
      probes(points);
      const std::vector<Row> table = replay("mesh.nc");
      const std::size_t n = lattice.faces.size();
      ASSERT_EQ(table.size(), 2 * n);
      for (std::size_t i = 0; i < 2 * n; ++i) {
        const auto [x, y] = lattice.centre(i % n);
        const double t = i < n ? 0 : 1;
        EXPECT_NEAR(table[i].at("temp"), 1 + 2 * x - 3 * y + 100 * t, 1e-12);
        EXPECT_NEAR(table[i].at("depth"), x + y, 1e-12);
        EXPECT_EQ(table[i].at("number"), double(i % n) + 1000 * t);
        EXPECT_EQ(table[i].at("cell"), double(i % n));
        EXPECT_EQ(table[i].at("time"), 3 * 3600 * t);
      }
    }
}

/// Degrees say that the frame is geodetic: a drifter along a circle of latitude, over the date
/// line, by metres per second. The rate of longitude is u / ((N + h) cos(latitude)).
TEST_F(Ugrid, LongitudesAndLatitudesAreGeodetic) {
  UgridLattice lattice;
  lattice.x0 = 178;
  lattice.y0 = 59;
  lattice.degrees = true;
  lattice.make();
  {
    UgridFile out(path("sea.nc"), lattice, 3, "days since 1990-01-01");
    const int u = out.field("u", {out.time, out.node}, "node"),
              v = out.field("v", {out.time, out.node}, "node");
    out.file.say(u, {"standard_name", "eastward_sea_water_velocity"});
    out.file.say(v, {"standard_name", "northward_sea_water_velocity"});
    // Longitudes from -180 on: the second column of nodes is beyond the date line.
    for (auto& p : lattice.nodes)
      p[0] = p[0] >= 180 ? p[0] - 360 : p[0];
    out.begin({0, 0.25, 0.5});
    out.file.put(u, std::vector<double>(3 * lattice.nodes.size(), 2.0));
    out.file.put(v, std::vector<double>(3 * lattice.nodes.size(), 0.0));
  }
  put("scene.yaml", "insitu: 1\ntracers:\n  - {name: drift, velocity: sea_water_velocity, seeds: "
                    "[[179.5, 60.5, 0]]}\n");
  const Outcome o = run("--scene scene.yaml --out out sea.nc");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Row> table = rows("out/drift.csv");
  ASSERT_GE(table.size(), 3u) << contents(path("out/drift.csv"));
  const double latitude = 60.5 * std::acos(-1.0) / 180,
               radius = prime_vertical(latitude) * std::cos(latitude);
  for (std::size_t i = 0; i < 3; ++i) {
    const double time = 21600 * double(i), turned = time * 2 / radius * 180 / std::acos(-1.0);
    EXPECT_EQ(table[i].at("time"), time);
    // The tolerance allows an error of 1e-6 m a second: 8e-7 degrees in the end.
    EXPECT_NEAR(std::remainder(table[i].at("x") - 179.5 - turned, 360.0), 0, 8e-7);
    EXPECT_NEAR(table[i].at("y"), 60.5, 4e-7);
  }
}

/// A hexagon amid quads is cut about its centre; what it was is told.
TEST_F(Ugrid, PolygonsAreCutIntoTriangles) {
  UgridLattice lattice = hexagon_and_quad();
  write_lattice("mesh.nc", lattice, NC_64BIT_OFFSET);
  probes("[1, 1, 0], [3, 2.5, 0], [5, 1, 0], [2, 2, 0]");
  const Outcome o = run("--scene scene.yaml --out out mesh.nc");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.err.find("mesh.nc: 1 faces of more than four vertices are cut"), std::string::npos)
      << o.err;
  const std::vector<Row> table = rows("out/g.csv");
  ASSERT_EQ(table.size(), 8u);
  const double x[] = {1, 3, 5, 2}, y[] = {1, 2.5, 1, 2}, face[] = {0, 0, 1, 0};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(table[i].at("temp"), 1 + 2 * x[i] - 3 * y[i], 1e-12);
    EXPECT_EQ(table[i].at("ugrid_face"), face[i]);
    EXPECT_EQ(table[i].at("number"), face[i]);
  }
  lattice.nodes[3] = {0.5, 0.5}; // a face that its mean does not see whole
  write_lattice("bent.nc", lattice, NC_64BIT_OFFSET);
  const Outcome bent = run("--scene scene.yaml --out out bent.nc");
  EXPECT_EQ(bent.code, 1);
  EXPECT_NE(bent.err.find("bent.nc: mesh 'Mesh': face 0 of 6 vertices"), std::string::npos)
      << bent.err;
}

TEST_F(Ugrid, FillValuesAreNoValuesAndNumbersAreUnpacked) {
  UgridLattice lattice;
  lattice.make();
  {
    UgridFile out(path("mesh.nc"), lattice, 1, "seconds since 2000-01-01");
    const int temp = out.field("temp", {out.time, out.node}, "node", NC_SHORT),
              salt = out.field("salt", {out.time, out.face}, "face", NC_FLOAT);
    out.file.say(temp, "scale_factor", 0.5, NC_DOUBLE);
    out.file.say(temp, "add_offset", 10, NC_DOUBLE);
    out.file.say(temp, "_FillValue", -1, NC_SHORT);
    out.file.say(out.field("flux", {out.file.dim("nMesh_edge", 5)}, "edge"), {"units", "1"});
    out.begin({0});
    std::vector<double> numbers(lattice.nodes.size(), 8), salts(lattice.faces.size(), 35);
    numbers[0] = -1;
    salts[1] = NC_FILL_FLOAT;
    out.file.put(temp, numbers);
    out.file.put(salt, salts);
  }
  probes("[0.25, 0.25, 0], [2.5, 0.5, 0], [1.75, 0.25, 0]");
  const Outcome o = run("--scene scene.yaml --out out mesh.nc");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.err.find("variable 'flux' is left out"), std::string::npos) << o.err;
  const std::vector<Row> table = rows("out/g.csv");
  ASSERT_EQ(table.size(), 3u);
  EXPECT_TRUE(std::isnan(table[0].at("temp")));
  EXPECT_EQ(table[1].at("temp"), 14.0);
  EXPECT_EQ(table[1].at("salt"), 35.0);
  EXPECT_TRUE(std::isnan(table[2].at("salt")));
  expect_checked("--scene scene.yaml mesh.nc",
                 {"mesh 'mesh': 18 cells, 20 vertices\n",
                  "  field 'temp' on vertices, 1 component\n",
                  "  field 'salt' on cells, 1 component\n", "1 step\n"});
  put("typo.yaml", "insitu: 1\nprobes:\n  - {name: g, points: [[1, 1, 0]], fields: [salts]}\n");
  expect_checked("--scene typo.yaml mesh.nc", {"1 step\n"}, "did you mean 'salt'?");
}

/// What is wrong with a file is told with its name, the variable's and the number.
TEST_F(Ugrid, WhatIsWrongIsNamed) {
  UgridLattice lattice;
  lattice.make();
  const auto refused = [&](const std::string& name, const std::string& message) {
    const Outcome o = run("--scene scene.yaml --out out " + name);
    EXPECT_EQ(o.code, 1) << name;
    EXPECT_NE(o.err.find(name + ": " + message), std::string::npos) << o.err;
    EXPECT_NE(run("--check --scene scene.yaml " + name).code, 0);
  };
  probes("[0.5, 0.5, 0]");
  UgridLattice wrong = lattice;
  wrong.start = 1;
  wrong.faces[5][1] = 20;
  write_lattice("range.nc", wrong, NC_64BIT_OFFSET);
  refused("range.nc", "variable 'Mesh_nodes': face 5: node 1 has the id 21, 1 to 20 expected by "
                      "start_index");
  wrong = lattice;
  for (auto& face : wrong.faces) // which count from 1, and nobody says so
    for (int& id : face)
      ++id;
  write_lattice("start.nc", wrong, NC_NETCDF4);
  refused("start.nc", "variable 'Mesh_nodes': face 16: node 2 has the id 20, 0 to 19 expected; "
                      "start_index is missing, so ids count from 0");
  wrong = lattice;
  wrong.faces[2].resize(2);
  write_lattice("short.nc", wrong, NC_64BIT_OFFSET);
  refused("short.nc", "variable 'Mesh_nodes': face 2 has 2 nodes; 3 or more expected");
  {
    NcFile out(path("nomesh.nc"));
    const int temp = out.var("temp", {out.dim("node", 3)});
    out.say(temp, {"mesh", "Mesh7", "location", "node"});
    out.begin();
  }
  refused("nomesh.nc",
          "variable 'temp': mesh names the variable 'Mesh7', which is not in the file");
  const auto without_faces = [&](const std::string& name, double last_y) {
    NcFile out(path(name));
    const int mesh = out.var("Mesh", {}, NC_INT), node = out.dim("node", 3);
    const int x = out.var("x", {node}), y = out.var("y", {node});
    out.say(mesh, {"cf_role", "mesh_topology", "node_coordinates", "x y"});
    out.say(mesh, "topology_dimension", 2);
    out.begin();
    out.put(x, {0, 1, 0});
    out.put(y, {0, 0, last_y});
  };
  without_faces("noids.nc", NC_FILL_DOUBLE);
  refused("noids.nc", "variable 'y': node 2 has no coordinate");
  without_faces("nofaces.nc", 1);
  refused("nofaces.nc", "variable 'Mesh': has no face_node_connectivity");
  {
    UgridFile out(path("location.nc"), lattice, 1, "seconds since 2000-01-01");
    out.field("temp", {out.time, out.face}, "node");
    out.begin({0});
  }
  refused("location.nc", "variable 'temp': location is node, but it does not have the dimension "
                         "'nMesh_node'");
  write_lattice("mesh.nc", lattice, NC_64BIT_OFFSET);
  const std::string whole = contents(path("mesh.nc"));
  put("cut.nc", whole.substr(0, whole.size() * 2 / 3));
  refused("cut.nc", "variable '");
  put("header.nc", whole.substr(0, 100));
  refused("header.nc", "ends within its header");
}

/// Two wedges and a hexahedron of topology dimension 3, by the numbers of their nodes.
TEST_F(Ugrid, Volumes) {
  {
    NcFile out(path("solid.nc"));
    const int node = out.dim("node", 12), cell = out.dim("cell", 3), most = out.dim("most", 8),
              mesh = out.var("Mesh", {}, NC_INT);
    int axes[3];
    for (int a = 0; a < 3; ++a)
      axes[a] = out.var(std::string(1, char('x' + a)), {node});
    out.say(mesh, {"cf_role", "mesh_topology", "node_coordinates", "x y z",
                   "volume_node_connectivity", "nodes"});
    out.say(mesh, "topology_dimension", 3);
    const int nodes = out.var("nodes", {cell, most}, NC_INT), f = out.var("f", {node}),
              g = out.var("g", {cell});
    out.say(nodes, "_FillValue", -1);
    out.say(nodes, "start_index", 1);
    out.say(f, {"mesh", "Mesh", "location", "node"});
    out.say(g, {"mesh", "Mesh", "location", "volume"});
    out.begin();
    std::vector<double> xyz[3], values; // two layers of 3 x 2 nodes
    for (int k = 0; k < 2; ++k)
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 3; ++i) {
          xyz[0].push_back(i);
          xyz[1].push_back(j);
          xyz[2].push_back(2 * k);
          values.push_back(field_of(i, j, 2 * k));
        }
    for (int a = 0; a < 3; ++a)
      out.put(axes[a], xyz[a]);
    out.put(nodes,
            {1, 2, 5, 4, 7, 8, 11, 10, 2, 6, 3, 8, 12, 9, -1, -1, 2, 5, 6, 8, 11, 12, -1, -1});
    out.put(f, values);
    out.put(g, {0, 1, 2});
  }
  probes("[0.5, 0.5, 1], [1.75, 0.25, 1.5], [1.25, 0.75, 0.5]");
  const std::vector<Row> table = replay("solid.nc");
  ASSERT_EQ(table.size(), 3u);
  const double x[] = {0.5, 1.75, 1.25}, y[] = {0.5, 0.25, 0.75}, z[] = {1, 1.5, 0.5};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(table[i].at("f"), field_of(x[i], y[i], z[i]), 1e-12);
    EXPECT_EQ(table[i].at("g"), double(i));
    EXPECT_EQ(table[i].at("cell"), double(i));
  }
}
