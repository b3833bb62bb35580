/* The command line of amr_blast. */
#ifndef AMR_BLAST_OPTIONS_H
#define AMR_BLAST_OPTIONS_H

#include "blast.h"

typedef struct options {
  blast_config config;
  double end;
  long cycles;
  int regrid; /* cycles from one to the next */
  const char *scene, *output;
  int library_threads;
  int quiet;
  int checkers; /* 1: the cells themselves as another mesh */
} options;

/* Fills in what the arguments say. Returns -1 to go on, otherwise the status to leave with: what to
 * say was said. */
int parse_options(int argc, char** argv, options* out);

#endif
