#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "cells/kernels/faces.h"
#include "workload/mesh.h"

namespace insitu::workload {

/// Faces by their sorted vertex ids, and how often each is met.
inline std::map<std::vector<std::int32_t>, int> count_faces(const Mesh& mesh) {
  std::map<std::vector<std::int32_t>, int> count;
  for (std::int64_t c = 0; c < mesh.cell_count(); ++c) {
    const cells::FaceTable table = cells::face_table(mesh.shape(c));
    for (int f = 0; f < table.face_count; ++f) {
      std::vector<std::int32_t> ids;
      for (int v = 0; v < table.faces[f].vertex_count; ++v)
        ids.push_back(mesh.ids(c)[table.faces[f].vertices[v]]);
      std::sort(ids.begin(), ids.end());
      ++count[ids];
    }
  }
  return count;
}

} // namespace insitu::workload
