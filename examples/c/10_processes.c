/* 10: a solver of several processes without a communicator. Each session works on its process's
 * pieces alone, so each needs a folder of its own; two that would write the same files are told
 * apart. Two sessions stand for two processes here. */
#include <insitu/insitu.h>
#include <stdio.h>

static const char scene[] = "insitu: 1\n"
                            "probes: [{name: middle, points: [[1, 0.5, 0.5]], fields: [rank]}]\n";

static void on_log(insitu_log_level level, const char* message, void* user) {
  printf("rank %d, log of level %d: %s\n", *(int*)user, (int)level, message);
}

static insitu_status open_session(int* rank, const char* folder, insitu_session* session) {
  insitu_session_options options = insitu_session_options_default();
  options.scene_text = scene;
  options.output = folder;
  options.threads = 1; /* of a program on MPI: options.communicator = &comm */
  options.log = on_log;
  options.log_user = rank;
  return insitu_session_open(&options, session);
}

/* Each process has the cells from x = rank to rank + 1, and those of its neighbour as ghosts. */
static int run(int rank, insitu_session session, double* found_here) {
  static const uint8_t ghosts[2][2] = {{0, 1}, {1, 0}}; /* VTK's DUPLICATECELL */
  const double values[2] = {rank, rank};
  insitu_mesh mesh = NULL;
  insitu_block block = insitu_block_default();
  block.kind = INSITU_BLOCK_UNIFORM;
  block.vertices[0] = 3;
  block.vertices[1] = block.vertices[2] = 2;
  const insitu_array bits = insitu_array_of(ghosts[rank], INSITU_UINT8, 2, 1);
  const insitu_array field = insitu_array_of(values, INSITU_FLOAT64, 2, 1);
  const double middle[3] = {1, 0.5, 0.5};
  return insitu_session_mesh(session, "box", &mesh) != INSITU_OK ||
         insitu_mesh_block(mesh, 0, &block) != INSITU_OK ||
         insitu_mesh_ghosts(mesh, 0, &bits, INSITU_GHOSTS_VTK) != INSITU_OK ||
         insitu_mesh_field(mesh, 0, "rank", INSITU_CELL, &field, 1) != INSITU_OK ||
         insitu_session_execute(session, 0, 0.0) != INSITU_OK ||
         insitu_mesh_sample_point(mesh, "rank", middle, found_here, NULL) != INSITU_OK;
}

int main(void) {
  int ranks[2] = {0, 1}, wrong = 0;
  insitu_session sessions[2] = {NULL, NULL};

  /* Two processes in one folder: the second one is refused, and nothing is overwritten. */
  wrong += open_session(&ranks[0], "insitu_out/ranks", &sessions[0]) != INSITU_OK;
  wrong += open_session(&ranks[1], "insitu_out/ranks", &sessions[1]) != INSITU_ERROR_FILE;
  wrong += insitu_session_close(&sessions[0]) != INSITU_OK;

  /* A folder each. Both find the point, which lies on the face between them: it has one owner in
   * each process. */
  for (int rank = 0; rank < 2; ++rank) {
    char folder[64];
    double value = -1;
    snprintf(folder, sizeof folder, "insitu_out/ranks/%d", rank);
    wrong += open_session(&ranks[rank], folder, &sessions[rank]) != INSITU_OK;
    wrong += run(rank, sessions[rank], &value);
    printf("rank %d found the value %g; see %s/middle.csv\n", rank, value, folder);
    wrong += value != rank;
  }
  for (int rank = 0; rank < 2; ++rank)
    wrong += insitu_session_close(&sessions[rank]) != INSITU_OK;
  return wrong;
}
