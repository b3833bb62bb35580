// Faces that do not bound cells are refused by the piece, the cell and the face.
#include <limits>

#include "../query/query_test.h"
#include "core/status.h"
#include "fixtures/polyhedra.h"

using namespace insitu;
using fixtures::FaceArrays;
using fixtures::FaceMesh;

namespace {

constexpr std::int64_t far_out = std::int64_t(1) << 40;

/// What a commit says of these faces.
template <class Id>
class RefusedWith {
public:
  explicit RefusedWith(const FaceMesh& mesh = fixtures::octahedra(2), int base = 0)
      : arrays(mesh, base), by_owner(arrays.by_owner()), by_cell(arrays.by_cell()) {}

  std::string commit(const insitu_faces& faces, insitu_status status = INSITU_ERROR_MESH) {
    fixtures::Committed m;
    const insitu_array points = arrays.point_array();
    try {
      m.mesh.mesh().set_points(0, &points, 1);
      m.mesh.mesh().set_faces(0, &faces);
    } catch (const core::Error& e) {
      EXPECT_EQ(e.status(), status) << e.what();
      return e.what();
    }
    try {
      if (status == INSITU_ERROR_MESH) {
        const cells::Validation found = m.mesh.validate(m.threads);
        EXPECT_FALSE(found.findings.empty());
        const insitu_validation& c = found.counts;
        EXPECT_GT(c.index_errors + c.shape_errors + c.coordinate_errors, 0);
      }
      m.commit();
    } catch (const core::Error& e) {
      EXPECT_EQ(e.status(), status) << e.what();
      EXPECT_FALSE(m.mesh.committed());
      return e.what();
    }
    return "accepted";
  }

  FaceArrays<Id> arrays;
  insitu_faces by_owner, by_cell;
};
using Refused = RefusedWith<std::int32_t>;

void expect_in(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts)
    EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' not in: " << message;
}

} // namespace

TEST(BadFaces, OwnersAndNeighboursOutOfRange) {
  Refused r;
  r.arrays.owner[3] = 9;
  expect_in(r.commit(r.by_owner), {"mesh 'test', piece 0, face 3: owner 9, 0 to 8 expected"});
  r.arrays.owner[3] = -2;
  expect_in(r.commit(r.by_owner), {"face 3: owner -2"});
  r.arrays.owner[3] = r.arrays.neighbour[3];
  expect_in(r.commit(r.by_owner), {"face 3: neighbour", "is its owner, too"});
  Refused one(fixtures::octahedra(2), 1);
  one.arrays.neighbour[0] = 10;
  expect_in(one.commit(one.by_owner), {"face 0: neighbour 10, 1 to 9 expected"});
  // With cells of other processes there the same id is one of theirs: the face is a boundary here.
  one.by_owner.far_cells = 1;
  expect_in(one.commit(one.by_owner), {"is not closed"}); // its cell lacks the face
}

TEST(BadFaces, FacesThatAreNoneOfTheirCells) {
  Refused r;
  std::swap(r.arrays.owner[0], r.arrays.owner.back());
  expect_in(r.commit(r.by_owner), {"piece 0, cell ", "is not closed: the edge of the vertex ids",
                                   "lies on 1 of its faces, face "});
  Refused three;
  three.arrays.cell_faces[0] = three.arrays.cell_faces[1];
  expect_in(three.commit(three.by_cell), {"cell 0: lists face"});
  Refused third;
  const FaceArrays<> good = third.arrays;
  for (std::size_t f = 0; f < good.neighbour.size(); ++f) // a face of two cells, in a third one
    if (good.owner[f] != 3 && good.neighbour[f] != 3) {
      third.arrays.cell_faces[std::size_t(good.cell_offsets[3])] = std::int32_t(f);
      break;
    }
  expect_in(third.commit(third.by_cell), {"is the third cell of face "});
}

TEST(BadFaces, Rings) {
  Refused r;
  r.arrays.vertices[1] = r.arrays.vertices[0];
  expect_in(r.commit(r.by_owner), {"cell 0: face 0 has vertex id", "twice"});
  Refused two;
  two.arrays.offsets[1] = 2;
  expect_in(two.commit(two.by_owner), {"face 0 has 2 vertices, 3 or more expected"});
  two.arrays.offsets[1] = -4;
  expect_in(two.commit(two.by_owner), {"face 0 lies at 0 to before -4 of"});
  Refused id(fixtures::octahedra(2), 1);
  id.arrays.vertices[2] = 0;
  expect_in(id.commit(id.by_owner), {"face 0 vertex 2 has id 0, 1 to"});
  Refused coordinate;
  coordinate.arrays.points[3 * std::size_t(coordinate.arrays.vertices[0]) + 1] = NAN;
  expect_in(coordinate.commit(coordinate.by_owner), {"coordinate y is NaN"});
}

/// Of no difference of which there may be a number.
TEST(BadFaces, OffsetsThatAreAnyNumbers) {
  using Numbers = std::numeric_limits<std::int64_t>;
  for (const std::int64_t wrong : {Numbers::max(), Numbers::min()})
    for (const int base : {0, 1}) {
      RefusedWith<std::int64_t> r(fixtures::octahedra(2), base);
      r.arrays.offsets[1] = wrong;
      for (const insitu_faces& faces : {r.by_owner, r.by_cell})
        expect_in(r.commit(faces), {"face 0 lies at " + std::to_string(base) + " to before " +
                                    std::to_string(wrong) + " of"});
    }
}

TEST(BadFaces, CellsThatAreOpenFlatOrSeveral) {
  FaceMesh open = fixtures::octahedra(2);
  open.cells[4].pop_back();
  Refused r(open);
  expect_in(r.commit(r.by_cell), {"cell 4: is not closed", "lies on 1 of its faces"});
  FaceMesh flat;
  flat.vertices = {{0, 0, 0.1}, {1, 0, 0.1}, {1, 1, 0.1}, {0, 1, 0.1}, {0.3, 0.4, 0.1}};
  flat.add_cell({{0, 1, 2, 3}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}});
  Refused f(flat);
  expect_in(f.commit(f.by_owner), {"cell 0: has no volume"});
  FaceMesh apart;
  apart.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1},
                    {5, 0, 0}, {6, 0, 0}, {5, 1, 0}, {5, 0, 1}};
  apart.add_cell(
      {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}, {4, 5, 6}, {4, 5, 7}, {4, 6, 7}, {5, 6, 7}});
  Refused a(apart);
  expect_in(a.commit(a.by_owner), {"cell 0: has faces that bound 2 bodies, face 0", "face 4"});
  FaceMesh few;
  few.vertices = apart.vertices;
  few.add_cell({{0, 1, 2}, {0, 1, 3}, {0, 2, 3}});
  Refused three(few);
  expect_in(three.commit(three.by_owner), {"cell 0: has 3 faces, 4 or more expected"});
}

TEST(BadFaces, Arguments) {
  Refused r;
  const auto refused = [&](auto change, const std::string& what) {
    insitu_faces f = r.by_owner;
    change(f);
    expect_in(r.commit(f, INSITU_ERROR_ARGUMENT), {"mesh 'test', piece 0 faces", what});
  };
  refused([](auto& f) { f.size = 8; }, "insitu_faces_default");
  refused([](auto& f) { f.form = insitu_faces_form(7); }, "unknown form 7");
  refused([](auto& f) { f.index_base = 2; }, "index_base 2");
  refused([](auto& f) { f.cell_count = -1; }, "cell_count -1");
  refused([](auto& f) { f.face_count = far_out + 1; }, "face_count");
  refused([](auto& f) { f.face_count += 2; }, "face offsets: ");
  refused([](auto& f) { f.owner.count -= 1; }, "owner: ");
  refused([](auto& f) { f.neighbour.count = f.face_count + 1; }, "neighbour: ");
  refused([](auto& f) { f.owner.type = INSITU_FLOAT64; }, "int32 or int64 expected");
  refused([](auto& f) { f.vertices.components = 2; }, "vertices: 2 components, 1 expected");
  refused([](auto& f) { f.far_cells = -1; }, "far_cells -1");
  refused([](auto& f) { f.boundary_count = 2; }, "boundary");
  refused([](auto& f) { f.owner.components = 2; }, "owner has two components");
  insitu_faces cells = r.by_cell;
  cells.cell_offsets.count -= 2;
  expect_in(r.commit(cells, INSITU_ERROR_ARGUMENT), {"cell offsets: 8 items, 10 expected"});
}

// Arrays that run backwards are arrays; pairs and a boundary apart are the same faces, and the last
// face and the last cell end where the ids do.
TEST(BadFaces, GoodOnesOfOtherLayouts) {
  Refused r;
  for (insitu_faces without : {r.by_owner, r.by_cell}) {
    --without.offsets.count;
    if (without.form == INSITU_FACES_CELLS)
      --without.cell_offsets.count;
    EXPECT_EQ(r.commit(without, INSITU_OK), "accepted");
  }
  std::vector<std::int32_t> backwards(r.arrays.vertices.rbegin(), r.arrays.vertices.rend());
  insitu_faces f = r.by_owner;
  f.vertices = FaceArrays<>::array(backwards);
  f.vertices.data = backwards.data() + backwards.size() - 1;
  f.vertices.stride[0] = -4;
  EXPECT_EQ(r.commit(f, INSITU_OK), "accepted");

  const std::size_t inner = r.arrays.neighbour.size();
  std::vector<std::int32_t> pairs;
  for (std::size_t i = 0; i < inner; ++i)
    pairs.insert(pairs.end(), {r.arrays.owner[i], r.arrays.neighbour[i]});
  f = r.by_owner;
  f.face_count = std::int64_t(inner);
  f.offsets.count = f.face_count + 1;
  f.owner = insitu_array_of(pairs.data(), INSITU_INT32, f.face_count, 2);
  f.neighbour = insitu_array_default();
  f.boundary_count = r.by_owner.face_count - f.face_count;
  const std::int32_t first = r.arrays.offsets[inner];
  std::vector<std::int32_t> offsets(r.arrays.offsets.begin() + std::ptrdiff_t(inner),
                                    r.arrays.offsets.end());
  for (std::int32_t& o : offsets)
    o -= first;
  f.boundary_vertices = insitu_array_of(r.arrays.vertices.data() + first, INSITU_INT32,
                                        std::int64_t(r.arrays.vertices.size()) - first, 1);
  f.boundary_offsets = FaceArrays<>::array(offsets);
  f.boundary_owner =
      insitu_array_of(r.arrays.owner.data() + inner, INSITU_INT32, f.boundary_count, 1);
  EXPECT_EQ(r.commit(f, INSITU_OK), "accepted");
  r.arrays.owner.back() = 77;
  expect_in(r.commit(f), {"boundary owner 77"});
}

TEST(BadFaces, APieceWithoutCellsIsNoError) {
  fixtures::Committed m(test::box(test::MeshKind::hexahedra, 2));
  const insitu_faces none = insitu_faces_default();
  m.mesh.mesh().set_faces(1, &none);
  m.commit();
  EXPECT_EQ(m.mesh.stand_in(), nullptr);
  EXPECT_EQ(m.sampler().locate({0.5, 0.5, 0.5}).cell, 0);
}

TEST(BadFaces, RecordsOfRings) {
  Refused r;
  const auto commit = [&](const std::vector<FaceArrays<>::Record>& rings) {
    return r.commit(FaceArrays<>::by_records(r.by_owner, rings));
  };
  auto rings = r.arrays.records();
  rings[5].ids = nullptr;
  expect_in(commit(rings), {"mesh 'test', piece 0: the pointer of face 5 is null"});
  rings = r.arrays.records();
  rings[2].size = -1;
  expect_in(commit(rings), {"face 2 has -1 vertices, 3 or more expected"});
  insitu_faces few = FaceArrays<>::by_records(r.by_owner, rings);
  --few.vertices.count;
  expect_in(r.commit(few, INSITU_ERROR_ARGUMENT), {"vertices: ", " pointers, "});
  insitu_faces offsets = FaceArrays<>::by_records(r.by_owner, rings);
  offsets.offsets.indirect = 1;
  expect_in(r.commit(offsets, INSITU_ERROR_ARGUMENT), {"indirect; only fields, leaves and"});
}
