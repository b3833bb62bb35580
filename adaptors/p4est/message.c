#include "message.h"

#include <stdarg.h>
#include <stdio.h>

#include "insitu/p4est.h"

static __thread char message[1024];

insitu_status refuse(insitu_status status, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(message, sizeof message, format, arguments);
  va_end(arguments);
  return status;
}

void forget_message(void) {
  message[0] = '\0';
}

const char* insitu_p4est_message(void) {
  return message;
}
