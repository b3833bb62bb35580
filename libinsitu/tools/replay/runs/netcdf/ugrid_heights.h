#pragma once

#include <string>
#include <vector>

#include "runs/netcdf/ugrid_vertical.h"

namespace insitu_replay {

/// Whether a variable is a vertical coordinate whose heights can be had: lengths, or one of the
/// parametric coordinates of oceans that the CF conventions have.
bool gives_heights(const NetcdfFile& file, const NetcdfFile::Variable& v);

/// Heights in metres along the variable's dimension `level` at the nodes, [level][node]. numbers:
/// those of the variable, or others in their place, [level][node].
std::vector<double> heights_of(const UgridDims& dims, const NetcdfFile::Variable& v,
                               std::vector<double> numbers, std::size_t step, int level);

/// Whether heights hang on the step.
bool heights_move(const UgridDims& dims, const NetcdfFile::Variable& v);

/// Whether its heights need no variable along the levels but itself.
bool is_alone_along_levels(const NetcdfFile& file, const NetcdfFile::Variable& v);

} // namespace insitu_replay
