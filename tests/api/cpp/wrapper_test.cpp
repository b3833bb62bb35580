/// insitu.hpp over the shared library: what a C++ solver sees. Compiled as C++17 and as C++20.

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>
#include <limits>

#include "two.h"

namespace {

template <class Call>
insitu_status status_of(Call&& call, std::string* what = nullptr) {
  try {
    call();
  } catch (const insitu::Error& e) {
    if (what)
      *what = e.what();
    return e.status();
  }
  return INSITU_OK;
}

struct Wrapper : testing::Test {
  Two two;
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  void give() {
    mesh.points(two.x.data(), two.y.data(), two.z.data(), two.x.size());
    mesh.hexahedra(two.ids.data(), 2);
    mesh.vertex_field("p", two.pressure.data());
    mesh.cell_field("rho", two.density.data());
  }
  /// The value of p, or NaN.
  double p(double x, double y, double z) {
    double value = 0;
    mesh.sample_point("p", {x, y, z}, {&value, 1});
    return value;
  }
  const insitu::AuditEntry entry(const std::string& name) {
    for (const insitu::AuditEntry& e : mesh.audit())
      if (e.name == name)
        return e;
    ADD_FAILURE() << "no audit entry " << name;
    return {};
  }
};

} // namespace

TEST_F(Wrapper, MinimalCoupling) {
  give();
  const insitu::CommitReport report = mesh.commit();
  EXPECT_EQ(report.action, INSITU_REBUILD);
  EXPECT_EQ(report.cells, 2);
  EXPECT_EQ(report.vertices, 12);
  const std::vector<std::array<double, 3>> points{{0.25, 0.5, 0.75}, {1.5, 0.5, 0.5}, {5, 0, 0}};
  const insitu::Samples s = mesh.sample("p", points);
  ASSERT_EQ(s.size(), 3u);
  EXPECT_NEAR(s(0), linear(0.25, 0.5, 0.75), 1e-14);
  EXPECT_NEAR(s(1), linear(1.5, 0.5, 0.5), 1e-14);
  EXPECT_TRUE(std::isnan(s(2)));
  EXPECT_EQ(s.found, (std::vector<std::uint8_t>{1, 1, 0}));
  EXPECT_EQ(s.cells, (std::vector<std::int64_t>{0, 1, -1}));
  EXPECT_EQ(s.pieces, (std::vector<std::int32_t>{0, 0, -1}));
  EXPECT_NEAR(s.parametric[3], 0.5, 1e-14);
}

TEST_F(Wrapper, ArraysAreReadInPlace) {
  give();
  mesh.commit();
  EXPECT_EQ(entry("piece 0 points component 1").data, two.y.data());
  EXPECT_EQ(entry("piece 0 connectivity").data, two.ids.data());
  EXPECT_EQ(entry("piece 0 field 'p'").data, two.pressure.data());
  for (const insitu::AuditEntry& e : mesh.audit())
    EXPECT_EQ(e.borrowed, 1) << e.name;
  std::fill(two.pressure.begin(), two.pressure.end(), 7.0);
  mesh.changed(insitu::fields);
  EXPECT_EQ(mesh.commit().action, INSITU_KEEP);
  EXPECT_EQ(p(0.5, 0.5, 0.5), 7.0);
}

TEST_F(Wrapper, Locators) {
  give();
  mesh.commit();
  const double expected = p(0.3, 0.4, 0.5);
  EXPECT_EQ(mesh.locator_info().method, INSITU_METHOD_BVH);
  mesh.locator(insitu::Method::shared_bilinear_faces, insitu::Backend::cpu);
  mesh.commit();
  EXPECT_EQ(mesh.locator_info().method, INSITU_METHOD_SHARED_BILINEAR_FACES);
  EXPECT_STREQ(mesh.locator_info().reason, "as asked for");
  EXPECT_EQ(p(0.3, 0.4, 0.5), expected);
  const std::vector<std::array<double, 3>> points{{0.25, 0.5, 0.75}, {1.5, 0.5, 0.5}, {5, 0, 0}};
  EXPECT_EQ(mesh.locate(points).cells, (std::vector<std::int64_t>{0, 1, -1}));
  try {
    mesh.locator(insitu::Method::bvh, insitu::Backend::optix);
    ADD_FAILURE() << "optix has no bvh";
  } catch (const insitu::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_UNSUPPORTED);
  }
  EXPECT_EQ(insitu::Array(two.x).on_device().get(-1, "x").memory, INSITU_DEVICE);
}

TEST_F(Wrapper, ChangedGeometryIsRefitted) {
  give();
  mesh.commit();
  for (double& x : two.x)
    x += 10.0;
  mesh.changed(insitu::geometry | insitu::fields);
  EXPECT_EQ(mesh.commit().action, INSITU_REFIT);
  EXPECT_EQ(mesh.locate(std::vector<float>{11.5f, 0.5f, 0.5f}).cells[0], 1);
}

TEST_F(Wrapper, ContainersCarryTheirSizes) {
  mesh.points(two.x, two.y, two.z);
  mesh.hexahedra(two.ids);
  mesh.cell_field("rho", two.density);
  mesh.vertex_field("v", {two.x, two.y, two.z});
  EXPECT_EQ(mesh.commit().cells, 2);
  const insitu::Samples v = mesh.sample("v", std::vector<double>{1.25, 0.5, 0.75});
  ASSERT_EQ(v.components, 3);
  EXPECT_NEAR(v(0, 0), 1.25, 1e-14);
  EXPECT_NEAR(v(0, 2), 0.75, 1e-14);

  const std::vector<double> short_by_one(11, 0.0);
  mesh.vertex_field("short", short_by_one);
  std::string what;
  EXPECT_EQ(status_of([&] { mesh.commit(); }, &what), INSITU_ERROR_FIELD);
  EXPECT_NE(what.find("11"), std::string::npos) << what;
  mesh.remove_field("short");
  mesh.commit();
}

TEST_F(Wrapper, SizesThatDoNotFitAreRefusedAtOnce) {
  std::string what;
  const std::vector<double> ten(10);
  EXPECT_EQ(status_of([&] { mesh.points(ten); }, &what), INSITU_ERROR_ARGUMENT);
  EXPECT_NE(what.find("10 values are not whole items of 3"), std::string::npos) << what;
  const std::vector<int> nine(9);
  EXPECT_EQ(status_of([&] { mesh.hexahedra(nine); }), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(status_of([&] { (void)mesh.locate(ten); }), INSITU_ERROR_ARGUMENT);
  // A bare pointer without cells: no count to go by.
  EXPECT_EQ(status_of([&] { mesh.cell_field("rho", two.density.data()); }, &what),
            INSITU_ERROR_ORDER);
  // Strides that would leave the container.
  give();
  EXPECT_EQ(status_of([&] { mesh.cell_field("s", insitu::Array(two.density).stride(16)); }, &what),
            INSITU_ERROR_ARGUMENT);
  EXPECT_NE(what.find("byte 24"), std::string::npos) << what;
  EXPECT_EQ(
      status_of([&] { mesh.cell_field("s", insitu::Array(two.density).stride(-8).count(2)); }),
      INSITU_ERROR_ARGUMENT);
  double two_values[2];
  mesh.commit();
  EXPECT_EQ(status_of([&] {
              mesh.sample_point("p", {0, 0, 0}, two_values);
            }),
            INSITU_ERROR_ARGUMENT);
}

TEST_F(Wrapper, LayoutsOfOneMeshAgree) {
  give();
  mesh.commit();
  const double expected = p(1.3, 0.4, 0.6);
  ASSERT_NEAR(expected, linear(1.3, 0.4, 0.6), 1e-14);

  std::vector<insitu::Mesh> others;
  const auto other = [&](const char* name) -> insitu::Mesh& {
    return others.emplace_back(session.mesh(name));
  };
  // 64-bit ids from 1, interleaved points.
  std::vector<std::int64_t> from_one(two.ids.begin(), two.ids.end());
  for (std::int64_t& id : from_one)
    ++id;
  insitu::Mesh& one_based = other("one based");
  one_based.points(two.xyz.data(), 12);
  one_based.hexahedra(from_one.data(), 2, 1);
  // Mixed, with n + 1 offsets.
  const std::vector<std::uint8_t> types{12, 12};
  const std::vector<int> offsets{0, 8, 16};
  insitu::Mesh& mixed = other("mixed");
  mixed.points(two.xyz);
  mixed.mixed_cells(types, offsets, two.ids);
  // Padded.
  insitu::Mesh& padded = other("padded");
  padded.points(two.xyz);
  padded.padded_cells(two.ids);
  // Ids in records with a material number.
  std::vector<int> records;
  for (int c = 0; c < 2; ++c) {
    records.push_back(99);
    records.insert(records.end(), two.ids.begin() + 8 * c, two.ids.begin() + 8 * c + 8);
  }
  insitu::Mesh& strided = other("strided");
  strided.points(two.xyz);
  strided.hexahedra(insitu::Array(records.data() + 1, 2).stride(9 * sizeof(int)));
  // Blocks.
  insitu::Mesh& curvilinear = other("curvilinear");
  curvilinear.block(3, 2, 2);
  curvilinear.points(insitu::Array(two.xyz.data()).components(3)); // the count is the block's
  insitu::Mesh& uniform = other("uniform");
  uniform.uniform_block({3, 2, 2}, {0, 0, 0}, {1, 1, 1});
  const std::vector<double> along_x{0, 1, 2}, along{0, 1};
  insitu::Mesh& rectilinear = other("rectilinear");
  rectilinear.rectilinear_block(along_x, along, along);
  // Points as structs.
  struct Node {
    double t;
    float x, y, z;
  };
  std::vector<Node> nodes;
  for (std::size_t i = 0; i < 12; ++i)
    nodes.push_back({0, float(two.x[i]), float(two.y[i]), float(two.z[i])});
  insitu::Mesh& structs = other("structs");
  structs.points(insitu::Array(&nodes[0].x, nodes.size()).components(3).stride(sizeof(Node)));
  structs.cells(insitu::Shape::hexahedron, two.ids);

  for (insitu::Mesh& m : others) {
    m.vertex_field("p", two.pressure.data());
    m.commit();
    double value = 0;
    ASSERT_TRUE(m.sample_point("p", {1.3, 0.4, 0.6}, {&value, 1}));
    EXPECT_NEAR(value, expected, 1e-14);
    EXPECT_EQ(m.locate(std::vector<double>{1.3, 0.4, 0.6}).cells[0], 1);
  }
}

TEST_F(Wrapper, SubBlockOfALargerArray) {
  give();
  // Cells (2, 1, 1) with one ghost layer all around in an array of 4 x 3 x 3.
  std::vector<double> padded(36, -1.0);
  const auto at = [](int i, int j, int k) { return std::size_t(i + 4 * (j + 3 * k)); };
  padded[at(1, 1, 1)] = 5.0;
  padded[at(2, 1, 1)] = 6.0;
  mesh.cell_field("t", insitu::Array(&padded[at(1, 1, 1)]).block({2, 1, 1}, {8, 32, 96}));
  mesh.commit();
  const insitu::Samples s = mesh.sample("t", std::vector<double>{0.5, 0.5, 0.5, 1.5, 0.5, 0.5});
  EXPECT_EQ(s.values, (std::vector<double>{5.0, 6.0}));
  EXPECT_EQ(status_of([&] {
              mesh.cell_field("u", insitu::Array(padded).block({2, 3, 4}, {8, 32, 96}));
            }),
            INSITU_ERROR_ARGUMENT);
}

TEST_F(Wrapper, PiecesAndGhosts) {
  give();
  std::vector<double> right = two.x;
  for (double& x : right)
    x += 1.0; // overlaps by one cell
  insitu::Piece second = mesh.piece(1);
  second.points(right, two.y, two.z);
  second.hexahedra(two.ids.data(), 2);
  second.vertex_field("p", two.pressure.data());
  second.cell_field("rho", two.density.data());
  mesh.commit();
  const std::vector<double> both{1.5, 0.5, 0.5, 2.5, 0.5, 0.5};
  EXPECT_EQ(mesh.locate(both).pieces, (std::vector<std::int32_t>{0, 1}));
  const std::vector<std::uint8_t> ghosts{0, 1};
  mesh.ghosts(ghosts);
  mesh.commit();
  const insitu::Locations at = mesh.locate(both);
  EXPECT_EQ(at.pieces, (std::vector<std::int32_t>{1, 1}));
  EXPECT_EQ(at.cells, (std::vector<std::int64_t>{0, 1}));
  mesh.no_ghosts();
  mesh.commit();
  EXPECT_EQ(mesh.locate(both).pieces[0], 0);
}

TEST_F(Wrapper, SeveralFieldsAtOnce) {
  give();
  mesh.commit();
  insitu::LocateOptions exact;
  exact.accuracy = insitu::Accuracy::exact;
  exact.cell_base = 1;
  const insitu::FieldSamples s =
      mesh.sample_fields({"rho", "p"}, {two.x.data(), two.y.data(), two.z.data(), 12}, exact);
  ASSERT_EQ(s.values.size(), 2u);
  EXPECT_EQ(s.values[0].name, "rho");
  for (std::size_t v = 0; v < 12; ++v) {
    EXPECT_EQ(s.cells[v], two.x[v] < 2.0 ? 1 : 2); // the lowest cell that holds the vertex
    EXPECT_NEAR(s.values[1].values[v], two.pressure[v], 1e-14);
  }
}

TEST_F(Wrapper, ReasonsOfASample) {
  give();
  mesh.commit();
  insitu::LocateOptions options;
  options.reasons = true;
  const std::vector<double> points{1.0, 0.5, 0.5, 2.0, 1.0, 0.5, 7.0, 0.0, 0.0};
  const insitu::Samples s = mesh.sample("p", points, options);
  EXPECT_EQ(s.reasons,
            (std::vector<insitu::Reason>{insitu::Reason::on_face, insitu::Reason::on_edge,
                                         insitu::Reason::outside}));
}

TEST_F(Wrapper, FramesOfPoints) {
  give();
  mesh.frame(insitu::Frame::enu(9.0, 48.0, 300.0));
  mesh.commit();
  const insitu::Frame geodetic = insitu::Frame::geodetic();
  insitu::LocateOptions options;
  options.frame = &geodetic;
  // 0.5 m up, a little north-east of the origin: about 0.37 m and 0.56 m.
  const std::vector<double> point{9.0 + 5e-6, 48.0 + 5e-6, 300.5};
  const insitu::Samples s = mesh.sample("p", point, options);
  ASSERT_EQ(s.found[0], 1);
  EXPECT_NEAR(s(0), linear(0.373, 0.556, 0.5), 1e-2);
}

TEST_F(Wrapper, MeshesInLongitudeLatitudeAndDepth) {
  give(); // longitudes 0 to 2, latitudes 0 to 1, depths 0 to 1 km
  mesh.frame(insitu::Frame::geodetic(insitu::Vertical::down, insitu::Angle::degrees,
                                     insitu::Length::kilometres));
  mesh.commit();
  EXPECT_EQ(entry("piece 0 points component 2").data, two.z.data());
  EXPECT_NEAR(p(1.5, 0.5, 0.25), linear(1.5, 0.5, 0.25), 1e-14);
  EXPECT_NEAR(p(361.5, 0.5, 0.0), linear(1.5, 0.5, 0.0), 1e-12); // another name of the meridian
  const insitu::Frame heights = insitu::Frame::geodetic();
  const insitu::Frame depths =
      insitu::Frame::geodetic(insitu::Vertical::down, insitu::Angle::radians);
  insitu::LocateOptions options;
  options.frame = &heights;
  const insitu::Samples s =
      mesh.sample("p", std::vector<double>{1.5, 0.5, -250, 1, 1, 0, 1, 1, 1}, options);
  EXPECT_NEAR(s(0), linear(1.5, 0.5, 0.25), 1e-14);
  EXPECT_NEAR(s(1), linear(1, 1, 0), 1e-14);
  EXPECT_EQ(s.found[2], 0);
  options.frame = &depths;
  const double radians = std::atan(1.0) / 45;
  EXPECT_NEAR(mesh.sample("p", std::vector<double>{1.5 * radians, 0.5 * radians, 250}, options)(0),
              linear(1.5, 0.5, 0.25), 1e-12);
  mesh.frame(insitu::Frame::cartesian());
  mesh.commit();
  EXPECT_TRUE(std::isnan(p(361.5, 0.5, 0.0)));
}

TEST_F(Wrapper, MessagesNameTheThing) {
  give();
  mesh.commit();
  std::string what;
  EXPECT_EQ(status_of([&] { (void)mesh.sample("pp", std::vector<double>(3)); }, &what),
            INSITU_ERROR_FIELD);
  EXPECT_NE(what.find("'pp'"), std::string::npos) << what;
  insitu::Options bad;
  bad.scene_text = "insitu: 1\nprobs: []\n";
  EXPECT_EQ(status_of([&] { insitu::Session s(bad); }, &what), INSITU_ERROR_SCENE);
  EXPECT_NE(what.find("probes"), std::string::npos) << what;
  insitu::Mesh nothing;
  EXPECT_EQ(status_of([&] { nothing.points(two.xyz.data(), 12); }), INSITU_ERROR_HANDLE);
  EXPECT_EQ(status_of([&] { nothing.commit(); }), INSITU_ERROR_HANDLE);
}

TEST_F(Wrapper, ARefusedMeshIsExplained) {
  two.ids[3] = 77;
  give();
  const insitu::Validation v = mesh.validate();
  EXPECT_FALSE(v.accepted);
  EXPECT_EQ(v.counts.index_errors, 1);
  EXPECT_NE(v.findings.find("77"), std::string::npos) << v.findings;
  EXPECT_EQ(status_of([&] { mesh.commit(); }), INSITU_ERROR_MESH);
  two.ids[3] = 3;
  mesh.changed(insitu::topology);
  EXPECT_TRUE(mesh.validate().accepted);
  mesh.commit();
}

TEST_F(Wrapper, SessionsMoveAndMeshesEndWithThem) {
  give();
  insitu::Session moved = std::move(session);
  mesh.commit();
  EXPECT_EQ(moved.mesh("m").handle(), mesh.handle());
  // What is known of a mesh is known to every Mesh of that name.
  moved.mesh("m").cell_field("again", two.density.data());
  mesh.commit();
  EXPECT_EQ(status_of([&] { session.execute(0, 0.0); }), INSITU_ERROR_HANDLE);
  moved.close();
  EXPECT_EQ(moved.handle(), nullptr);
  EXPECT_EQ(status_of([&] { mesh.commit(); }), INSITU_ERROR_HANDLE);
}
