#pragma once

#include <cmath>
#include <iterator>
#include <string>
#include <vector>

#include "core/context.h"
#include "methods/rates.h"
#include "options.h"
#include "query/device/device_locator.h"

namespace insitu::bench::paper {

using accel::Backend;
using accel::Method;
using workload::Kind;
using workload::Spacing;

/// A data set of the paper, and what of ours stands in for it.
struct MorricalSet {
  const char* name;
  double millions; ///< elements
  Kind kind;
  Spacing spacing;
  Wanted wanted; ///< what it has values of
};
constexpr MorricalSet morrical_sets[] = {
    {"fusion", 3, Kind::tetrahedra, Spacing::graded, Wanted::vertex_value},
    {"jets", 12, Kind::tetrahedra, Spacing::even, Wanted::vertex_value},
    {"agul-t", 36, Kind::tetrahedra, Spacing::even, Wanted::cell_value},
    {"jpn-t", 62, Kind::tetrahedra, Spacing::sparse, Wanted::vertex_value},
    {"agul-w", 14, Kind::wedges, Spacing::even, Wanted::cell_value},
    {"jpn-h", 8, Kind::hexahedra, Spacing::sparse, Wanted::vertex_value}};
constexpr std::size_t morrical_set_count = std::size(morrical_sets);

/// What was measured of one method on one mesh.
struct MethodCase {
  Sizes sizes;
  double uniform = 0.0, random = 0.0, view = 0.0; ///< million samples a second, fast
  double random_standard = 0.0, random_exact = 0.0;
  std::int64_t lost = 0, other = 0; ///< of random points: without a cell in standard; by exact
  double watts = NAN, joules = NAN; ///< of samples along view rays; a million of them
};

/// A mesh with all that was measured on it.
struct MorricalCase {
  std::int64_t cells = 0;
  double mesh_bytes = 0.0;
  double view_samples = 0.0; ///< of a frame of 1024 x 1024
  MethodCase of[accel::backend_count][accel::method_count];
  double frame_seconds = 0.0; ///< of 1024 x 1024 pixels by the renderer
  double vtk_seconds = NAN;
  std::string vtk_why = "asked for by no mesh";
};

/// Whether a backend of this build has the method.
bool is_here(int backend, int method);

/// Makes the meshes and measures every method of every backend that is here.
class MorricalBench {
public:
  explicit MorricalBench(const Options& o) : o_(o), context_(o.threads, core::Log()) {}

  MorricalCase measure(const MorricalSet& set);
  int threads() const { return context_.threads.count(); }
  int frame_size() const { return o_.quick ? 64 : o_.size; }
  const EnergyMeter& processor() const { return processor_; }
  const EnergyMeter& card() const { return card_; }

private:
  std::int64_t cells_of(const MorricalSet& set) const {
    return std::max<std::int64_t>(300, std::llround(double(o_.cells[0]) * set.millions / 62));
  }
  std::vector<math::Vec3d> draw(const MorricalSet& set, const MethodMesh& mesh, MorricalCase& out);
  MethodCase measure(Backend backend, Method method, const MorricalSet& set, MethodMesh& mesh,
                     std::span<const math::Vec3d> uniform, std::span<const math::Vec3d> random,
                     std::span<const math::Vec3d> view, const std::vector<std::int64_t>& owners);

  const Options& o_;
  core::Context context_;
  EnergyMeter processor_{EnergyMeter::Of::processor}, card_{EnergyMeter::Of::card};
};

} // namespace insitu::bench::paper
