/* What the last failed call of the calling thread said. */
#ifndef INSITU_ADAPTORS_P4EST_MESSAGE_H
#define INSITU_ADAPTORS_P4EST_MESSAGE_H

#include "insitu/insitu.h"

/* Writes the message, and returns the status. */
__attribute__((visibility("hidden"))) insitu_status refuse(insitu_status status, const char* format,
                                                           ...);
__attribute__((visibility("hidden"))) void forget_message(void);

#endif /* INSITU_ADAPTORS_P4EST_MESSAGE_H */
