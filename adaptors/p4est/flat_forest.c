/* Forests of two dimensions. */
#include <p4est.h>

#define forest_type p4est_t
#define forest_connectivity p4est_connectivity_t
#define forest_tree p4est_tree_t
#define forest_quadrant p4est_quadrant_t
#define forest_dimensions 2
#define forest_corners 4
#define forest_most_level P4EST_MAXLEVEL
#define forest_root_length ((int64_t)P4EST_ROOT_LEN)
#define forest_mesh insitu_p4est_flat_mesh
#define forest_mesh_as insitu_p4est_flat_mesh_as
#define forest_field insitu_p4est_flat_field
#define forest_mesh_name "insitu_p4est_flat_mesh"

#include "forest.inc"
