#include "advect/effects/sides.h"

#include <limits>

#include "core/status.h"
#include "query/walk/longitudes.h"

namespace insitu::advect {

namespace {

void join(Box& box, const mesh::Box& other) {
  box.extend({other.low, other.high});
}

/// The box of all of them.
Box whole_box(const mesh::MeshView& mesh, const core::Threads& threads) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Box all{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  for (const Box& box : query::over_boxes(mesh, threads, all, join))
    join(all, box);
  return all;
}

} // namespace

Sides sides_of(const query::Sampler& sampler, const BoundaryEffect& boundary,
               const core::Threads& threads) {
  if (!boundary.any_periodic())
    return {};
  if (!sampler.chart())
    return Sides(whole_box(sampler.mesh(), threads), boundary.periodic);
  if (boundary.periodic[1] || boundary.periodic[2])
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      "tracer: on a mesh in longitude and latitude periodic sides are those along "
                      "x, its western and eastern ones: no others are as long as each other");
  const mesh::MeshView& mesh = sampler.among_images().mesh();
  for (std::int32_t p = 0; p < mesh.piece_count; ++p)
    if (geo::Pole(mesh.pieces[p].pole) != geo::Pole::none)
      throw core::Error(INSITU_ERROR_UNSUPPORTED,
                        "tracer: periodic sides are not for meshes with cells at a pole");
  parallel::SerialWorld alone;
  return meridians_of(sampler, threads, alone);
}

Sides meridians_of(const query::Sampler& sampler, const core::Threads& threads,
                   parallel::World& world) {
  const query::ChartImage* const chart = sampler.chart();
  const auto found = query::longitudes_of(sampler.among_images().mesh(), chart, threads, world);
  if (!found || !chart)
    return {};
  Box box;
  box.low.x = found->low;
  box.high.x = found->high;
  return Sides(box, {true, false, false}, chart->units.turn());
}

} // namespace insitu::advect
