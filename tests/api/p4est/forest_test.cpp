/// p8est forests as adaptive meshes: placed, read in place, refused when they are no brick.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <gtest/gtest.h>
#include <insitu/p4est.h>
#include <map>
#include <p4est_extended.h>
#include <p8est_extended.h>
#include <string>
#include <vector>

#include "fixtures/mpi.h"

namespace {

using Index = std::array<int, 3>;

struct Record {
  float weight;
  double rho, velocity[3];
};

/// Refines towards the brick's middle corner.
int towards_origin(p8est_t*, p4est_topidx_t tree, p8est_quadrant_t* q) {
  return tree == 0 && q->level < 4 && q->x == 0 && q->y == 0 && q->z == 0;
}

void number(p8est_t* forest, p4est_topidx_t tree, p8est_quadrant_t* q) {
  const double n = ++*static_cast<int*>(forest->user_pointer);
  *static_cast<Record*>(q->p.user_data) = {float(tree), n, {double(q->x), double(q->y), n}};
}

struct Forest {
  explicit Forest(p8est_connectivity_t* c, std::size_t data_size = sizeof(Record))
      : connectivity(c), forest(p8est_new_ext(sc_MPI_COMM_SELF, c, 0, 1, 1, data_size,
                                              data_size ? number : nullptr, &count)) {}
  ~Forest() {
    p8est_destroy(forest);
    p8est_connectivity_destroy(connectivity);
  }
  Forest(const Forest&) = delete;
  Forest& operator=(const Forest&) = delete;
  void refine() {
    p8est_refine(forest, 1, towards_origin, number);
    p8est_balance(forest, P8EST_CONNECT_FULL, number);
  }
  const p8est_quadrant_t* quadrants(p4est_topidx_t tree) const {
    return reinterpret_cast<const p8est_quadrant_t*>(
        p8est_tree_array_index(forest->trees, tree)->quadrants.array);
  }
  int count = 0;
  p8est_connectivity_t* connectivity;
  p8est_t* forest;
};

struct P4est : testing::Test {
  insitu_session session = nullptr;
  insitu_mesh mesh = nullptr;
  void SetUp() override {
    ASSERT_EQ(insitu_session_open(nullptr, &session), INSITU_OK);
    ASSERT_EQ(insitu_session_mesh(session, "forest", &mesh), INSITU_OK);
  }
  void TearDown() override { EXPECT_EQ(insitu_session_close(&session), INSITU_OK); }
  std::map<std::string, insitu_audit_entry> audit() const {
    std::int32_t n = 0;
    EXPECT_EQ(insitu_mesh_audit(mesh, nullptr, &n), INSITU_OK);
    std::vector<insitu_audit_entry> entries(std::size_t(n), insitu_audit_entry{});
    EXPECT_EQ(insitu_mesh_audit(mesh, entries.data(), &n), INSITU_OK);
    std::map<std::string, insitu_audit_entry> by_name;
    for (const insitu_audit_entry& e : entries) {
      EXPECT_TRUE(e.borrowed) << e.name;
      by_name[e.name] = e;
    }
    return by_name;
  }
  insitu_status give_density(p8est_t* forest) {
    return insitu_p4est_field(mesh, forest, "rho", INSITU_FLOAT64, offsetof(Record, rho), 1);
  }
  void expect_refused(insitu_status status, insitu_status expected, const char* words) {
    EXPECT_EQ(status, expected) << insitu_p4est_message();
    EXPECT_NE(std::string(insitu_p4est_message()).find(words), std::string::npos)
        << insitu_p4est_message();
  }
};

} // namespace

TEST_F(P4est, ABrickIsReadInPlace) {
  Forest f(p8est_connectivity_new_brick(2, 1, 3, 0, 1, 0));
  const auto give = [&] {
    ASSERT_EQ(insitu_p4est_mesh(mesh, f.forest, nullptr, nullptr), INSITU_OK)
        << insitu_p4est_message();
    ASSERT_EQ(give_density(f.forest), INSITU_OK) << insitu_p4est_message();
    ASSERT_EQ(insitu_p4est_field(mesh, f.forest, "velocity", INSITU_FLOAT64,
                                 offsetof(Record, velocity), 3),
              INSITU_OK)
        << insitu_p4est_message();
    ASSERT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_OK) << insitu_last_message();
    const auto entries = audit();
    EXPECT_EQ(entries.size(), 6u * 4u);
    for (p4est_topidx_t t = 0; t < 6; ++t) {
      const p8est_quadrant_t* const q = f.quadrants(t);
      const std::string piece = "piece " + std::to_string(t) + " ";
      EXPECT_EQ(entries.at(piece + "levels").data, &q->level);
      EXPECT_EQ(entries.at(piece + "corners").data, &q->x);
      EXPECT_EQ(entries.at(piece + "field 'rho'").data, &q->p);
    }
  };
  give();
  f.refine();
  give();
}

/// Read in place; each quadrant's centre has its value, at any height.
TEST_F(P4est, AForestOfTwoDimensions) {
  struct Numbers {
    static void set(p4est_t* forest, p4est_topidx_t tree, p4est_quadrant_t* q) {
      const double n = ++*static_cast<int*>(forest->user_pointer);
      *static_cast<Record*>(q->p.user_data) = {float(tree), n, {1, 2, n}};
    }
    static int towards_origin(p4est_t*, p4est_topidx_t tree, p4est_quadrant_t* q) {
      return tree == 0 && q->level < 4 && q->x == 0 && q->y == 0;
    }
  };
  int count = 0;
  p4est_connectivity_t* const c = p4est_connectivity_new_brick(2, 3, 1, 0);
  p4est_t* const forest =
      p4est_new_ext(sc_MPI_COMM_SELF, c, 0, 1, 1, sizeof(Record), Numbers::set, &count);
  for (int step = 0; step < 2; ++step) {
    ASSERT_EQ(insitu_p4est_flat_mesh(mesh, forest, nullptr, nullptr), INSITU_OK)
        << insitu_p4est_message();
    ASSERT_EQ(
        insitu_p4est_flat_field(mesh, forest, "rho", INSITU_FLOAT64, offsetof(Record, rho), 1),
        INSITU_OK)
        << insitu_p4est_message();
    ASSERT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_OK) << insitu_last_message();
    EXPECT_EQ(audit().size(), 6u * 3u);
    for (p4est_topidx_t t = 0; t < 6; ++t) {
      const sc_array_t& quadrants = p4est_tree_array_index(forest->trees, t)->quadrants;
      const p4est_topidx_t* const of = c->tree_to_vertex + 4 * t;
      for (std::size_t i = 0; i < quadrants.elem_count; ++i) {
        const p4est_quadrant_t& q = reinterpret_cast<const p4est_quadrant_t*>(quadrants.array)[i];
        const double size = std::ldexp(1.0, -q.level), unit = std::ldexp(1.0, -P4EST_MAXLEVEL);
        const double place[3] = {c->vertices[3 * of[0]] + unit * q.x + 0.5 * size,
                                 c->vertices[3 * of[0] + 1] + unit * q.y + 0.5 * size, 7.0};
        double value = 0;
        std::int32_t found = 0;
        ASSERT_EQ(insitu_mesh_sample_point(mesh, "rho", place, &value, &found), INSITU_OK);
        EXPECT_EQ(found, 1);
        EXPECT_NEAR(value, static_cast<const Record*>(q.p.user_data)->rho, 1e-11);
      }
    }
    p4est_refine(forest, 0, Numbers::towards_origin, Numbers::set);
  }
  expect_refused(insitu_p4est_flat_field(mesh, forest, "rho", INSITU_FLOAT64, 0, 1),
                 INSITU_ERROR_ORDER, "call insitu_p4est_flat_mesh first");
  c->vertices[2] = 0.5;
  expect_refused(insitu_p4est_flat_mesh(mesh, forest, nullptr, nullptr), INSITU_ERROR_UNSUPPORTED,
                 "only bricks");
  EXPECT_EQ(insitu_mesh_drop_pieces(mesh, 0), INSITU_OK);
  p4est_destroy(forest);
  p4est_connectivity_destroy(c);
}

TEST_F(P4est, OtherForestsAreRefusedByName) {
  Forest turned(p8est_connectivity_new_rotcubes());
  expect_refused(insitu_p4est_mesh(mesh, turned.forest, nullptr, nullptr), INSITU_ERROR_UNSUPPORTED,
                 "only bricks");
  Forest shell(p8est_connectivity_new_shell());
  expect_refused(insitu_p4est_mesh(mesh, shell.forest, nullptr, nullptr), INSITU_ERROR_UNSUPPORTED,
                 "at one place");
  Forest bent(p8est_connectivity_new_brick(2, 2, 1, 0, 0, 0));
  bent.connectivity->vertices[3 * 4 + 1] += 0.25;
  expect_refused(insitu_p4est_mesh(mesh, bent.forest, nullptr, nullptr), INSITU_ERROR_UNSUPPORTED,
                 "corner");
  EXPECT_EQ(insitu_mesh_drop_pieces(mesh, 0), INSITU_OK); // none was given
  std::int32_t n = 1;
  EXPECT_EQ(insitu_mesh_audit(mesh, nullptr, &n), INSITU_OK);
  EXPECT_EQ(n, 0);
}

TEST_F(P4est, BadArgumentsAreRefusedByNumber) {
  Forest f(p8est_connectivity_new_unitcube());
  const double origin[3] = {0, 0, 0}, flat[3] = {1, 0, 1}, size[3] = {1, 1, 1};
  expect_refused(insitu_p4est_mesh(mesh, nullptr, nullptr, nullptr), INSITU_ERROR_ARGUMENT, "null");
  expect_refused(insitu_p4est_mesh(mesh, f.forest, origin, nullptr), INSITU_ERROR_ARGUMENT,
                 "tree_size");
  expect_refused(insitu_p4est_mesh(mesh, f.forest, origin, flat), INSITU_ERROR_ARGUMENT,
                 "spacing along axis 1 is 0");
  expect_refused(insitu_p4est_mesh(nullptr, f.forest, origin, size), INSITU_ERROR_HANDLE, "null");
  ASSERT_EQ(insitu_p4est_mesh(mesh, f.forest, origin, size), INSITU_OK);
  EXPECT_STREQ(insitu_p4est_message(), "");
  expect_refused(
      insitu_p4est_field(mesh, f.forest, "v", INSITU_FLOAT64, offsetof(Record, velocity) + 8, 3),
      INSITU_ERROR_ARGUMENT, "bytes 24 to 48");
  expect_refused(insitu_p4est_field(mesh, f.forest, "v", INSITU_INT32, 0, 1), INSITU_ERROR_ARGUMENT,
                 "float32 or float64");
  expect_refused(insitu_p4est_field(mesh, f.forest, "v", INSITU_FLOAT64, 8, 0),
                 INSITU_ERROR_ARGUMENT, "0 components");
  Forest bare(p8est_connectivity_new_unitcube(), 0);
  expect_refused(insitu_p4est_field(mesh, bare.forest, "v", INSITU_FLOAT64, 0, 1),
                 INSITU_ERROR_ARGUMENT, "record, which has 0");
}

TEST_F(P4est, FewerTreesLeaveFewerPieces) {
  Forest many(p8est_connectivity_new_brick(2, 2, 2, 0, 0, 0));
  Forest one(p8est_connectivity_new_unitcube());
  for (p8est_t* const forest : {many.forest, one.forest}) {
    ASSERT_EQ(insitu_p4est_mesh(mesh, forest, nullptr, nullptr), INSITU_OK);
    ASSERT_EQ(give_density(forest), INSITU_OK);
    ASSERT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_OK) << insitu_last_message();
  }
  EXPECT_EQ(audit().size(), 3u);
}

/// What p8est keeps on a process that has no quadrants (p8est.h: first_local_tree is -1 there).
TEST_F(P4est, AProcessWithoutQuadrants) {
  Forest f(p8est_connectivity_new_brick(2, 1, 1, 0, 0, 0));
  p8est_t none = *f.forest;
  none.first_local_tree = -1;
  none.last_local_tree = -2;
  none.local_num_quadrants = 0;
  const double place[3] = {0.3, 0.4, 0.6};
  for (p8est_t* const forest : {&none, f.forest, &none}) { // partitioned to and fro
    ASSERT_EQ(insitu_p4est_mesh(mesh, forest, nullptr, nullptr), INSITU_OK)
        << insitu_p4est_message();
    ASSERT_EQ(give_density(forest), INSITU_OK) << insitu_p4est_message();
    ASSERT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_OK) << insitu_last_message();
    double value = 7.0;
    std::int32_t found = -1;
    ASSERT_EQ(insitu_mesh_sample_point(mesh, "rho", place, &value, &found), INSITU_OK)
        << insitu_last_message();
    EXPECT_EQ(found, forest == f.forest);
    EXPECT_EQ(std::isnan(value), forest == &none);
    ASSERT_EQ(insitu_session_execute(session, 0, 0.0), INSITU_OK) << insitu_last_message();
  }
}

/// Three by three trees but the middle one, with numbers in float.
TEST_F(P4est, ABrickWithAHole) {
  p8est_connectivity_t* const whole = p8est_connectivity_new_brick(3, 3, 1, 0, 0, 0);
  std::vector<p4est_topidx_t> corners, trees;
  std::vector<int8_t> faces;
  std::vector<Index> places; // of trees
  for (p4est_topidx_t t = 0; t < whole->num_trees; ++t) {
    const p4est_topidx_t* const of = whole->tree_to_vertex + 8 * t;
    Index at;
    for (int a = 0; a < 3; ++a)
      at[std::size_t(a)] = int(whole->vertices[3 * of[0] + a]);
    if (at[0] == 1 && at[1] == 1)
      continue;
    corners.insert(corners.end(), of, of + 8);
    for (int f = 0; f < 6; ++f) {
      trees.push_back(p4est_topidx_t(places.size()));
      faces.push_back(int8_t(f));
    }
    places.push_back(at);
  }
  const p4est_topidx_t none = 0;
  p8est_connectivity_t* const ring = p8est_connectivity_new_copy(
      whole->num_vertices, p4est_topidx_t(places.size()), 0, 0, whole->vertices, corners.data(),
      trees.data(), faces.data(), nullptr, &none, nullptr, nullptr, nullptr, &none, nullptr,
      nullptr);
  p8est_connectivity_destroy(whole);
  p8est_connectivity_complete(ring);
  Forest f(ring);
  f.refine();
  ASSERT_EQ(insitu_p4est_mesh_as(mesh, f.forest, nullptr, nullptr, INSITU_NEAREST), INSITU_OK)
      << insitu_p4est_message();
  ASSERT_EQ(insitu_p4est_field(mesh, f.forest, "tree", INSITU_FLOAT32, offsetof(Record, weight), 1),
            INSITU_OK)
      << insitu_p4est_message();
  ASSERT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_OK) << insitu_last_message();
  for (int n = 0; n < 9 * 64; ++n) {
    const int i = n % 3, j = n / 3 % 3, k = n / 9;
    const double p[3] = {i + 0.05 + 0.9 * (k % 4) / 4, j + 0.05 + 0.9 * (k / 4 % 4) / 4,
                         0.05 + 0.9 * (k / 16) / 4};
    double value = 0;
    std::int32_t found = -1;
    ASSERT_EQ(insitu_mesh_sample_point(mesh, "tree", p, &value, &found), INSITU_OK)
        << insitu_last_message();
    const auto tree = std::find(places.begin(), places.end(), Index{i, j, 0});
    ASSERT_EQ(found, tree != places.end()) << p[0] << ", " << p[1];
    if (found) {
      ASSERT_EQ(value, double(tree - places.begin())) << p[0] << ", " << p[1];
    }
  }
}

/// Of p8est's own regrids a field of the quadrants as they are now tells; of quadrants that changed
/// where they are, a checked session's commit.
TEST_F(P4est, ARegridThatWasNotAnnouncedIsFoundOut) {
  ASSERT_EQ(insitu_session_close(&session), INSITU_OK);
  setenv("INSITU_CHECKED", "1", 1);
  SetUp();
  unsetenv("INSITU_CHECKED");
  Forest f(p8est_connectivity_new_brick(2, 1, 1, 0, 0, 0));
  ASSERT_EQ(insitu_p4est_mesh(mesh, f.forest, nullptr, nullptr), INSITU_OK);
  ASSERT_EQ(give_density(f.forest), INSITU_OK) << insitu_p4est_message();
  ASSERT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_OK) << insitu_last_message();
  ASSERT_EQ(give_density(f.forest), INSITU_OK) << insitu_p4est_message();

  auto* const q = const_cast<p8est_quadrant_t*>(f.quadrants(1)) + 3;
  q->level = 2;
  ASSERT_EQ(insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS), INSITU_OK);
  EXPECT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_ERROR_ORDER);
  const std::string half = std::to_string(P8EST_QUADRANT_LEN(1));
  for (const std::string& word :
       {std::string("piece 1, leaf 3"), "was level 1, corner (" + half + ", " + half + ", 0)",
        std::string("now level 2, corner")})
    EXPECT_NE(std::string(insitu_last_message()).find(word), std::string::npos)
        << word << " not in: " << insitu_last_message();
  q->level = 1;
  EXPECT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_OK) << insitu_last_message();

  f.refine();
  expect_refused(give_density(f.forest), INSITU_ERROR_ORDER, "tree 0 has ");
  expect_refused(give_density(f.forest), INSITU_ERROR_ORDER, "call insitu_p4est_mesh first");
  ASSERT_EQ(insitu_p4est_mesh(mesh, f.forest, nullptr, nullptr), INSITU_OK);
  ASSERT_EQ(give_density(f.forest), INSITU_OK) << insitu_p4est_message();
  EXPECT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_OK) << insitu_last_message();
}
