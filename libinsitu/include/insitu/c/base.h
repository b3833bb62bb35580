/** @file base.h
 *  What every part of insitu.h needs: version, status, handles. */
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

/* Enumerations are ints. In C++ that has to be said, or a value that is none of theirs, which the
 * library tells the caller about, would be undefined behaviour before it could. */
#ifdef __cplusplus
#define INSITU_INT : int
extern "C" {
#else
#define INSITU_INT
#endif

/** Values of this and the other enumerations are fixed; gaps are for later members. */
typedef enum insitu_status INSITU_INT {
  INSITU_OK = 0,
  INSITU_ERROR_ARGUMENT = 1,     /**< an argument is null, negative, of a wrong type or count */
  INSITU_ERROR_HANDLE = 2,       /**< a handle is null, released, or of another kind */
  INSITU_ERROR_BUSY = 3,         /**< another thread is inside this session */
  INSITU_ERROR_ORDER = 4,        /**< calls out of order, such as locate before commit */
  INSITU_ERROR_MESH = 5,         /**< validation refused the mesh */
  INSITU_ERROR_FIELD = 6,        /**< no such field, or its shape does not fit */
  INSITU_ERROR_SCENE = 7,        /**< the scene cannot be parsed or asks for what is not there */
  INSITU_ERROR_FILE = 8,         /**< a file or folder cannot be read or written */
  INSITU_ERROR_MEMORY = 9,       /**< out of memory */
  INSITU_ERROR_UNSUPPORTED = 10, /**< known, but not available in this build or version */
  INSITU_ERROR_CONVERSION = 11,  /**< strict mode refuses to copy or convert an array */
  INSITU_ERROR_ACTION = 12,      /**< a probe, tracer or frame failed; the rest was done */
  INSITU_ERROR_INTERNAL = 100
} insitu_status;

/** Opaque handles: a session, and a mesh that belongs to one session. */
typedef struct insitu_session_handle* insitu_session;
typedef struct insitu_mesh_handle* insitu_mesh;

/** The name of a status, such as "INSITU_ERROR_MESH". Never null. */
INSITU_API const char* insitu_status_name(insitu_status status);

/** The version of the library that is running; each pointer may be null. */
INSITU_API insitu_status insitu_version(int* major, int* minor, int* patch);

/** The message of the calling thread's last failed call ("" if none). Valid until the thread's
 *  next call of this library. Never null. */
INSITU_API const char* insitu_last_message(void);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_BASE_H */
