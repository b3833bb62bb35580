#pragma once

#include <cstdint>
#include <vector>

#include "query/sampler.h"
#include "render/clip.h"
#include "render/volume/macrocells.h"
#include "render/volume/volume.h"

namespace insitu::render {

/// The shadow that a volume casts on surfaces: how much light comes through it, by samples in the
/// middle of even steps from the ray's origin on, in macrocells that show something. An error of
/// the step, as of marching; of a homogeneous medium half a step's at either end of the mesh.
class VolumeShadow {
public:
  /// The step is that of ray marching without a tolerance. density: factor on the extinction. The
  /// majorants and the clips must outlive it; majorants null: all is sampled.
  VolumeShadow(const query::Sampler& sampler, const VolumeSettings& settings, double density,
               const Majorants* majorants, const std::vector<Clip>& clips);

  /// The share of light that passes from the ray's origin to t_max. samples: adds those located.
  double through(const Ray& ray, double t_max, std::int64_t& samples) const;

private:
  bool follow(const Ray& ray, double from, double to, double& light, std::int64_t& samples) const;

  query::Sampler sampler_;
  ScalarField field_;
  query::LocateOptions options_;
  double step_;
  Classifier classifier_;
  const Majorants* majorants_;
  const std::vector<Clip>& clips_;
  math::Vec3d low_, high_;
};

} // namespace insitu::render
