#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "accel/locator.h"
#include "core/context.h"
#include "mesh/registered/mesh.h"
#include "workload/mesh.h"

namespace insitu::bench {

/// What a query asks for: the papers time these apart.
enum class Wanted { ids, cell_value, vertex_value };
constexpr int wanted_count = 3;

/// Bytes and primitives of a method's structures.
struct Sizes {
  std::int64_t primitives = 0, bytes = 0;
  std::int64_t peak = 0;       ///< while building in groups of a million primitives
  std::int64_t peak_whole = 0; ///< while building all at once; 0: there are no groups
  double faces_s = 0.0;        ///< to find the faces; 0: the method uses none
};

/// How points were answered, in points.
struct Ways {
  std::int64_t kept = 0;         ///< by the cell that the ray told, certified
  std::int64_t by_neighbour = 0; ///< by the cell across the face; on a device among those kept
  std::int64_t by_tree = 0, on_host = 0;
};

/// A method on a backend, over the fields "f" (vertices) and "c" (cells) of one mesh.
class MethodRunner {
public:
  virtual ~MethodRunner() = default;
  /// Builds; then refits after the vertices moved: seconds of the method's own structures, with
  /// the table of faces (Sizes::faces_s).
  virtual Sizes build(double& build_seconds) = 0;
  virtual double refit() = 0;
  /// The points of the calls below, brought to where the backend reads them.
  virtual void set_points(std::span<const math::Vec3d> points) = 0;
  /// Answers all points, results left there.
  virtual void answer(Wanted wanted, insitu_accuracy accuracy) = 0;
  /// Of the last answer, unless that was `fast`.
  virtual Ways ways() const = 0;
  /// The ids of the last answer, which asked for them.
  virtual void ids(std::vector<std::int64_t>& out) = 0;
};

/// The mesh with its fields, as solvers hold it.
struct MethodMesh {
  workload::Mesh mesh;
  std::vector<double> vertex_field, cell_field;
  void register_with(mesh::Mesh& to) const;
};

std::unique_ptr<MethodRunner> make_cpu_runner(accel::Method method, MethodMesh& mesh,
                                              core::Context& context);
/// Only in builds with CUDA; points and answers stay in device memory.
std::unique_ptr<MethodRunner> make_device_runner(accel::Backend backend, accel::Method method,
                                                 MethodMesh& mesh, core::Context& context);
/// The card and driver, or empty.
std::string device_name();

} // namespace insitu::bench
