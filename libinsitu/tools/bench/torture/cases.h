#pragma once

#include <string>
#include <vector>

#include "workload/mesh.h"

namespace insitu::bench::torture {

/// A small mesh that is hard to locate points in.
struct Case {
  std::string name;
  workload::Mesh mesh;
  /// Cells neither fold nor overlap and have a volume.
  bool valid = true;
  /// The cells fill the mesh's hull: neighbours share whole faces.
  bool conforming = true;
  /// The library is given the coordinates as float32 (which they are).
  bool float32 = false;
};

/// All cases, from boxes of n blocks along each axis.
std::vector<Case> make_cases(int n);

} // namespace insitu::bench::torture
