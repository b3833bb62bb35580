#pragma once

#include <optional>
#include <span>
#include <vector>

#include "query/sampler.h"
#include "render/ray_state.h"
#include "render/scalar_field.h"
#include "render/transfer_function.h"

namespace insitu::render {

/// A field drawn as a medium that emits and absorbs.
struct VolumeSettings {
  ScalarField field;
  TransferFunction function;
  /// The distance between samples along a ray: step_factor times typical_cell_size(), or `step`
  /// itself where it is given.
  double step_factor = 0.5;
  std::optional<double> step = std::nullopt;
  /// Length of ray over which the function's opacities hold; 0: a hundredth of the mesh's diagonal.
  double unit_distance = 0;
  insitu_accuracy accuracy = INSITU_STANDARD; ///< of locating the samples
};

/// The median, over up to 4096 cells evenly picked by id, of the cube root of the cell's bounding
/// box's volume; at least 1/16384 of the mesh's diagonal, and 1/256 of it for cells without volume.
double typical_cell_size(const query::Sampler& sampler);

/// Marches rays through a volume. Sample i of a ray stands for the distances from i * step to
/// (i + 1) * step and lies in the middle, whatever the mesh; nothing is gathered outside of cells.
class VolumeMarcher {
public:
  VolumeMarcher(const query::Sampler& sampler, const VolumeSettings& settings);

  double step() const { return step_; }

  /// Sets the ray's samples: those within the tree's bounds, up to its first opaque hit.
  void start(RayState& ray) const;

  /// Gathers the samples of all rays, and those of their hits that lie before each ray's last
  /// sample, in depth order. Returns the number of samples taken.
  std::int64_t march(std::span<RayState> rays) const;

private:
  void add_sample(RayState& ray, std::int64_t index, const ColorSample& sample,
                  std::int64_t cell) const;

  query::Sampler sampler_;
  ScalarField field_;
  query::LocateOptions options_;
  double step_;
  Classifier classifier_;
  math::Vec3d low_, high_;
};

} // namespace insitu::render
