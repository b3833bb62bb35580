#include <algorithm>
#include <cmath>

#include "accel/tree.h"
#include "render/structures.h"
#include "render/volume.h"

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
    const std::int64_t flat = tree.cells()[i * items / count];
    mesh::gather(mesh, flat, cell); // of a gridlet its first cell, which has to stand for all
    const double several = double(mesh.pieces[cell.piece].cells_an_item());
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
    empty += opacity < TransferFunction::invisible;
    const Vec3d d = to - from;
    volume += several * d.x * d.y * d.z;
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

} // namespace

bool skipping_pays(const query::Sampler& sampler, const VolumeSettings& settings,
                   std::int64_t rays) {
  if (sampler.tree().empty() || !settings.skip_empty)
    return false;
  bool shows_all = settings.function.nan_opacity() > 0;
  for (const OpacityPoint& p : settings.function.opacity_points())
    shows_all = shows_all && p.opacity > 0;
  if (shows_all)
    return false;
  const Look look = look_at_some(sampler, settings);
  // Empty macrocells are those of cells that show nothing, and those without cells.
  const double share = 1 - look.filled * (1 - look.empty);
  if (share < 0.1)
    return false;
  // Reading a cell costs about what locating a sample does.
  const double step =
      settings.step ? *settings.step : settings.step_factor * typical_cell_size(sampler);
  const double samples = double(rays) * 0.5 * mesh_diagonal(sampler) / step;
  return samples * share > look.cells;
}

VolumeStructures volume_structures(const query::Sampler& sampler, const VolumeSettings& settings,
                                   std::int64_t rays, Structures& structures) {
  VolumeStructures found;
  check(settings);
  if (sampler.tree().empty())
    return found;
  const bool skips = skipping_pays(sampler, settings, rays);
  if (settings.tolerance)
    found.macrocells = &structures.macrocells_with_sizes(settings.field);
  if (!skips)
    return found;
  const Majorants& majorants = structures.majorants(settings.field, settings.function);
  // Walking macrocells costs a few percent of what it cannot save.
  if (majorants.empty_share() >= 0.1)
    found.majorants = &majorants;
  return found;
}

} // namespace insitu::render
