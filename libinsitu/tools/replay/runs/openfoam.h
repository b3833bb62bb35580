#pragma once

#include <memory>
#include <string>

#include "runs/run.h"

namespace insitu_replay {

/// A case of OpenFOAM, by VTK's reader: the inner mesh with the fields of its cells as the solver
/// has them, polyhedra as they are. Of the whole case and what its processor folders hold, that
/// which has more times is read, and the whole at a tie. Throws FileError.
std::unique_ptr<Run> open_openfoam(const std::string& folder);

} // namespace insitu_replay
