#include "render/processes/whole_macrocells.h"

#include <optional>

#include "accel/tree/tree.h"

namespace insitu::render {

CellWidths whole_widths(parallel::World& world, const query::Sampler& sampler,
                        Structures& structures) {
  CellWidths widths{};
  world.agree_after([&] { widths = structures.cell_widths(sampler.facts().bounds); });
  world.reduce(std::span(widths), parallel::Reduction::sum);
  return widths;
}

Macrocells whole_macrocells(parallel::World& world, const query::Sampler& sampler,
                            const ScalarField& field, const MacrocellGrid& grid, bool with_sizes,
                            Structures& structures) {
  std::vector<std::int64_t> extremes;
  world.agree_after([&] {
    extremes = sampler.tree().empty() ? Macrocells::no_extremes(grid, with_sizes)
               : with_sizes           ? structures.macrocells_with_sizes(field, grid).extremes()
                                      : structures.macrocells(field, &grid).extremes();
  });
  world.reduce(std::span(extremes), parallel::Reduction::least);
  std::optional<Macrocells> whole;
  world.agree_after([&] { whole.emplace(grid, extremes, structures.memory()); });
  return std::move(*whole);
}

} // namespace insitu::render
