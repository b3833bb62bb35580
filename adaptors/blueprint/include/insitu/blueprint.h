/** @file blueprint.h
 *  Meshes that Conduit nodes describe, by the mesh Blueprint, become meshes of a session. C99.
 *
 *  Programs link insitu::blueprint. Conduit is not needed to build the library: it uses the
 *  Conduit that the program itself has loaded, that of the nodes which it is given. Solvers that
 *  speak Catalyst 2 need none of this: doc/guide/catalyst.md. */
#ifndef INSITU_BLUEPRINT_H
#define INSITU_BLUEPRINT_H

#include "insitu/insitu.h"

#if defined(_WIN32)
#define INSITU_BLUEPRINT_API
#else
#define INSITU_BLUEPRINT_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** A mesh that nodes describe, step after step. */
typedef struct insitu_blueprint_handle* insitu_blueprint;

typedef struct insitu_blueprint_options {
  size_t size;
  const char* topology; /**< name of the topology; null: the first one whose cells have volume */
  int32_t adaptive;     /**< 1: the domains are the patches of an adaptive mesh, with
                             state/level_id or state/level */
  int32_t reserved;     /**< always 0 */
} insitu_blueprint_options;

static inline insitu_blueprint_options insitu_blueprint_options_default(void) {
  insitu_blueprint_options o;
  o.size = sizeof o;
  o.topology = NULL;
  o.adaptive = 0;
  o.reserved = 0;
  return o;
}

/** Gives the mesh that a node describes to the session's mesh of that name; nothing is committed.
 *  The first call has *blueprint null, and makes it; later calls, each with the node of the next
 *  step, update it. options null means the defaults; those of the first call hold.
 *
 *  node: a conduit_node of Conduit's C interface (in C++ conduit::c_node(&node)), which is a mesh,
 *  or has one domain a child, each of which becomes a piece. The library reads arrays where the
 *  solver has them: float32 and float64, int32 and int64 and their unsigned kinds, with any stride,
 *  interleaved or not. It copies integers that are fields, ids of 8 and 16 bits, and shapes of
 * mixed cells whose numbers are not VTK's, and what polygons, polyhedra among other shapes and
 * lists of topologies of one shape become; the audit names these copies, and strict sessions refuse
 * them. The arrays must stay until the next call, or until the mesh is given others. Coordinates
 * and connectivity are compared with those of the step before by value, so the library refits or
 *  rebuilds only where they changed.
 *
 *  INSITU_ERROR_ARGUMENT: the tree lacks something, or has it in a form that cannot be; the message
 *  names its path. INSITU_ERROR_FIELD: a field has another number of items than its topology.
 *  INSITU_ERROR_UNSUPPORTED: the tree is right, and the library cannot do it. After an error the
 *  mesh is refused (insitu_mesh_refuse) until a node is attached that is right. */
INSITU_BLUEPRINT_API insitu_status insitu_blueprint_attach(insitu_session session, const char* name,
                                                           const void* node,
                                                           const insitu_blueprint_options* options,
                                                           insitu_blueprint* blueprint);

/** Returns what of the last node was not given to the mesh, and why, a line each; "" for nothing.
 *  The text stays valid until the next call of insitu_blueprint_attach. */
INSITU_BLUEPRINT_API const char* insitu_blueprint_left_out(insitu_blueprint blueprint);

/** Releases what insitu_blueprint_attach made, and sets *blueprint to null. The caller does so
 * after the session is closed, or before it gives the mesh other arrays. */
INSITU_BLUEPRINT_API void insitu_blueprint_release(insitu_blueprint* blueprint);

/** Returns the message of the calling thread's last failed call of a function above, or "" if none
 *  failed. The text stays valid until the thread's next such call. */
INSITU_BLUEPRINT_API const char* insitu_blueprint_message(void);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_BLUEPRINT_H */
