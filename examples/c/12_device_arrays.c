/* 12: a solver whose arrays lie in a graphics card's memory. The library reads them there; points
 * and answers of a query stay there too, in the order of the solver's stream. */
#include <cuda_runtime_api.h>
#include <insitu/insitu.h>
#include <stdio.h>
#include <stdlib.h>

enum { n = 17, vertices = n * n * n, cells = (n - 1) * (n - 1) * (n - 1), queries = 2 };

static double xyz[vertices][3], temperature[vertices];
static int32_t ids[cells][8];
static const double where[queries][3] = {{0.25, 0.5, 0.5}, {1.5, 0.5, 0.5}};

static int failed(insitu_status status) {
  if (status != INSITU_OK)
    fprintf(stderr, "%s: %s\n", insitu_status_name(status), insitu_last_message());
  return status != INSITU_OK;
}

/* A copy of host memory on the card; of a solver there, its own arrays. */
static void* on_card(const void* host, size_t bytes) {
  void* data = NULL;
  if (cudaMalloc(&data, bytes) != cudaSuccess ||
      (host && cudaMemcpy(data, host, bytes, cudaMemcpyHostToDevice) != cudaSuccess))
    exit(1);
  return data;
}

static insitu_array card_array(const void* data, insitu_type type, int64_t count,
                               int32_t components) {
  insitu_array a = insitu_array_of(data, type, count, components);
  a.memory = INSITU_DEVICE;
  return a;
}

static void make_cube(void) {
  for (int v = 0; v < vertices; ++v) {
    const int at[3] = {v % n, v / n % n, v / n / n};
    for (int a = 0; a < 3; ++a)
      xyz[v][a] = at[a] / (n - 1.0);
    temperature[v] = at[0]; /* 16 x */
  }
  for (int c = 0; c < cells; ++c) {
    const int m = n - 1, low = c % m + n * (c / m % m + n * (c / m / m));
    const int corners[8] = {0, 1, n + 1, n, n * n, n * n + 1, n * n + n + 1, n * n + n};
    for (int k = 0; k < 8; ++k)
      ids[c][k] = low + corners[k];
  }
}

int main(void) {
  int cards = 0;
  if (cudaGetDeviceCount(&cards) != cudaSuccess || cards == 0) {
    printf("no card\n");
    return 0;
  }
  make_cube();
  const insitu_array points = card_array(on_card(xyz, sizeof xyz), INSITU_FLOAT64, vertices, 3);
  const insitu_array field =
      card_array(on_card(temperature, sizeof temperature), INSITU_FLOAT64, vertices, 1);
  insitu_cells hexahedra = insitu_cells_default();
  hexahedra.count = cells;
  hexahedra.connectivity = card_array(on_card(ids, sizeof ids), INSITU_INT32, cells, 8);
  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  if (failed(insitu_session_open(NULL, &session)) ||
      failed(insitu_session_mesh(session, "cube", &mesh)) ||
      failed(insitu_mesh_points(mesh, 0, &points, 1)) ||
      failed(insitu_mesh_cells(mesh, 0, &hexahedra)) ||
      failed(insitu_mesh_field(mesh, 0, "temperature", INSITU_VERTEX, &field, 1)))
    return 1;
  const insitu_status status = insitu_mesh_commit(mesh, NULL);
  if (failed(status)) /* a library that was built without CUDA */
    return status != INSITU_ERROR_UNSUPPORTED;

  cudaStream_t stream;
  if (cudaStreamCreate(&stream) != cudaSuccess)
    return 1;
  const insitu_array there = card_array(on_card(where, sizeof where), INSITU_FLOAT64, queries, 3);
  const char* const fields[1] = {"temperature"};
  double* const values[1] = {on_card(NULL, queries * sizeof(double))};
  insitu_sample_args args = insitu_sample_args_default();
  args.locate.points = &there;
  args.locate.found = on_card(NULL, queries);
  args.locate.memory = INSITU_DEVICE; /* of the points and of all outputs */
  args.locate.stream = stream;
  args.fields = fields;
  args.field_count = 1;
  args.values = values;
  if (failed(insitu_mesh_sample(mesh, &args)))
    return 1;

  double t[queries]; /* a solver would go on with kernels in this stream */
  uint8_t found[queries];
  if (cudaMemcpyAsync(t, values[0], sizeof t, cudaMemcpyDeviceToHost, stream) != cudaSuccess ||
      cudaMemcpyAsync(found, args.locate.found, sizeof found, cudaMemcpyDeviceToHost, stream) !=
          cudaSuccess ||
      cudaStreamSynchronize(stream) != cudaSuccess)
    return 1;
  printf("temperature %g; found %d and %d\n", t[0], found[0], found[1]);
  const int wrong = !(found[0] && t[0] == 4.0 && !found[1]);
  return failed(insitu_session_close(&session)) || wrong; /* then the arrays may be freed */
}
