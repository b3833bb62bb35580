/* 11: where points find their cells: on a graphics card if there is one, else on the processor. The
 * answers of INSITU_EXACT are the same. */
#include <insitu/insitu.h>
#include <stdio.h>

enum { n = 17, count = n * n * n };

static double temperature[count];

static int failed(insitu_status status) {
  if (status != INSITU_OK)
    fprintf(stderr, "%s: %s\n", insitu_status_name(status), insitu_last_message());
  return status != INSITU_OK;
}

int main(void) {
  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  insitu_block block = insitu_block_default(); /* the unit cube */
  block.kind = INSITU_BLOCK_UNIFORM;
  for (int a = 0; a < 3; ++a) {
    block.vertices[a] = n;
    block.spacing[a] = 1.0 / (n - 1);
  }
  for (int v = 0; v < count; ++v)
    temperature[v] = v % n; /* 16 x */
  const insitu_array field = insitu_array_of(temperature, INSITU_FLOAT64, count, 1);
  if (failed(insitu_session_open(NULL, &session)) ||
      failed(insitu_session_mesh(session, "box", &mesh)) ||
      failed(insitu_mesh_block(mesh, 0, &block)) ||
      failed(insitu_mesh_field(mesh, 0, "temperature", INSITU_VERTEX, &field, 1)))
    return 1;

  insitu_locator locator = insitu_locator_default();
  locator.method = INSITU_METHOD_BVH;
  locator.backend = INSITU_BACKEND_CUDA;
  const insitu_status status = insitu_mesh_locator(mesh, &locator);
  if (status == INSITU_ERROR_UNSUPPORTED) { /* nothing has changed: the choice is still `auto` */
    printf("no card: %s\n", insitu_last_message());
  } else if (failed(status)) {
    return 1;
  }
  if (failed(insitu_mesh_commit(mesh, NULL)))
    return 1;

  const double where[2][3] = {{0.25, 0.5, 0.5}, {1.5, 0.5, 0.5}};
  const insitu_array points = insitu_array_of(where, INSITU_FLOAT64, 2, 3);
  const char* const fields[1] = {"temperature"};
  double t[2], *const values[1] = {t};
  uint8_t found[2];
  insitu_sample_args args = insitu_sample_args_default();
  args.locate.points = &points; /* in host memory, and so are the answers */
  args.locate.accuracy = INSITU_EXACT;
  args.locate.found = found;
  args.fields = fields;
  args.field_count = 1;
  args.values = values;
  insitu_locator_info info = insitu_locator_info_default();
  if (failed(insitu_mesh_sample(mesh, &args)) || failed(insitu_mesh_locator_info(mesh, &info)))
    return 1;
  printf("temperature %g; backend %d, %ld bytes, of which %ld are copies on the device: %s\n", t[0],
         (int)info.backend, (long)info.bytes, (long)info.bytes_copied, info.reason);
  insitu_session_close(&session);
  return !(found[0] && t[0] == 4.0 && !found[1]);
}
