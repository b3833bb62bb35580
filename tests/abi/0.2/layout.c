/* Sizes and offsets of the argument structs as C has them, for layout_test.f90, and frozen for
 * tests/abi. Members called reserved are left out: later versions call them otherwise. */
#include <stddef.h>

#include "insitu/c/probe.h"
#include "insitu/insitu.h"

#define AT(type, member) (int64_t) offsetof(type, member)

/** The size of struct number `which`, then the offsets of its members in order; returns how many.
 */
int layout_of(int which, int64_t* out) {
  const int64_t options[] = {sizeof(insitu_session_options),
                             AT(insitu_session_options, size),
                             AT(insitu_session_options, scene),
                             AT(insitu_session_options, scene_text),
                             AT(insitu_session_options, output),
                             AT(insitu_session_options, default_scene),
                             AT(insitu_session_options, threads),
                             AT(insitu_session_options, strict),
                             AT(insitu_session_options, log_level),
                             AT(insitu_session_options, log),
                             AT(insitu_session_options, log_user),
                             AT(insitu_session_options, communicator),
                             AT(insitu_session_options, fortran_communicator),
                             AT(insitu_session_options, preview)};
  const int64_t array[] = {
      sizeof(insitu_array),     AT(insitu_array, size),       AT(insitu_array, data),
      AT(insitu_array, type),   AT(insitu_array, components), AT(insitu_array, count),
      AT(insitu_array, extent), AT(insitu_array, stride),     AT(insitu_array, component_stride),
      AT(insitu_array, memory), AT(insitu_array, converted),  AT(insitu_array, indirect),
      AT(insitu_array, offset)};
  const int64_t cells[] = {
      sizeof(insitu_cells),    AT(insitu_cells, size),    AT(insitu_cells, layout),
      AT(insitu_cells, shape), AT(insitu_cells, count),   AT(insitu_cells, connectivity),
      AT(insitu_cells, types), AT(insitu_cells, offsets), AT(insitu_cells, index_base)};
  const int64_t faces[] = {sizeof(insitu_faces),
                           AT(insitu_faces, size),
                           AT(insitu_faces, form),
                           AT(insitu_faces, index_base),
                           AT(insitu_faces, cell_count),
                           AT(insitu_faces, face_count),
                           AT(insitu_faces, vertices),
                           AT(insitu_faces, offsets),
                           AT(insitu_faces, owner),
                           AT(insitu_faces, neighbour),
                           AT(insitu_faces, boundary_count),
                           AT(insitu_faces, boundary_vertices),
                           AT(insitu_faces, boundary_offsets),
                           AT(insitu_faces, boundary_owner),
                           AT(insitu_faces, far_cells),
                           AT(insitu_faces, cell_faces),
                           AT(insitu_faces, cell_offsets)};
  const int64_t block[] = {
      sizeof(insitu_block),          AT(insitu_block, size),   AT(insitu_block, kind),
      AT(insitu_block, vertices),    AT(insitu_block, origin), AT(insitu_block, spacing),
      AT(insitu_block, coordinates), AT(insitu_block, first),  AT(insitu_block, dimensions)};
  const int64_t frame[] = {
      sizeof(insitu_frame),     AT(insitu_frame, size),     AT(insitu_frame, kind),
      AT(insitu_frame, origin), AT(insitu_frame, utm_zone), AT(insitu_frame, utm_north),
      AT(insitu_frame, angle),  AT(insitu_frame, length),   AT(insitu_frame, vertical)};
  const int64_t commit[] = {sizeof(insitu_commit_report),
                            AT(insitu_commit_report, size),
                            AT(insitu_commit_report, action),
                            AT(insitu_commit_report, validated),
                            AT(insitu_commit_report, seconds),
                            AT(insitu_commit_report, cells),
                            AT(insitu_commit_report, vertices),
                            AT(insitu_commit_report, bytes),
                            AT(insitu_commit_report, bytes_allocated),
                            AT(insitu_commit_report, cost_ratio),
                            AT(insitu_commit_report, builder)};
  const int64_t validation[] = {sizeof(insitu_validation),
                                AT(insitu_validation, size),
                                AT(insitu_validation, cells),
                                AT(insitu_validation, index_errors),
                                AT(insitu_validation, shape_errors),
                                AT(insitu_validation, coordinate_errors),
                                AT(insitu_validation, inverted_cells),
                                AT(insitu_validation, zero_volume_cells),
                                AT(insitu_validation, folded_cells),
                                AT(insitu_validation, collapsed_cells),
                                AT(insitu_validation, ghost_cells),
                                AT(insitu_validation, coincident_vertices),
                                AT(insitu_validation, crowded_faces),
                                AT(insitu_validation, split_faces),
                                AT(insitu_validation, hanging_vertices),
                                AT(insitu_validation, covered_vertices)};
  const int64_t audit[] = {sizeof(insitu_audit_entry),    AT(insitu_audit_entry, size),
                           AT(insitu_audit_entry, name),  AT(insitu_audit_entry, data),
                           AT(insitu_audit_entry, bytes), AT(insitu_audit_entry, borrowed),
                           AT(insitu_audit_entry, reason)};
  const int64_t locate[] = {sizeof(insitu_locate_args),
                            AT(insitu_locate_args, size),
                            AT(insitu_locate_args, points),
                            AT(insitu_locate_args, point_arrays),
                            AT(insitu_locate_args, frame),
                            AT(insitu_locate_args, accuracy),
                            AT(insitu_locate_args, cell_base),
                            AT(insitu_locate_args, cells),
                            AT(insitu_locate_args, pieces),
                            AT(insitu_locate_args, parametric),
                            AT(insitu_locate_args, found),
                            AT(insitu_locate_args, reasons),
                            AT(insitu_locate_args, memory),
                            AT(insitu_locate_args, stream),
                            AT(insitu_locate_args, scope),
                            AT(insitu_locate_args, ranks),
                            AT(insitu_locate_args, global_cells),
                            AT(insitu_locate_args, outside),
                            AT(insitu_locate_args, greatest_distance),
                            AT(insitu_locate_args, distances),
                            AT(insitu_locate_args, nearest)};
  const int64_t sample[] = {sizeof(insitu_sample_args),          AT(insitu_sample_args, size),
                            AT(insitu_sample_args, locate),      AT(insitu_sample_args, fields),
                            AT(insitu_sample_args, field_count), AT(insitu_sample_args, values)};
  const int64_t report[] = {sizeof(insitu_report),
                            AT(insitu_report, size),
                            AT(insitu_report, executions),
                            AT(insitu_report, commit_s),
                            AT(insitu_report, query_s),
                            AT(insitu_report, advect_s),
                            AT(insitu_report, render_s),
                            AT(insitu_report, output_s),
                            AT(insitu_report, keeps),
                            AT(insitu_report, refits),
                            AT(insitu_report, rebuilds),
                            AT(insitu_report, bytes_borrowed),
                            AT(insitu_report, bytes_held),
                            AT(insitu_report, bytes_peak),
                            AT(insitu_report, bytes_by_purpose),
                            AT(insitu_report, points_located),
                            AT(insitu_report, points_outside),
                            AT(insitu_report, particles_seeded),
                            AT(insitu_report, particles),
                            AT(insitu_report, frames),
                            AT(insitu_report, probe_rows),
                            AT(insitu_report, files),
                            AT(insitu_report, failures),
                            AT(insitu_report, located_by_reason),
                            AT(insitu_report, ranges_s),
                            AT(insitu_report, classify_s),
                            AT(insitu_report, purposes),
                            AT(insitu_report, endings),
                            AT(insitu_report, reasons),
                            AT(insitu_report, halo_cells),
                            AT(insitu_report, messages_sent),
                            AT(insitu_report, bytes_sent)};
  const int64_t locator[] = {sizeof(insitu_locator), AT(insitu_locator, size),
                             AT(insitu_locator, method), AT(insitu_locator, backend)};
  const int64_t info[] = {sizeof(insitu_locator_info),
                          AT(insitu_locator_info, size),
                          AT(insitu_locator_info, method),
                          AT(insitu_locator_info, backend),
                          AT(insitu_locator_info, reason),
                          AT(insitu_locator_info, primitives),
                          AT(insitu_locator_info, bytes),
                          AT(insitu_locator_info, bytes_peak),
                          AT(insitu_locator_info, bytes_copied),
                          AT(insitu_locator_info, kept),
                          AT(insitu_locator_info, by_neighbour),
                          AT(insitu_locator_info, by_tree),
                          AT(insitu_locator_info, settled_on_host)};
  const int64_t amr[] = {sizeof(insitu_amr),           AT(insitu_amr, size),
                         AT(insitu_amr, origin),       AT(insitu_amr, spacing),
                         AT(insitu_amr, level_count),  AT(insitu_amr, ratios),
                         AT(insitu_amr, finest_first), AT(insitu_amr, reconstruction),
                         AT(insitu_amr, dimensions),   AT(insitu_amr, reserved)};
  const int64_t patch[] = {sizeof(insitu_patch),          AT(insitu_patch, size),
                           AT(insitu_patch, level),       AT(insitu_patch, lower),
                           AT(insitu_patch, cells),       AT(insitu_patch, ghosts_before),
                           AT(insitu_patch, ghosts_after)};
  const int64_t leaves[] = {sizeof(insitu_leaves),          AT(insitu_leaves, size),
                            AT(insitu_leaves, levels),      AT(insitu_leaves, corners),
                            AT(insitu_leaves, corner_bits), AT(insitu_leaves, offset)};
  const int64_t amr_info[] = {sizeof(insitu_amr_info),        AT(insitu_amr_info, size),
                              AT(insitu_amr_info, leaves),    AT(insitu_amr_info, masked),
                              AT(insitu_amr_info, gridlets),  AT(insitu_amr_info, cubes),
                              AT(insitu_amr_info, stitching), AT(insitu_amr_info, folded),
                              AT(insitu_amr_info, repaired),  AT(insitu_amr_info, bytes),
                              AT(insitu_amr_info, build_s),   AT(insitu_amr_info, by_places)};
  const int64_t vertices[] = {sizeof(insitu_vertices_args),
                              AT(insitu_vertices_args, size),
                              AT(insitu_vertices_args, points),
                              AT(insitu_vertices_args, point_arrays),
                              AT(insitu_vertices_args, nearest),
                              AT(insitu_vertices_args, frame),
                              AT(insitu_vertices_args, greatest_distance),
                              AT(insitu_vertices_args, scope),
                              AT(insitu_vertices_args, vertex_base),
                              AT(insitu_vertices_args, vertices),
                              AT(insitu_vertices_args, pieces),
                              AT(insitu_vertices_args, ranks),
                              AT(insitu_vertices_args, global_vertices),
                              AT(insitu_vertices_args, distances),
                              AT(insitu_vertices_args, places)};
  const int64_t answers[] = {
      sizeof(insitu_probe_answers),           AT(insitu_probe_answers, size),
      AT(insitu_probe_answers, name),         AT(insitu_probe_answers, cycle),
      AT(insitu_probe_answers, time),         AT(insitu_probe_answers, answered),
      AT(insitu_probe_answers, column_count), AT(insitu_probe_answers, point_count),
      AT(insitu_probe_answers, column_names), AT(insitu_probe_answers, points),
      AT(insitu_probe_answers, inside),       AT(insitu_probe_answers, values)};
  const struct {
    const int64_t* numbers;
    size_t count;
  } structs[] = {{options, sizeof options / 8},
                 {array, sizeof array / 8},
                 {cells, sizeof cells / 8},
                 {block, sizeof block / 8},
                 {frame, sizeof frame / 8},
                 {commit, sizeof commit / 8},
                 {validation, sizeof validation / 8},
                 {audit, sizeof audit / 8},
                 {locate, sizeof locate / 8},
                 {sample, sizeof sample / 8},
                 {report, sizeof report / 8},
                 {locator, sizeof locator / 8},
                 {info, sizeof info / 8},
                 {amr, sizeof amr / 8},
                 {patch, sizeof patch / 8},
                 {leaves, sizeof leaves / 8},
                 {amr_info, sizeof amr_info / 8},
                 {faces, sizeof faces / 8},
                 {vertices, sizeof vertices / 8},
                 {answers, sizeof answers / 8}};
  for (size_t i = 0; i < structs[which].count; ++i)
    out[i] = structs[which].numbers[i];
  return (int)structs[which].count;
}

/** Every number of the public enumerations that insitu_c.f90 repeats, in its order. */
int constants(int64_t* out) {
  const int64_t all[] = {
      INSITU_MEMORY_ROOM, INSITU_END_ROOM, INSITU_REASON_ROOM, INSITU_OK, INSITU_ERROR_ARGUMENT,
      INSITU_ERROR_HANDLE, INSITU_ERROR_BUSY, INSITU_ERROR_ORDER, INSITU_ERROR_MESH,
      INSITU_ERROR_FIELD, INSITU_ERROR_SCENE, INSITU_ERROR_FILE, INSITU_ERROR_MEMORY,
      INSITU_ERROR_UNSUPPORTED, INSITU_ERROR_CONVERSION, INSITU_ERROR_ACTION, INSITU_ERROR_INTERNAL,
      INSITU_FLOAT32, INSITU_FLOAT64, INSITU_INT32, INSITU_INT64, INSITU_UINT8, INSITU_HOST,
      INSITU_DEVICE, INSITU_VERTEX, INSITU_CELL, INSITU_TRIANGLE, INSITU_PIXEL, INSITU_QUAD,
      INSITU_TETRAHEDRON, INSITU_VOXEL, INSITU_HEXAHEDRON, INSITU_WEDGE, INSITU_PYRAMID,
      INSITU_FAST, INSITU_STANDARD, INSITU_EXACT, INSITU_METHOD_AUTO, INSITU_METHOD_BVH,
      INSITU_METHOD_USER_GEOMETRY, INSITU_METHOD_REPLICATED_FACES, INSITU_METHOD_SHARED_FACES,
      INSITU_METHOD_SHARED_BILINEAR_FACES, INSITU_BACKEND_AUTO, INSITU_BACKEND_CPU,
      INSITU_BACKEND_CUDA, INSITU_BACKEND_OPTIX, INSITU_CHANGED_NOTHING, INSITU_CHANGED_FIELDS,
      INSITU_CHANGED_GEOMETRY, INSITU_CHANGED_TOPOLOGY, INSITU_CHANGED_ALL, INSITU_LOG_ERROR,
      INSITU_LOG_WARNING, INSITU_LOG_INFO, INSITU_LOG_DEBUG, INSITU_NO_COMMUNICATOR,
      INSITU_LAYOUT_UNIFORM, INSITU_LAYOUT_MIXED, INSITU_LAYOUT_PADDED, INSITU_BLOCK_UNIFORM,
      INSITU_BLOCK_RECTILINEAR, INSITU_BLOCK_CURVILINEAR, INSITU_GHOSTS_VTK, INSITU_GHOSTS_ASCENT,
      INSITU_OUTSIDE_NONE, INSITU_OUTSIDE_NEAREST, INSITU_DUAL, INSITU_NEAREST,
      INSITU_FRAME_CARTESIAN, INSITU_FRAME_GEOCENTRIC, INSITU_FRAME_GEODETIC, INSITU_FRAME_ENU,
      INSITU_FRAME_UTM, INSITU_DEGREES, INSITU_RADIANS, INSITU_METRES, INSITU_KILOMETRES, INSITU_UP,
      INSITU_DOWN, INSITU_KEEP, INSITU_REFIT, INSITU_REBUILD, INSITU_BUILDER_NONE,
      INSITU_BUILDER_MORTON, INSITU_BUILDER_SURFACE_AREA, INSITU_REASON_OUTSIDE,
      INSITU_REASON_CERTIFIED, INSITU_REASON_EXACT, INSITU_REASON_ON_FACE, INSITU_REASON_ON_EDGE,
      INSITU_REASON_ON_VERTEX, INSITU_REASON_COUNT,
      /* indices in Fortran: one more */
      INSITU_END_ALIVE + 1, INSITU_END_LEFT + 1, INSITU_END_STAGNATED + 1, INSITU_END_EXPIRED + 1,
      INSITU_END_STEP_LIMIT + 1, INSITU_END_SEED_OUTSIDE + 1, INSITU_END_NOT_FINITE + 1,
      INSITU_END_KILLED + 1, INSITU_END_STOPPED + 1, INSITU_END_REMOVED + 1,
      INSITU_END_STEP_TOO_SMALL + 1, INSITU_END_HOLE + 1, INSITU_END_HIDDEN + 1,
      INSITU_END_BLANK + 1, INSITU_END_PARTITION + 1, INSITU_END_COUNT, INSITU_MEMORY_TREE + 1,
      INSITU_MEMORY_BUILD + 1, INSITU_MEMORY_RANGES + 1, INSITU_MEMORY_EARLIER + 1,
      INSITU_MEMORY_QUERY + 1, INSITU_MEMORY_TRACER + 1, INSITU_MEMORY_FRAME + 1,
      INSITU_MEMORY_CONVERTED + 1, INSITU_MEMORY_EMBREE + 1, INSITU_MEMORY_DEVICE + 1,
      INSITU_MEMORY_AMR + 1, INSITU_MEMORY_GATHERED + 1, INSITU_MEMORY_GEOCENTRIC + 1,
      INSITU_MEMORY_CHART + 1, INSITU_MEMORY_NEIGHBOURS + 1, INSITU_MEMORY_BLANK + 1,
      INSITU_MEMORY_HALO + 1, INSITU_MEMORY_POLYHEDRA + 1, INSITU_MEMORY_FLAT + 1,
      INSITU_MEMORY_HELD + 1, INSITU_MEMORY_COUNT, INSITU_FACES_OWNERS, INSITU_FACES_CELLS};
  for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
    out[i] = all[i];
  return (int)(sizeof all / sizeof *all);
}
