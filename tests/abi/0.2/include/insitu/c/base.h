/** @file base.h
 *  The version, the statuses and the handles, which every other part of insitu.h needs. */
#ifndef INSITU_C_BASE_H
#define INSITU_C_BASE_H

#include <stddef.h>
#include <stdint.h>

#define INSITU_VERSION_MAJOR 0
#define INSITU_VERSION_MINOR 2
#define INSITU_VERSION_PATCH 0

#if defined(INSITU_STATIC)
#define INSITU_API
#elif defined(_WIN32)
#define INSITU_API __declspec(dllimport)
#else
#define INSITU_API __attribute__((visibility("default")))
#endif

/* Enumerations are ints. C++ has to be told so: otherwise a value that no member has would be
 * undefined behaviour before the library could refuse it. */
#ifdef __cplusplus
#define INSITU_INT : int
extern "C" {
#else
#define INSITU_INT
#endif

/** The values of this enumeration and of all others are fixed; gaps are for later members. */
typedef enum insitu_status INSITU_INT {
  INSITU_OK = 0,
  INSITU_ERROR_ARGUMENT = 1,     /**< an argument is null, negative, of a wrong type or count */
  INSITU_ERROR_HANDLE = 2,       /**< a handle is null, released, or of another kind */
  INSITU_ERROR_BUSY = 3,         /**< another thread is inside this session */
  INSITU_ERROR_ORDER = 4,        /**< calls came out of order, such as locate before commit */
  INSITU_ERROR_MESH = 5,         /**< validation refused the mesh */
  INSITU_ERROR_FIELD = 6,        /**< the mesh has no such field, or its shape does not fit */
  INSITU_ERROR_SCENE = 7,        /**< the scene cannot be parsed, or asks for what is not there */
  INSITU_ERROR_FILE = 8,         /**< a file or folder cannot be read or written */
  INSITU_ERROR_MEMORY = 9,       /**< out of memory */
  INSITU_ERROR_UNSUPPORTED = 10, /**< the library knows the request, but this build or version
                                      cannot do it */
  INSITU_ERROR_CONVERSION = 11,  /**< strict mode refuses to copy or convert an array */
  INSITU_ERROR_ACTION = 12,      /**< a probe, tracer or frame failed; everything else was done */
  INSITU_ERROR_INTERNAL = 100
} insitu_status;

/** In the place of a number that a collective call asks for: the caller lacks memory of its own for
 *  the call, which then fails on all processes with INSITU_ERROR_MEMORY, so that none waits. */
#define INSITU_LACKS_MEMORY INT32_MIN

/** Opaque handles of a session, and of a mesh that belongs to one session. */
typedef struct insitu_session_handle* insitu_session;
typedef struct insitu_mesh_handle* insitu_mesh;

/** Returns the name of a status, such as "INSITU_ERROR_MESH"; never null. */
INSITU_API const char* insitu_status_name(insitu_status status);

/** Writes the version of the library that is running. Each pointer may be null; that number is then
 *  left out. */
INSITU_API insitu_status insitu_version(int* major, int* minor, int* patch);

/** Returns the message of the calling thread's last failed call, or "" if none failed; never null.
 *  The text stays valid until the thread's next call of this library. */
INSITU_API const char* insitu_last_message(void);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_BASE_H */
