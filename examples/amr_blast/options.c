#include "options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char usage[] =
    "usage: amr_blast [options], or mpirun -n PROCESSES amr_blast [options]\n"
    "  --coarsest N         level of the coarsest cells (2); a unit cube is of level 0\n"
    "  --finest N           level of the finest cells (5)\n"
    "  --trees N            unit cubes along y and z, and N + 1 along x (2)\n"
    "  --walls KIND         'reflecting' (default) or 'periodic'\n"
    "  --end TIME           stop at this time (0.3)\n"
    "  --cycles N           stop after this many cycles\n"
    "  --regrid N           cycles from one regrid to the next (4)\n"
    "  --scene FILE         what libinsitu does with the run (nothing)\n"
    "  --output DIR         where it writes, instead of the scene's folder\n"
    "  --library-threads N  threads of libinsitu (all)\n"
    "  --checkers           the cells as a mesh 'grid' too, with a field 'checkers': 0 and 1 in\n"
    "                       turns, 2 where the level changes\n"
    "  --quiet              no line per cycle\n";

static int complain(const char* option, const char* what) {
  fprintf(stderr, "amr_blast: %s: %s\n%s", option, what, usage);
  return EXIT_FAILURE;
}

static int whole_number(const char* text, long least, long most, long* out) {
  char* end;
  *out = strtol(text, &end, 10);
  return end != text && *end == '\0' && *out >= least && *out <= most;
}

/* Options that are whole numbers: 1 if it was one of them, and its number good; 0 if it is another
 * option; -1 if the number is not good. */
static int parse_number(const char* option, const char* text, options* o) {
  long n = 0;
  const struct {
    const char* name;
    long least, most;
  } known[] = {{"--coarsest", 0, 12},    {"--finest", 0, 12},
               {"--trees", 1, 64},       {"--cycles", 1, 1000000000},
               {"--regrid", 1, 1000000}, {"--library-threads", 1, 4096}};
  size_t i = 0;
  while (i < sizeof known / sizeof *known && strcmp(option, known[i].name) != 0)
    ++i;
  if (i == sizeof known / sizeof *known)
    return 0;
  if (!whole_number(text, known[i].least, known[i].most, &n))
    return -1;
  switch (i) {
  case 0:
    o->config.coarsest = (int)n;
    break;
  case 1:
    o->config.finest = (int)n;
    break;
  case 2:
    o->config.trees[0] = (int)n + 1;
    o->config.trees[1] = o->config.trees[2] = (int)n;
    break;
  case 3:
    o->cycles = n;
    break;
  case 4:
    o->regrid = (int)n;
    break;
  default:
    o->library_threads = (int)n;
  }
  return 1;
}

static int parse_one(const char* option, const char* text, options* o) {
  char* end;
  const int number = parse_number(option, text, o);
  if (number < 0)
    return complain(option, "a whole number in its range expected");
  if (number > 0)
    return -1;
  if (strcmp(option, "--scene") == 0) {
    o->scene = text;
  } else if (strcmp(option, "--output") == 0) {
    o->output = text;
  } else if (strcmp(option, "--walls") == 0) {
    o->config.periodic = strcmp(text, "periodic") == 0;
    if (!o->config.periodic && strcmp(text, "reflecting") != 0)
      return complain(option, "'reflecting' or 'periodic' expected");
  } else if (strcmp(option, "--end") == 0) {
    o->end = strtod(text, &end);
    if (end == text || *end != '\0' || !(o->end > 0.0))
      return complain(option, "a positive time expected");
  } else {
    return complain(option, "no such option");
  }
  return -1;
}

int parse_options(int argc, char** argv, options* out) {
  int i, status = -1;
  out->config = blast_config_default();
  out->end = 0.3;
  out->cycles = 1000000000;
  out->regrid = 4;
  out->scene = out->output = NULL;
  out->library_threads = out->quiet = out->checkers = 0;
  for (i = 1; i < argc; ++i)
    if (strcmp(argv[i], "--help") == 0) {
      fputs(usage, stdout);
      return EXIT_SUCCESS;
    }
  for (i = 1; status < 0 && i < argc; ++i) {
    if (strcmp(argv[i], "--quiet") == 0 || strcmp(argv[i], "--checkers") == 0) {
      *(strcmp(argv[i], "--quiet") == 0 ? &out->quiet : &out->checkers) = 1;
      continue;
    }
    status = i + 1 < argc ? parse_one(argv[i], argv[i + 1], out)
                          : complain(argv[i], "no such option, or its value is missing");
    ++i;
  }
  if (status < 0 && out->config.finest < out->config.coarsest)
    status = complain("--finest", "below --coarsest");
  return status;
}
