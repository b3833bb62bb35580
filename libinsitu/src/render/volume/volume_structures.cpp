#include <algorithm>
#include <cmath>
#include <optional>

#include "accel/tree/tree.h"
#include "render/structures/structures.h"
#include "render/volume/volume.h"

namespace insitu::render {

namespace {

using math::Vec3d;

/// A look at some cells: how many of all there are, the part of them that nothing shows of, and the
/// part of the mesh's box that their boxes could fill.
struct Look {
  double cells = 0, empty = 0, filled = 1;
};

Look look_at_some(const query::Sampler& sampler, const VolumeSettings& settings) {
  const accel::Tree& tree = sampler.tree();
  const mesh::MeshView& mesh = sampler.mesh();
  constexpr std::int64_t most = 2048;
  const std::int64_t items = tree.cell_count(), count = std::min(items, most);
  const ScalarField& field = settings.field;
  mesh::CellVertices cell;
  std::int64_t empty = 0;
  double volume = 0, cells = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    std::int64_t flat = tree.cells()[i * items / count];
    const std::int32_t p = mesh.piece_of(flat);
    const auto [count_here, first] = mesh.pieces[p].item_cells(flat - mesh.first_cell[p]);
    const double several = double(count_here);
    flat = mesh.first_cell[p] + first; // which has to stand for all
    mesh::gather(mesh, flat, cell);
    double low = HUGE_VAL, high = -HUGE_VAL;
    bool nan = false;
    Vec3d from = cell.x[0], to = cell.x[0];
    for (int v = 0; v < cell.count; ++v) {
      const double f = field.field.association == INSITU_CELL
                           ? field.load(cell.piece, flat - mesh.first_cell[cell.piece])
                           : field.load(cell.piece, cell.ids[v]);
      nan = nan || f != f;
      low = std::min(low, f);
      high = std::max(high, f);
      for (int a = 0; a < 3; ++a) {
        from[a] = std::min(from[a], cell.x[v][a]);
        to[a] = std::max(to[a], cell.x[v][a]);
      }
    }
    const double opacity = nan           ? settings.function.nan_opacity()
                           : low <= high ? settings.function.max_opacity(low, high)
                                         : 0.0;
    const Vec3d d = to - from;
    volume += several * d.x * d.y * d.z;
    if (opacity < TransferFunction::invisible)
      ++empty;
    cells += several;
  }
  Look look;
  const double each = double(items) / double(count);
  look.cells = each * cells;
  look.empty = double(empty) / double(count);
  const Vec3d box = tree.bounds_max() - tree.bounds_min();
  const double of_box = box.x * box.y * box.z;
  look.filled = of_box > 0 ? std::min(1.0, each * volume / of_box) : 1.0;
  return look;
}

bool shows_all(const TransferFunction& function) {
  return function.nan_opacity() > 0 &&
         std::all_of(function.opacity_points().begin(), function.opacity_points().end(),
                     [](const OpacityPoint& p) { return p.opacity > 0; });
}

/// About as many samples as rays will take, if nothing is left out.
double expected_samples(const query::Sampler& sampler, const VolumeSettings& settings,
                        std::int64_t rays) {
  const double step =
      settings.step ? *settings.step : settings.step_factor * typical_cell_size(sampler);
  return double(rays) * 0.5 * mesh_diagonal(sampler) / step;
}

} // namespace

bool skipping_pays(const query::Sampler& sampler, const VolumeSettings& settings, std::int64_t rays,
                   bool culled) {
  if (sampler.tree().empty() || !settings.skip_empty || shows_all(settings.function))
    return false;
  const Look look = look_at_some(sampler, settings);
  // Empty macrocells are those of cells that show nothing, and those without cells.
  const double share = 1 - look.filled * (1 - look.empty);
  if (share < 0.1)
    return false;
  // Reading a cell costs about what locating a sample does, and ten of those that are culled.
  return expected_samples(sampler, settings, rays) * share > (culled ? 10 : 1) * look.cells;
}

VolumeStructures volume_structures(const query::Sampler& sampler, const VolumeSettings& settings,
                                   std::int64_t rays, Structures& structures,
                                   const MacrocellGrid* whole) {
  VolumeStructures found;
  found.counted = {structures.memory(), INSITU_MEMORY_FRAME};
  check(settings);
  if (sampler.tree().empty())
    return found;
  if (settings.culling == Culling::always && !settings.preintegrated)
    found.culled = structures.culled(settings.field, settings.function);
  // With a tolerance macrocells are there in any case.
  const bool is_cheap = found.culled && !settings.tolerance;
  const bool skips = skipping_pays(sampler, settings, rays, is_cheap);
  std::optional<MacrocellGrid> grid; // of both, if steps have levels
  if (settings.tolerance) {
    const mesh::MeshFacts facts = sampler.facts();
    grid = whole ? *whole : level_grid(facts, structures.cell_widths(facts.bounds));
    found.macrocells = &structures.macrocells_with_sizes(settings.field, *grid);
  }
  if (!skips)
    return found;
  const Majorants& majorants =
      structures.majorants(settings.field, settings.function, grid ? &*grid : nullptr);
  // Walking macrocells costs a few percent of what it cannot save.
  if (majorants.empty_share() >= 0.1)
    found.majorants = &majorants;
  return found;
}

} // namespace insitu::render
