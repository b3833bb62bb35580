/* 06: when things are wrong the solver goes on, and knows what and where. Then: what the library
 * did, what it holds, and which arrays it reads in place. */
#include <insitu/insitu.h>

#include <stdio.h>
#include <string.h>

static void on_log(insitu_log_level level, const char* message, void* user) {
  (void)level;
  printf("log: %s\n", message);
  ++*(int*)user;
}

static int expect(const char* what, insitu_status status, insitu_status expected) {
  printf("%s: %s: %s\n", what, insitu_status_name(status), insitu_last_message());
  return status != expected;
}

int main(void) {
  int wrong = 0, messages = 0;
  insitu_session session = NULL;
  insitu_mesh mesh = NULL;

  /* A scene with a typo. */
  insitu_session_options options = insitu_session_options_default();
  options.log = on_log;
  options.log_user = &messages;
  options.scene_text = "insitu: 1\nprobs: []\n";
  wrong += expect("typo", insitu_session_open(&options, &session), INSITU_ERROR_SCENE);

  options.scene_text = NULL;
  wrong += insitu_session_open(&options, &session) != INSITU_OK;
  wrong += insitu_session_mesh(session, "m", &mesh) != INSITU_OK;

  /* A mesh with an id out of range. It is refused; the arrays are corrected, and all is well. */
  const double xyz[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  int32_t ids[4] = {0, 1, 2, 9};
  const int32_t numbers[1] = {3};
  double pressure[4] = {1, 2, 3, 4};
  const insitu_array points = insitu_array_of(xyz, INSITU_FLOAT64, 4, 3);
  insitu_cells cells = insitu_cells_default();
  cells.shape = INSITU_TETRAHEDRON;
  cells.count = 1;
  cells.connectivity = insitu_array_of(ids, INSITU_INT32, 1, 4);
  insitu_mesh_points(mesh, 0, &points, 1);
  insitu_mesh_cells(mesh, 0, &cells);
  wrong += expect("bad id", insitu_mesh_commit(mesh, NULL), INSITU_ERROR_MESH);
  ids[3] = 3;
  insitu_mesh_changed(mesh, INSITU_CHANGED_TOPOLOGY);
  insitu_commit_report commit = insitu_commit_report_default();
  wrong += insitu_mesh_commit(mesh, &commit) != INSITU_OK;
  printf("commit: %d cell, %d vertices, %d bytes held\n", (int)commit.cells, (int)commit.vertices,
         (int)commit.bytes);

  /* Fields of a wrong type or name. */
  const insitu_array integers = insitu_array_of(numbers, INSITU_INT32, 1, 1);
  wrong += expect("integers", insitu_mesh_field(mesh, 0, "n", INSITU_CELL, &integers, 1),
                  INSITU_ERROR_ARGUMENT);
  const insitu_array field = insitu_array_of(pressure, INSITU_FLOAT64, 4, 1);
  insitu_mesh_field(mesh, 0, "pressure", INSITU_VERTEX, &field, 1);
  wrong += insitu_mesh_commit(mesh, NULL) != INSITU_OK;
  const double at[3] = {0.1, 0.1, 0.1};
  double value;
  wrong += expect("typo", insitu_mesh_sample_point(mesh, "presure", at, &value, NULL),
                  INSITU_ERROR_FIELD);

  /* Which arrays are read in place. */
  insitu_audit_entry entries[8];
  int32_t count = 8;
  insitu_mesh_audit(mesh, entries, &count);
  for (int i = 0; i < count && i < 8; ++i) {
    printf("%s: %s\n", entries[i].name, entries[i].borrowed ? "in place" : entries[i].reason);
    wrong += !entries[i].borrowed;
  }
  insitu_report report = insitu_report_default();
  insitu_session_report(session, &report);
  printf("%d rebuilds, %d bytes held, %d bytes borrowed\n", (int)report.rebuilds,
         (int)report.bytes_held, (int)report.bytes_borrowed);
  insitu_session_close(&session);

  /* A handle that is no more is found out, not followed. */
  wrong += expect("released", insitu_mesh_commit(mesh, NULL), INSITU_ERROR_HANDLE);
  return wrong;
}
