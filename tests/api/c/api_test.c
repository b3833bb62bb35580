/* The C API, as a C99 solver sees it: a mesh of two hexahedra; the answers; the errors. Every
 * failed expectation is printed and counted; the exit status is their number. */
#include <insitu/insitu.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "expect.h"

static double points[12][3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0},
                               {0, 0, 1}, {1, 0, 1}, {2, 0, 1}, {0, 1, 1}, {1, 1, 1}, {2, 1, 1}};
static int32_t cells[2][8] = {{0, 1, 4, 3, 6, 7, 10, 9}, {1, 2, 5, 4, 7, 8, 11, 10}};
static double field[12];
static double density[2] = {3, 4};

static insitu_session open_session(void) {
  insitu_session session = NULL;
  insitu_session_options options = insitu_session_options_default();
  options.threads = 2;
  EXPECT(insitu_session_open(&options, &session) == INSITU_OK);
  return session;
}

static insitu_mesh register_mesh(insitu_session session) {
  insitu_mesh mesh = NULL;
  insitu_array a = insitu_array_of(points, INSITU_FLOAT64, 12, 3);
  insitu_cells c = insitu_cells_default();
  int i;
  for (i = 0; i < 12; ++i)
    field[i] = points[i][0] + 2 * points[i][1] + 3 * points[i][2];
  EXPECT(insitu_session_mesh(session, "box", &mesh) == INSITU_OK);
  EXPECT(insitu_mesh_points(mesh, 0, &a, 1) == INSITU_OK);
  c.count = 2;
  c.connectivity = insitu_array_of(cells, INSITU_INT32, 2, 8);
  EXPECT(insitu_mesh_cells(mesh, 0, &c) == INSITU_OK);
  a = insitu_array_of(field, INSITU_FLOAT64, 12, 1);
  EXPECT(insitu_mesh_field(mesh, 0, "f", INSITU_VERTEX, &a, 1) == INSITU_OK);
  a = insitu_array_of(density, INSITU_FLOAT64, 2, 1);
  EXPECT(insitu_mesh_field(mesh, 0, "density", INSITU_CELL, &a, 1) == INSITU_OK);
  return mesh;
}

static void test_answers(void) {
  insitu_session session = open_session();
  insitu_mesh mesh = register_mesh(session), again = NULL;
  insitu_commit_report report = insitu_commit_report_default();
  insitu_sample_args args = insitu_sample_args_default();
  const double query[4][3] = {{0.25, 0.5, 0.75}, {1.5, 0.5, 0.5}, {1, 0.5, 0.5}, {2.5, 0, 0}};
  insitu_array where = insitu_array_of(query, INSITU_FLOAT64, 4, 3);
  int64_t owner[4];
  int32_t piece[4], found = 0;
  uint8_t inside[4];
  double f[4], rho[4], rst[4][3], value = 0;
  double* values[2];
  const char* names[2] = {"f", "density"};

  EXPECT(insitu_session_mesh(session, "box", &again) == INSITU_OK && again == mesh);
  EXPECT(insitu_mesh_commit(mesh, &report) == INSITU_OK);
  EXPECT(report.action == INSITU_REBUILD && report.validated == 1 && report.cells == 2 &&
         report.vertices == 12);
  values[0] = f;
  values[1] = rho;
  args.locate.points = &where;
  args.locate.cells = owner;
  args.locate.pieces = piece;
  args.locate.found = inside;
  args.locate.parametric = &rst[0][0];
  args.fields = names;
  args.field_count = 2;
  args.values = values;
  EXPECT(insitu_mesh_sample(mesh, &args) == INSITU_OK);
  EXPECT(owner[0] == 0 && owner[1] == 1 && owner[2] == 0 && owner[3] == -1);
  EXPECT(piece[0] == 0 && piece[3] == -1);
  EXPECT(inside[0] == 1 && inside[3] == 0);
  EXPECT(fabs(f[0] - (0.25 + 1 + 2.25)) < 1e-14 && fabs(f[1] - 4) < 1e-14);
  EXPECT(rho[0] == 3 && rho[1] == 4 && rho[2] == 3 && isnan(rho[3]) && isnan(rst[3][0]));
  EXPECT(fabs(rst[1][0] - 0.5) < 1e-14);
  args.locate.cell_base = 1; /* as Fortran counts */
  args.locate.accuracy = INSITU_EXACT;
  EXPECT(insitu_mesh_locate(mesh, &args.locate) == INSITU_OK);
  EXPECT(owner[0] == 1 && owner[1] == 2 && owner[2] == 1 && owner[3] == 0);
  EXPECT(insitu_mesh_sample_point(mesh, "f", query[0], &value, &found) == INSITU_OK);
  EXPECT(found == 1 && fabs(value - 3.5) < 1e-14);
  EXPECT(insitu_mesh_sample_point(mesh, "f", query[3], &value, &found) == INSITU_OK);
  EXPECT(found == 0 && isnan(value));

  /* Nothing changed, values changed, vertices moved, cells changed. */
  EXPECT(insitu_mesh_commit(mesh, &report) == INSITU_OK && report.action == INSITU_KEEP);
  EXPECT(insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS) == INSITU_OK);
  EXPECT(insitu_mesh_commit(mesh, &report) == INSITU_OK && report.action == INSITU_KEEP);
  points[2][0] = points[5][0] = points[8][0] = points[11][0] = 3;
  EXPECT(insitu_mesh_changed(mesh, INSITU_CHANGED_GEOMETRY) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_locate(mesh, &args.locate), INSITU_ERROR_ORDER, "commit");
  EXPECT_ERROR(insitu_mesh_complete(mesh, NULL), INSITU_ERROR_ORDER, "commit");
  EXPECT(insitu_mesh_commit(mesh, &report) == INSITU_OK && report.action == INSITU_REFIT);
  EXPECT(insitu_mesh_locate(mesh, &args.locate) == INSITU_OK && owner[3] == 2);
  EXPECT(insitu_mesh_complete(mesh, &report) == INSITU_OK && report.action == INSITU_KEEP);
  EXPECT(insitu_mesh_changed(mesh, INSITU_CHANGED_GEOMETRY) == INSITU_OK);
  EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);
  EXPECT(insitu_mesh_complete(mesh, &report) == INSITU_OK && report.action == INSITU_REFIT &&
         report.cells == 2);
  EXPECT(insitu_mesh_changed(mesh, INSITU_CHANGED_TOPOLOGY) == INSITU_OK);
  EXPECT(insitu_mesh_commit(mesh, &report) == INSITU_OK && report.action == INSITU_REBUILD);
  points[2][0] = points[5][0] = points[8][0] = points[11][0] = 2;

  EXPECT(insitu_session_close(&session) == INSITU_OK && session == NULL);
  EXPECT_ERROR(insitu_mesh_commit(mesh, NULL), INSITU_ERROR_HANDLE, "closed");
  EXPECT(insitu_session_close(&session) == INSITU_OK); /* null is fine */
}

/* Why: inside, and on each kind of thing that two cells, or a cell and the outside, share. */
static void test_reasons(void) {
  static const double query[10][3] = {
      {0.25, 0.5, 0.75}, {1.5, 0.5, 0.5}, /* centres and the like */
      {1, 0.5, 0.5},     {0.5, 0.25, 0},  /* the face between the two; a face of the boundary */
      {1, 0.25, 1},      {0.5, 0, 0},     /* edges of two cells and of one */
      {1, 1, 1},         {2, 0, 1},       /* vertices of two cells and of one */
      {2.5, 0.5, 0.5},   {NAN, 0, 0}};    /* outside */
  static const int64_t owners[10] = {0, 1, 0, 0, 0, 0, 0, 1, -1, -1};
  static const insitu_reason kinds[10] = {INSITU_REASON_CERTIFIED, INSITU_REASON_CERTIFIED,
                                          INSITU_REASON_ON_FACE,   INSITU_REASON_ON_FACE,
                                          INSITU_REASON_ON_EDGE,   INSITU_REASON_ON_EDGE,
                                          INSITU_REASON_ON_VERTEX, INSITU_REASON_ON_VERTEX,
                                          INSITU_REASON_OUTSIDE,   INSITU_REASON_OUTSIDE};
  insitu_session session = open_session();
  insitu_mesh mesh = register_mesh(session);
  insitu_array where = insitu_array_of(query, INSITU_FLOAT64, 10, 3);
  insitu_locate_args args = insitu_locate_args_default();
  insitu_report report = insitu_report_default();
  int64_t owner[10], sum = 0;
  uint8_t reasons[10];
  int i, exact;

  EXPECT(args.reasons == NULL);
  EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);
  args.points = &where;
  args.cells = owner;
  args.reasons = reasons;
  for (exact = 0; exact < 2; ++exact) {
    args.accuracy = exact ? INSITU_EXACT : INSITU_STANDARD;
    memset(reasons, 99, sizeof reasons);
    EXPECT(insitu_mesh_locate(mesh, &args) == INSITU_OK);
    for (i = 0; i < 10; ++i) {
      /* Inside, it is the library's choice how it makes sure. */
      const int same = reasons[i] == kinds[i] || (i < 2 && reasons[i] == INSITU_REASON_EXACT);
      if (owner[i] != owners[i] || !same) {
        printf("point %d: cell %d, reason %d\n", i, (int)owner[i], reasons[i]);
        ++failures;
      }
    }
  }
  EXPECT(insitu_session_report(session, &report) == INSITU_OK);
  for (i = 0; i < INSITU_REASON_COUNT; ++i)
    sum += report.located_by_reason[i];
  EXPECT(sum == 20 && report.points_located == 20);
  EXPECT(report.located_by_reason[INSITU_REASON_OUTSIDE] == 4);
  EXPECT(report.located_by_reason[INSITU_REASON_CERTIFIED] +
             report.located_by_reason[INSITU_REASON_EXACT] ==
         4);
  EXPECT(report.located_by_reason[INSITU_REASON_ON_FACE] == 4);
  EXPECT(report.located_by_reason[INSITU_REASON_ON_EDGE] == 4);
  EXPECT(report.located_by_reason[INSITU_REASON_ON_VERTEX] == 4);
  EXPECT(insitu_session_close(&session) == INSITU_OK);
}

static void test_audit(void) {
  insitu_session session = open_session();
  insitu_mesh mesh = register_mesh(session);
  insitu_audit_entry entries[8];
  int32_t count = 0, i, seen = 0;
  EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);
  EXPECT(insitu_mesh_audit(mesh, NULL, &count) == INSITU_OK && count == 4);
  count = 8;
  EXPECT(insitu_mesh_audit(mesh, entries, &count) == INSITU_OK);
  for (i = 0; i < count; ++i) {
    EXPECT(entries[i].borrowed == 1);
    seen += entries[i].data == (void*)points || entries[i].data == (void*)cells ||
            entries[i].data == (void*)field || entries[i].data == (void*)density;
  }
  EXPECT(seen == 4);
  EXPECT(insitu_session_close(&session) == INSITU_OK);
}

static void test_errors(void) {
  insitu_session session = open_session(), copy;
  insitu_mesh mesh = NULL, empty = NULL;
  insitu_array a = insitu_array_default();
  insitu_cells c = insitu_cells_default();
  insitu_locate_args l = insitu_locate_args_default();
  insitu_validation v = insitu_validation_default();
  insitu_session_options o = insitu_session_options_default();
  insitu_session bad = NULL;
  double nan_query[6] = {NAN, 0, 0, 0.5, INFINITY, 0.5};
  double huge_query[3] = {1e300, -1e300, 0};
  int64_t owner[2];

  EXPECT_ERROR(insitu_session_mesh(NULL, "m", &mesh), INSITU_ERROR_HANDLE, "null");
  EXPECT_ERROR(insitu_mesh_commit((insitu_mesh)points, NULL), INSITU_ERROR_HANDLE, "mesh");
  EXPECT_ERROR(insitu_session_mesh(session, "", &mesh), INSITU_ERROR_ARGUMENT, "name");
  EXPECT_ERROR(insitu_session_mesh(session, NULL, &mesh), INSITU_ERROR_ARGUMENT, "name");
  o.threads = -1;
  EXPECT_ERROR(insitu_session_open(&o, &bad), INSITU_ERROR_ARGUMENT, "threads");
  o = insitu_session_options_default();
  o.scene = "/no/such/scene.yaml";
  EXPECT_ERROR(insitu_session_open(&o, &bad), INSITU_ERROR_FILE, "/no/such/scene.yaml");
  o.scene = NULL;
  o.scene_text = "insitu: 1\nframes:\n  - name: a\n    volume: {feild: f}\n";
  EXPECT_ERROR(insitu_session_open(&o, &bad), INSITU_ERROR_SCENE, "did you mean 'field'");
  EXPECT(bad == NULL);

  EXPECT(insitu_session_mesh(session, "m", &mesh) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_commit(mesh, (insitu_commit_report*)&(size_t){3}), INSITU_ERROR_ARGUMENT,
               "insitu_commit_report_default");
  EXPECT_ERROR(insitu_mesh_points(mesh, 0, NULL, 1), INSITU_ERROR_ARGUMENT, "null");
  EXPECT_ERROR(
      insitu_mesh_points(mesh, 1, (a = insitu_array_of(points, INSITU_FLOAT64, 12, 3), &a), 1),
      INSITU_ERROR_ARGUMENT, "without gaps");
  a.type = (insitu_type)77;
  EXPECT_ERROR(insitu_mesh_points(mesh, 0, &a, 1), INSITU_ERROR_ARGUMENT, "unknown type 77");
  a = insitu_array_of(NULL, INSITU_FLOAT64, 12, 3);
  EXPECT_ERROR(insitu_mesh_points(mesh, 0, &a, 1), INSITU_ERROR_ARGUMENT, "data is null");
  a = insitu_array_of(points, INSITU_FLOAT64, -12, 3);
  EXPECT_ERROR(insitu_mesh_points(mesh, 0, &a, 1), INSITU_ERROR_ARGUMENT, "-12");
  a = insitu_array_of(points, INSITU_FLOAT64, 12, 1);
  EXPECT_ERROR(insitu_mesh_points(mesh, 0, &a, 1), INSITU_ERROR_ARGUMENT, "3 expected");
  a = insitu_array_of(points, INSITU_INT32, 12, 3);
  EXPECT_ERROR(insitu_mesh_points(mesh, 0, &a, 1), INSITU_ERROR_ARGUMENT, "float32 or float64");
  a = insitu_array_of(points, INSITU_FLOAT64, 12, 3);
  EXPECT(insitu_mesh_points(mesh, 0, &a, 1) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_commit(mesh, NULL), INSITU_ERROR_ORDER, "no cells");
  c.shape = (insitu_shape)25;
  EXPECT_ERROR(insitu_mesh_cells(mesh, 0, &c), INSITU_ERROR_ARGUMENT, "unknown shape 25");
  c = insitu_cells_default();
  c.count = 3;
  c.connectivity = insitu_array_of(cells, INSITU_INT32, 2, 8);
  EXPECT_ERROR(insitu_mesh_cells(mesh, 0, &c), INSITU_ERROR_ARGUMENT, "3 cells");
  c.count = -1;
  EXPECT_ERROR(insitu_mesh_cells(mesh, 0, &c), INSITU_ERROR_ARGUMENT, "count -1");
  c.count = 2;
  EXPECT(insitu_mesh_cells(mesh, 0, &c) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_locate(mesh, &l), INSITU_ERROR_ORDER, "not committed");

  /* A field of the wrong length is found at the commit; the mesh works again once it is gone. */
  a = insitu_array_of(field, INSITU_FLOAT64, 11, 1);
  EXPECT(insitu_mesh_field(mesh, 0, "short", INSITU_VERTEX, &a, 1) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_commit(mesh, NULL), INSITU_ERROR_FIELD, "11 values for 12 vertices");
  EXPECT_ERROR(insitu_mesh_remove_field(mesh, "shirt"), INSITU_ERROR_FIELD, "did you mean 'short'");
  EXPECT(insitu_mesh_remove_field(mesh, "short") == INSITU_OK);
  EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);

  /* An id out of range, a NaN coordinate. */
  cells[1][2] = 12;
  EXPECT(insitu_mesh_changed(mesh, INSITU_CHANGED_TOPOLOGY) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_commit(mesh, NULL), INSITU_ERROR_MESH, "cell 1: vertex 2 has id 12");
  cells[1][2] = 5;
  points[5][1] = NAN;
  EXPECT_ERROR(insitu_mesh_validate(mesh, &v), INSITU_ERROR_MESH, "coordinate y is NaN");
  EXPECT(v.coordinate_errors == 1 && v.cells == 2);
  EXPECT_ERROR(insitu_mesh_commit(mesh, NULL), INSITU_ERROR_MESH, "cell 1");
  points[5][1] = 1;
  EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);
  points[5][1] = NAN; /* moved there later */
  EXPECT(insitu_mesh_changed(mesh, INSITU_CHANGED_GEOMETRY) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_commit(mesh, NULL), INSITU_ERROR_MESH, "cell 1");
  points[5][1] = 1;
  EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);

  /* Queries. */
  EXPECT_ERROR(insitu_mesh_locate(mesh, &l), INSITU_ERROR_ARGUMENT, "points");
  a = insitu_array_of(nan_query, INSITU_FLOAT64, 2, 3);
  l.points = &a;
  l.cells = owner;
  EXPECT(insitu_mesh_locate(mesh, &l) == INSITU_OK && owner[0] == -1 && owner[1] == -1);
  a = insitu_array_of(huge_query, INSITU_FLOAT64, 1, 3);
  EXPECT(insitu_mesh_locate(mesh, &l) == INSITU_OK && owner[0] == -1);
  a.count = 0;
  EXPECT(insitu_mesh_locate(mesh, &l) == INSITU_OK);
  a.count = 1;
  l.parametric = huge_query;
  EXPECT_ERROR(insitu_mesh_locate(mesh, &l), INSITU_ERROR_ARGUMENT, "overlaps");
  l.parametric = NULL;
  l.point_arrays = 2;
  EXPECT_ERROR(insitu_mesh_locate(mesh, &l), INSITU_ERROR_ARGUMENT, "point_arrays");

  /* An empty mesh, and one whose every cell is a ghost: fine, and nothing is inside. */
  EXPECT(insitu_session_mesh(session, "empty", &empty) == INSITU_OK);
  EXPECT(insitu_mesh_commit(empty, NULL) == INSITU_OK);
  l = insitu_locate_args_default();
  l.points = &a;
  l.cells = owner;
  EXPECT(insitu_mesh_locate(empty, &l) == INSITU_OK && owner[0] == -1);
  {
    static const uint8_t ghosts[2] = {1, 32};
    const double inside[3] = {0.5, 0.5, 0.5};
    insitu_array g = insitu_array_of(ghosts, INSITU_UINT8, 2, 1);
    EXPECT(insitu_mesh_ghosts(mesh, 0, &g, INSITU_GHOSTS_VTK) == INSITU_OK);
    EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);
    a = insitu_array_of(inside, INSITU_FLOAT64, 1, 3);
    EXPECT(insitu_mesh_locate(mesh, &l) == INSITU_OK && owner[0] == -1);
    EXPECT(insitu_mesh_ghosts(mesh, 0, NULL, INSITU_GHOSTS_VTK) == INSITU_OK);
    EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);
    EXPECT(insitu_mesh_locate(mesh, &l) == INSITU_OK && owner[0] == 0);
  }

  copy = session;
  EXPECT(insitu_session_close(&session) == INSITU_OK);
  EXPECT_ERROR(insitu_session_close(&copy), INSITU_ERROR_HANDLE, "closed already");
  EXPECT_ERROR(insitu_session_execute(copy, 0, 0.0), INSITU_ERROR_HANDLE, "closed");
}

/* The two hexahedra by their faces: each face names its cells, then each cell its faces. */
static void test_faces(void) {
  static const int32_t vertices[44] = {1, 4, 10, 7, 0,  3,  9, 6,  0, 1, 7, 6,  3,  4, 10,
                                       9, 0, 1,  4, 3,  6,  7, 10, 9, 2, 5, 11, 8,  1, 2,
                                       8, 7, 4,  5, 11, 10, 1, 2,  5, 4, 7, 8,  11, 10};
  static const int64_t offsets[12] = {0, 4, 8, 12, 16, 20, 24, 28, 32, 36, 40, 44};
  static int32_t owner[11] = {0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1};
  static const int32_t neighbour[1] = {1};
  static const int32_t lists[12] = {0, 1, 2, 3, 4, 5, 0, 6, 7, 8, 9, 10};
  static const int32_t list_offsets[3] = {0, 6, 12};
  const double query[3][3] = {{0.25, 0.5, 0.75}, {1.5, 0.5, 0.5}, {2.5, 0, 0}};
  insitu_session session = open_session();
  insitu_mesh mesh = register_mesh(session);
  insitu_commit_report report = insitu_commit_report_default();
  insitu_sample_args args = insitu_sample_args_default();
  insitu_faces f = insitu_faces_default();
  insitu_array where = insitu_array_of(query, INSITU_FLOAT64, 3, 3);
  const char* name = "f";
  int64_t cell[3];
  double value[3];
  double* values = value;
  int form;

  f.cell_count = 2;
  f.face_count = 11;
  f.vertices = insitu_array_of(vertices, INSITU_INT32, 44, 1);
  f.offsets = insitu_array_of(offsets, INSITU_INT64, 12, 1);
  f.owner = insitu_array_of(owner, INSITU_INT32, 11, 1);
  f.neighbour = insitu_array_of(neighbour, INSITU_INT32, 1, 1);
  args.locate.points = &where;
  args.locate.cells = cell;
  args.field_count = 1;
  args.fields = &name;
  args.values = &values;
  for (form = 0; form < 2; ++form) {
    if (form == 1) {
      f.form = INSITU_FACES_CELLS;
      f.cell_faces = insitu_array_of(lists, INSITU_INT32, 12, 1);
      f.cell_offsets = insitu_array_of(list_offsets, INSITU_INT32, 3, 1);
    }
    EXPECT(insitu_mesh_faces(mesh, 0, &f) == INSITU_OK);
    EXPECT(insitu_mesh_commit(mesh, &report) == INSITU_OK);
    EXPECT(report.cells == 2 && report.vertices == 12);
    EXPECT(insitu_mesh_sample(mesh, &args) == INSITU_OK);
    EXPECT(cell[0] == 0 && cell[1] == 1 && cell[2] == -1);
    EXPECT(fabs(value[0] - 3.5) < 1e-14 && fabs(value[1] - 4.0) < 1e-14 && isnan(value[2]));
  }
  f.form = INSITU_FACES_OWNERS;
  owner[3] = 2;
  EXPECT(insitu_mesh_faces(mesh, 0, &f) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_commit(mesh, NULL), INSITU_ERROR_MESH,
               "piece 0, face 3: owner 2, 0 to 1 expected");
  EXPECT_ERROR(insitu_mesh_faces(mesh, 0, NULL), INSITU_ERROR_ARGUMENT, "null");
  EXPECT(insitu_session_close(&session) == INSITU_OK);
}

int main(void) {
  test_answers();
  test_faces();
  test_reasons();
  test_audit();
  test_errors();
  if (failures)
    printf("%d expectations failed\n", failures);
  return failures ? 1 : 0;
}
