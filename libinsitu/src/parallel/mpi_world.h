#pragma once

#include <cstdint>
#include <memory>

#include "core/log.h"
#include "parallel/world.h"

namespace insitu::parallel {

/// Whether this build has libinsitu-mpi.
bool has_mpi();

/// The processes of a communicator: that at the address, or with none that of the Fortran integer.
/// Collective over it. It is duplicated, and freed with the World, on all processes alike. Loads
/// libinsitu-mpi, and with it MPI. Throws core::Error: INSITU_ERROR_UNSUPPORTED if the program has
/// loaded another MPI than libinsitu-mpi was built with, or that library is not found;
/// INSITU_ERROR_ORDER if MPI is not initialised, or finalised; INSITU_ERROR_ARGUMENT for no
/// communicator to work on; AgreedError (INSITU_ERROR_MEMORY) on all processes if one of them
/// lacks memory; and, with seconds above 0, INSITU_ERROR_ORDER once a process has not come so long.
std::shared_ptr<World> make_mpi_world(const void* communicator, std::int32_t fortran_communicator,
                                      const core::Log& log, double seconds = 0.0);

/// What a loaded library's file is an MPI by, such as "Open MPI" of "libmpi.so.40", or null.
const char* mpi_of(const char* library);

} // namespace insitu::parallel
