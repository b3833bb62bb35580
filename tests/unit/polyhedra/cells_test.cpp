// Cells given by faces are located as the definition says: recognised where they have a shape, and
// cut around their centres where they have none.
#include "owners.h"

using namespace insitu;
using fixtures::CommittedFaces;
using fixtures::FaceMesh;
using math::Vec3d;
using test::Random;

namespace {

/// Each cell's number of parts.
std::vector<int> part_counts(const CommittedFaces& m) {
  std::vector<int> counts(std::size_t(m.mesh.mesh().own_view().cell_count()), 0);
  for (std::int64_t part = 0; part < m.mesh.mesh().view().cell_count(); ++part)
    ++counts[std::size_t(m.mesh.stand_in()->place(part).own)];
  return counts;
}

} // namespace

// The same mesh by shapes and by faces: the same owner, to the cell, of points that are hard.
TEST(Polyhedra, StandardCellsGivenByFacesHaveTheSameOwners) {
  for (const auto kind : test::all_kinds) {
    const test::TestMesh shapes = test::box(kind, 4);
    const fixtures::Committed want(shapes);
    std::vector<Vec3d> points = test::hard_points(want.mesh.mesh().view(), 800, 2);
    const auto inner = test::inner_points(want.mesh.mesh().view(), 300, 3);
    points.insert(points.end(), inner.begin(), inner.end());
    for (const int base : {0, 1})
      for (const bool by_cell : {false, true}) {
        const CommittedFaces m(fixtures::faces_of(shapes), base, by_cell);
        EXPECT_TRUE(m.warnings.empty()) << m.warnings[0];
        // Voxels are hexahedra here: their boxes are the same sets of points.
        ASSERT_EQ(m.mesh.mesh().view().cell_count(), want.mesh.mesh().view().cell_count());
        for (const auto accuracy : {INSITU_STANDARD, INSITU_EXACT})
          for (const Vec3d& p : points)
            ASSERT_EQ(m.owner(p, accuracy), want.sampler().locate(p, -1, {accuracy, 1.0}).cell)
                << test::kind_name(kind) << " " << test::text(p);
      }
  }
}

TEST(Polyhedra, OctahedraAreCutAroundTheirCentres) {
  for (const double jitter : {0.0, 0.15}) {
    const FaceMesh mesh = fixtures::octahedra(3, jitter);
    const CommittedFaces m(mesh);
    for (const int count : part_counts(m))
      ASSERT_EQ(count, 6 + 8 * 6); // a pyramid a square, six tetrahedra a hexagon
    expect_filled(m, {1, 1, 1}, {7, 7, 7}, 600, 4);
    expect_owners(m, mesh.vertices);
  }
}

TEST(Polyhedra, HexahedraCutAtPlanes) {
  const FaceMesh mesh = fixtures::cut_hexahedra(4, 5);
  const CommittedFaces m(mesh);
  const std::vector<int> counts = part_counts(m);
  EXPECT_GT(std::ranges::count_if(counts, [](int n) { return n > 1; }), 30);
  EXPECT_GT(std::ranges::count(counts, 1), 10);
  expect_filled(m, {0, 0, 0}, {4, 4, 4}, 800, 7);
}

// As polyDualMesh makes them; a corner of the box that one tetrahedron has leaves a dual cell of a
// few faces only.
TEST(Polyhedra, DualsOfTetrahedra) {
  const CommittedFaces m(fixtures::dual_of(
      test::make_mesh({.kind = test::MeshKind::tetrahedra, .size = 4, .jitter = 0.15}, 11)));
  expect_filled(m, {0.6, 0.6, 0.6}, {3.4, 3.4, 3.4}, 300, 12);
}

// Points on faces, edges and vertices, within roundings of them, have one owner: the lowest of all
// cells that hold them. INSITU_TEST_POINTS: so many.
TEST(Polyhedra, PointsOnFacesAreOwnedOnce) {
  for (const FaceMesh& mesh :
       {fixtures::octahedra(3, 0.15),
        fixtures::dual_of(
            test::make_mesh({.kind = test::MeshKind::tetrahedra, .size = 4, .jitter = 0.15}, 11))})
    expect_one_owner(CommittedFaces(mesh));
}

// Which cell answers does not hang on the form, the base, or the way that faces are wound.
TEST(Polyhedra, FormsAreTheSame) {
  FaceMesh mesh = fixtures::octahedra(2, 0.1);
  const CommittedFaces by_owner(mesh);
  const auto points = test::hard_points(by_owner.mesh.mesh().view(), 400, 10);
  const CommittedFaces by_cell(mesh, 1, true);
  Random random(11);
  for (auto& ring : mesh.faces) {
    if (random.below(2) == 0)
      std::ranges::reverse(ring);
    std::ranges::rotate(ring, ring.begin() + random.below(int(ring.size())));
  }
  const CommittedFaces wound(mesh);
  for (const Vec3d& p : points) {
    ASSERT_EQ(by_cell.owner(p), by_owner.owner(p));
    ASSERT_EQ(wound.owner(p), by_owner.owner(p));
  }
}

// Rings are read where their records say, in both forms, and stand in the audit with all their ids.
TEST(Polyhedra, RingsInRecordsOfTheirOwn) {
  const FaceMesh mesh = fixtures::octahedra(2, 0.1);
  const CommittedFaces packed(mesh);
  const auto points = test::hard_points(packed.mesh.mesh().view(), 400, 10);
  for (const int base : {0, 1})
    for (const bool by_cell : {false, true}) {
      const fixtures::FaceArrays<> arrays(mesh, base);
      const auto rings = arrays.records();
      const insitu_faces faces =
          arrays.by_records(by_cell ? arrays.by_cell() : arrays.by_owner(), rings);
      const insitu_array vertices = arrays.point_array();
      fixtures::Committed m;
      m.mesh.mesh().set_points(0, &vertices, 1);
      m.mesh.mesh().set_faces(0, &faces);
      m.commit();
      for (const Vec3d& p : points)
        ASSERT_EQ(m.mesh.own(m.sampler().locate(p, -1, {INSITU_EXACT, 1.0}), p).cell,
                  packed.owner(p));
      int found = 0;
      for (const insitu_audit_entry& entry : m.mesh.mesh().audit())
        if (entry.name == std::string("piece 0 vertices")) {
          ++found;
          EXPECT_EQ(entry.borrowed, 1);
          EXPECT_EQ(entry.bytes, std::int64_t(4 * arrays.vertices.size()));
        }
      EXPECT_EQ(found, 1);
    }
}

// A prism over an L sees all of itself from near its inner corner alone, one over a U from nowhere.
TEST(Polyhedra, CentresOfCellsThatAreNotConvex) {
  const auto prism = [](const std::vector<Vec3d>& base) {
    FaceMesh mesh;
    const int n = int(base.size());
    for (const double z : {0.0, 1.0})
      for (const Vec3d& x : base)
        mesh.vertices.push_back({x.x, x.y, z});
    std::vector<FaceMesh::Ring> rings(2);
    for (int k = 0; k < n; ++k) {
      rings[0].push_back(k);
      rings[1].push_back(n + k);
      rings.push_back({k, (k + 1) % n, n + (k + 1) % n, n + k});
    }
    mesh.add_cell(rings);
    return mesh;
  };
  const CommittedFaces thin(
      prism({{0, 0, 0}, {9, 0, 0}, {9, 1, 0}, {1, 1, 0}, {1, 9, 0}, {0, 9, 0}}));
  // The hexagon's own centre does not see all of its edges, whatever the cell's centre.
  ASSERT_EQ(thin.warnings.size(), 1u);
  const CommittedFaces u(prism(
      {{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}}));
  ASSERT_EQ(u.warnings.size(), 1u);
  EXPECT_NE(u.warnings[0].find("1 are folded, or given by faces that no point found in them sees "
                               "all"),
            std::string::npos)
      << u.warnings[0];
  EXPECT_NE(u.warnings[0].find("cell 0 of piece 0"), std::string::npos) << u.warnings[0];
}

// A tetrahedron with a deep dent in one face: the mean of the vertices lies in the dent.
TEST(Polyhedra, ACentreIsLookedForWhereTheMeanDoesNotSeeAllFaces) {
  FaceMesh mesh;
  mesh.vertices = {{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {0, 0, 9}};
  std::vector<FaceMesh::Ring> rings{{0, 1, 2}, {0, 1, 3}, {0, 2, 3}};
  // The face 1, 2, 3 is pushed inward to a point near vertex 0, and many vertices lie far out.
  mesh.vertices.push_back({0.5, 0.5, 0.5});
  rings.push_back({1, 2, 4});
  rings.push_back({2, 3, 4});
  rings.push_back({3, 1, 4});
  mesh.add_cell(rings);
  const CommittedFaces m(mesh);
  EXPECT_TRUE(m.warnings.empty()) << m.warnings[0];
  const mesh::MeshView& view = m.mesh.mesh().view();
  ASSERT_EQ(view.cell_count(), 6);
  const Vec3d centre = view.pieces[0].point(5);
  EXPECT_LT(centre.x + centre.y + centre.z, 1.5); // behind the dent
  expect_owners(m, test::hard_points(view, 500, 12));
  EXPECT_EQ(m.owner({0.2, 0.2, 0.2}), 0);
  EXPECT_EQ(m.owner({2, 2, 2}), -1);
}

TEST(Polyhedra, PiecesByFacesAndByShapes) {
  const test::TestMesh shapes = test::box(test::MeshKind::hexahedra, 3, 0.0);
  const FaceMesh octahedra = fixtures::octahedra(2);
  fixtures::FaceArrays<std::int64_t> faces(octahedra, 1);
  for (std::size_t i = 0; i < faces.points.size(); i += 3)
    faces.points[i] += 20.0;
  fixtures::Committed m(shapes);
  const insitu_array points = faces.point_array();
  const insitu_faces given = faces.by_owner();
  m.mesh.mesh().set_points(1, &points, 1);
  m.mesh.mesh().set_faces(1, &given);
  const insitu_commit_report report = m.commit();
  EXPECT_EQ(report.cells, 27 + 9);
  EXPECT_EQ(report.vertices, 64 + std::int64_t(octahedra.vertices.size()));
  EXPECT_EQ(m.mesh.own(m.sampler().locate({0.5, 0.5, 0.5}), {}).cell, 0);
  EXPECT_EQ(m.mesh.own(m.sampler().locate({20, 0, 0}), {}).cell, 27);
  EXPECT_EQ(m.mesh.own(m.sampler().locate({22, 2, 2}), {}).cell, 27 + 8);
  // Back to shapes alone.
  m.mesh.mesh().drop_pieces(1);
  m.commit();
  EXPECT_EQ(m.mesh.stand_in(), nullptr);
  EXPECT_EQ(m.sampler().locate({20, 0, 0}).cell, -1);
}

TEST(Polyhedra, GhostsOwnNothingAndMayHoldAnything) {
  CommittedFaces m(fixtures::octahedra(2, 0.1));
  std::vector<std::uint8_t> ghosts(9, 0);
  ghosts[8] = 1;
  const insitu_array array = insitu_array_of(ghosts.data(), INSITU_UINT8, 9, 1);
  m.mesh.mesh().set_ghosts(0, &array, INSITU_GHOSTS_VTK);
  m.commit();
  EXPECT_EQ(m.owner({2, 2, 2}), -1);
  EXPECT_EQ(m.owner({0, 0, 0}), 0);
  EXPECT_EQ(part_counts(m)[8], 54); // it lends its values
  insitu_faces garbage = m.arrays_of_faces.by_cell();
  std::vector<std::int32_t> lists = m.arrays_of_faces.cell_faces;
  for (auto k = std::size_t(m.arrays_of_faces.cell_offsets[8]); k < lists.size(); ++k)
    lists[k] = 123456789;
  garbage.cell_faces = m.arrays_of_faces.array(lists);
  m.mesh.mesh().set_faces(0, &garbage);
  m.commit();
  EXPECT_EQ(part_counts(m)[8], 0);
  EXPECT_EQ(m.owner({2, 2, 2}), -1);
  EXPECT_EQ(m.owner({0, 0, 0}), 0);
  EXPECT_EQ(m.mesh.validate(m.threads).counts.ghost_cells, 1);
}

/// A commit names the solver's cells of two pieces that overlap; not those of pieces that meet.
TEST(Polyhedra, PiecesThatOverlapAreNamed) {
  FaceMesh other = fixtures::octahedra(2);
  for (const double by : {0.0, 8.0}) {
    CommittedFaces m(fixtures::octahedra(2));
    for (Vec3d& x : other.vertices)
      x.x += by;
    const fixtures::FaceArrays<> arrays(other);
    const insitu_array points = arrays.point_array();
    const insitu_faces faces = arrays.by_cell();
    m.mesh.mesh().set_points(1, &points, 1);
    m.mesh.mesh().set_faces(1, &faces);
    m.commit();
    const std::string told = m.warnings.empty() ? "" : m.warnings[0];
    EXPECT_EQ(told.substr(0, told.find(" share")),
              by == 0.0
                  ? "mesh 'test': pieces 0 and 1 overlap: cell 0 of piece 0 and cell 0 of piece 1"
                  : "");
  }
}
