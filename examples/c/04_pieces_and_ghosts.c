/* 04: several pieces form one mesh, here two blocks that overlap by a layer of ghost cells. A ghost
 * cell owns no point, so each point has one owner. */
#include <insitu/insitu.h>

#include <stdio.h>

static int failed(insitu_status status) {
  if (status != INSITU_OK)
    fprintf(stderr, "%s: %s\n", insitu_status_name(status), insitu_last_message());
  return status != INSITU_OK;
}

int main(void) {
  enum { cells = 4, pieces = 2 };
  /* Each piece: 4 x 1 x 1 cells of size 1. Piece 0 from x = 0 to 4, piece 1 from x = 2 to 6. Where
   * they overlap, cell 3 of piece 0 and cell 0 of piece 1 are ghosts. */
  const double first_x[pieces] = {0.0, 2.0};
  const uint8_t ghosts[pieces][cells] = {{0, 0, 0, 1}, {1, 0, 0, 0}}; /* VTK's DUPLICATECELL */
  double owner[pieces][cells];

  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  if (failed(insitu_session_open(NULL, &session)) ||
      failed(insitu_session_mesh(session, "two blocks", &mesh)))
    return 1;
  for (int p = 0; p < pieces; ++p) {
    insitu_block block = insitu_block_default();
    block.kind = INSITU_BLOCK_UNIFORM;
    block.vertices[0] = cells + 1;
    block.vertices[1] = block.vertices[2] = 2;
    block.origin[0] = first_x[p];
    for (int c = 0; c < cells; ++c)
      owner[p][c] = 10 * p + c;
    const insitu_array ghost_array = insitu_array_of(ghosts[p], INSITU_UINT8, cells, 1);
    const insitu_array field = insitu_array_of(owner[p], INSITU_FLOAT64, cells, 1);
    if (failed(insitu_mesh_block(mesh, p, &block)) ||
        failed(insitu_mesh_ghosts(mesh, p, &ghost_array, INSITU_GHOSTS_VTK)) ||
        failed(insitu_mesh_field(mesh, p, "owner", INSITU_CELL, &field, 1)))
      return 1;
  }
  if (failed(insitu_mesh_commit(mesh, NULL)))
    return 1;

  double points[6][3];
  for (int i = 0; i < 6; ++i) {
    points[i][0] = i + 0.5;
    points[i][1] = points[i][2] = 0.5;
  }
  const insitu_array where = insitu_array_of(points, INSITU_FLOAT64, 6, 3);
  int64_t cell[6];
  int32_t piece[6];
  insitu_locate_args args = insitu_locate_args_default();
  args.points = &where;
  args.cells = cell;
  args.pieces = piece;
  if (failed(insitu_mesh_locate(mesh, &args)))
    return 1;
  /* x = 2.5 lies in piece 0 (and in a ghost of piece 1), x = 3.5 in piece 1 (and a ghost of 0). */
  const int expected_piece[6] = {0, 0, 0, 1, 1, 1}, expected_cell[6] = {0, 1, 2, 1, 2, 3};
  int wrong = 0;
  for (int i = 0; i < 6; ++i) {
    printf("x = %g: piece %d, cell %d\n", points[i][0], (int)piece[i], (int)cell[i]);
    wrong += piece[i] != expected_piece[i] || cell[i] != expected_cell[i];
  }
  return failed(insitu_session_close(&session)) || wrong;
}
