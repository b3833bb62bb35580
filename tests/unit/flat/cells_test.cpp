// Flat meshes: owners, values, what is made of them, and what is refused.
#include <gtest/gtest.h>
#include <limits>

#include "flat_meshes.h"

using namespace flat_meshes;

namespace {

/// The values add four terms of up to about 40, each rounded at its own size.
constexpr double rounding = 2e-14;

constexpr Kind kinds[] = {Kind::triangles, Kind::quads, Kind::pixels, Kind::mixed};

/// Owners as a search over all cells finds them, and values of the linear field, for all accuracies
/// and heights of points.
void expect_answers(insitu::Mesh& mesh, const Flat& m, int n) {
  const std::vector<double> xyz = points_of(m, n);
  for (const insitu::Accuracy accuracy : {insitu::Accuracy::standard, insitu::Accuracy::exact}) {
    insitu::LocateOptions options;
    options.accuracy = accuracy;
    const insitu::Samples found = mesh.sample("f", xyz, options);
    for (std::size_t i = 0; i < xyz.size() / 3; ++i) {
      const double x = xyz[3 * i], y = xyz[3 * i + 1];
      ASSERT_EQ(found.cells[i], owner(m, x, y)) << x << " " << y;
      if (found.cells[i] >= 0) {
        ASSERT_NEAR(found.values[i], linear(x, y), rounding) << x << " " << y;
      }
    }
  }
}

std::string refusal(insitu::Mesh& mesh) {
  try {
    mesh.commit();
  } catch (const insitu::Error& e) {
    return e.what();
  }
  return "";
}

#define EXPECT_REFUSED(mesh, ...)                                                                  \
  do {                                                                                             \
    const std::string why = refusal(mesh);                                                         \
    for (const char* part : {__VA_ARGS__})                                                         \
      EXPECT_NE(why.find(part), std::string::npos) << why;                                         \
  } while (false)

} // namespace

TEST(FlatMeshes, OwnersAreTheLowestCellsAndLinearFieldsAreMet) {
  constexpr int n = 5;
  for (const Kind kind : kinds) {
    const Flat m = flat_mesh(n, kind, true);
    Arrays arrays(m, kind);
    const std::vector<double> f = values_of(m);
    insitu::Session session;
    insitu::Mesh mesh = session.mesh("m");
    arrays.give(mesh, kind);
    mesh.vertex_field("f", insitu::Array(f));
    const insitu::Validation v = mesh.validate();
    EXPECT_TRUE(v.accepted) << v.findings;
    EXPECT_EQ(v.counts.cells, std::int64_t(m.cells.size()));
    EXPECT_EQ(v.counts.inverted_cells + v.counts.zero_volume_cells + v.counts.folded_cells, 0);
    const insitu::CommitReport report = mesh.commit();
    EXPECT_EQ(report.cells, std::int64_t(m.cells.size()));
    EXPECT_EQ(report.vertices, std::int64_t(m.vertices()));
    expect_answers(mesh, m, n);
  }
}

TEST(FlatMeshes, GivenInOtherWaysAreTheSame) {
  constexpr int n = 4;
  const Flat m = flat_mesh(n, Kind::mixed, true);
  const std::vector<double> f = values_of(m);
  // Padded, from 1, with a third coordinate far from 0 and in float; clockwise; backwards in
  // memory.
  std::vector<std::int64_t> padded;
  for (std::size_t c = 0; c < m.cells.size(); ++c) {
    std::vector<int> ring = m.cells[c];
    if (c % 3 == 0)
      std::reverse(ring.begin(), ring.end());
    for (std::size_t v = 0; v < 4; ++v)
      padded.push_back(v < ring.size() ? ring[v] + 1 : -1);
  }
  std::vector<float> xyz;
  std::vector<double> backwards(f.rbegin(), f.rend()), y_x;
  for (std::size_t v = 0; v < m.vertices(); ++v)
    xyz.insert(xyz.end(), {float(m.x[v]), float(m.y[v]), 12345.678f});
  for (std::size_t v = m.vertices(); v-- > 0;)
    y_x.insert(y_x.end(), {m.y[v], m.x[v]});
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("padded"), reversed = session.mesh("reversed");
  mesh.points(insitu::Array(xyz.data(), m.vertices()));
  mesh.padded_flat_cells(insitu::Array(padded.data(), m.cells.size()), 1);
  mesh.vertex_field("f", insitu::Array(f));
  mesh.commit();
  expect_answers(mesh, m, n);
  EXPECT_EQ(mesh.validate().counts.inverted_cells, 0);

  insitu_array xy[2];
  for (int c = 0; c < 2; ++c) {
    xy[c] = insitu_array_of(y_x.data() + 2 * (m.vertices() - 1) + std::size_t(1 - c),
                            INSITU_FLOAT64, std::int64_t(m.vertices()), 1);
    xy[c].stride[0] = -16;
  }
  ASSERT_EQ(insitu_mesh_points(reversed.handle(), 0, xy, 2), INSITU_OK) << insitu_last_message();
  Arrays arrays(m, Kind::mixed);
  reversed.mixed_cells(insitu::Array(arrays.types), insitu::Array(arrays.offsets),
                       insitu::Array(arrays.ids));
  insitu_array values = insitu_array_of(backwards.data() + backwards.size() - 1, INSITU_FLOAT64,
                                        std::int64_t(f.size()), 1);
  values.stride[0] = -8;
  ASSERT_EQ(insitu_mesh_field(reversed.handle(), 0, "f", INSITU_VERTEX, &values, 1), INSITU_OK);
  reversed.commit();
  expect_answers(reversed, m, n);
}

TEST(FlatMeshes, OfBlocks) {
  constexpr int n = 6;
  const Flat m = flat_mesh(n, Kind::quads, false);
  const std::vector<double> f = values_of(m), axis{0, 1, 2, 3, 4, 5, 6};
  std::vector<double> cells;
  for (std::size_t c = 0; c < m.cells.size(); ++c)
    cells.push_back(double(c));
  insitu::Session session;
  for (int kind = 0; kind < 3; ++kind) {
    insitu::Mesh mesh = session.mesh("m" + std::to_string(kind));
    if (kind == 0)
      mesh.flat_uniform_block({n + 1, n + 1}, {-1, 2}, {1, 1}, {1, -2});
    if (kind == 1)
      mesh.flat_rectilinear_block(insitu::Array(axis), insitu::Array(axis));
    if (kind == 2) {
      mesh.flat_block(n + 1, n + 1);
      mesh.points(insitu::Array(m.x), insitu::Array(m.y));
    }
    mesh.vertex_field("f", insitu::Array(f));
    mesh.cell_field("c", insitu::Array(cells));
    mesh.commit();
    expect_answers(mesh, m, n);
    const insitu::Samples c = mesh.sample("c", points_of(m, n));
    for (std::size_t i = 0; i < c.values.size(); ++i)
      if (c.found[i]) {
        ASSERT_EQ(c.values[i], double(c.cells[i]));
      }
    if (kind < 2)
      EXPECT_EQ(session.report().bytes_by_purpose[INSITU_MEMORY_FLAT], 0);
    else
      EXPECT_GT(session.report().bytes_by_purpose[INSITU_MEMORY_FLAT], 0);
  }
}

TEST(FlatMeshes, BilinearFieldsAreMetOnRectangles) {
  constexpr int n = 4;
  std::vector<double> f;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      f.push_back((1.0 + 0.5 * i) * (2.0 - 0.25 * j));
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  mesh.flat_uniform_block({n + 1, n + 1}, {0, 0}, {0.5, 0.25});
  mesh.vertex_field("f", insitu::Array(f));
  mesh.commit();
  std::mt19937_64 random(3);
  for (int k = 0; k < 500; ++k) {
    const double x = 2.0 * double(random()) / 0x1p64, y = double(random()) / 0x1p64;
    double value = 0;
    ASSERT_TRUE(mesh.sample_point("f", {x, y, 1e6}, insitu::View<double>(&value, 1)));
    ASSERT_NEAR(value, (1.0 + x) * (2.0 - y), rounding);
  }
}

TEST(FlatMeshes, VerticesThatMove) {
  constexpr int n = 4;
  Flat m = flat_mesh(n, Kind::mixed, true);
  Arrays arrays(m, Kind::mixed);
  std::vector<double> f = values_of(m);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  arrays.give(mesh, Kind::mixed);
  mesh.vertex_field("f", insitu::Array(f));
  mesh.commit();
  for (int step = 0; step < 3; ++step) {
    for (std::size_t v = 0; v < m.vertices(); ++v) {
      m.x[v] = arrays.xy[2 * v] += 0.25 * m.y[v];
      f[v] = linear(m.x[v], m.y[v]);
    }
    mesh.changed(insitu::geometry | insitu::fields);
    const insitu::CommitReport report = mesh.commit();
    EXPECT_NE(report.action, INSITU_KEEP);
    expect_answers(mesh, m, n);
  }
}

TEST(FlatMeshes, LowerCellsAreLeftOutWithOneWarningThatCountsThem) {
  std::vector<std::string> warnings;
  insitu::Options options;
  options.log = [&](insitu::LogLevel level, const char* message) {
    if (level <= insitu::LogLevel::warning)
      warnings.push_back(message);
  };
  insitu::Session session(options);
  // A line, a quad, a vertex, two triangles: a flat mesh of three.
  const std::vector<double> xy{0, 0, 1, 0, 1, 1, 0, 1, 2, 0, 2, 1};
  const std::vector<int> ids{0, 1, 0, 1, 2, 3, 5, 1, 4, 2, 4, 5, 2}, offsets{0, 2, 6, 7, 10, 13};
  const std::vector<std::uint8_t> types{3, 9, 1, 5, 5};
  const std::vector<double> number{0, 1, 2, 3, 4};
  insitu::Mesh mesh = session.mesh("m");
  mesh.flat_points(insitu::Array(xy.data(), 6));
  mesh.mixed_cells(insitu::Array(types), insitu::Array(offsets), insitu::Array(ids));
  mesh.cell_field("number", insitu::Array(number));
  mesh.commit();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("1 lines, 1 vertices"), std::string::npos) << warnings[0];
  const insitu::Samples s = mesh.sample(
      "number", std::vector<double>{0.5, 0.5, 0, 0.5, 0, 0, 1.25, 0.25, 0, 1.75, 0.75, 0});
  EXPECT_EQ(s.cells, (std::vector<std::int64_t>{1, 1, 3, 4}));
  EXPECT_EQ(s.values, (std::vector<double>{1, 1, 3, 4}));

  // The same beside a volume cell, as meshers write boundaries.
  std::vector<double> box;
  for (int v = 0; v < 8; ++v)
    box.insert(box.end(), {double(v & 1), double((v >> 1) & 1), double(v >> 2)});
  const std::vector<int> box_ids{0, 1, 3, 2, 0, 1, 0, 1, 3, 2, 4, 5, 7, 6, 4, 5, 7},
      starts{0, 4, 6, 14, 17};
  const std::vector<std::uint8_t> box_types{9, 3, 12, 5};
  insitu::Mesh volume = session.mesh("volume");
  volume.points(insitu::Array(box.data(), 8));
  volume.mixed_cells(insitu::Array(box_types), insitu::Array(starts), insitu::Array(box_ids));
  volume.commit();
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[1].find("2 triangles, quads and other surfaces, 1 lines"), std::string::npos)
      << warnings[1];
  const insitu::Locations at = volume.locate(std::vector<double>{0.5, 0.5, 0.5, 0.5, 0.5, 0});
  EXPECT_EQ(at.cells, (std::vector<std::int64_t>{2, 2}));
}

TEST(FlatMeshes, GhostsSeveralPiecesAndNone) {
  constexpr int n = 3;
  const Flat m = flat_mesh(n, Kind::quads, true);
  Arrays arrays(m, Kind::quads);
  const std::vector<double> f = values_of(m);
  std::vector<std::uint8_t> ghosts(m.cells.size(), 0);
  ghosts[4] = 1;
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  arrays.give(mesh, Kind::quads);
  mesh.vertex_field("f", insitu::Array(f));
  mesh.ghosts(insitu::Array(ghosts));
  // A block to the east, and a piece without cells.
  std::vector<double> east;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      east.push_back(linear(n + i, j));
  insitu::Piece block = mesh.piece(1), none = mesh.piece(2);
  block.flat_uniform_block({n + 1, n + 1}, {n, 0}, {1, 1});
  block.vertex_field("f", insitu::Array(east));
  none.triangles(static_cast<const int*>(nullptr), 0);
  mesh.commit();
  const insitu::Samples s =
      mesh.sample("f", std::vector<double>{1.5, 1.5, 0, 3, 1.5, 0, 4.5, 0.5, 7});
  EXPECT_EQ(s.found, (std::vector<std::uint8_t>{0, 1, 1}));
  EXPECT_EQ(s.pieces, (std::vector<std::int32_t>{-1, 0, 1}));
  EXPECT_NEAR(s.values[1], linear(3, 1.5), rounding);
  EXPECT_NEAR(s.values[2], linear(4.5, 0.5), rounding);
}

TEST(FlatMeshes, OnLongitudeAndLatitude) {
  // Quads of 10 degrees all around, to both poles, numbered from 180 degrees on.
  constexpr int ni = 36, nj = 18;
  std::vector<double> lon, lat, f, east;
  for (int j = 0; j <= nj; ++j)
    for (int i = 0; i < ni; ++i) {
      lon.push_back(i < ni / 2 ? 180 + 10 * i : 10 * i - 180);
      lat.push_back(-90 + 10 * j);
      f.push_back(lat.back());
    }
  std::vector<int> ids;
  for (int j = 0; j < nj; ++j)
    for (int i = 0; i < ni; ++i) {
      const int v = i + ni * j, w = (i + 1) % ni + ni * j;
      ids.insert(ids.end(), {v, w, w + ni, v + ni});
    }
  insitu_frame frame = insitu_frame_default();
  frame.kind = INSITU_FRAME_GEODETIC;
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  mesh.points(insitu::Array(lon), insitu::Array(lat));
  mesh.quads(ids);
  mesh.vertex_field("f", insitu::Array(f));
  ASSERT_EQ(insitu_mesh_frame(mesh.handle(), &frame), INSITU_OK);
  mesh.commit();
  std::mt19937_64 random(5);
  std::vector<double> points;
  for (int k = 0; k < 500; ++k)
    points.insert(points.end(), {720.0 * double(random()) / 0x1p64 - 360.0,
                                 160.0 * double(random()) / 0x1p64 - 80.0, 1e4});
  points.insert(points.end(), {180, 0, 0, -180, 5, 0, 175, 85, 0, 0, -90, 0, 12, 90, 0});
  const insitu::Samples s = mesh.sample("f", points);
  for (std::size_t i = 0; i < points.size() / 3; ++i) {
    ASSERT_TRUE(s.found[i]) << points[3 * i] << " " << points[3 * i + 1];
    if (std::abs(points[3 * i + 1]) < 80) {
      ASSERT_NEAR(s.values[i], points[3 * i + 1], 1e-12); // a few roundings of 360
    }
  }
}

TEST(BadFlatMeshes, SurfacesCurvedInSpaceAndBadIdsAreRefusedByCell) {
  const Flat m = flat_mesh(3, Kind::quads, false);
  Arrays arrays(m, Kind::quads);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  const auto give = [&](const std::vector<double>& z) {
    mesh.points(insitu::Array(m.x), insitu::Array(m.y), insitu::Array(z));
    mesh.quads(arrays.ids.data(), arrays.types.size());
  };
  std::vector<double> z(m.vertices(), 2.0);
  give(z);
  EXPECT_EQ(refusal(mesh), "");
  z[5] = 2.25;
  mesh.changed(insitu::everything);
  EXPECT_REFUSED(mesh, "'m'", "piece 0, cell 0", "vertex id 5", "lies 0.25 out of the plane z = 2",
                 "curved in space");
  // In another plane.
  mesh.points(insitu::Array(z), insitu::Array(m.x), insitu::Array(m.y));
  z[5] = 2.0;
  EXPECT_REFUSED(mesh, "constant x", "give its two other coordinates");
  give(z);
  EXPECT_EQ(refusal(mesh), "");
  z[5] = std::numeric_limits<double>::quiet_NaN();
  mesh.changed(insitu::everything);
  EXPECT_REFUSED(mesh, "cell 0", "vertex id 5", "coordinate z is NaN");
  z[5] = 2.0;
  arrays.ids[6] = 99;
  mesh.changed(insitu::everything);
  EXPECT_REFUSED(mesh, "piece 0, cell 1", "vertex 2 has id 99", "0 to 15 expected");
  EXPECT_FALSE(mesh.validate().accepted);
  arrays.ids[6] = -1;
  mesh.changed(insitu::everything);
  EXPECT_REFUSED(mesh, "vertex 2 has id -1");
}

TEST(BadFlatMeshes, KindsThatDoNotFit) {
  const Flat m = flat_mesh(2, Kind::quads, false);
  Arrays arrays(m, Kind::quads);
  const std::vector<double> z(m.vertices(), 0.0);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  arrays.give(mesh, Kind::quads);
  insitu::Piece volume = mesh.piece(1);
  volume.uniform_block({2, 2, 2}, {0, 0, 0}, {1, 1, 1});
  EXPECT_REFUSED(mesh, "piece 0: has flat cells, but piece 1 has volume cells");
  insitu::Mesh points = session.mesh("two coordinates");
  points.points(insitu::Array(m.x), insitu::Array(m.y));
  const std::vector<int> tetrahedron{0, 1, 3, 4};
  points.tetrahedra(tetrahedron);
  EXPECT_REFUSED(points, "2 coordinates a vertex, 3 expected");
  // Polygons, and cells that end too early.
  insitu::Mesh mixed = session.mesh("mixed");
  mixed.points(insitu::Array(m.x), insitu::Array(m.y));
  std::vector<std::uint8_t> types{9, 7};
  std::vector<int> offsets{0, 4, 9}, ids{0, 1, 4, 3, 1, 2, 5, 8, 4};
  mixed.mixed_cells(insitu::Array(types), insitu::Array(offsets), insitu::Array(ids));
  EXPECT_REFUSED(mixed, "cell 1: type 7, 5, 8 or 9 expected of a flat mesh");
  types[1] = 5;
  mixed.changed(insitu::everything);
  EXPECT_REFUSED(mixed, "cell 1", "5 ids between its offsets, 3 expected");
  insitu_block block = insitu_block_default();
  block.dimensions = 4;
  EXPECT_EQ(insitu_mesh_block(mixed.handle(), 0, &block), INSITU_ERROR_ARGUMENT);
  block.dimensions = 2;
  block.vertices[0] = block.vertices[1] = block.vertices[2] = 3;
  EXPECT_EQ(insitu_mesh_block(mixed.handle(), 0, &block), INSITU_ERROR_ARGUMENT);
  EXPECT_NE(std::string(insitu_last_message()).find("3 vertices along axis 2"), std::string::npos);
}

TEST(BadFlatMeshes, CellsWithoutAreaAreCounted) {
  const std::vector<double> x{0, 1, 2, 0}, y{0, 0, 0, 1};
  const std::vector<int> ids{0, 1, 2, 0, 1, 3, 1, 1, 3};
  insitu::Options options;
  std::vector<std::string> warnings;
  options.log = [&](insitu::LogLevel level, const char* message) {
    if (level <= insitu::LogLevel::warning)
      warnings.push_back(message);
  };
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("m");
  mesh.points(insitu::Array(x), insitu::Array(y));
  mesh.triangles(ids);
  mesh.commit();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("2 have no volume"), std::string::npos) << warnings[0];
  EXPECT_EQ(mesh.locate(std::vector<double>{0.25, 0.25, 0}).cells[0], 1);
}
