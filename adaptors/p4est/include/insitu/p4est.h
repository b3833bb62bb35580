/** @file p4est.h
 *  A p8est forest, or a p4est forest of two dimensions, becomes an adaptive mesh: its local trees
 *  are the mesh's pieces, in order, and its quadrants the leaves, which the library reads in place.
 *  C99.
 *
 *  The adaptor supports a brick: trees that are equal boxes along the axes, side by side without
 *  rotation, as p8est_connectivity_new_brick and _new_unitcube make, and
 *  p4est_connectivity_new_brick and _new_unitsquare (periodic or not, with holes, with vertices
 *  scaled). The place of each tree follows from the connectivity's vertices. The adaptor refuses
 *  any other connectivity, and any geometry that bends trees, by name.
 *
 *  The caller calls both functions again, insitu_p4est_mesh first, whenever p4est may have moved
 *  its quadrants or records: after refining, coarsening, balancing and partitioning. In between,
 *  insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS) says that the values are others. The forest and
 *  its records must stay until the mesh is given another forest, or its session is closed. */
#ifndef INSITU_P4EST_H
#define INSITU_P4EST_H

#include <p4est.h>
#include <p8est.h>

#include "insitu/insitu.h"

#if defined(_WIN32)
#define INSITU_P4EST_API
#else
#define INSITU_P4EST_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Gives the forest's cells to an empty mesh, or to one that was given a forest before. origin: the
 *  lower corner of the brick. tree_size: the lengths of a tree. Where both are null, the
 *  coordinates of the connectivity's vertices hold. A forest without quadrants on this process is a
 *  mesh of one piece without cells. INSITU_ERROR_ARGUMENT: an argument is null, sizes are not
 *  positive, or the connectivity has no vertices. INSITU_ERROR_UNSUPPORTED: the trees are no brick.
 *  Other errors are those of insitu_mesh_amr and insitu_mesh_leaves. */
INSITU_P4EST_API insitu_status insitu_p4est_mesh(insitu_mesh mesh, p8est_t* forest,
                                                 const double origin[3], const double tree_size[3]);

/** Does as insitu_p4est_mesh, which has INSITU_DUAL, with a reconstruction of samples. */
INSITU_P4EST_API insitu_status insitu_p4est_mesh_as(insitu_mesh mesh, p8est_t* forest,
                                                    const double origin[3],
                                                    const double tree_size[3],
                                                    insitu_reconstruction reconstruction);

/** Gives a field of the cells: `components` values of a type, float32 or float64, side by side
 *  `offset` bytes from the place that each quadrant's p.user_data names. The library reads the
 *  records in place. INSITU_ERROR_ARGUMENT: the forest keeps no records, or a record ends before
 *  the values do. INSITU_ERROR_ORDER: the forest's quadrants are not those that insitu_p4est_mesh
 *  gave. */
INSITU_P4EST_API insitu_status insitu_p4est_field(insitu_mesh mesh, p8est_t* forest,
                                                  const char* name, insitu_type type, size_t offset,
                                                  int32_t components);

/** Does as insitu_p4est_mesh with a forest of two dimensions, which becomes a flat mesh
 *  (insitu_amr, dimensions). origin[2] is its plane, and tree_size[2] is of no account. Where both
 *  are null, the plane is that of the connectivity's vertices, which must all have one third
 *  coordinate. */
INSITU_P4EST_API insitu_status insitu_p4est_flat_mesh(insitu_mesh mesh, p4est_t* forest,
                                                      const double origin[3],
                                                      const double tree_size[3]);

/** Does as insitu_p4est_flat_mesh, which has INSITU_DUAL, with a reconstruction of samples. */
INSITU_P4EST_API insitu_status insitu_p4est_flat_mesh_as(insitu_mesh mesh, p4est_t* forest,
                                                         const double origin[3],
                                                         const double tree_size[3],
                                                         insitu_reconstruction reconstruction);

/** Does as insitu_p4est_field with a forest of two dimensions. */
INSITU_P4EST_API insitu_status insitu_p4est_flat_field(insitu_mesh mesh, p4est_t* forest,
                                                       const char* name, insitu_type type,
                                                       size_t offset, int32_t components);

/** Returns the message of the calling thread's last failed call of a function above, or "" if none
 *  failed. The text stays valid until the thread's next such call. */
INSITU_P4EST_API const char* insitu_p4est_message(void);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_P4EST_H */
