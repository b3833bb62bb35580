/** @file probe.h
 *  What the probes of a session's scene answered. */
#ifndef INSITU_C_PROBE_H
#define INSITU_C_PROBE_H

#include "insitu/c/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What a probe answered when it was due last. All pointers are the library's and stay valid until
 *  the session's next execute, its next insitu_session_keep_answers(), or its close. */
typedef struct insitu_probe_answers {
  size_t size;
  const char* name;                /**< of the probe, as the scene has it */
  int64_t cycle;                   /**< of the execute at which the probe answered */
  double time;                     /**< of that execute */
  int32_t answered;                /**< 0: the probe has not answered yet; the members but for name
                                        and size are then 0 and null */
  int32_t column_count;            /**< number of values of a point */
  int64_t point_count;             /**< number of the probe's points */
  const char* const* column_names; /**< [column] as the probe's table names them, such as v_x */
  const double* points;            /**< [point][3] in the mesh's coordinates */
  const uint8_t* inside;           /**< [point] 1: a cell answered for the point, which is the
                                        nearest one where the probe says `outside: nearest` */
  const double* values;            /**< [point][column]; NaN where no cell answered */
} insitu_probe_answers;

static inline insitu_probe_answers insitu_probe_answers_default(void) {
  insitu_probe_answers a;
  a.size = sizeof a;
  a.name = NULL;
  a.cycle = 0;
  a.time = 0.0;
  a.answered = a.column_count = 0;
  a.point_count = 0;
  a.column_names = NULL;
  a.points = NULL;
  a.inside = NULL;
  a.values = NULL;
  return a;
}

/** From the next execute on (keep 1) each process keeps what each probe of the scene answers, or no
 *  process does any more (0), as in a session that was just opened. Of several processes the root
 *  sends the values to all of them while the probe is executed, 8 bytes a value. Collective: all
 *  processes give the same. INSITU_ERROR_ARGUMENT: keep is neither 0 nor 1. */
INSITU_API insitu_status insitu_session_keep_answers(insitu_session session, int32_t keep);

/** Writes what probe number `probe` of the scene answered last, from 0 on, and to *count how many
 *  probes the scene has; answers null: the number alone. The answers are the same on all processes,
 *  to the bit. Not collective: any process may ask, at any time. INSITU_ERROR_ARGUMENT: the scene
 *  has no such probe; *count is written all the same. */
INSITU_API insitu_status insitu_session_answers(insitu_session session, int32_t probe,
                                                insitu_probe_answers* answers, int32_t* count);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_PROBE_H */
