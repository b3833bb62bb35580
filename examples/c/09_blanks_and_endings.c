/* 09: where a mesh has pieces, gaps, hidden cells, another process's cells and blank values. Lines
 * run along five lanes of a channel, and each ends for another reason, which the report counts. */
#include <insitu/insitu.h>
#include <math.h>
#include <stdio.h>

enum { n = 5, vertices = (n + 1) * (n + 1) * 2, cells = n * n };

/* Piece 0 reaches from x = 0 to 5, piece 1 from 5 to 10; both have a cell a lane. Piece 2 is one
 * cell from x = 11 to 12, behind a gap in lane 3. Vertices are ordered x first, then y, then z. */
static const double first_x[3] = {0, n, 2 * n + 1}, first_y[3] = {0, 0, 3};
static double velocity[3][vertices][3];
static float salt[3][vertices];
static uint8_t ghosts[cells];

static const char scene[] = "insitu: 1\n"
                            "page: false\n"
                            "tracers:\n"
                            "  - name: lanes\n"
                            "    kind: streamline\n"
                            "    velocity: velocity\n"
                            "    seeds: {line: {from: [0.5, 0.5, 0.5], to: [0.5, 4.5, 0.5], "
                            "count: 5}}\n";

static int failed(insitu_status status) {
  if (status != INSITU_OK)
    fprintf(stderr, "%s: %s\n", insitu_status_name(status), insitu_last_message());
  return status != INSITU_OK;
}

static int give(insitu_mesh mesh, int32_t piece) {
  const int size = piece < 2 ? n : 1, count = (size + 1) * (size + 1) * 2;
  insitu_block block = insitu_block_default();
  block.kind = INSITU_BLOCK_UNIFORM;
  block.origin[0] = first_x[piece];
  block.origin[1] = first_y[piece];
  block.vertices[0] = block.vertices[1] = size + 1;
  block.vertices[2] = 2;
  for (int v = 0; v < count; ++v) {
    const int i = v % (size + 1), j = v / (size + 1) % (size + 1);
    velocity[piece][v][0] = 1;
    salt[piece][v] = 35;
    if (piece == 1 && i >= 3 && j == n) { /* no water here: only lane 4 has cells there */
      velocity[piece][v][0] = -999;
      salt[piece][v] = 1e20f;
    }
  }
  const insitu_array u = insitu_array_of(velocity[piece], INSITU_FLOAT64, count, 3);
  const insitu_array s = insitu_array_of(salt[piece], INSITU_FLOAT32, count, 1);
  return failed(insitu_mesh_block(mesh, piece, &block)) ||
         failed(insitu_mesh_field(mesh, piece, "velocity", INSITU_VERTEX, &u, 1)) ||
         failed(insitu_mesh_field(mesh, piece, "salt", INSITU_VERTEX, &s, 1));
}

int main(void) {
  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  insitu_session_options options = insitu_session_options_default();
  options.scene_text = scene;
  options.output = "insitu_out/lanes";
  if (failed(insitu_session_open(&options, &session)) ||
      failed(insitu_session_mesh(session, "channel", &mesh)) || give(mesh, 0) || give(mesh, 1) ||
      give(mesh, 2))
    return 1;
  ghosts[n * 1 + 3] = 32; /* of piece 1: lane 1 has a hidden cell (VTK's HIDDENCELL), */
  ghosts[n * 2 + 3] = 1;  /* lane 2 one that another process owns (DUPLICATECELL) */
  const insitu_array bits = insitu_array_of(ghosts, INSITU_UINT8, cells, 1);
  if (failed(insitu_mesh_ghosts(mesh, 1, &bits, INSITU_GHOSTS_VTK)) ||
      failed(insitu_mesh_field_blank(mesh, "velocity", -999)) ||
      failed(insitu_mesh_field_blank(mesh, "salt", 1e20)) || /* the float nearest to it */
      failed(insitu_session_execute(session, 0, 0.0)))
    return 1;

  insitu_report report = insitu_report_default();
  insitu_session_report(session, &report);
  const int64_t* ended = report.particles;
  printf("left %d, hidden %d, partition %d, hole %d, blank %d\n", (int)ended[INSITU_END_LEFT],
         (int)ended[INSITU_END_HIDDEN], (int)ended[INSITU_END_PARTITION],
         (int)ended[INSITU_END_HOLE], (int)ended[INSITU_END_BLANK]);
  int wrong = ended[INSITU_END_LEFT] != 1 || ended[INSITU_END_HIDDEN] != 1 ||
              ended[INSITU_END_PARTITION] != 1 || ended[INSITU_END_HOLE] != 1 ||
              ended[INSITU_END_BLANK] != 1;

  /* A cell with a blank vertex owns points, but has no salt; a hidden cell owns nothing. */
  const double in_blank[3] = {8.5, 4.5, 0.5}, in_hidden[3] = {8.5, 1.5, 0.5};
  double value;
  int32_t found;
  wrong += failed(insitu_mesh_sample_point(mesh, "salt", in_blank, &value, &found));
  printf("blank: found %d, salt %g\n", (int)found, fabs(value)); /* NaN may have a sign */
  wrong += !found || !isnan(value);
  wrong += failed(insitu_mesh_sample_point(mesh, "salt", in_hidden, &value, &found));
  printf("hidden: found %d\n", (int)found);
  wrong += found;
  return failed(insitu_session_close(&session)) || wrong;
}
