// insitu-replay on netCDF by the UGRID conventions: layers by sigma, s and depths.
#include "replay.h"
#include "ugrid_files.h"

namespace {

struct UgridLayers : Replay {
  void probes(const std::string& points) const {
    put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: [" + points + "], frame: mesh}\n");
  }
  std::vector<Row> replay(const std::string& file) const {
    const Outcome o = run("--scene scene.yaml --out out " + file);
    EXPECT_EQ(o.code, 0) << o.err;
    return rows("out/g.csv");
  }
};

double eta_of(double x, double y, double t) {
  return 0.25 * x - 0.125 * y + t;
}
double depth_of(double x, double y) {
  return 20 + 2 * x + y;
}

} // namespace

/// Layers between sigma levels, with values at the middles: fields are linear in x, y and the
/// height, hence met to rounding between the first and the last of the middles, and as they are
/// there beyond. The surface goes up by 1 m from step to step.
TEST_F(UgridLayers, BySigmaFromMiddlesAndLevels) {
  UgridLattice lattice;
  lattice.make();
  const std::size_t layers = 4, nodes = lattice.nodes.size(), faces = lattice.faces.size();
  const double level[] = {0, -0.125, -0.375, -0.75, -1}; // from the surface down
  {
    UgridFile out(path("sea.nc"), lattice, 2, "seconds since 2000-01-01");
    NcFile& file = out.file;
    const int middle_dim = file.dim("siglay", layers), level_dim = file.dim("siglev", layers + 1),
              middle = file.var("siglay", {middle_dim, out.node}),
              levels = file.var("siglev", {level_dim, out.node});
    for (const int v : {middle, levels})
      file.say(v, {"standard_name", "ocean_sigma_coordinate", "formula_terms",
                   std::string("sigma: ") + (v == middle ? "siglay" : "siglev") +
                       " eta: zeta depth: h"});
    const int zeta = out.field("zeta", {out.time, out.node}, "node"),
              h = out.field("h", {out.node}, "node"),
              temp = out.field("temp", {out.time, middle_dim, out.node}, "node"),
              omega = out.field("omega", {level_dim, out.node, out.time}, "node"),
              u = out.field("u", {out.time, out.face, middle_dim}, "face"),
              w = out.field("w", {level_dim, out.face}, "face");
    out.begin({0, 60});
    std::vector<double> middles, all, temps, omegas(2 * (layers + 1) * nodes), us, ws;
    for (std::size_t k = 0; k <= layers; ++k)
      for (std::size_t n = 0; n < nodes; ++n) {
        all.push_back(level[k]);
        if (k < layers)
          middles.push_back((level[k] + level[k + 1]) / 2);
      }
    const auto height = [&](double s, std::size_t n, double t) {
      const auto [x, y] = lattice.nodes[n];
      return eta_of(x, y, t) + s * (depth_of(x, y) + eta_of(x, y, t));
    };
    for (std::size_t t = 0; t < 2; ++t) {
      for (std::size_t i = 0; i < layers * nodes; ++i)
        temps.push_back(field_of(lattice.nodes[i % nodes][0], lattice.nodes[i % nodes][1],
                                 height(middles[i], i % nodes, double(t))));
      for (std::size_t i = 0; i < (layers + 1) * nodes; ++i)
        omegas[2 * i + t] = field_of(lattice.nodes[i % nodes][0], lattice.nodes[i % nodes][1],
                                     height(all[i], i % nodes, double(t)));
      for (std::size_t i = 0; i < layers * faces; ++i)
        us.push_back(double(100 * (i % layers) + i / layers + 10000 * t));
    }
    for (std::size_t k = 0; k <= layers; ++k)
      for (std::size_t f = 0; f < faces; ++f)
        ws.push_back(double(2 * k));
    file.put(middle, middles);
    file.put(levels, all);
    file.put(zeta, out.of_nodes(2, eta_of));
    file.put(h, out.of_nodes(1, [](double x, double y, double) { return depth_of(x, y); }));
    file.put(temp, temps);
    file.put(omega, omegas);
    file.put(u, us);
    file.put(w, ws);
  }
  // Three quarters of the way down each layer of each face's middle, as it is at the first step.
  std::string points;
  std::vector<std::array<double, 3>> places;
  for (std::size_t f = 0; f < faces; ++f)
    for (std::size_t k = 0; k < layers; ++k) {
      const auto [x, y] = lattice.centre(f);
      const double s = 0.25 * level[k] + 0.75 * level[k + 1];
      places.push_back({x, y, eta_of(x, y, 0) + s * (depth_of(x, y) + eta_of(x, y, 0))});
      points += (points.empty() ? "" : ", ") + text_of(x, y, places.back()[2]);
    }
  points += ", [0.5, 0.5, 0.75]"; // above the water at first
  probes(points);
  const std::vector<Row> table = replay("sea.nc");
  ASSERT_EQ(table.size(), 2 * (places.size() + 1));
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto [x, y, z] = places[i];
    const std::size_t f = i / layers, k = i % layers;
    EXPECT_EQ(table[i].at("cell"), double(k * faces + f));
    EXPECT_NEAR(table[i].at("omega"), field_of(x, y, z), 1e-11);
    EXPECT_NEAR(table[i].at("zeta"), eta_of(x, y, 0), 1e-12);
    EXPECT_EQ(table[i].at("u"), double(100 * k + f));
    EXPECT_EQ(table[i].at("w"), double(2 * k + 1));
    if (k > 0 && k + 1 < layers) {
      EXPECT_NEAR(table[i].at("temp"), field_of(x, y, z), 1e-11);
    }
    const Row& later = table[places.size() + 1 + i];
    EXPECT_NEAR(later.at("omega"), field_of(x, y, z), 1e-11);
    EXPECT_NEAR(later.at("zeta"), eta_of(x, y, 1), 1e-12);
  }
  EXPECT_TRUE(std::isnan(table[places.size()].at("zeta")));
  EXPECT_NEAR(table.back().at("zeta"), eta_of(0.5, 0.5, 1), 1e-12);
}

/// The heights of the parametric coordinates, as the conventions have them: a field of these
/// heights is the height everywhere.
TEST_F(UgridLayers, ByStretchedCoordinates) {
  const double a = 3, b = 0.5, hc = 5;
  const auto c_of = [&](double s) {
    return (1 - b) * std::sinh(a * s) / std::sinh(a) +
           b * (std::tanh(a * (s + 0.5)) / (2 * std::tanh(a / 2)) - 0.5);
  };
  for (const std::string kind :
       {"ocean_s_coordinate", "ocean_s_coordinate_g1", "ocean_s_coordinate_g2"}) {
    UgridLattice lattice;
    lattice.make();
    const std::size_t levels = 5;
    const auto height = [&](double s, double x, double y) {
      const double eta = eta_of(x, y, 1), h = depth_of(x, y), c = c_of(s),
                   still = hc * s + (h - hc) * c;
      return kind == "ocean_s_coordinate"      ? eta * (1 + s) + still
             : kind == "ocean_s_coordinate_g1" ? still + eta * (1 + still / h)
                                               : eta + (eta + h) * (hc * s + h * c) / (hc + h);
    };
    {
      UgridFile out(path("sea.nc"), lattice, 1, "seconds since 2000-01-01");
      NcFile& file = out.file;
      const int dim = file.dim("s", levels), s = file.var("s", {dim});
      const bool stretched = kind != "ocean_s_coordinate";
      file.say(s, {"standard_name", kind, "formula_terms",
                   stretched ? "s: s C: C eta: zeta depth: h depth_c: hc"
                             : "s: s a: a b: b eta: zeta depth: h depth_c: hc"});
      const int zeta = out.field("zeta", {out.time, out.node}, "node"),
                h = out.field("h", {out.node}, "node"), z = out.field("z", {dim, out.node}, "node"),
                c = file.var("C", {dim}), a_ = file.var("a", {}), b_ = file.var("b", {}),
                hc_ = file.var("hc", {});
      out.begin({0});
      std::vector<double> numbers, stretching, heights;
      for (std::size_t k = 0; k < levels; ++k) {
        numbers.push_back(-1 + 0.25 * double(k)); // from the bottom up
        stretching.push_back(c_of(numbers.back()));
        for (const auto& [x, y] : lattice.nodes)
          heights.push_back(height(numbers.back(), x, y));
      }
      file.put(s, numbers);
      file.put(c, stretching);
      file.put(a_, {a});
      file.put(b_, {b});
      file.put(hc_, {hc});
      file.put(zeta, out.of_nodes(1, [](double x, double y, double) { return eta_of(x, y, 1); }));
      file.put(h, out.of_nodes(1, [](double x, double y, double) { return depth_of(x, y); }));
      file.put(z, heights);
    }
    probes("[0.5, 0.5, 0.9], [0.5, 0.5, -3], [1.25, 2.5, -12], [3.5, 0.25, -20], [2, 1, -23.5]");
    const std::vector<Row> table = replay("sea.nc");
    ASSERT_EQ(table.size(), 5u);
    const double z[] = {0.9, -3, -12, -20, -23.5};
    for (std::size_t i = 0; i < 5; ++i)
      EXPECT_NEAR(table[i].at("z"), z[i], 1e-11) << kind << " " << i;
  }
}

/// Depths in kilometres with bounds, in longitude and latitude: values of faces are those of the
/// layers. Without bounds layers reach half way to each other.
TEST_F(UgridLayers, ByDepthsWithBoundsAndWithout) {
  for (const bool bounds : {true, false}) {
    UgridLattice lattice;
    lattice.x0 = 10;
    lattice.y0 = 50;
    lattice.degrees = true;
    lattice.make();
    {
      UgridFile out(path("sea.nc"), lattice, 1, "seconds since 2000-01-01");
      NcFile& file = out.file;
      const int dim = file.dim("lev", 3), two = file.dim("two", 2), lev = file.var("lev", {dim}),
                ends = file.var("lev_bounds", {dim, two});
      file.say(lev, {"units", "km", "positive", "down"});
      if (bounds)
        file.say(lev, {"bounds", "lev_bounds"});
      const int salt = out.field("salt", {out.face, dim}, "face"),
                ignored = out.field("sand", {out.face, file.dim("sediment", 4)}, "face");
      file.say(ignored, {"units", "1"});
      out.begin({0});
      file.put(lev, {0.25, 1, 2});
      file.put(ends, {0, 0.5, 0.5, 1.25, 1.25, 3});
      std::vector<double> salts;
      for (std::size_t i = 0; i < 3 * lattice.faces.size(); ++i)
        salts.push_back(double(i));
      file.put(salt, salts);
    }
    // Half way between the middles are 0.625 and 1.5 km; as far beyond are -0.125 and 2.5 km.
    probes("[10.5, 50.5, -100], [10.5, 50.5, -550], [10.5, 50.5, -1300], [10.5, 50.5, -2600], "
           "[12.5, 50.5, -1400]");
    const Outcome o = run("--scene scene.yaml --out out sea.nc");
    ASSERT_EQ(o.code, 0) << o.err;
    EXPECT_NE(o.err.find("variable 'sand' is left out: its dimension 'sediment'"),
              std::string::npos)
        << o.err;
    const std::vector<Row> table = rows("out/g.csv");
    ASSERT_EQ(table.size(), 5u);
    const double with[] = {0, 1, 2, 2, 11}, without[] = {0, 0, 1, NAN, 10};
    for (std::size_t i = 0; i < 5; ++i) {
      const double expected = bounds ? with[i] : without[i];
      if (std::isnan(expected))
        EXPECT_TRUE(std::isnan(table[i].at("salt")));
      else
        EXPECT_EQ(table[i].at("salt"), expected) << bounds << " " << i;
    }
  }
}

/// A hexagon and a quad in layers between heights at the nodes, which the surface moves; the
/// surface and the bottom are values of faces, and all alike.
TEST_F(UgridLayers, OfPolygonsWithTermsOfFaces) {
  const UgridLattice lattice = hexagon_and_quad();
  const std::size_t nodes = lattice.nodes.size();
  const double level[] = {-1, -0.5, 0};
  {
    UgridFile out(path("sea.nc"), lattice, 2, "minutes since 2000-01-01", NC_NETCDF4);
    NcFile& file = out.file;
    const int dim = file.dim("levels", 3), s = file.var("levels", {dim});
    file.say(s, {"standard_name", "ocean_sigma_coordinate", "formula_terms",
                 "sigma: levels eta: eta depth: bottom"});
    const int eta = out.field("eta", {out.time, out.face}, "face"),
              bottom = out.field("bottom", {out.face}, "face"),
              f = out.field("f", {out.time, out.node, dim}, "node"),
              g = out.field("g", {out.face, dim}, "face");
    out.begin({0, 1});
    std::vector<double> values;
    for (std::size_t t = 0; t < 2; ++t)
      for (std::size_t n = 0; n < nodes; ++n)
        for (const double l : level)
          values.push_back(
              field_of(lattice.nodes[n][0], lattice.nodes[n][1], double(t) + l * (10 + double(t))));
    file.put(s, {level[0], level[1], level[2]});
    file.put(eta, {0, 0, 1, 1});
    file.put(bottom, {10, 10});
    file.put(f, values);
    file.put(g, {0, 2, 4, 10, 20, 30}); // on levels: averaged in layers
  }
  probes("[1, 1, -7], [3, 2.5, -2], [5, 1, -2], [1, 1, 0.5]");
  const std::vector<Row> table = replay("sea.nc");
  ASSERT_EQ(table.size(), 8u);
  const double x[] = {1, 3, 5, 1}, y[] = {1, 2.5, 1, 1}, z[] = {-7, -2, -2, 0.5},
               g[] = {1, 3, 25, 3}, face[] = {0, 0, 1, 0};
  for (std::size_t i = 0; i < 8; ++i) {
    const std::size_t p = i % 4;
    if (i == 3) { // above the surface
      EXPECT_TRUE(std::isnan(table[i].at("f")));
      continue;
    }
    EXPECT_NEAR(table[i].at("f"), field_of(x[p], y[p], z[p]), 1e-11);
    EXPECT_EQ(table[i].at("g"), g[p]);
    EXPECT_EQ(table[i].at("ugrid_face"), face[p]);
    EXPECT_EQ(table[i].at("time"), i < 4 ? 0 : 60);
  }
}

/// As SCHISM writes it: heights at the nodes of each step without attributes, a dimension of
/// components, no locations, and a vertical coordinate along which nothing goes.
TEST_F(UgridLayers, ByHeightsAtNodesWithVectors) {
  UgridLattice lattice;
  lattice.start = 1;
  lattice.make();
  const std::size_t nodes = lattice.nodes.size(), levels = 3;
  {
    UgridFile out(path("sea.nc"), lattice, 2, "seconds since 2000-01-01");
    NcFile& file = out.file;
    const int sigma_dim = file.dim("sigma", levels), sigma = file.var("sigma", {sigma_dim}),
              dim = file.dim("nSCHISM_vgrid_layers", levels), two = file.dim("two", 2),
              z = file.var("zCoordinates", {out.time, out.node, dim}),
              hvel = file.var("hvel", {out.time, out.node, dim, two}, NC_FLOAT),
              dahv = file.var("dahv", {out.node, two});
    file.say(sigma, {"standard_name", "ocean_sigma_coordinate", "formula_terms",
                     "sigma: sigma eta: elev depth: depth"});
    for (const int v : {z, hvel, dahv})
      file.say(v, {"mesh", "Mesh", "data_horizontal_center", "node"});
    out.begin({0, 30});
    std::vector<double> heights, vectors, flat;
    for (int t = 0; t < 2; ++t)
      for (std::size_t n = 0; n < nodes; ++n) {
        const auto [x, y] = lattice.nodes[n];
        for (std::size_t k = 0; k < levels; ++k) {
          heights.push_back(-8 + 4 * double(k) + 0.5 * x + t);
          vectors.insert(vectors.end(), {x + heights.back(), 2 * y});
        }
        if (t == 0)
          flat.insert(flat.end(), {x, -y});
      }
    file.put(sigma, {-1, -0.5, 0});
    file.put(z, heights);
    file.put(hvel, vectors);
    file.put(dahv, flat);
  }
  probes("[0.5, 0.5, -6], [2.5, 1.25, -1]");
  const std::vector<Row> table = replay("sea.nc");
  ASSERT_EQ(table.size(), 4u);
  const double x[] = {0.5, 2.5}, y[] = {0.5, 1.25}, z[] = {-6, -1};
  for (std::size_t i = 0; i < 4; ++i) {
    const Row& row = table[i];
    const std::size_t p = i % 2;
    EXPECT_NEAR(row.at("hvel_x"), x[p] + z[p], 1e-12);
    EXPECT_NEAR(row.at("hvel_y"), 2 * y[p], 1e-12);
    EXPECT_EQ(row.at("hvel_z"), 0.0);
    EXPECT_NEAR(row.at("dahv_y"), -y[p], 1e-12);
    EXPECT_EQ(row.count("zCoordinates"), 0u);
  }
}

/// A drifter between depths, by velocities of faces in metres per second: over the ellipsoid at its
/// height. The rate of longitude is u / ((N + h) cos(latitude)).
TEST_F(UgridLayers, DriftersGoOverTheEllipsoidAtTheirDepth) {
  UgridLattice lattice;
  lattice.x0 = 10;
  lattice.y0 = -40;
  lattice.degrees = true;
  lattice.make();
  {
    UgridFile out(path("sea.nc"), lattice, 3, "hours since 2000-01-01");
    NcFile& file = out.file;
    const int dim = file.dim("lev", 2), two = file.dim("two", 2), lev = file.var("lev", {dim}),
              ends = file.var("lev_bounds", {dim, two});
    file.say(lev, {"units", "m", "positive", "down", "bounds", "lev_bounds"});
    const int u = out.field("ucx", {out.time, out.face, dim}, "face"),
              v = out.field("ucy", {out.time, out.face, dim}, "face");
    file.say(u, {"standard_name", "sea_water_x_velocity"});
    file.say(v, {"standard_name", "sea_water_y_velocity"});
    out.begin({0, 6, 12});
    file.put(lev, {50, 2500});
    file.put(ends, {0, 100, 100, 4900});
    std::vector<double> east;
    for (std::size_t i = 0; i < 3 * lattice.faces.size(); ++i)
      east.insert(east.end(), {1.5, -2.5});
    file.put(u, east);
    file.put(v, std::vector<double>(east.size(), 0.0));
  }
  put("scene.yaml", "insitu: 1\ntracers:\n  - {name: t, velocity: sea_water_velocity, seeds: "
                    "[[11.5, -38.5, -60], [11.5, -38.5, -4000]]}\n");
  const Outcome o = run("--scene scene.yaml --out out sea.nc");
  ASSERT_EQ(o.code, 0) << o.err;
  const double pi = std::acos(-1.0), latitude = -38.5 * pi / 180;
  int rows_of[2] = {};
  for (const Row& row : rows("out/t.csv")) {
    const auto p = std::size_t(row.at("particle"));
    const double height = p ? -4000 : -60, speed = p ? -2.5 : 1.5,
                 turned = row.at("time") * speed /
                          ((prime_vertical(latitude) + height) * std::cos(latitude));
    ++rows_of[p];
    // The tolerance allows an error of 1e-6 m a second: 5e-7 degrees in the end.
    EXPECT_NEAR(row.at("x"), 11.5 + turned * 180 / pi, 5e-7);
    EXPECT_NEAR(row.at("y"), -38.5, 4e-7);
    EXPECT_NEAR(row.at("z"), height, 1e-6);
  }
  EXPECT_GE(rows_of[0], 3);
  EXPECT_GE(rows_of[1], 3);
}

TEST_F(UgridLayers, ADepthThatIsMissingIsNamed) {
  UgridLattice lattice;
  lattice.make();
  {
    UgridFile out(path("sea.nc"), lattice, 1, "seconds since 2000-01-01");
    const int dim = out.file.dim("siglev", 2), levels = out.file.var("siglev", {dim}),
              h = out.field("h", {out.node}, "node");
    out.file.say(levels, {"standard_name", "ocean_sigma_coordinate", "formula_terms",
                          "sigma: siglev eta: h depth: h"});
    out.field("temp", {dim, out.node}, "node");
    out.begin({0});
    out.file.put(levels, {0, -1});
    std::vector<double> depths(lattice.nodes.size(), 20);
    depths[3] = NC_FILL_DOUBLE;
    out.file.put(h, depths);
  }
  probes("[0.5, 0.5, 0]");
  const Outcome o = run("--scene scene.yaml --out out sea.nc");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("sea.nc: variable 'h': node 3 has no value, which heights of 'siglev' need"),
            std::string::npos)
      << o.err;
}
