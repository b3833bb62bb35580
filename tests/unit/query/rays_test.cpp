// Ray methods: the answers are those of bvh, in exact and standard; fast is what the papers' rules
// make of it.
#include "rays_test.h"

#include <algorithm>
#include <numeric>

using namespace insitu;
using accel::Method;
using math::Vec3d;
using query::Location;
using test::all_kinds;
using test::Answers;
using test::ask;
using test::box;
using test::expect_same;
using test::MeshKind;
using test::points_of;
using test::ray_methods;
using test::TestMesh;
using test::upright;

namespace {

/// Every ray method against what stands, which answers by bvh.
void check(fixtures::Committed& m, const std::vector<Vec3d>& points, const std::string& what) {
  m.mesh.set_locator({Method::bvh, accel::Backend::cpu});
  m.commit();
  const Answers exact = ask(m, points, INSITU_EXACT), standard = ask(m, points, INSITU_STANDARD);
  for (std::size_t i = 0; i < points.size(); i += 5)
    ASSERT_EQ(exact.at[i].cell, test::owner(m.sampler().mesh(), points[i])) << what;
  for (const Method method : ray_methods) {
    m.mesh.set_locator({method, accel::Backend::cpu});
    m.commit();
    ASSERT_NE(m.mesh.locators().rays(), nullptr);
    const std::string name = what + ", " + accel::name(method);
    const std::int64_t kept = m.mesh.locators().ray_counts().kept;
    expect_same(ask(m, points, INSITU_EXACT), exact, points, name + ", exact");
    // What rays_kept_test.cpp has in shares: the rays were asked, where they may answer.
    EXPECT_EQ(m.mesh.locators().ray_counts().kept > kept, m.sampler().mesh().covers_once) << name;
    if (m.sampler().mesh().covers_once)
      expect_same(ask(m, points, INSITU_STANDARD), standard, points, name + ", standard");
  }
}

void check(const TestMesh& from, const std::string& what, int count = 1500) {
  fixtures::Committed m(from, 2);
  check(m, points_of(m.sampler().mesh(), count, 41), what);
}

std::int64_t wrong(const std::vector<Location>& a, const std::vector<Location>& b) {
  std::int64_t n = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    n += a[i].cell != b[i].cell;
  return n;
}

Vec3d turned(const Vec3d& p) { // about a line that is no axis
  const Vec3d u{0.36, 0.48, 0.8}, n = cross(u, p);
  return 0.6 * p + 0.8 * n + (0.4 * dot(u, p)) * u;
}

} // namespace

TEST(Rays, AnswerAsTheTreeOnEveryShape) {
  for (const MeshKind kind : all_kinds)
    check(upright(box(kind, 6)), kind_name(kind));
  check(box(MeshKind::tetrahedra, 5), "tetrahedra, half of them inverted");
}

TEST(Rays, AnswerAsTheTreeOnTwistedLongFarAndFlatCells) {
  check(box(MeshKind::hexahedra, 6, 0.45), "twisted, some folded");
  check(box(MeshKind::mixed, 5, 0.4), "twisted, mixed");
  check(test::twisted_box(6, 0.4), "twisted, none folded");
  check(box(MeshKind::hexahedra, 3, 0.2, 0, {100, 1, 1}), "long");
  check(box(MeshKind::wedges, 3, 0.2, 0, {1, 1, 1e5}), "needles");
  check(box(MeshKind::hexahedra, 5, 0.2, 1e7), "far from zero");
  check(box(MeshKind::hexahedra, 5, 0.2, 0, {1, 1, 1e-6}), "sheets");
}

TEST(Rays, AnswerAsTheTreeOnOddMeshes) {
  TestMesh one;
  const test::Vertices unit = test::unit_cell(mesh::Shape::hexahedron);
  one.vertices.assign(unit.begin(), unit.end());
  one.cells = {{mesh::Shape::hexahedron, {0, 1, 2, 3, 4, 5, 6, 7}}};
  check(one, "one cell", 300);

  TestMesh twice = box(MeshKind::hexahedra, 4);
  for (std::size_t c = 0; c < 64; c += 3)
    twice.cells.push_back(twice.cells[c]);
  std::reverse(twice.cells.begin(), twice.cells.end());
  check(twice, "duplicates, faces of three cells");

  TestMesh alone = one;
  alone.cells.push_back(alone.cells[0]);
  check(alone, "one cell twice", 300);

  TestMesh copies = box(MeshKind::tetrahedra, 3);
  const int vertices = int(copies.vertices.size());
  const auto cells = copies.cells.size();
  for (int v = 0; v < vertices; ++v)
    copies.vertices.push_back(Vec3d{copies.vertices[std::size_t(v)]} + Vec3d{0.5, 0.25, 0.125});
  for (std::size_t c = 0; c < cells; ++c) {
    test::MeshCell cell = copies.cells[c];
    for (int& v : cell.vertices)
      v += vertices;
    copies.cells.push_back(cell);
  }
  std::reverse(copies.cells.begin(), copies.cells.end());
  check(copies, "two overlapping boxes");

  check(test::make_mesh({.kind = MeshKind::mixed, .size = 5, .jitter = 0.2, .collapse = 0.2}, 3),
        "vertices at the same place");
  TestMesh wedges = box(MeshKind::hexahedra, 4); // by repeated ids, an edge at a time
  for (std::size_t c = 0; c < wedges.cells.size(); c += 4) {
    auto& v = wedges.cells[c].vertices;
    v[3] = v[2];
    v[7] = v[6];
  }
  wedges.vertices.insert(wedges.vertices.end(), 5, {0.1, 0.1, 0.1}); // isolated
  check(wedges, "hexahedra collapsed to wedges");
}

TEST(Rays, SkipGhostsAndJoinPieces) {
  const TestMesh from = box(MeshKind::mixed, 5);
  const fixtures::SolverArrays arrays(from);
  fixtures::SolverArrays beside(from);
  for (std::size_t i = 0; i < beside.points.size(); i += 3)
    beside.points[i] += 4.5; // overlaps the first
  std::vector<std::uint8_t> ghosts(from.cells.size());
  for (std::size_t i = 0; i < ghosts.size(); ++i)
    ghosts[i] = i % 7 == 3;
  fixtures::Committed m(2);
  const insitu_array p0 = arrays.point_array(), p1 = beside.point_array();
  const insitu_cells c = arrays.cells();
  const insitu_array g = insitu_array_of(ghosts.data(), INSITU_UINT8, c.count, 1);
  m.mesh.mesh().set_points(0, &p0, 1);
  m.mesh.mesh().set_cells(0, &c);
  m.mesh.mesh().set_ghosts(0, &g, INSITU_GHOSTS_ASCENT);
  m.commit();
  check(m, points_of(m.sampler().mesh(), 1500, 43), "ghosts");
  m.mesh.mesh().set_points(1, &p1, 1);
  m.mesh.mesh().set_cells(1, &c);
  m.commit(INSITU_CHANGED_ALL);
  check(m, points_of(m.sampler().mesh(), 1500, 44), "two pieces");
}

TEST(Rays, FollowMovedVertices) {
  for (const MeshKind kind : {MeshKind::hexahedra, MeshKind::mixed})
    for (const Method method : ray_methods) {
      const TestMesh from = box(kind, 6, 0.0); // planar at first: the move bends faces
      fixtures::Committed m(from, 2), fresh(from, 2);
      m.mesh.set_locator({method, accel::Backend::cpu});
      m.commit();
      test::Random random(7);
      for (int step = 0; step < 4; ++step) {
        for (double& x : m.arrays.points)
          x = step == 2 ? x + 100 : x + random.uniform(-0.05, 0.05); // step 2 moves the whole
        m.commit(INSITU_CHANGED_GEOMETRY);
        fresh.arrays.points = m.arrays.points;
        fresh.commit(INSITU_CHANGED_ALL);
        const auto points = points_of(fresh.sampler().mesh(), 800, std::uint64_t(50 + step));
        const std::string what =
            std::string(accel::name(method)) + ", step " + std::to_string(step);
        expect_same(ask(m, points, INSITU_EXACT), ask(fresh, points, INSITU_EXACT), points, what);
        EXPECT_TRUE(m.sampler().mesh().covers_once) << what;
        const std::int64_t before = m.mesh.locators().ray_counts().kept;
        const auto inner = test::inner_points(m.sampler().mesh(), 1000, 3);
        ask(m, inner, INSITU_EXACT);
        EXPECT_GT(m.mesh.locators().ray_counts().kept - before, 850) << what; // refitted, not lost
      }
    }
}

TEST(Rays, LeavePointsBetweenStepsToTheTree) {
  fixtures::Committed m(box(MeshKind::hexahedra, 5), 2);
  m.mesh.set_locator({Method::shared_bilinear_faces, accel::Backend::cpu});
  m.commit();
  m.mesh.mesh().keep_earlier({}, m.threads);
  test::Random random(9);
  for (double& x : m.arrays.points)
    x += random.uniform(-0.05, 0.05);
  m.commit(INSITU_CHANGED_GEOMETRY);
  m.mesh.show_earlier(m.threads);
  const auto points = test::inner_points(m.sampler().mesh(), 1000, 5);
  for (const insitu_accuracy accuracy : {INSITU_FAST, INSITU_STANDARD, INSITU_EXACT}) {
    std::vector<Location> at(points.size());
    m.sampler().locate(m.threads, points, at, {accuracy, 0.5});
    for (std::size_t i = 0; i < points.size(); ++i)
      ASSERT_EQ(at[i].cell, test::owner(m.sampler().mesh(), points[i], 0.5));
  }
  EXPECT_EQ(m.mesh.locators().ray_counts().by_tree, 3000);
}

TEST(Rays, WithoutCoordinatesTheHitAloneTellsTheCellInFast) {
  const TestMesh from = box(MeshKind::hexahedra, 8, 0.2);
  for (const Method method : ray_methods) {
    fixtures::Committed m(from, 2);
    m.mesh.set_locator({method, accel::Backend::cpu});
    m.commit();
    const auto points = points_of(m.sampler().mesh(), 2000, 67);
    for (const insitu_accuracy accuracy : {INSITU_FAST, INSITU_STANDARD, INSITU_EXACT}) {
      const Answers whole = ask(m, points, accuracy);
      Answers cells{std::vector<Location>(points.size()), std::vector<std::uint8_t>(points.size())};
      m.sampler().locate(m.threads, points, cells.at, {accuracy, 1.0, false}, cells.reasons);
      for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_EQ(cells.at[i].cell, whole.at[i].cell) << accel::name(method) << ", point " << i;
        if (accuracy == INSITU_FAST && cells.at[i]) { // Newton's method did not run
          EXPECT_EQ(cells.reasons[i], std::uint8_t(query::Reason::on_face));
          EXPECT_EQ(dot(cells.at[i].parametric, cells.at[i].parametric), 0.0);
        } else {
          EXPECT_EQ(cells.reasons[i], whole.reasons[i]);
        }
      }
    }
  }
}

TEST(Rays, FindNothingWhereNoCellOwnsPoints) {
  const TestMesh from = box(MeshKind::hexahedra, 3);
  for (const Method method : ray_methods) {
    fixtures::Committed m(from, 2);
    const std::vector<std::uint8_t> ghosts(from.cells.size(), 1);
    const insitu_array g = insitu_array_of(ghosts.data(), INSITU_UINT8, m.arrays.cell_count(), 1);
    m.mesh.mesh().set_ghosts(0, &g, INSITU_GHOSTS_ASCENT);
    m.mesh.set_locator({method, accel::Backend::cpu});
    m.commit(INSITU_CHANGED_ALL);
    const std::vector<Vec3d> points(100, {1.5, 1.5, 1.5});
    for (const insitu_accuracy accuracy : {INSITU_FAST, INSITU_STANDARD, INSITU_EXACT})
      for (const Location& at : ask(m, points, accuracy).at)
        ASSERT_FALSE(at);
  }
}

TEST(Rays, DoNotDependOnBatchesOrThreads) {
  const TestMesh from = box(MeshKind::mixed, 7);
  for (const Method method : ray_methods)
    for (const insitu_accuracy accuracy : {INSITU_FAST, INSITU_STANDARD, INSITU_EXACT}) {
      Answers first;
      for (const int threads : {1, 2, 4}) {
        fixtures::Committed m(from, threads);
        m.mesh.set_locator({method, accel::Backend::cpu});
        m.commit();
        const auto points = points_of(m.sampler().mesh(), 3000, 61);
        const Answers a = ask(m, points, accuracy);
        if (first.at.empty())
          first = a;
        expect_same(a, first, points, accel::name(method));
        EXPECT_EQ(a.reasons, first.reasons);
        Answers parts{std::vector<Location>(points.size()),
                      std::vector<std::uint8_t>(points.size())};
        for (std::size_t i = 0; i < points.size(); i += 77) {
          const std::size_t n = std::min<std::size_t>(77, points.size() - i);
          m.sampler().locate_serial(std::span(points).subspan(i, n),
                                    std::span(parts.at).subspan(i, n), {accuracy, 1.0},
                                    std::span(parts.reasons).subspan(i, n));
        }
        expect_same(parts, first, points, accel::name(method));
        EXPECT_EQ(parts.reasons, first.reasons);
      }
    }
}

TEST(Rays, FastIsWrongAsOftenAsThePaperSays) {
  const auto share = [](const TestMesh& from, Method method) {
    fixtures::Committed m(from, 2);
    const auto points = test::inner_points(m.sampler().mesh(), 20000, 71);
    const Answers exact = ask(m, points, INSITU_EXACT);
    m.mesh.set_locator({method, accel::Backend::cpu});
    m.commit();
    const Answers fast = ask(m, points, INSITU_FAST);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const bool certified = fast.reasons[i] == std::uint8_t(query::Reason::certified);
      EXPECT_TRUE(!certified || fast.at[i].cell == exact.at[i].cell);
      EXPECT_EQ(fast.at[i].cell < 0, fast.reasons[i] == std::uint8_t(query::Reason::outside));
    }
    const double found = double(wrong(fast.at, exact.at)) / double(points.size());
    ::testing::Test::RecordProperty(accel::name(method), std::to_string(found));
    return found;
  };
  const TestMesh bent = box(MeshKind::hexahedra, 14, 0.2);
  EXPECT_EQ(share(bent, Method::user_geometry), 0);
  EXPECT_LT(share(bent, Method::shared_bilinear_faces), 0.002);
  EXPECT_GT(share(bent, Method::shared_faces), 0.01);
  EXPECT_LT(share(bent, Method::shared_faces), 0.1);
  EXPECT_LT(share(bent, Method::replicated_faces), 0.1);
  EXPECT_LT(share(box(MeshKind::tetrahedra, 8), Method::shared_faces), 0.0005);
  TestMesh flat = box(MeshKind::hexahedra, 12, 0.0);
  for (Vec3d& p : flat.vertices)
    p = turned(p); // planar but for rounding
  EXPECT_LT(share(flat, Method::shared_bilinear_faces), 0.0005);
  TestMesh wedges = box(MeshKind::wedges, 8, 0.2); // as their shape functions have them
  for (test::MeshCell& cell : wedges.cells) {
    std::swap(cell.vertices[1], cell.vertices[2]);
    std::swap(cell.vertices[4], cell.vertices[5]);
  }
  EXPECT_LT(share(wedges, Method::shared_bilinear_faces), 0.002);
}

TEST(Rays, CountHowPointsWereAnswered) {
  for (const Method method : ray_methods) {
    fixtures::Committed m(box(MeshKind::hexahedra, 10), 2);
    m.mesh.set_locator({method, accel::Backend::cpu});
    m.commit();
    const query::RayCounts& counts = m.mesh.locators().ray_counts();
    const auto points = test::inner_points(m.sampler().mesh(), 10000, 81);
    EXPECT_TRUE(m.sampler().mesh().covers_once);
    ask(m, points, INSITU_EXACT);
    EXPECT_EQ(counts.kept + counts.by_neighbour + counts.by_tree, 10000);
    EXPECT_LT(counts.by_tree, 500) << accel::name(method);
    if (method == Method::shared_faces) {
      EXPECT_GT(counts.by_neighbour, 100);
    }
    EXPECT_GT(counts.kept, 9000);
  }
}

TEST(Rays, KnowWhereCellsOverlap) {
  const auto covers_once = [](const TestMesh& from, Method method = Method::shared_faces) {
    fixtures::Committed m(from, 2);
    EXPECT_FALSE(m.sampler().mesh().covers_once) << "not looked for with bvh";
    m.mesh.set_locator({method, accel::Backend::cpu});
    m.commit();
    return m.sampler().mesh().covers_once;
  };
  for (const MeshKind kind : all_kinds)
    EXPECT_TRUE(covers_once(upright(box(kind, 4, 0.1)))) << kind_name(kind);
  EXPECT_TRUE(covers_once(box(MeshKind::mixed, 4), Method::user_geometry));
  TestMesh twice = box(MeshKind::hexahedra, 4);
  twice.cells.push_back(twice.cells[20]);
  EXPECT_FALSE(covers_once(twice));
  EXPECT_FALSE(covers_once(twice, Method::user_geometry));
  TestMesh alone = box(MeshKind::hexahedra, 1);
  alone.cells.push_back(alone.cells[0]);
  EXPECT_FALSE(covers_once(alone)) << "no boundary at all";
  TestMesh copied = alone; // with vertices of its own
  copied.vertices.insert(copied.vertices.end(), alone.vertices.begin(), alone.vertices.end());
  for (int& v : copied.cells[1].vertices)
    v += 8;
  EXPECT_FALSE(covers_once(copied));
  TestMesh split = box(MeshKind::hexahedra, 1);
  split.vertices.push_back({0.5, 0.5, 2});
  const auto top = split.cells[0].vertices;
  split.cells.push_back({mesh::Shape::tetrahedron, {top[4], top[5], top[6], 8}});
  split.cells.push_back({mesh::Shape::tetrahedron, {top[4], top[6], top[7], 8}});
  EXPECT_FALSE(covers_once(split)) << "a quad against two triangles";
  TestMesh inside = box(MeshKind::hexahedra, 3, 0.1);
  const int first = int(inside.vertices.size());
  for (const Vec3d& p : test::unit_cell(mesh::Shape::tetrahedron))
    inside.vertices.push_back(0.2 * p + Vec3d{1.3, 1.4, 1.5});
  inside.cells.push_back({mesh::Shape::tetrahedron, {first, first + 1, first + 2, first + 3}});
  EXPECT_FALSE(covers_once(inside)) << "a cell within another";
}

TEST(Rays, GroupsChangeNothingAndMemoryComesBack) {
  const fixtures::Committed m(box(MeshKind::mixed, 8), 2);
  const mesh::MeshView& view = m.sampler().mesh();
  const auto points = test::inner_points(view, 5000, 91);
  for (const Method method : ray_methods) {
    core::Memory memory;
    {
      accel::MeshFaces faces(memory);
      faces.build(view, m.threads);
      const auto found = [&](std::int64_t group) {
        const auto rays = accel::make_embree_locator(method, memory, group);
        rays->build(view, &faces, m.threads);
        const accel::RayLocatorReport report = rays->report();
        EXPECT_EQ(report.groups, (report.primitives + group - 1) / group);
        EXPECT_GT(report.bytes, report.primitives * 4);
        EXPECT_GE(report.peak_bytes, report.bytes);
        EXPECT_GE(memory.current(), report.bytes);
        std::vector<std::int64_t> cells(points.size());
        rays->find(points, cells);
        return cells;
      };
      const auto one = found(1 << 20), many = found(300);
      std::size_t differ = 0;
      for (std::size_t i = 0; i < one.size(); ++i)
        differ += one[i] != many[i]; // rays along edges
      EXPECT_LE(differ, 2u) << accel::name(method);
    }
    EXPECT_EQ(memory.current(), 0) << accel::name(method);
  }
}
