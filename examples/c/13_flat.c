/* 13: a flat mesh. Shallow water sloshes in a closed basin of triangles; the library reads x, y,
 * the surface's height and the velocity of two components. A gauge is held against the closed form.
 */
#include <insitu/insitu.h>
#include <math.h>
#include <stdio.h>

enum { n = 24, side = n + 1, vertices = side * side, cells = 2 * n * n };

static const double pi = 3.14159265358979323846, length = 1000.0, depth = 20.0, gravity = 9.81;
static double xy[vertices][2], height[vertices], velocity[vertices][2];
static int32_t ids[cells][3];

static const char scene[] =
    "insitu: 1\n"
    "page: false\n"
    "probes:\n"
    "  - {name: gauges, points: [[10, 20, 0], [700, 300, 0]], fields: [height]}\n"
    "tracers:\n"
    "  - {name: drifters, velocity: velocity, effects: [{boundary: slide}],\n"
    "     seeds: {box: {min: [100, 100, 0], max: [900, 900, 0], counts: [5, 5, 1]}}}\n"
    "frames:\n"
    "  - {name: surface, size: [300, 300], every: 20, boundary: {color: {field: height}}}\n";

/* The lowest mode of the linear equations, at a time. */
static double mode(double x, double y, double t) {
  const double k = pi / length, omega = k * sqrt(2.0 * gravity * depth);
  return cos(k * x) * cos(k * y) * cos(omega * t);
}

static void solve(double t) {
  const double k = pi / length, omega = k * sqrt(2.0 * gravity * depth);
  for (int v = 0; v < vertices; ++v) {
    const double x = k * xy[v][0], y = k * xy[v][1], rate = gravity * k / omega * sin(omega * t);
    height[v] = mode(xy[v][0], xy[v][1], t);
    velocity[v][0] = rate * sin(x) * cos(y);
    velocity[v][1] = rate * cos(x) * sin(y);
  }
}

static int failed(insitu_status status) {
  if (status != INSITU_OK)
    fprintf(stderr, "%s\n", insitu_last_message());
  return status != INSITU_OK;
}

int main(void) {
  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  insitu_session_options options = insitu_session_options_default();
  options.scene_text = scene;
  options.output = "13_flat";
  if (failed(insitu_session_open(&options, &session)) ||
      failed(insitu_session_mesh(session, "basin", &mesh)))
    return 1;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      xy[i + side * j][0] = length * i / n;
      xy[i + side * j][1] = length * j / n;
    }
  for (int c = 0; c < n * n; ++c) {
    const int32_t v = c % n + side * (c / n), w = v + side;
    const int32_t two[2][3] = {{v, v + 1, w + 1}, {v, w + 1, w}};
    for (int k = 0; k < 6; ++k)
      ids[2 * c + k / 3][k % 3] = two[k / 3][k % 3];
  }
  insitu_array points = insitu_array_of(xy, INSITU_FLOAT64, vertices, 2);
  insitu_array heights = insitu_array_of(height, INSITU_FLOAT64, vertices, 1);
  insitu_array velocities = insitu_array_of(velocity, INSITU_FLOAT64, vertices, 2);
  insitu_cells triangles = insitu_cells_default();
  triangles.layout = INSITU_LAYOUT_UNIFORM;
  triangles.shape = INSITU_TRIANGLE;
  triangles.count = cells;
  triangles.connectivity = insitu_array_of(ids, INSITU_INT32, cells, 3);
  if (failed(insitu_mesh_points(mesh, 0, &points, 1)) ||
      failed(insitu_mesh_cells(mesh, 0, &triangles)) ||
      failed(insitu_mesh_field(mesh, 0, "height", INSITU_VERTEX, &heights, 1)) ||
      failed(insitu_mesh_field(mesh, 0, "velocity", INSITU_VERTEX, &velocities, 1)))
    return 1;
  double worst = 0.0;
  for (int cycle = 0; cycle <= 100; ++cycle) {
    const double t = 2.0 * cycle, gauge[3] = {700.0, 300.0, 0.0};
    double value = 0.0;
    int32_t found = 0;
    solve(t);
    insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS);
    if (failed(insitu_session_execute(session, cycle, t)) ||
        failed(insitu_mesh_sample_point(mesh, "height", gauge, &value, &found)))
      return 1;
    worst = fmax(worst, fabs(value - mode(gauge[0], gauge[1], t)));
  }
  insitu_report report = insitu_report_default();
  if (failed(insitu_session_report(session, &report)) || failed(insitu_session_close(&session)))
    return 1;
  printf("gauge within %.4f m of the closed form, %lld bytes of volume cells, %lld frames\n", worst,
         (long long)report.bytes_by_purpose[INSITU_MEMORY_FLAT], (long long)report.frames);
  return worst < 0.01 ? 0 : 1; /* of 1 m, interpolated over cells of 1/24 of half a wave */
}
