#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/box.h"
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

  // Where a mesh is spread over processes (render/processes): all claim a ray's samples, and one of
  // them sees what passes.

  /// The bounds are those of the whole mesh of sampler.facts(), and cells may be few here, or none.
  void take_part();
  struct Claim {
    std::int64_t index, cell; ///< of the sample; flat
    float opacity;            ///< above 0
  };
  /// Adds a ray's samples that show in flat cells below own_cells, by index.
  void claim(const Ray& ray, double t_max, std::int64_t own_cells, std::vector<Claim>& claims,
             std::int64_t& samples) const;
  /// The share of light that passes by the samples of all processes, by index and once each.
  static double through(std::span<const Claim> claims);

private:
  /// Takes the samples from index `first` on; false: the ray ends.
  using Take =
      core::FunctionRef<bool(std::int64_t first, std::span<const query::Location> samples)>;
  void follow(const Ray& ray, double t_max, std::int64_t& samples, const Take& take) const;
  bool follow(const Ray& ray, double from, double to, std::int64_t& samples,
              const Take& take) const;

  query::Sampler sampler_, located_; ///< the latter where places are
  ScalarField field_;
  query::LocateOptions options_;
  double step_;
  Classifier classifier_;
  const Majorants* majorants_;
  const std::vector<Clip>& clips_;
  mesh::Box box_; ///< nothing is outside of it
  bool takes_part_ = false;
};

} // namespace insitu::render
