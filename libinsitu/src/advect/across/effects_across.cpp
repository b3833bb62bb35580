#include "advect/across/effects_across.h"

namespace insitu::advect {

void share_effects(parallel::World& world, const query::Sampler& sampler,
                   const core::Threads& threads, std::optional<EffectSetup>& setup) {
  if (!setup)
    return;
  // A process without cells may lack the fields of effects.
  double greatest[] = {setup->largest.x,          setup->largest.y,
                       setup->largest.z,          setup->sides.box().high.x,
                       setup->sides.box().high.y, setup->sides.box().high.z};
  double least[] = {setup->sides.box().low.x, setup->sides.box().low.y, setup->sides.box().low.z};
  world.reduce(std::span(greatest), parallel::Reduction::greatest);
  world.reduce(std::span(least), parallel::Reduction::least);
  setup->largest = {greatest[0], greatest[1], greatest[2]};
  if (const std::optional<BoundaryEffect>& boundary = setup->effects.boundary;
      boundary && boundary->any_periodic()) {
    std::int64_t on_chart = sampler.chart() != nullptr;
    world.reduce(std::span(&on_chart, 1), parallel::Reduction::greatest);
    if (on_chart) {
      setup->sides = meridians_of(sampler, threads, world);
      return;
    }
    setup->sides = Sides({{least[0], least[1], least[2]}, {greatest[3], greatest[4], greatest[5]}},
                         boundary->periodic);
  }
}

} // namespace insitu::advect
