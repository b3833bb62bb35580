#pragma once

#include <cstdint>
#include <span>

#include "core/memory.h"
#include "core/parallel.h"
#include "query/sampler.h"
#include "render/color/transfer_function.h"
#include "render/structures/place_value.h"
#include "render/structures/scalar_field.h"
#include "render/volume/macrocells.h"
#include "render/volume/volume.h"

namespace insitu::render {

/// Narrows [near, far] to where a ray is within a box, and not endless; false: nowhere.
bool clip_to_box(const Ray& ray, const mesh::Box& box, double& near, double& far);

/// A field as a medium that light collides with. Its extinction, per unit length, of a value v is
/// density * -log(1 - min(opacity(v), largest_opacity)) / unit_distance, so that without scattering
/// a stretch of unit_distance dims by the stated opacity at density 1; its albedo is the transfer
/// function's colour. Outside of cells there is nothing.
class Medium {
public:
  /// Of a volume's settings those of marching (steps, lighting) and culling are not used. The field
  /// and the majorants are of the sampler's mesh, which must outlive it; the extinctions of
  /// macrocells are kept as floats, rounded up, counted in memory. Throws core::Error
  /// (INSITU_ERROR_ARGUMENT) for what is out of range.
  Medium(const query::Sampler& sampler, const VolumeSettings& volume, double density,
         const Majorants& majorants, const core::Threads& threads, core::Memory& memory);

  double extinction(double value) const;
  Color albedo(double value) const;

  /// The value at a place, which is looked for from the cell `hint` on, if it is not -1.
  PlaceValue value_at(const math::Vec3d& place, std::int64_t hint) const {
    return value_at(sampler_.locate(place, hint, options_));
  }
  /// Sets the values at points.
  void find_values(std::span<const math::Vec3d> points, std::span<PlaceValue> found) const;

  const mesh::MeshView& mesh() const { return sampler_.mesh(); }
  /// Of the whole mesh.
  const mesh::Box& bounds() const { return bounds_; }
  const MacrocellGrid& grid() const { return grid_; }
  /// An upper bound of the extinction in a macrocell.
  float majorant(std::int64_t macrocell) const { return majorants_[std::size_t(macrocell)]; }
  std::int64_t bytes() const { return std::int64_t(majorants_.bytes()); }

private:
  double extinction_of_opacity(double opacity) const;
  PlaceValue value_at(const query::Location& at) const {
    return {at.cell, at ? field_.at(sampler_.mesh(), at) : 0.0};
  }

  query::Sampler sampler_;
  mesh::Box bounds_;
  query::LocateOptions options_;
  ScalarField field_;
  TransferFunction function_;
  double scale_;
  MacrocellGrid grid_;
  core::Buffer<float> majorants_;
  ColorTable colors_;
};

} // namespace insitu::render
