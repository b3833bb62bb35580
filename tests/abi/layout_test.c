/* Structs and constants of the frozen headers against those of now: members stay where they were,
 * structs that others hold keep their size, others grow at their end alone. */
#include <inttypes.h>
#include <stdio.h>

#include "insitu/insitu.h"

int layout_then(int which, int64_t* out);
int layout_now(int which, int64_t* out);
int constants_then(int64_t* out);
int constants_now(int64_t* out);

enum { STRUCTS = 20 };

/* Of layout.c: held by value, or in lists. */
static int keeps_size(int which) {
  enum { ARRAY = 1, AUDIT = 7, LOCATE = 8 };
  return which == ARRAY || which == AUDIT || which == LOCATE;
}

/* Numbers of endings and the like, which grow. */
static int is_count(int64_t constant) {
  return constant == INSITU_REASON_COUNT || constant == INSITU_END_COUNT ||
         constant == INSITU_MEMORY_COUNT;
}

int main(void) {
  int64_t then[256], now[256];
  int failures = 0;
  for (int which = 0; which < STRUCTS; ++which) {
    const int count = layout_then(which, then);
    if (layout_now(which, now) != count || now[0] < then[0] ||
        (keeps_size(which) && now[0] != then[0])) {
      fprintf(stderr, "struct %d: %" PRId64 " bytes then, %" PRId64 " now\n", which, then[0],
              now[0]);
      ++failures;
    }
    for (int m = 1; m < count; ++m)
      if (then[m] != now[m]) {
        fprintf(stderr, "struct %d, member %d: at %" PRId64 " then, at %" PRId64 " now\n", which,
                m - 1, then[m], now[m]);
        ++failures;
      }
  }
  const int count = constants_then(then);
  if (constants_now(now) != count)
    return 1;
  for (int i = 0; i < count; ++i)
    if (then[i] != now[i] && !(is_count(then[i]) && now[i] > then[i])) {
      fprintf(stderr, "constant %d: %" PRId64 " then, %" PRId64 " now\n", i, then[i], now[i]);
      ++failures;
    }
  return failures != 0;
}
