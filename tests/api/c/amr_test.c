/* Adaptive meshes through the C API: patches and leaves are registered, read in place, and refused
 * by name. Every failed expectation is printed and counted; the exit status is their number. */
#include <insitu/insitu.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "expect.h"

static void expect_borrowed(insitu_mesh mesh, const char* name, const void* data, int line) {
  insitu_audit_entry entries[16];
  int32_t count = 16, i;
  if (insitu_mesh_audit(mesh, entries, &count) == INSITU_OK)
    for (i = 0; i < count; ++i)
      if (strcmp(entries[i].name, name) == 0 && entries[i].data == data && entries[i].borrowed)
        return;
  printf("line %d: '%s' is not read in place\n", line, name);
  ++failures;
}
#define EXPECT_BORROWED(mesh, name, data) expect_borrowed((mesh), (name), (data), __LINE__)

static insitu_session open_session(void) {
  insitu_session session = NULL;
  insitu_session_options options = insitu_session_options_default();
  options.threads = 2;
  EXPECT(insitu_session_open(&options, &session) == INSITU_OK);
  return session;
}

/* A patch of 4^3 cells with two ghost layers, and one of 2^3 over the cell (1, 1, 1). */
static void test_patches(void) {
  static double coarse[8][8][8], fine[2][2][2];
  insitu_session session = open_session();
  insitu_mesh mesh = NULL;
  insitu_amr amr = insitu_amr_default();
  insitu_patch patch = insitu_patch_default();
  insitu_array a = insitu_array_of(&coarse[2][2][2], INSITU_FLOAT64, 64, 1);
  int i;
  EXPECT(insitu_session_mesh(session, "patches", &mesh) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_patch(mesh, 0, &patch), INSITU_ERROR_ORDER, "insitu_mesh_amr");
  EXPECT_ERROR(insitu_mesh_amr(mesh, NULL), INSITU_ERROR_ARGUMENT, "insitu_amr_default");
  amr.spacing[1] = NAN;
  EXPECT_ERROR(insitu_mesh_amr(mesh, &amr), INSITU_ERROR_ARGUMENT, "spacing along axis 1 is nan");
  amr.spacing[1] = 1;
  amr.level_count = 2;
  EXPECT(insitu_mesh_amr(mesh, &amr) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_points(mesh, 0, &a, 1), INSITU_ERROR_ORDER, "adaptive");
  EXPECT(insitu_mesh_patch(mesh, 0, &patch) == INSITU_OK); /* without cells: adds nothing */
  patch.cells[0] = -1;
  EXPECT_ERROR(insitu_mesh_patch(mesh, 0, &patch), INSITU_ERROR_ARGUMENT, "-1 cells along axis 0");
  for (i = 0; i < 3; ++i) {
    patch.cells[i] = 4;
    a.extent[i] = 4;
  }
  a.stride[1] = 8 * 8;
  a.stride[2] = 8 * 8 * 8;
  EXPECT(insitu_mesh_patch(mesh, 0, &patch) == INSITU_OK);
  EXPECT(insitu_mesh_field(mesh, 0, "rho", INSITU_CELL, &a, 1) == INSITU_OK);
  patch.level = 1;
  for (i = 0; i < 3; ++i)
    patch.lower[i] = patch.cells[i] = 2;
  EXPECT(insitu_mesh_patch(mesh, 1, &patch) == INSITU_OK);
  a = insitu_array_of(fine, INSITU_FLOAT64, 7, 1);
  EXPECT(insitu_mesh_field(mesh, 1, "rho", INSITU_CELL, &a, 1) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_commit(mesh, NULL), INSITU_ERROR_FIELD, "7 values for 8 cells");
  a.count = 8;
  EXPECT(insitu_mesh_field(mesh, 1, "rho", INSITU_CELL, &a, 1) == INSITU_OK);
  EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);
  EXPECT_BORROWED(mesh, "piece 0 field 'rho'", &coarse[2][2][2]);
  EXPECT_BORROWED(mesh, "piece 1 field 'rho'", fine);
  {
    const int64_t cells[] = {63, 0, -1, 7}, bases[] = {64, 1, 0, 8};
    const int32_t pieces[] = {0, 1, 1, 1}, beyond[] = {0, 1, 2, 1};
    int32_t levels[] = {9, 9, 9, 9};
    EXPECT(insitu_mesh_cell_levels(mesh, 4, cells, pieces, 0, levels) == INSITU_OK);
    EXPECT(levels[0] == 0 && levels[1] == 1 && levels[2] == -1 && levels[3] == 1);
    levels[0] = levels[3] = 9;
    EXPECT(insitu_mesh_cell_levels(mesh, 4, bases, pieces, 1, levels) == INSITU_OK);
    EXPECT(levels[0] == 0 && levels[1] == 1 && levels[2] == -1 && levels[3] == 1);
    EXPECT(insitu_mesh_cell_levels(mesh, 0, NULL, NULL, 0, NULL) == INSITU_OK);
    EXPECT_ERROR(insitu_mesh_cell_levels(mesh, 4, cells, NULL, 0, levels), INSITU_ERROR_ARGUMENT,
                 "pieces: null, of a mesh of 2");
    EXPECT_ERROR(insitu_mesh_cell_levels(mesh, 4, NULL, pieces, 0, levels), INSITU_ERROR_ARGUMENT,
                 "cells: null");
    EXPECT_ERROR(insitu_mesh_cell_levels(mesh, 4, bases, pieces, 0, levels), INSITU_ERROR_ARGUMENT,
                 "item 0 is cell 64 of piece 0, which has 64 cells");
    EXPECT_ERROR(insitu_mesh_cell_levels(mesh, 1, cells + 3, beyond + 2, 0, levels),
                 INSITU_ERROR_ARGUMENT, "cell 7 of piece 2, which has 0 cells");
    EXPECT_ERROR(insitu_mesh_cell_levels(mesh, 4, cells, pieces, 2, levels), INSITU_ERROR_ARGUMENT,
                 "from 2 on");
  }
  EXPECT(insitu_mesh_drop_pieces(mesh, 1) == INSITU_OK);
  EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_drop_pieces(mesh, 2), INSITU_ERROR_ARGUMENT, "0 to 1 expected");
  EXPECT(insitu_session_close(&session) == INSITU_OK);
}

/* Values 1 in a patch whose ghost cells hold 3: 2 half way between, at the boundary; as before at
 * the faces whose ghosts are not to be used; what the solver writes to them counts from a commit
 * on. */
static void test_ghosts(void) {
  static float rho[4][4][4];
  insitu_session session = open_session();
  insitu_mesh mesh = NULL;
  insitu_amr amr = insitu_amr_default();
  insitu_patch patch = insitu_patch_default();
  insitu_array a = insitu_array_of(&rho[1][1][1], INSITU_FLOAT32, 8, 1);
  const double upper[3] = {2, 1, 1}, lower[3] = {0, 1, 1}, edge[3] = {2, 2, 1};
  double value;
  int32_t found;
  int i, j, k;
  for (k = 0; k < 4; ++k)
    for (j = 0; j < 4; ++j)
      for (i = 0; i < 4; ++i)
        rho[k][j][i] = i % 3 && j % 3 && k % 3 ? 1.0f : 3.0f;
  for (i = 0; i < 3; ++i) {
    patch.cells[i] = a.extent[i] = 2;
    patch.ghosts_after[i] = 1;
  }
  EXPECT(insitu_session_mesh(session, "ghosts", &mesh) == INSITU_OK);
  EXPECT(insitu_mesh_amr(mesh, &amr) == INSITU_OK);
  EXPECT(insitu_mesh_patch(mesh, 0, &patch) == INSITU_OK);
  EXPECT(insitu_mesh_field(mesh, 0, "rho", INSITU_CELL, &a, 1) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_commit(mesh, NULL), INSITU_ERROR_FIELD, "no room for ghosts");
  a.stride[1] = 4 * 4;
  a.stride[2] = 4 * 4 * 4;
  EXPECT(insitu_mesh_field(mesh, 0, "rho", INSITU_CELL, &a, 1) == INSITU_OK);
  EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);
  EXPECT(insitu_mesh_sample_point(mesh, "rho", upper, &value, &found) == INSITU_OK);
  EXPECT(found && value == 2.0);
  EXPECT(insitu_mesh_sample_point(mesh, "rho", edge, &value, &found) == INSITU_OK);
  EXPECT(found && value == 3.0); /* 1 + (2 - 1) + (2 - 1) */
  EXPECT(insitu_mesh_sample_point(mesh, "rho", lower, &value, &found) == INSITU_OK);
  EXPECT(found && value == 1.0);
  for (k = 1; k < 3; ++k)
    for (j = 1; j < 3; ++j)
      rho[k][j][3] = 5.0f;
  EXPECT(insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS) == INSITU_OK);
  EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);
  EXPECT(insitu_mesh_sample_point(mesh, "rho", upper, &value, &found) == INSITU_OK);
  EXPECT(found && value == 3.0);
  EXPECT(insitu_session_close(&session) == INSITU_OK);
}

typedef struct leaf {
  int32_t corner[3];
  uint8_t level;
  void* record;
} leaf;

typedef struct record {
  float weight;
  double rho, velocity[3];
} record;

/* The eight children of a unit cube, each with a record behind a pointer. */
static void test_leaves(void) {
  static leaf leaves[8];
  static record records[8];
  insitu_session session = open_session();
  insitu_mesh mesh = NULL;
  insitu_amr amr = insitu_amr_default();
  insitu_leaves l = insitu_leaves_default();
  insitu_array a = insitu_array_of(&leaves[0].record, INSITU_FLOAT64, 8, 1);
  int i;
  for (i = 0; i < 8; ++i) {
    leaves[i].corner[0] = (i & 1) << 18;
    leaves[i].corner[1] = (i >> 1 & 1) << 18;
    leaves[i].corner[2] = (i >> 2) << 18;
    leaves[i].level = 1;
    leaves[i].record = &records[i];
  }
  EXPECT(insitu_session_mesh(session, "leaves", &mesh) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_leaves(mesh, 0, &l), INSITU_ERROR_ORDER, "insitu_mesh_amr");
  amr.level_count = 2;
  EXPECT(insitu_mesh_amr(mesh, &amr) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_leaves(mesh, 0, NULL), INSITU_ERROR_ARGUMENT, "insitu_leaves_default");
  l.levels = insitu_array_of(&leaves[0].level, INSITU_UINT8, 8, 1);
  l.corners = insitu_array_of(leaves[0].corner, INSITU_INT32, 8, 3);
  l.levels.stride[0] = l.corners.stride[0] = a.stride[0] = sizeof(leaf);
  l.corner_bits = 19;
  EXPECT(insitu_mesh_leaves(mesh, 0, &l) == INSITU_OK);
  a.indirect = 1;
  a.offset = offsetof(record, rho);
  EXPECT(insitu_mesh_field(mesh, 0, "rho", INSITU_CELL, &a, 1) == INSITU_OK);
  a.offset = offsetof(record, velocity);
  a.components = 3;
  EXPECT(insitu_mesh_field(mesh, 0, "velocity", INSITU_CELL, &a, 1) == INSITU_OK);
  leaves[3].level = 2;
  EXPECT_ERROR(insitu_mesh_commit(mesh, NULL), INSITU_ERROR_MESH, "piece 0, leaf 3: level 2");
  leaves[3].level = 1;
  leaves[5].corner[0] += 1;
  EXPECT_ERROR(insitu_mesh_commit(mesh, NULL), INSITU_ERROR_MESH, "leaf 5: level 1, corner");
  leaves[5].corner[0] -= 1;
  leaves[2].record = NULL;
  EXPECT_ERROR(insitu_mesh_commit(mesh, NULL), INSITU_ERROR_FIELD, "pointer of item 2 is null");
  leaves[2].record = &records[2];
  EXPECT(insitu_mesh_commit(mesh, NULL) == INSITU_OK);
  EXPECT_BORROWED(mesh, "piece 0 levels", &leaves[0].level);
  EXPECT_BORROWED(mesh, "piece 0 corners", leaves[0].corner);
  EXPECT_BORROWED(mesh, "piece 0 field 'velocity'", &leaves[0].record);
  a.memory = INSITU_DEVICE;
  EXPECT(insitu_mesh_field(mesh, 0, "rho", INSITU_CELL, &a, 1) != INSITU_OK);
  a = insitu_array_of(records, INSITU_FLOAT64, 8, 1);
  EXPECT(insitu_mesh_field(mesh, 0, "rho", INSITU_VERTEX, &a, 1) == INSITU_OK);
  EXPECT_ERROR(insitu_mesh_commit(mesh, NULL), INSITU_ERROR_FIELD, "on vertices");
  EXPECT(insitu_session_close(&session) == INSITU_OK);
}

int main(void) {
  test_patches();
  test_ghosts();
  test_leaves();
  if (failures)
    printf("%d expectations failed\n", failures);
  return failures ? 1 : 0;
}
