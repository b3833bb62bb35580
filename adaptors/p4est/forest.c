/* Forests of three dimensions. */
#include <p8est.h>

#define forest_type p8est_t
#define forest_connectivity p8est_connectivity_t
#define forest_tree p8est_tree_t
#define forest_quadrant p8est_quadrant_t
#define forest_dimensions 3
#define forest_corners 8
#define forest_most_level P8EST_MAXLEVEL
#define forest_root_length ((int64_t)P8EST_ROOT_LEN)
#define forest_mesh insitu_p4est_mesh
#define forest_mesh_as insitu_p4est_mesh_as
#define forest_field insitu_p4est_field
#define forest_mesh_name "insitu_p4est_mesh"

#include "forest.inc"
