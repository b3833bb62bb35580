/* Expectations for programs in C99: each that fails is printed and counted. */
#ifndef INSITU_TESTS_EXPECT_H
#define INSITU_TESTS_EXPECT_H

#include <insitu/insitu.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;

static void expect(int condition, const char* text, int line) {
  if (condition)
    return;
  printf("line %d: expected %s; last message: %s\n", line, text, insitu_last_message());
  ++failures;
}
#define EXPECT(condition) expect((condition) != 0, #condition, __LINE__)

/* Fails with this status, and its message holds this text. */
static void expect_error(insitu_status status, insitu_status expected, const char* text, int line) {
  if (status == expected && strstr(insitu_last_message(), text))
    return;
  printf("line %d: %s expected with '%s', got %s with '%s'\n", line, insitu_status_name(expected),
         text, insitu_status_name(status), insitu_last_message());
  ++failures;
}
#define EXPECT_ERROR(call, status, text) expect_error((call), (status), (text), __LINE__)

#endif /* INSITU_TESTS_EXPECT_H */
