#include "communicator.h"

// OpenFOAM makes a macro of Log, so its headers come last.
// clang-format off
#include <insitu/insitu.hpp>
#include <PstreamGlobals.H>
#include <UPstream.H>
// clang-format on

namespace Foam::PstreamGlobals {
// A Pstream that knows no MPI has no such list.
extern DynamicList<MPI_Comm> MPICommunicators_ __attribute__((weak));
} // namespace Foam::PstreamGlobals

namespace insitu::foam {

const void* world_communicator() {
  if (!Foam::UPstream::parRun())
    return nullptr;
  auto* const all = &Foam::PstreamGlobals::MPICommunicators_;
  if (!all || all->size() <= Foam::UPstream::worldComm)
    throw Error(INSITU_ERROR_UNSUPPORTED, "OpenFOAM's Pstream has no communicators of MPI");
  return &(*all)[Foam::UPstream::worldComm];
}

} // namespace insitu::foam
