#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "math/vec.h"
#include "measure.h"
#include "workload/mesh.h"

namespace insitu::bench {

/// Lines of another library through the same velocity, which it interpolates as we do.
struct PeerLines {
  std::string name;
  Series time; ///< on one thread
  std::int64_t steps = 0;
  std::vector<math::Vec3d> ends; ///< by seed; of those without a line, the seed
  std::vector<double> times;     ///< of the ends, as the library says; 0 of those without a line
  std::vector<bool> whole;       ///< the line has the length that was asked for
};

/// vtkStreamTracer with Runge and Kutta's method of order 4 (step: in cell lengths) and with the
/// pair 4(5) by Cash and Karp (error: tolerated, in coordinates), lines of `length`; none without
/// VTK. velocity: interleaved, at the vertices.
std::vector<PeerLines> trace_by_vtk(const workload::Mesh& mesh, const std::vector<double>& velocity,
                                    const std::vector<math::Vec3d>& seeds, double length,
                                    double step, double error, int repetitions);

} // namespace insitu::bench
