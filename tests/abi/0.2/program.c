/* A solver of version 0.2, in C: every struct that it may give or be given. Also what programs of
 * other versions do: structs that are longer, with zeros and without. */
#include <insitu/insitu.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;

#define EXPECT(what)                                                                               \
  do {                                                                                             \
    if (!(what)) {                                                                                 \
      fprintf(stderr, "line %d: %s; last message: %s\n", __LINE__, #what, insitu_last_message());  \
      ++failures;                                                                                  \
    }                                                                                              \
  } while (0)

static const char scene[] = "insitu: 1\n"
                            "probes:\n"
                            "  - {name: point, points: [[0.25, 0.5, 0.5]], fields: [pressure]}\n"
                            "tracers:\n"
                            "  - {name: paths, velocity: velocity, seeds: [[0.2, 0.5, 0.5]]}\n";

static double x[8] = {0, 1, 1, 0, 0, 1, 1, 0}, y[8] = {0, 0, 1, 1, 0, 0, 1, 1},
              z[8] = {0, 0, 0, 0, 1, 1, 1, 1}, pressure[8], velocity[24];
static const int32_t connectivity[8] = {0, 1, 2, 3, 4, 5, 6, 7};

static int mentions(const char* word) {
  return strstr(insitu_last_message(), word) != NULL;
}

static void give_mesh(insitu_mesh mesh) {
  insitu_array points[3], field, vector;
  insitu_cells cells = insitu_cells_default();
  insitu_commit_report commit = insitu_commit_report_default();
  insitu_validation validation = insitu_validation_default();
  insitu_frame frame = insitu_frame_default();
  points[0] = insitu_array_of(x, INSITU_FLOAT64, 8, 1);
  points[1] = insitu_array_of(y, INSITU_FLOAT64, 8, 1);
  points[2] = insitu_array_of(z, INSITU_FLOAT64, 8, 1);
  EXPECT(insitu_mesh_points(mesh, 0, points, 3) == INSITU_OK);
  cells.shape = INSITU_HEXAHEDRON;
  cells.count = 1;
  cells.connectivity = insitu_array_of(connectivity, INSITU_INT32, 1, 8);
  EXPECT(insitu_mesh_cells(mesh, 0, &cells) == INSITU_OK);
  EXPECT(insitu_mesh_frame(mesh, &frame) == INSITU_OK);
  field = insitu_array_of(pressure, INSITU_FLOAT64, 8, 1);
  vector = insitu_array_of(velocity, INSITU_FLOAT64, 8, 3);
  EXPECT(insitu_mesh_field(mesh, 0, "pressure", INSITU_VERTEX, &field, 1) == INSITU_OK);
  EXPECT(insitu_mesh_field(mesh, 0, "velocity", INSITU_VERTEX, &vector, 1) == INSITU_OK);
  EXPECT(insitu_mesh_validate(mesh, &validation) == INSITU_OK);
  EXPECT(validation.size == sizeof validation && validation.cells == 1);
  EXPECT(insitu_mesh_commit(mesh, &commit) == INSITU_OK);
  EXPECT(commit.size == sizeof commit && commit.cells == 1 && commit.vertices == 8);
}

static void ask_mesh(insitu_mesh mesh) {
  const double at[6] = {0.25, 0.5, 0.5, 2.0, 0.0, 0.0};
  const insitu_array points = insitu_array_of(at, INSITU_FLOAT64, 2, 3);
  const char* names[1] = {"pressure"};
  double values[2];
  double* outputs[1];
  int64_t cells[2];
  uint8_t reasons[2];
  insitu_sample_args sample = insitu_sample_args_default();
  insitu_locator locator = insitu_locator_default();
  insitu_locator_info info = insitu_locator_info_default();
  insitu_audit_entry entries[8];
  int32_t count = 8;
  outputs[0] = values;
  sample.locate.points = &points;
  sample.locate.cells = cells;
  sample.locate.reasons = reasons;
  sample.fields = names;
  sample.field_count = 1;
  sample.values = outputs;
  EXPECT(insitu_mesh_sample(mesh, &sample) == INSITU_OK);
  EXPECT(cells[0] == 0 && cells[1] == -1 && fabs(values[0] - 0.25) < 1e-15 &&
         values[1] != values[1]);
  EXPECT(reasons[1] == INSITU_REASON_OUTSIDE);
  EXPECT(insitu_mesh_locate(mesh, &sample.locate) == INSITU_OK);
  EXPECT(insitu_mesh_locator(mesh, &locator) == INSITU_OK);
  EXPECT(insitu_mesh_locator_info(mesh, &info) == INSITU_OK);
  EXPECT(info.size == sizeof info && info.method == INSITU_METHOD_BVH && info.primitives == 1);
  EXPECT(insitu_mesh_audit(mesh, entries, &count) == INSITU_OK);
  EXPECT(count == 6 && entries[0].data == x && entries[1].data == y);
}

static void read_report(insitu_session session) {
  insitu_report report = insitu_report_default();
  int64_t particles = 0;
  int i;
  EXPECT(insitu_session_report(session, &report) == INSITU_OK);
  EXPECT(report.size == sizeof report && report.executions == 3 && report.failures == 0);
  EXPECT(report.endings >= INSITU_END_COUNT && report.endings <= INSITU_END_ROOM);
  EXPECT(report.purposes >= INSITU_MEMORY_COUNT && report.purposes <= INSITU_MEMORY_ROOM);
  EXPECT(report.reasons >= INSITU_REASON_COUNT && report.reasons <= INSITU_REASON_ROOM);
  for (i = 0; i < report.endings; ++i)
    particles += report.particles[i];
  EXPECT(particles == 1 && report.particles_seeded == 1);
  EXPECT(report.particles[INSITU_END_ALIVE] == 1 &&
         report.bytes_by_purpose[INSITU_MEMORY_TREE] > 0);
  EXPECT(report.located_by_reason[INSITU_REASON_OUTSIDE] == 2);
}

static void adaptive(insitu_session session) {
  insitu_mesh mesh = NULL;
  insitu_amr amr = insitu_amr_default();
  insitu_patch patch = insitu_patch_default();
  insitu_amr_info info = insitu_amr_info_default();
  double density[8] = {1, 2, 3, 4, 5, 6, 7, 8};
  const insitu_array field = insitu_array_of(density, INSITU_FLOAT64, 8, 1);
  const uint8_t levels[1] = {0};
  const int32_t corners[3] = {5, 5, 5};
  insitu_leaves leaves = insitu_leaves_default();
  insitu_block block = insitu_block_default();
  int i;
  EXPECT(insitu_session_mesh(session, "adaptive", &mesh) == INSITU_OK);
  EXPECT(insitu_mesh_amr(mesh, &amr) == INSITU_OK);
  for (i = 0; i < 3; ++i)
    patch.cells[i] = 2;
  EXPECT(insitu_mesh_patch(mesh, 0, &patch) == INSITU_OK);
  EXPECT(insitu_mesh_field(mesh, 0, "density", INSITU_CELL, &field, 1) == INSITU_OK);
  EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);
  EXPECT(insitu_mesh_amr_info(mesh, &info) == INSITU_OK && info.size == sizeof info &&
         info.leaves == 8);
  leaves.levels = insitu_array_of(levels, INSITU_UINT8, 1, 1);
  leaves.corners = insitu_array_of(corners, INSITU_INT32, 1, 3);
  EXPECT(insitu_session_mesh(session, "leaves", &mesh) == INSITU_OK);
  EXPECT(insitu_mesh_amr(mesh, &amr) == INSITU_OK);
  EXPECT(insitu_mesh_leaves(mesh, 0, &leaves) == INSITU_OK);
  EXPECT(insitu_session_mesh(session, "block", &mesh) == INSITU_OK);
  block.kind = INSITU_BLOCK_UNIFORM;
  for (i = 0; i < 3; ++i)
    block.vertices[i] = 2;
  EXPECT(insitu_mesh_block(mesh, 0, &block) == INSITU_OK);
  EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);
}

/* Structs of a version that has more members, and structs that are none. */
static void other_versions(insitu_session session) {
  struct {
    insitu_patch known;
    int64_t more[64];
  } patch;
  struct {
    insitu_report known;
    int64_t more[64];
  } report;
  insitu_mesh mesh = NULL;
  insitu_amr amr = insitu_amr_default();
  insitu_array array = insitu_array_of(x, INSITU_FLOAT64, 8, 1), arrays[3];
  insitu_frame frame = insitu_frame_default();
  insitu_session_options options = insitu_session_options_default();
  insitu_session other = NULL;
  int i;
  memset(&patch, 0, sizeof patch);
  patch.known = insitu_patch_default();
  for (i = 0; i < 3; ++i)
    patch.known.cells[i] = 2;
  patch.known.size = sizeof patch;
  EXPECT(insitu_session_mesh(session, "other", &mesh) == INSITU_OK);
  EXPECT(insitu_mesh_amr(mesh, &amr) == INSITU_OK);
  EXPECT(insitu_mesh_patch(mesh, 0, &patch.known) == INSITU_OK);
  patch.more[63] = 7;
  EXPECT(insitu_mesh_patch(mesh, 0, &patch.known) == INSITU_ERROR_ARGUMENT);
  EXPECT(mentions("insitu_patch") && mentions("is 7, 0 expected"));
  patch.known.size = sizeof patch.known - 8;
  EXPECT(insitu_mesh_patch(mesh, 0, &patch.known) == INSITU_ERROR_ARGUMENT);
  EXPECT(mentions("insitu_patch_default()") && mentions("or more expected"));
  patch.known.size = (size_t)1 << 60;
  EXPECT(insitu_mesh_patch(mesh, 0, &patch.known) == INSITU_ERROR_ARGUMENT);

  report.known = insitu_report_default();
  report.known.size = sizeof report;
  report.more[63] = 11; /* beyond what any version may come to have */
  EXPECT(insitu_session_report(session, &report.known) == INSITU_OK);
  EXPECT(report.known.size == sizeof report && report.known.executions == 3);
  EXPECT(report.more[63] == 11);

  EXPECT(insitu_session_mesh(session, "arrays", &mesh) == INSITU_OK);
  arrays[0] = arrays[1] = arrays[2] = array;
  EXPECT(insitu_mesh_points(mesh, 0, arrays, 3) == INSITU_OK);
  arrays[1].size += 8;
  EXPECT(insitu_mesh_points(mesh, 0, arrays, 3) == INSITU_ERROR_ARGUMENT && mentions("size is"));

  /* without units, as before 0.1 */
  frame.size = offsetof(insitu_frame, angle);
  frame.angle = (insitu_angle)77;
  EXPECT(insitu_mesh_frame(mesh, &frame) == INSITU_OK);

  options.size = 4104;
  EXPECT(insitu_session_open(&options, &other) == INSITU_ERROR_ARGUMENT && other == NULL);
  EXPECT(mentions("at most 4096"));
}

int main(void) {
  insitu_session_options options = insitu_session_options_default();
  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  int major = -1, cycle, i;
  EXPECT(insitu_version(&major, NULL, NULL) == INSITU_OK && major >= 0);
  for (i = 0; i < 8; ++i) {
    pressure[i] = x[i];
    velocity[3 * i] = 0.01;
  }
  options.scene_text = scene;
  options.threads = 2;
  EXPECT(insitu_session_open(&options, &session) == INSITU_OK);
  EXPECT(insitu_session_mesh(session, "hydro", &mesh) == INSITU_OK);
  give_mesh(mesh);
  for (cycle = 0; cycle < 3; ++cycle) {
    EXPECT(insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS) == INSITU_OK);
    EXPECT(insitu_session_execute(session, cycle, 0.1 * cycle) == INSITU_OK);
  }
  ask_mesh(mesh);
  read_report(session);
  adaptive(session);
  other_versions(session);
  EXPECT(insitu_session_close(&session) == INSITU_OK && session == NULL);
  return failures != 0;
}
