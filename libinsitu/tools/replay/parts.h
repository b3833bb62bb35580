#pragma once

#include <functional>
#include <string>
#include <vector>
#include <vtkSmartPointer.h>

#include "steps.h"

class vtkDataObject;

namespace insitu_replay {

/// A piece of a step's mesh: a file, or a block of one.
struct Part {
  std::string name; ///< for messages
  vtkSmartPointer<vtkDataObject> data;
};

using Say = std::function<void(const std::string&)>;

/// Reads the parts of a file: the blocks of a multi-block data set, the data object of any other.
/// Throws FileError. step: whose file it is.
std::vector<Part> read_parts(const std::string& path, const Step& step);

/// Leaves out parts that have no cell of volume (boundaries, as solvers write them beside the
/// inside), if others have; says so with counts.
void drop_surfaces(std::vector<Part>& parts, const Say& say);

/// Takes arrays out that some part with cells lacks, or has in another shape: a field is on all of
/// the mesh. Says which.
void keep_common_arrays(const std::vector<Part>& parts, const Say& say);

/// The names of the numeric arrays of points and cells, ghosts left out.
std::vector<std::string> field_names_of(const std::vector<Part>& parts);

} // namespace insitu_replay
