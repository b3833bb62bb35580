#pragma once

namespace insitu::foam {

/// The address of the MPI_Comm of all processes of the run; null if OpenFOAM runs on one process.
/// Throws Error if OpenFOAM's library of messages (Pstream) has no communicators.
const void* world_communicator();

} // namespace insitu::foam
