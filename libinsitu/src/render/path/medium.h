#pragma once

#include <cstdint>
#include <vector>

#include "core/memory.h"
#include "core/parallel.h"
#include "query/sampler.h"
#include "render/color/transfer_function.h"
#include "render/structures/scalar_field.h"
#include "render/volume/macrocells.h"

namespace insitu::render {

/// A field as a medium that light collides with. Its extinction, per unit length, of a value v is
/// density * -log(1 - min(opacity(v), largest_opacity)) / unit_distance, so that without scattering
/// a stretch of unit_distance dims by the stated opacity at density 1; its albedo is the transfer
/// function's colour. Outside of cells there is nothing.
class Medium {
public:
  /// unit_distance: in mesh units, above 0. The field and the majorants are of the sampler's mesh;
  /// the extinctions of macrocells are kept as floats, rounded up, counted in memory.
  Medium(const query::Sampler& sampler, const ScalarField& field, const TransferFunction& function,
         double density, double unit_distance, const Majorants& majorants,
         const core::Threads& threads, core::Memory& memory);

  double extinction(double value) const;
  Color albedo(double value) const;
  double value(const query::Location& at) const { return field_.at(sampler_.mesh(), at); }

  const query::Sampler& sampler() const { return sampler_; }
  const MacrocellGrid& grid() const { return grid_; }
  /// An upper bound of the extinction in a macrocell.
  float majorant(std::int64_t macrocell) const { return majorants_[std::size_t(macrocell)]; }
  std::int64_t bytes() const { return std::int64_t(majorants_.bytes()); }

private:
  double extinction_of_opacity(double opacity) const;

  query::Sampler sampler_;
  ScalarField field_;
  TransferFunction function_;
  double scale_;
  MacrocellGrid grid_;
  core::Buffer<float> majorants_;
  ColorTable colors_;
};

} // namespace insitu::render
