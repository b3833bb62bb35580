/** @file insitu.h
 *  libinsitu answers in-situ queries, moves tracers and draws frames for a running simulation. This
 *  header is the C99 API and the one stable ABI; insitu.hpp (C++17) and the Fortran module are thin
 *  layers over it.
 *
 *  Rules that hold for every call
 *  - Every call returns a status; INSITU_OK is 0. After a failure insitu_last_message() names the
 *    argument and the numbers. No call aborts, throws, or prints to stdout. A failed call changes
 *    nothing.
 *  - The library checks handles: a call with a handle that was released returns
 *    INSITU_ERROR_HANDLE.
 *  - One thread at a time uses a session; a second thread inside it gets INSITU_ERROR_BUSY.
 *    Different sessions are independent.
 *  - The library saves the caller's floating-point environment (rounding, traps, flush-to-zero) at
 *    entry and restores it before the return; the call and its worker threads run in the default
 *    environment.
 *  - Structs start with their size. Their _default() function makes them, which lets later versions
 *    add members. From 0.2 on the library takes an argument struct of an earlier version (a shorter
 *    one), with defaults for the members that it lacks, and one of a later version (a longer one)
 *    if the bytes that this version does not know are zero; otherwise INSITU_ERROR_ARGUMENT names
 *    the struct and the sizes. The library writes as much of a result as the caller's size has room
 *    for. Members called reserved are 0.
 *  - Strings are UTF-8, and the library copies them. Arrays are **external**: the library keeps the
 *    pointer and reads the array in place (insitu_array says for how long).
 *  - Ids are 0-based unless an index_base or cell_base argument says otherwise. Coordinates are in
 *    the units of the solver; geographic frames have degrees and metres.
 *
 *  Include this header; each of its parts in insitu/c/ can also be included alone. */
#ifndef INSITU_H
#define INSITU_H

#include "insitu/c/amr.h"
#include "insitu/c/array.h"
#include "insitu/c/base.h"
#include "insitu/c/commit.h"
#include "insitu/c/locator.h"
#include "insitu/c/mesh.h"
#include "insitu/c/probe.h"
#include "insitu/c/query.h"
#include "insitu/c/report.h"
#include "insitu/c/session.h"

#endif /* INSITU_H */
