/** @file p4est.h
 *  A p8est forest as an adaptive mesh: the local trees are its pieces, in order, and the quadrants
 *  their leaves, read in place. C99.
 *
 *  Supported is a brick: trees that are equal boxes along the axes, side by side without rotation,
 * such as p8est_connectivity_new_brick and _new_unitcube make (periodic or not, with holes, with
 * vertices scaled); where each lies follows from the connectivity's vertices. Any other
 * connectivity, and any geometry that bends trees, is refused by name.
 *
 *  Call both functions again, the mesh first, whenever p4est may have moved its quadrants or
 *  records: after refining, coarsening, balancing and partitioning. In between,
 * insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS) says that the values are others. The forest and
 * its records must stay until the mesh is given another one, or its session is closed. */
#ifndef INSITU_P4EST_H
#define INSITU_P4EST_H

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

/** Gives the forest's cells to an empty mesh, or to one that a forest was given to before.
 *  origin: the lower corner of the brick; tree_size: the lengths of a tree; both null: the
 *  coordinates of the connectivity's vertices.
 *  A forest without quadrants on this process is a mesh of one piece without cells.
 *  INSITU_ERROR_ARGUMENT: a null argument, sizes that are not positive, or no vertices.
 *  INSITU_ERROR_UNSUPPORTED: the trees are no brick. Otherwise as insitu_mesh_amr and _leaves. */
INSITU_P4EST_API insitu_status insitu_p4est_mesh(insitu_mesh mesh, p8est_t* forest,
                                                 const double origin[3], const double tree_size[3]);

/** The same, with a reconstruction of samples: insitu_p4est_mesh has INSITU_DUAL. */
INSITU_P4EST_API insitu_status insitu_p4est_mesh_as(insitu_mesh mesh, p8est_t* forest,
                                                    const double origin[3],
                                                    const double tree_size[3],
                                                    insitu_reconstruction reconstruction);

/** A field of the cells: `components` values of a type, float32 or float64, side by side `offset`
 * bytes from where each quadrant's p.user_data points. The records stay where they are.
 *  INSITU_ERROR_ARGUMENT: the forest keeps no records, or they end before the values do.
 *  INSITU_ERROR_ORDER: the forest's quadrants are not those that insitu_p4est_mesh gave. */
INSITU_P4EST_API insitu_status insitu_p4est_field(insitu_mesh mesh, p8est_t* forest,
                                                  const char* name, insitu_type type, size_t offset,
                                                  int32_t components);

/** What was wrong with the calling thread's last failed call of a function above; "" if none was.
 *  Valid until its next such call. */
INSITU_P4EST_API const char* insitu_p4est_message(void);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_P4EST_H */
