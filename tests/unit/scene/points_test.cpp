#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <set>
#include <tuple>

#include "scene/earth/reference_frames.h"
#include "scene/probes/points.h"
#include "scene/probes/points_file.h"
#include "scene_test.h"

using namespace insitu;
using namespace insitu::scene;

namespace {

std::string error(const std::string& text) {
  return test::error_of_call([&] { parse_points_text(text, "p.csv"); });
}

TEST(FrameOfReference, UnitsAreThoseOfGeodeticFrames) {
  insitu_frame mesh = insitu_frame_default();
  mesh.kind = INSITU_FRAME_GEODETIC;
  mesh.angle = INSITU_RADIANS;
  mesh.length = INSITU_KILOMETRES;
  mesh.vertical = INSITU_DOWN;
  FrameOfReference stated;
  stated.kind = FrameOfReference::Kind::geodetic;
  const double degree = std::atan(1.0) / 45;
  std::vector<insitu::math::Vec3d> points{{180, 45, -250}, {-90, 90, 0}};
  convert_points(points, to_api(stated, mesh), mesh);
  EXPECT_NEAR(points[0].x, 180 * degree, 1e-15);
  EXPECT_NEAR(points[0].y, 45 * degree, 1e-15);
  EXPECT_EQ(points[0].z, 0.25);
  EXPECT_EQ(points[1].y, std::atan(1.0) * 2); // the pole stays the pole, the surface the surface
  EXPECT_EQ(points[1].z, 0.0);
  stated.depth = true;
  EXPECT_EQ(to_api(stated, mesh).vertical, INSITU_DOWN);
  stated.kind = FrameOfReference::Kind::mesh; // in its own units
  EXPECT_EQ(to_api(stated, mesh).angle, INSITU_RADIANS);

  insitu_frame bad = mesh;
  bad.kind = INSITU_FRAME_ENU;
  EXPECT_THROW(read_frame(bad), insitu::core::Error);
  bad = mesh;
  bad.angle = insitu_angle(7);
  EXPECT_THROW(read_frame(bad), insitu::core::Error);
  bad = mesh;
  bad.size = 3;
  EXPECT_THROW(read_frame(bad), insitu::core::Error);
  // From a header without units: what it meant then.
  insitu_frame old = mesh;
  old.size = offsetof(insitu_frame, angle);
  const insitu_frame read = read_frame(old);
  EXPECT_EQ(read.size, sizeof read);
  EXPECT_EQ(read.angle, INSITU_DEGREES);
  EXPECT_EQ(read.vertical, INSITU_UP);
}

} // namespace

TEST(Points, Lines) {
  const PointSource line = Line{{0.1, 0, -3}, {0.3, 1, 7}, 11};
  EXPECT_EQ(point_count(line), 11);
  EXPECT_EQ(point_at(line, 0), (math::Vec3d{0.1, 0, -3}));
  EXPECT_EQ(point_at(line, 10), (math::Vec3d{0.3, 1, 7}));
  EXPECT_NEAR(point_at(line, 5).z, 2, 1e-14);
  EXPECT_NEAR(point_at(Line{{0, 0, 0}, {1, 2, 3}, 1}, 0).y, 1, 0); // a single one in the middle
  EXPECT_EQ(point_at(Transect{{0, 0, 0}, {4, 0, 0}, 5}, 3).x, 3);
  EXPECT_EQ(point_at(Line{{-1e308, 0, 0}, {1e308, 0, 0}, 3}, 1).x, 0); // no overflow
}

TEST(Points, CurtainsAreColumnsAlongAPath) {
  // 3 + 4 + 5 long: twelve steps of 1 and corners that are stations.
  const Curtain curtain{{{0, 0, 0}, {3, 0, 0}, {3, 4, 0}, {0, 0, 0}}, 13, {2, -1}};
  ASSERT_EQ(point_count(curtain), 26);
  EXPECT_EQ(path_length(curtain), 12);
  EXPECT_EQ(point_at(curtain, 0), (math::Vec3d{0, 0, 2}));
  EXPECT_EQ(point_at(curtain, 1), (math::Vec3d{0, 0, -1}));
  EXPECT_EQ(point_at(curtain, 25), (math::Vec3d{0, 0, -1}));
  const auto near = [&](std::int64_t station, const math::Vec3d& at) {
    const math::Vec3d d = point_at(curtain, 2 * station) - at;
    EXPECT_LT(std::sqrt(math::dot(d, d)), 1e-14) << station;
    EXPECT_EQ(distance_at(curtain, station), double(station));
  };
  near(2, {2, 0, 2});
  near(3, {3, 0, 2});
  near(5, {3, 2, 2});
  near(7, {3, 4, 2});
  near(12 - 5 + 1, {3 - 0.6, 4 - 0.8, 2});
}

TEST(Points, BoxesCountXFirstAndMeetTheirCorners) {
  const PointSource box = Box{{0.1, 0.2, 0.3}, {0.7, 0.9, 1.1}, {3, 4, 5}};
  ASSERT_EQ(point_count(box), 60);
  EXPECT_EQ(point_at(box, 0), (math::Vec3d{0.1, 0.2, 0.3}));
  EXPECT_EQ(point_at(box, 2), (math::Vec3d{0.7, 0.2, 0.3}));
  EXPECT_EQ(point_at(box, 9), (math::Vec3d{0.1, 0.9, 0.3}));
  EXPECT_EQ(point_at(box, 59), (math::Vec3d{0.7, 0.9, 1.1}));
  std::set<std::tuple<double, double, double>> different;
  for (std::int64_t i = 0; i < 60; ++i) {
    const math::Vec3d p = point_at(box, i);
    different.insert({p.x, p.y, p.z});
  }
  EXPECT_EQ(different.size(), 60u);
}

TEST(Points, Planes) {
  const PointSource plane = Plane{{1, 1, 1}, {2, 0, 0}, {0, 4, 0}, {3, 2}};
  ASSERT_EQ(point_count(plane), 6);
  EXPECT_EQ(point_at(plane, 1), (math::Vec3d{2, 1, 1}));
  EXPECT_EQ(point_at(plane, 5), (math::Vec3d{3, 5, 1}));
}

TEST(Points, BallsAreFilledEvenly) {
  const std::int64_t count = 8000;
  const Sphere ball{{1, 2, 3}, 2, count};
  const PointSource source = ball;
  std::array<int, 8> octants{};
  int inner = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    const math::Vec3d p = point_at(source, i) - ball.center;
    const double radius = std::sqrt(math::dot(p, p));
    ASSERT_LE(radius, 2 * (1 + 1e-12));
    inner += radius < 1 ? 1 : 0;
    ++octants[static_cast<std::size_t>((p.x > 0) + 2 * (p.y > 0) + 4 * (p.z > 0))];
  }
  EXPECT_NEAR(inner, count / 8, 1); // half the radius holds an eighth of the volume
  for (const int octant : octants) {
    EXPECT_NEAR(octant, count / 8, 0.02 * count / 8);
  }
}

TEST(PointsFile, Cartesian) {
  const PointTable table =
      parse_points_text("\xEF\xBB\xBFz , X,y\r\n# comment\r\n\r\n3,1,2\r\n+.5, -1e2 ,0", "p.csv");
  ASSERT_EQ(table.points.size(), 2u);
  EXPECT_EQ(table.points[0], (math::Vec3d{1, 2, 3}));
  EXPECT_EQ(table.points[1], (math::Vec3d{-100, 0, 0.5}));
  EXPECT_FALSE(table.geographic || table.depth);
  EXPECT_TRUE(table.names.empty());
}

TEST(PointsFile, Geographic) {
  const PointTable table = parse_points_text(
      "name,lon,lat,depth,comment\n\"a, \"\"b\"\"\",-170,90,5,x\n,10,-90,0,\n", "p.csv");
  ASSERT_EQ(table.points.size(), 2u);
  EXPECT_TRUE(table.geographic && table.depth);
  EXPECT_EQ(table.points[0], (math::Vec3d{-170, 90, 5}));
  EXPECT_EQ(table.names, (std::vector<std::string>{"a, \"b\"", ""}));
  EXPECT_FALSE(parse_points_text("longitude,latitude,height\n1,2,3\n", "p.csv").depth);
}

TEST(PointsFile, Errors) {
  EXPECT_EQ(error(""),
            "p.csv: the file is empty; its first line names the columns: x,y,z or lon,lat,height");
  EXPECT_EQ(error("x,y,z\n"), "p.csv: the file has no points");
  EXPECT_EQ(error("1,2,3\n4,5,6\n"),
            "p.csv:1: the first line must name the columns: x,y,z or lon,lat,height (or "
            "depth), and optionally name");
  EXPECT_EQ(error("x,y\n1,2\n"), "p.csv:1: column 'z' is missing");
  EXPECT_EQ(error("lon,lattitude,height\n1,2,3\n").find("p.csv:1: column 'lat' is missing"), 0u);
  EXPECT_EQ(error("lon,lat,hieght\n1,2,3\n"),
            "p.csv:1: column 'height' or 'depth' is missing; is it 'hieght'?");
  EXPECT_EQ(error("x,y,z,x\n1,2,3,4\n"), "p.csv:1:7: column 'x' repeats column 'x'");
  EXPECT_EQ(error("lon,lat,height,depth\n1,2,3,4\n"),
            "p.csv:1:16: column 'depth' repeats column 'height'");
  EXPECT_EQ(error("x,lat,z\n1,2,3\n"),
            "p.csv:1: the columns mix x, y, z with longitude and latitude");
  EXPECT_EQ(error("x,y,z\n1,2\n"), "p.csv:2: 3 columns expected, 2 found");
  EXPECT_EQ(error("x,y,z\n1, two,3\n"), "p.csv:2:4: a finite number expected, 'two' found");
  EXPECT_EQ(error("x,y,z\n1,,3\n"), "p.csv:2:3: a finite number expected, nothing found");
  EXPECT_EQ(error("x,y,z\n1,2,inf\n"), "p.csv:2:5: a finite number expected, 'inf' found");
  EXPECT_EQ(error("lon,lat,height\n0,91,0\n"),
            "p.csv:2:3: a latitude from -90 to 90 degrees expected, '91' found");
  EXPECT_EQ(error("x,y,z,name\n1,2,3,\"a\n").find("p.csv:2:7: the quotation mark is not closed"),
            0u);
  EXPECT_EQ(error("x,y,z,name\n1,2,3,\"a\"b\n").find("p.csv:2:7: the quotation mark is not closed"),
            0u);
  EXPECT_EQ(error("x,y,z\na,2,3\n1,b,3\n"), "p.csv:2:1: a finite number expected, 'a' found\n"
                                            "p.csv:3:3: a finite number expected, 'b' found");
  EXPECT_EQ(error("x,y,z\n" + std::string(70000, '1')),
            "p.csv:2: the line has more than 65536 bytes");
}

TEST(PointsFile, IsReadFromDisk) {
  const auto path = (std::filesystem::path(testing::TempDir()) / "insitu_points.csv").string();
  std::ofstream(path) << "x,y,z\n1,2,3\n";
  EXPECT_EQ(read_points_file(path).points.size(), 1u);
  for (const std::string wrong : {"/nowhere/p.csv", "/"}) {
    try {
      read_points_file(wrong);
      FAIL() << wrong;
    } catch (const core::Error& e) {
      EXPECT_EQ(e.status(), INSITU_ERROR_FILE);
      EXPECT_NE(std::string(e.what()).find("'" + wrong + "'"), std::string::npos);
    }
  }
}

TEST(PointsFile, ColumnsMustSuitTheFrame) {
  using Kind = FrameOfReference::Kind;
  PointTable table;
  table.file = "p.csv";
  FrameOfReference frame;
  frame.line = 4;
  EXPECT_EQ(frame_of(table, frame, "s.yaml").kind, Kind::mesh);
  table.geographic = table.depth = true;
  EXPECT_EQ(frame_of(table, frame, "s.yaml").kind, Kind::geodetic);
  EXPECT_TRUE(frame_of(table, frame, "s.yaml").depth);
  frame.kind = Kind::utm;
  EXPECT_EQ(
      test::error_of_call([&] { frame_of(table, frame, "s.yaml"); }),
      "s.yaml:4: the columns of 'p.csv' are longitude and latitude, but the frame is not geodetic");
  frame.kind = Kind::geodetic;
  table.geographic = false;
  EXPECT_EQ(test::error_of_call([&] { frame_of(table, frame, "s.yaml"); }),
            "s.yaml:4: the columns of 'p.csv' are x, y, z, but the frame is geodetic");
}
