/* Runs a scene of libinsitu inside Code_Saturne 6.0 (doc/guide/saturne.md). A case has this file in
 * its SRC/ and the scene in its DATA/, as insitu.yaml. The mesh and the fields are read where
 * Code_Saturne has them, at the end of each time step. Whatever goes wrong is told in the log, once
 * a text, and the calculation goes on.
 *
 * Environment: INSITU_SCENE names another scene, from the run's folder; INSITU_STRICT=1 makes a
 * strict session. */
#include <insitu/insitu.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cs_defs.h"
#include "cs_headers.h"
#include "cs_prototypes.h"

/* The arrays of a mesh; others than before are other cells. */
typedef struct {
  const void *points, *pairs, *singles, *rings, *boundary_rings;
  cs_lnum_t cells, faces, boundary_faces, vertices;
} places_t;

static insitu_session session; /* null: not open */
static insitu_mesh mesh;
static places_t places;        /* as given last; all 0: nothing is given */
static cs_gnum_t* own_numbers; /* of cells, where Code_Saturne has none as it runs on one process */
static int is_refused;

/* Only the root's log is a file. */
static void warn(insitu_log_level level, const char* text, void* unused) {
  enum { MOST = 64 };
  static unsigned long said[MOST];
  static int count = 0;
  unsigned long hash = 5381;
  CS_UNUSED(unused);
  for (const char* c = text; *c != '\0'; ++c)
    hash = 33 * hash + (unsigned char)*c;
  for (int i = 0; i < count; ++i)
    if (said[i] == hash)
      return;
  if (count == MOST)
    return;
  said[count++] = hash;
  const char* const kind = level == INSITU_LOG_ERROR ? "error" : "warning";
  if (cs_glob_rank_id <= 0) {
    bft_printf("\ninsitu: %s: %s\n", kind, text);
    bft_printf_flush();
  } else {
    fprintf(stderr, "insitu: process %d: %s: %s\n", cs_glob_rank_id, kind, text);
  }
}

static int is_file(const char* path) {
  FILE* const file = fopen(path, "r");
  if (file != NULL)
    fclose(file);
  return file != NULL;
}

static void open_session(void) {
  const char* const scene = getenv("INSITU_SCENE");
  const char* const strict = getenv("INSITU_STRICT");
  insitu_session_options options = insitu_session_options_default();
  if (scene != NULL && scene[0] != '\0')
    options.scene = scene;
  else if (is_file("insitu.yaml"))
    options.scene = "insitu.yaml";
  options.default_scene = options.scene == NULL;
  options.strict = strict != NULL && strcmp(strict, "1") == 0;
  options.log = warn;
#if defined(HAVE_MPI)
  if (cs_glob_n_ranks > 1)
    options.communicator = &cs_glob_mpi_comm;
#endif
  if (insitu_session_open(&options, &session) == INSITU_OK && /* else the library told why */
      insitu_session_mesh(session, "fluid", &mesh) != INSITU_OK) {
    warn(INSITU_LOG_ERROR, insitu_last_message(), NULL);
    insitu_session_close(&session);
  }
}

static places_t places_of(const cs_mesh_t* m) {
  places_t p;
  memset(&p, 0, sizeof p); /* with what lies between members */
  p.points = m->vtx_coord;
  p.pairs = m->i_face_cells;
  p.singles = m->b_face_cells;
  p.rings = m->i_face_vtx_lst;
  p.boundary_rings = m->b_face_vtx_lst;
  p.cells = m->n_cells;
  p.faces = m->n_i_faces;
  p.boundary_faces = m->n_b_faces;
  p.vertices = m->n_vertices;
  return p;
}

static insitu_array numbers(const cs_lnum_t* data, cs_lnum_t count, int components) {
  return insitu_array_of(data, sizeof *data == 4 ? INSITU_INT32 : INSITU_INT64, count, components);
}

/* Faces between processes, and periodic ones, lead to ghost cells, which are no cells here. */
static insitu_status give_cells(const cs_mesh_t* m) {
  const insitu_array points = insitu_array_of(m->vtx_coord, INSITU_FLOAT64, m->n_vertices, 3);
  insitu_faces faces = insitu_faces_default();
  faces.cell_count = m->n_cells;
  faces.far_cells = m->n_ghost_cells;
  faces.face_count = m->n_i_faces;
  faces.vertices = numbers(m->i_face_vtx_lst, m->i_face_vtx_connect_size, 1);
  faces.offsets = numbers(m->i_face_vtx_idx, m->n_i_faces + 1, 1);
  faces.owner = numbers((const cs_lnum_t*)m->i_face_cells, m->n_i_faces, 2);
  faces.boundary_count = m->n_b_faces;
  faces.boundary_vertices = numbers(m->b_face_vtx_lst, m->b_face_vtx_connect_size, 1);
  faces.boundary_offsets = numbers(m->b_face_vtx_idx, m->n_b_faces + 1, 1);
  faces.boundary_owner = numbers(m->b_face_cells, m->n_b_faces, 1);
  insitu_status status = insitu_mesh_points(mesh, 0, &points, 1);
  if (status == INSITU_OK)
    status = insitu_mesh_faces(mesh, 0, &faces);
  return status == INSITU_OK ? insitu_mesh_changed(mesh, INSITU_CHANGED_TOPOLOGY) : status;
}

static insitu_status give_global_ids(insitu_association on, const cs_gnum_t* ids, cs_lnum_t count) {
  const insitu_array array =
      insitu_array_of(ids, sizeof *ids == 4 ? INSITU_INT32 : INSITU_INT64, count, 1);
  return insitu_mesh_global_ids(mesh, 0, on, ids != NULL ? &array : NULL);
}

/* So that tables name cells alike on any number of processes. */
static insitu_status give_numbers(const cs_mesh_t* m) {
  const cs_gnum_t* cells = m->global_cell_num;
  if (cells == NULL) {
    BFT_REALLOC(own_numbers, m->n_cells, cs_gnum_t);
    for (cs_lnum_t c = 0; c < m->n_cells; ++c)
      own_numbers[c] = (cs_gnum_t)c + 1;
    cells = own_numbers;
  }
  const insitu_status status = give_global_ids(INSITU_CELL, cells, m->n_cells);
  return status == INSITU_OK ? give_global_ids(INSITU_VERTEX, m->global_vtx_num, m->n_vertices)
                             : status;
}

static insitu_status give_fields(const cs_mesh_t* m) {
  insitu_status status = INSITU_OK;
  for (int i = 0; i < cs_field_n_fields() && status == INSITU_OK; ++i) {
    const cs_field_t* const f = cs_field_by_id(i);
    const int on_cells = f->location_id == CS_MESH_LOCATION_CELLS;
    if (f->val == NULL || (!on_cells && f->location_id != CS_MESH_LOCATION_VERTICES))
      continue;
    const insitu_array values =
        insitu_array_of(f->val, INSITU_FLOAT64, on_cells ? m->n_cells : m->n_vertices, f->dim);
    status =
        insitu_mesh_field(mesh, 0, f->name, on_cells ? INSITU_CELL : INSITU_VERTEX, &values, 1);
  }
  return status == INSITU_OK ? insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS) : status;
}

static insitu_status give_what_changed(const cs_mesh_t* m) {
  const places_t now = places_of(m);
  insitu_status status = INSITU_OK;
  if (cs_turbomachinery_get_model() == CS_TURBOMACHINERY_TRANSIENT || /* joins each step anew */
      memcmp(&now, &places, sizeof now) != 0) {
    memset(&places, 0, sizeof places); /* until all is given */
    status = give_cells(m);
    if (status == INSITU_OK)
      status = give_numbers(m);
  } else if (cs_glob_ale != CS_ALE_NONE) {
    status = insitu_mesh_changed(mesh, INSITU_CHANGED_GEOMETRY);
  }
  if (status == INSITU_OK)
    status = give_fields(m);
  if (status == INSITU_OK)
    places = now;
  return status;
}

/* A process that cannot give its arrays says so to all by a mesh that is refused. */
static void execute(const cs_mesh_t* m, const cs_time_step_t* step) {
  const int is_given = give_what_changed(m) == INSITU_OK;
  if (!is_given) {
    char why[2048]; /* the next call of the library may change its own text */
    snprintf(why, sizeof why, "%s", insitu_last_message());
    insitu_mesh_refuse(mesh, why);
  } else if (is_refused) {
    insitu_mesh_refuse(mesh, NULL);
  }
  is_refused = !is_given;
  const insitu_status status = insitu_session_execute(session, step->nt_cur, step->t_cur);
  if (status != INSITU_OK && status != INSITU_ERROR_ACTION && /* which the library told */
      cs_glob_rank_id <= 0)                                   /* as all processes have this error */
    warn(INSITU_LOG_ERROR, insitu_last_message(), NULL);
}

void cs_user_extra_operations_initialize(cs_domain_t* domain) {
  CS_UNUSED(domain);
  open_session();
}

void cs_user_extra_operations(cs_domain_t* domain) {
  CS_UNUSED(domain);
  if (session != NULL)
    execute(cs_glob_mesh, cs_glob_time_step);
}

void cs_user_extra_operations_finalize(cs_domain_t* domain) {
  CS_UNUSED(domain);
  if (insitu_session_close(&session) != INSITU_OK)
    warn(INSITU_LOG_ERROR, insitu_last_message(), NULL);
  BFT_FREE(own_numbers);
}
