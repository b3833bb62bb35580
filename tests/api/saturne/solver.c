/* The solver's side of the test api_saturne: a velocity `swirl` that hangs on the cell alone, and
 * each process's values after every step in values.RANK, by global number. On one process the
 * centres of cells go to the file that the environment's CENTRES names. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cs_defs.h"
#include "cs_headers.h"
#include "cs_prototypes.h"

void cs_user_model(void) {
  cs_parameters_add_property("swirl", 3, CS_MESH_LOCATION_CELLS);
}

/* Without the last bits of centres, which hang on the order of a cell's faces. */
static cs_real_t rounded(cs_real_t x) {
  return rint(1e6 * x) / 1e6;
}

static void write_centres(const cs_real_t (*centre)[3]) {
  FILE* const file = fopen(getenv("CENTRES"), "w");
  fprintf(file, "x,y,z\n");
  for (cs_lnum_t c = 0; c < cs_glob_mesh->n_cells; ++c)
    fprintf(file, "%.17g,%.17g,%.17g\n", centre[c][0], centre[c][1], centre[c][2]);
  fclose(file);
}

void cs_user_initialization(cs_domain_t* domain) {
  const cs_real_t(*const centre)[3] = (const cs_real_t(*)[3])cs_glob_mesh_quantities->cell_cen;
  cs_real_t* const swirl = cs_field_by_name("swirl")->val;
  CS_UNUSED(domain);
  for (cs_lnum_t c = 0; c < cs_glob_mesh->n_cells; ++c) {
    swirl[3 * c] = 5 + 10 * (rounded(centre[c][1]) - 0.4);
    swirl[3 * c + 1] = 4 * (1.2 - rounded(centre[c][0]));
    swirl[3 * c + 2] = 0;
  }
  if (cs_glob_n_ranks == 1)
    write_centres(centre);
}

void cs_user_postprocess_activate(int last, int step, double time) {
  char name[32];
  const cs_real_t* const velocity = cs_field_by_name("velocity")->val;
  const cs_real_t* const pressure = cs_field_by_name("pressure")->val;
  const cs_real_t* const dye = cs_field_by_name("dye")->val;
  const cs_gnum_t* const numbers = cs_glob_mesh->global_cell_num;
  CS_UNUSED(last);
  CS_UNUSED(step);
  CS_UNUSED(time);
  snprintf(name, sizeof name, "values.%d", CS_MAX(cs_glob_rank_id, 0));
  FILE* const file = fopen(name, "w");
  for (cs_lnum_t c = 0; c < cs_glob_mesh->n_cells; ++c)
    fprintf(file, "%lu %.17g %.17g %.17g %.17g %.17g\n",
            numbers != NULL ? (unsigned long)numbers[c] : (unsigned long)c + 1, velocity[3 * c],
            velocity[3 * c + 1], velocity[3 * c + 2], pressure[c], dye[c]);
  fclose(file);
}
