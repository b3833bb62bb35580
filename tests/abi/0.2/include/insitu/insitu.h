/** @file insitu.h
 *  libinsitu: in-situ queries, tracers and frames for a running simulation. The C99 API and the
 *  one stable ABI; insitu.hpp (C++17) and the Fortran module are thin layers over it.
 *
 *  Rules that hold for every call
 *  - It returns a status; INSITU_OK is 0. On failure insitu_last_message() names the argument and
 *    the numbers. No call aborts, throws, or prints to stdout. A failed call changes nothing.
 *  - Handles are checked: a handle used after its release is answered by INSITU_ERROR_HANDLE.
 *  - A session is used by one thread at a time; a second one inside it gets INSITU_ERROR_BUSY.
 *    Different sessions are independent.
 *  - The caller's floating-point environment (rounding, traps, flush-to-zero) is saved at entry
 *    and restored before return; inside and in the workers the default environment is used.
 *  - Structs start with their size; make them with their _default() function, which lets later
 *    versions add members. From 0.2 on an argument struct of an earlier version (shorter) is taken,
 *    with defaults for what it lacks, and one of a later version (longer) if what this version does
 *    not know is zero; else INSITU_ERROR_ARGUMENT names the struct and the sizes. Of results as
 *    much is written as the caller's size has room for. Members called reserved are 0.
 *  - Strings are UTF-8 and copied. Arrays are **external**: the library keeps the pointer and reads
 *    it in place (see insitu_array for how long).
 *  - Ids are 0-based unless an index_base or cell_base argument says otherwise. Coordinates are in
 *    the units of the solver; degrees and metres in geographic frames.
 *
 *  Include this header; its parts in insitu/c/ stand on their own too. */
#ifndef INSITU_H
#define INSITU_H

#include "insitu/c/amr.h"
#include "insitu/c/array.h"
#include "insitu/c/base.h"
#include "insitu/c/commit.h"
#include "insitu/c/locator.h"
#include "insitu/c/mesh.h"
#include "insitu/c/query.h"
#include "insitu/c/report.h"
#include "insitu/c/session.h"

#endif /* INSITU_H */
