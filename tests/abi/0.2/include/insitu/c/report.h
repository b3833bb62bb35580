/** @file report.h
 *  A report holds the totals of a session. */
#ifndef INSITU_C_REPORT_H
#define INSITU_C_REPORT_H

#include "insitu/c/query.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Why a particle ended. The endings of particles that left the mesh tell what lies beyond the
 *  face: a cell that is hidden (VTK's ghost bits 8 and 32), a cell that another process owns (bit 1
 *  alone), a cell in which the velocity is blank (insitu_mesh_field_blank), a gap or an obstacle,
 *  behind which the line straight out of the face comes to cells again, or nothing. A particle that
 *  was seeded in such a cell ends likewise. On adaptive meshes places without leaves are gaps. */
typedef enum insitu_ending INSITU_INT {
  INSITU_END_ALIVE = 0,
  INSITU_END_LEFT = 1,            /**< left the mesh, and nothing lies ahead */
  INSITU_END_STAGNATED = 2,       /**< came to rest in a steady field, or no step could be found */
  INSITU_END_EXPIRED = 3,         /**< reached its time, length or age */
  INSITU_END_STEP_LIMIT = 4,      /**< took the largest number of steps */
  INSITU_END_SEED_OUTSIDE = 5,    /**< was seeded outside the mesh */
  INSITU_END_NOT_FINITE = 6,      /**< the velocity is NaN or infinite */
  INSITU_END_KILLED = 7,          /**< the session was closed while it lived */
  INSITU_END_STOPPED = 8,         /**< met the boundary, where its scene says that it stops */
  INSITU_END_REMOVED = 9,         /**< met the condition by which its scene removes particles */
  INSITU_END_STEP_TOO_SMALL = 10, /**< no step as large as its scene's min_step kept the
                                       tolerance */
  INSITU_END_HOLE = 11,           /**< left the mesh at a gap or an obstacle, behind which the mesh
                                       goes on */
  INSITU_END_HIDDEN = 12,         /**< went into a hidden cell */
  INSITU_END_BLANK = 13,          /**< went where its velocity has blank values */
  INSITU_END_PARTITION = 14,      /**< went into a ghost cell, which another process owns */
  INSITU_END_COUNT = 15
} insitu_ending;

/** What a session holds memory for. */
typedef enum insitu_purpose INSITU_INT {
  INSITU_MEMORY_TREE = 0,        /**< nodes and leaves */
  INSITU_MEMORY_BUILD = 1,       /**< the builder's scratch, kept between builds */
  INSITU_MEMORY_RANGES = 2,      /**< value ranges */
  INSITU_MEMORY_EARLIER = 3,     /**< earlier steps, kept for pathlines */
  INSITU_MEMORY_QUERY = 4,       /**< scratch of queries */
  INSITU_MEMORY_TRACER = 5,      /**< particles */
  INSITU_MEMORY_FRAME = 6,       /**< images */
  INSITU_MEMORY_CONVERTED = 7,   /**< arrays that adaptors had to convert */
  INSITU_MEMORY_EMBREE = 8,      /**< memory that Embree holds */
  INSITU_MEMORY_DEVICE = 9,      /**< on devices: copies of arrays, trees, scratch */
  INSITU_MEMORY_AMR = 10,        /**< dual meshes of adaptive meshes */
  INSITU_MEMORY_GATHERED = 11,   /**< fields of adaptive meshes at the dual's vertices */
  INSITU_MEMORY_GEOCENTRIC = 12, /**< vertices of meshes drawn geocentric, with heights
                                      exaggerated */
  INSITU_MEMORY_CHART = 13,      /**< copies of a geodetic mesh's cells at its seam and poles, and
                                      fields there */
  INSITU_MEMORY_NEIGHBOURS = 14, /**< cells across faces, for tracers */
  INSITU_MEMORY_BLANK = 15,      /**< fields with blank values or hidden points, and their cells */
  INSITU_MEMORY_HALO = 16,       /**< cells of other processes that touch this one's, with their
                                      vertices and fields */
  INSITU_MEMORY_POLYHEDRA = 17,  /**< what cells given by faces are cut into, with their vertices
                                      and fields */
  INSITU_MEMORY_FLAT = 18,       /**< the flat cells of a flat mesh as volume cells, with their
                                      vertices and fields */
  INSITU_MEMORY_HELD = 19,       /**< copies of the solver's arrays, of steps that are held; their
                                      trees count as trees */
  INSITU_MEMORY_COUNT = 20
} insitu_purpose;

/** The room of the lists in insitu_report, of which later versions of the library use more. */
enum { INSITU_MEMORY_ROOM = 32, INSITU_END_ROOM = 32, INSITU_REASON_ROOM = 16 };

/** Totals since the session was opened. Seconds are wall-clock seconds in the library. purposes,
 *  endings and reasons tell how many items of the lists the running library counts, which may be
 *  more than INSITU_MEMORY_COUNT, INSITU_END_COUNT and INSITU_REASON_COUNT of this header. Items
 *  after those are 0. */
typedef struct insitu_report {
  size_t size;
  int64_t executions;
  double commit_s, query_s, advect_s, render_s, output_s;
  int64_t keeps, refits, rebuilds;
  int64_t bytes_borrowed; /**< bytes of the solver's arrays that the library reads in place */
  int64_t bytes_held;     /**< bytes of the library's own memory, now */
  int64_t bytes_peak;
  int64_t bytes_by_purpose[INSITU_MEMORY_ROOM]; /**< bytes held now, by insitu_purpose */
  int64_t points_located, points_outside;
  int64_t particles_seeded;
  int64_t particles[INSITU_END_ROOM]; /**< [insitu_ending] the counts sum up to particles_seeded */
  int64_t frames, probe_rows, files;
  int64_t failures;                              /**< actions that failed and were skipped */
  int64_t located_by_reason[INSITU_REASON_ROOM]; /**< [insitu_reason] every point located for
                                                      whatever purpose: queries, probes, tracers and
                                                      samples of frames, of all meshes */
  double ranges_s;   /**< part of render_s: finding the value ranges of macrocells and cells for the
                          first time, or refreshing them after new values */
  double classify_s; /**< part of render_s: classifying macrocells and cells by transfer functions,
                          and building trees of those that show, after new values or another
                          function */
  int32_t purposes, endings, reasons; /**< how many items of bytes_by_purpose, particles and
                                           located_by_reason are counted */
  int32_t reserved;
  int64_t halo_cells; /**< copies of other processes' cells that touch this one's, now; their bytes
                           are those of INSITU_MEMORY_HALO */
  int64_t messages_sent, bytes_sent; /**< by this process to others, all that the session sent */
} insitu_report;

static inline insitu_report insitu_report_default(void) {
  insitu_report r;
  int i;
  r.size = sizeof r;
  r.executions = 0;
  r.commit_s = r.query_s = r.advect_s = r.render_s = r.output_s = 0.0;
  r.keeps = r.refits = r.rebuilds = 0;
  r.bytes_borrowed = r.bytes_held = r.bytes_peak = 0;
  for (i = 0; i < INSITU_MEMORY_ROOM; ++i)
    r.bytes_by_purpose[i] = 0;
  r.points_located = r.points_outside = 0;
  r.particles_seeded = 0;
  for (i = 0; i < INSITU_END_ROOM; ++i)
    r.particles[i] = 0;
  r.frames = r.probe_rows = r.files = r.failures = 0;
  for (i = 0; i < INSITU_REASON_ROOM; ++i)
    r.located_by_reason[i] = 0;
  r.ranges_s = r.classify_s = 0.0;
  r.purposes = r.endings = r.reasons = r.reserved = 0;
  r.halo_cells = r.messages_sent = r.bytes_sent = 0;
  return r;
}

INSITU_API insitu_status insitu_session_report(insitu_session session, insitu_report* report);

/** Writes the report to a file, as JSON. solver_s: the solver's own seconds, from which the
 *  library's share of the run follows; negative: the share is left out. Collective: the root writes
 *  sums of all processes' counts, and of seconds, halos and what was sent that of the least, the
 *  mean and the greatest process. */
INSITU_API insitu_status insitu_session_write_summary(insitu_session session, const char* path,
                                                      double solver_s);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_REPORT_H */
