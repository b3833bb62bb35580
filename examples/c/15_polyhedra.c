/* 15: polyhedra by their faces, as finite-volume solvers hold them. Two cells of a honeycomb,
 * six-sided prisms that share one side: a ring of vertices a face, and for each face the cell that
 * owns it and the other one. Points between them have one owner; a point outside may ask for the
 * nearest cell. */
#include <insitu/insitu.h>
#include <math.h>
#include <stdio.h>

enum { corners = 10, face_count = 15, point_count = 4 };

/* The corners of both hexagons on the floor; those on the lid have numbers 10 above. */
static const double floor_xy[corners][2] = {{0.9, 0.5}, {0, 1},      {-0.9, 0.5}, {-0.9, -0.5},
                                            {0, -1},    {0.9, -0.5}, {2.7, 0.5},  {1.8, 1},
                                            {1.8, -1},  {2.7, -0.5}};
static const int32_t rings[2][6] = {{0, 1, 2, 3, 4, 5}, {6, 7, 0, 5, 8, 9}};

static double xyz[2 * corners][3], temperature[2 * corners];
static int32_t vertices[11 * 4 + 4 * 6], offsets[face_count + 1], owner[face_count];
static int32_t faces_so_far = 0;

static int failed(insitu_status status) {
  if (status != INSITU_OK)
    fprintf(stderr, "%s: %s\n", insitu_status_name(status), insitu_last_message());
  return status != INSITU_OK;
}

static double linear(const double* x) {
  return 20 + x[0] + 2 * x[1] - 3 * x[2];
}

static void add_face(int32_t cell, int count, const int32_t* ring) {
  int32_t* to = vertices + offsets[faces_so_far];
  for (int i = 0; i < count; ++i)
    to[i] = ring[i];
  owner[faces_so_far++] = cell;
  offsets[faces_so_far] = offsets[faces_so_far - 1] + count;
}

/* The upright face over the side from a corner to the next one. */
static void add_side(int32_t cell, int32_t a, int32_t b) {
  const int32_t ring[4] = {a, b, b + corners, a + corners};
  add_face(cell, 4, ring);
}

int main(void) {
  for (int v = 0; v < 2 * corners; ++v) {
    xyz[v][0] = floor_xy[v % corners][0];
    xyz[v][1] = floor_xy[v % corners][1];
    xyz[v][2] = v < corners ? 0 : 1;
    temperature[v] = linear(xyz[v]);
  }
  add_side(0, 5, 0); /* first the faces that have a neighbour */
  const int32_t neighbour[1] = {1};
  for (int32_t cell = 0; cell < 2; ++cell) {
    int32_t lid[6];
    for (int i = 0; i < 6; ++i) {
      const int32_t a = rings[cell][i], b = rings[cell][(i + 1) % 6];
      lid[i] = a + corners;
      if (!(a == 5 && b == 0) && !(a == 0 && b == 5)) /* the side between both is there */
        add_side(cell, a, b);
    }
    add_face(cell, 6, rings[cell]);
    add_face(cell, 6, lid);
  }

  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  insitu_faces faces = insitu_faces_default(); /* by owners */
  faces.cell_count = 2;
  faces.face_count = faces_so_far;
  faces.vertices = insitu_array_of(vertices, INSITU_INT32, offsets[faces_so_far], 1);
  faces.offsets = insitu_array_of(offsets, INSITU_INT32, faces_so_far + 1, 1);
  faces.owner = insitu_array_of(owner, INSITU_INT32, faces_so_far, 1);
  faces.neighbour = insitu_array_of(neighbour, INSITU_INT32, 1, 1);
  const insitu_array points = insitu_array_of(xyz, INSITU_FLOAT64, 2 * corners, 3);
  const insitu_array values = insitu_array_of(temperature, INSITU_FLOAT64, 2 * corners, 1);
  if (failed(insitu_session_open(NULL, &session)) ||
      failed(insitu_session_mesh(session, "honeycomb", &mesh)) ||
      failed(insitu_mesh_points(mesh, 0, &points, 1)) ||
      failed(insitu_mesh_faces(mesh, 0, &faces)) ||
      failed(insitu_mesh_field(mesh, 0, "temperature", INSITU_VERTEX, &values, 1)) ||
      failed(insitu_mesh_commit(mesh, NULL)))
    return 1;

  /* In each cell, on the face between them, and a quarter beyond the second one. */
  const double where[point_count][3] = {
      {-0.3, 0.4, 0.2}, {2, 0.1, 0.7}, {0.9, 0.2, 0.5}, {2.95, 0, 0.5}};
  const insitu_array where_array = insitu_array_of(where, INSITU_FLOAT64, point_count, 3);
  const char* const field = "temperature";
  double sampled[point_count], distance[point_count],
      nearest[point_count][3], *const columns[1] = {sampled};
  int64_t cell[point_count];
  uint8_t found[point_count];
  insitu_sample_args args = insitu_sample_args_default();
  args.fields = &field;
  args.field_count = 1;
  args.values = columns;
  args.locate.points = &where_array;
  args.locate.cells = cell;
  args.locate.found = found;
  args.locate.outside = INSITU_OUTSIDE_NEAREST;
  args.locate.greatest_distance = 1;
  args.locate.distances = distance;
  args.locate.nearest = &nearest[0][0];
  if (failed(insitu_mesh_sample(mesh, &args)))
    return 1;

  const int64_t expected_cell[point_count] = {0, 1, 0, 1}; /* on a face the lower cell owns */
  int wrong = 0;
  for (int p = 0; p < point_count; ++p) {
    printf("(%5.2f, %5.2f, %5.2f): ", where[p][0], where[p][1], where[p][2]);
    if (found[p])
      printf("in cell %d, temperature %g\n", (int)cell[p], sampled[p]);
    else
      printf("outside; cell %d is nearest, %g away, temperature there %g\n", (int)cell[p],
             distance[p], sampled[p]);
    wrong += cell[p] != expected_cell[p] || !(fabs(sampled[p] - linear(nearest[p])) < 1e-13) ||
             !(fabs(distance[p] - (p < 3 ? 0 : 0.25)) < 1e-13);
  }
  return failed(insitu_session_close(&session)) || wrong;
}
