#include "render/surface/isosurface.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "accel/camera_rays/ray_traversal.h"
#include "core/status.h"
#include "mesh/box.h"
#include "render/surface/tiles/isosurface_rays.h"

namespace insitu::render {

namespace {

using math::Vec3d;

/// Hits of one surface in two cells, nearer than this times the ray's length in them, are one.
constexpr double twin_distance = 1e-9;
/// Cells that wait for a ray alone before they are searched.
constexpr int lone_pairs = 4;

std::uint64_t next_number() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

bool same_scalar(const ScalarField& a, const ScalarField& b) {
  return a.field.pieces == b.field.pieces && a.field.association == b.field.association &&
         range_component(a) == range_component(b);
}

void check(const IsosurfaceSettings& s) {
  const std::string name = std::string("isosurface of '") + s.field.field.name + "': ";
  if (s.values.empty())
    throw core::Error(INSITU_ERROR_ARGUMENT, name + "no value given");
  for (const double v : s.values)
    if (!std::isfinite(v))
      throw core::Error(INSITU_ERROR_ARGUMENT, name + "a value is not finite");
  if (!(s.opacity >= 0 && s.opacity <= 1))
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      name + "opacity " + std::to_string(s.opacity) + "; 0 to 1 expected");
  if (s.field.component >= s.field.field.components)
    throw core::Error(INSITU_ERROR_FIELD, name + "component " + std::to_string(s.field.component) +
                                              " asked for, " +
                                              std::to_string(s.field.field.components) + " held");
}

} // namespace

unsigned IsosurfaceTracer::Group::needed(std::uint32_t node) const {
  unsigned children = 0;
  for (const Level& level : levels)
    children |= ranges->may_contain(node, level.low, level.high);
  return children;
}

IsosurfaceTracer::IsosurfaceTracer(const query::Sampler& sampler,
                                   const std::vector<IsosurfaceSettings>& settings,
                                   Structures& structures, bool lit)
    : sampler_(sampler), number_(next_number()), lit_(lit) {
  for (const IsosurfaceSettings& s : settings) {
    check(s);
    auto group = std::find_if(groups_.begin(), groups_.end(),
                              [&](const Group& g) { return same_scalar(g.source, s.field); });
    if (group == groups_.end()) {
      group = groups_.emplace(groups_.end());
      group->source = group->field = s.field;
    }
    for (const double v : s.values) {
      group->levels.push_back(
          {v, accel::float_below(v), accel::float_above(v), std::int32_t(surfaces_.size()), &s});
      surfaces_.push_back({&s, std::size_t(group - groups_.begin()), v});
    }
  }
  is_exact_ = std::all_of(settings.begin(), settings.end(), [](const IsosurfaceSettings& s) {
    return s.search == RootSearch::exact;
  });
  for (Group& group : groups_) {
    group.has_blank_cells =
        group.source.field.association == INSITU_CELL && group.source.field.has_blanks;
    if (group.source.field.association == INSITU_CELL)
      group.field = structures.average(group.source).field();
    group.ranges = &structures.value_ranges(group.field);
    for (const Level& level : group.levels)
      if (lit && level.settings->normals == Normals::smooth) {
        group.gradients = &structures.gradients(group.field);
        group.around = &structures.vertex_cells();
      }
  }
}

bool IsosurfaceTracer::Group::load(std::int32_t piece, std::int64_t cell, const std::int64_t* ids,
                                   int n, double* values) const {
  if (has_blank_cells && std::isnan(source.load(piece, cell)))
    return false; // averages of the cells around are none of its
  double sum = 0;
  for (int v = 0; v < n; ++v) {
    values[v] = field.load(piece, ids[v]);
    sum += values[v] - values[0];
  }
  return std::isfinite(sum);
}

SurfaceHit IsosurfaceTracer::hit_of(const LevelHit& root, double extent, std::int64_t flat,
                                    const Level& level) {
  SurfaceHit hit;
  hit.t = root.t;
  hit.cell = flat;
  hit.surface = level.surface;
  hit.opacity = float(level.settings->opacity);
  hit.extent = extent;
  hit.parametric = root.parametric;
  hit.gradient = root.gradient;
  return hit;
}

bool IsosurfaceTracer::keep(const SurfaceHit& hit, Search& search) {
  if (hit.t > search.t_max + twin_distance * hit.extent)
    return false;
  if (search.stays && !stays_at(*search.stays, hit.t))
    return true; // cut away: the ray goes on
  search.hits.push_back(hit);
  if (hit.opacity < 1)
    return true;
  search.t_max = search.any ? -1.0 : std::min(search.t_max, hit.t);
  return false;
}

void IsosurfaceTracer::search_by_ray(std::int64_t flat, const Group& group, const Level& level,
                                     const cells::RaySpace& space, double t_min, double t_max,
                                     const core::FunctionRef<bool(const SurfaceHit&)>& found,
                                     SurfaceCounts& counts) const {
  mesh::CellVertices cell;
  mesh::gather(sampler_.mesh(), flat, cell);
  double values[8];
  for (int v = 0; v < cell.count; ++v)
    values[v] = group.field.load(cell.piece, cell.ids[v]);
  CellRoots roots(cell, space, t_min, t_max);
  roots.find(
      values, level.value,
      [&](const LevelHit& root) { return found(hit_of(root, roots.extent(), flat, level)); },
      RootSearch::exact);
  counts.evaluations += roots.evaluations();
}

void IsosurfaceTracer::test_cell(std::int64_t flat, Search& search) const {
  ++search.counts.cells_tested;
  const mesh::MeshView& mesh = sampler_.mesh();
  mesh::CellVertices cell;
  cell.piece = mesh.piece_of(flat);
  const mesh::PieceView& piece = mesh.pieces[cell.piece];
  const std::int64_t local = flat - mesh.first_cell[cell.piece];
  cell.shape = piece.shape(local);
  cell.count = piece.vertex_ids(local, cell.ids);
  std::optional<CellRoots>
      roots; // most cells below a candidate leaf end before their points are read
  for (const Group& group : groups_) {
    double values[8];
    if (!group.load(cell.piece, local, cell.ids, cell.count, values))
      continue;
    const auto [low, high] = std::minmax_element(values, values + cell.count);
    for (const Level& level : group.levels) {
      if (!(*low <= level.value && level.value <= *high))
        continue;
      if (!roots) {
        mesh::gather_points(piece, local, cell);
        roots.emplace(cell, search.space, search.t_min, search.t_max);
      }
      if (!roots->meets())
        return;
      roots->find(
          values, level.value,
          [&](const LevelHit& root) {
            return keep(hit_of(root, roots->extent(), flat, level), search);
          },
          level.settings->search);
    }
  }
  if (roots)
    search.counts.evaluations += roots->evaluations();
}

Color IsosurfaceTracer::color(const SurfaceHit& hit) const {
  const IsosurfaceSettings& settings = *surfaces_[std::size_t(hit.surface)].settings;
  if (const Color* constant = std::get_if<Color>(&settings.color))
    return *constant;
  const ColorByField& by = std::get<ColorByField>(settings.color);
  return by.function.color(by.field.at(sampler_.mesh(), {hit.cell, hit.parametric}));
}

Vec3d IsosurfaceTracer::gradient(const SurfaceHit& hit, const Vec3d& p,
                                 SurfaceCounts& counts) const {
  const Surface& surface = surfaces_[std::size_t(hit.surface)];
  switch (surface.settings->normals) {
  case Normals::smooth: {
    const Group& group = groups_[surface.group];
    return group.gradients->at(sampler_.mesh(), group.field, *group.around, hit.cell,
                               hit.parametric);
  }
  case Normals::central: {
    const double half = half_length(hit);
    PlaceValue values[places_about];
    for (int i = 0; i < places_about && half > 0; ++i, ++counts.evaluations)
      values[i] = value_at(hit.surface, place_about(p, half, i), hit.cell);
    return central_gradient(hit.surface, half, values);
  }
  case Normals::cell:
    break;
  }
  return hit.gradient;
}

bool IsosurfaceTracer::is_central(std::int32_t surface) const {
  return surface >= 0 && surface < surface_count() &&
         surfaces_[std::size_t(surface)].settings->normals == Normals::central;
}

double IsosurfaceTracer::half_length(const SurfaceHit& hit) const {
  mesh::CellVertices cell;
  mesh::gather(sampler_.mesh(), hit.cell, cell);
  const Vec3d size = mesh::box_of(cell).size();
  return 0.5 * std::cbrt(size.x * size.y * size.z);
}

Vec3d IsosurfaceTracer::place_about(const Vec3d& p, double half, int number) {
  Vec3d place = p;
  place[number / 2] += number % 2 == 0 ? -half : half;
  return place;
}

PlaceValue IsosurfaceTracer::value_at(std::int32_t surface, const Vec3d& place,
                                      std::int64_t hint) const {
  const query::Location at = sampler_.locate(place, hint);
  if (!at)
    return {};
  const ScalarField& field = groups_[surfaces_[std::size_t(surface)].group].field;
  return {at.cell, field.at(sampler_.mesh(), at)};
}

/// One-sided where the mesh ends.
Vec3d IsosurfaceTracer::central_gradient(std::int32_t surface, double half,
                                         std::span<const PlaceValue, places_about> values) const {
  const double level = surfaces_[std::size_t(surface)].value;
  Vec3d gradient;
  for (int a = 0; a < 3; ++a) {
    const PlaceValue &below = values[std::size_t(2 * a)], &above = values[std::size_t(2 * a + 1)];
    const double length = (below.cell >= 0 ? half : 0.0) + (above.cell >= 0 ? half : 0.0);
    if (length > 0)
      gradient[a] =
          ((above.cell >= 0 ? above.value : level) - (below.cell >= 0 ? below.value : level)) /
          length;
  }
  return gradient;
}

IsosurfaceTracer::Search IsosurfaceTracer::search_of(const Ray& ray,
                                                     const std::vector<Stretch>* stays,
                                                     std::vector<SurfaceHit>& hits,
                                                     SurfaceCounts& counts) const {
  constexpr double farthest = std::numeric_limits<double>::max();
  return {cells::RaySpace(ray),
          stays,
          stays ? stays->front().from : 0.0,
          stays ? std::min(stays->back().to, farthest) : farthest,
          hits,
          counts};
}

void IsosurfaceTracer::trace(const Ray& ray, std::vector<SurfaceHit>& hits, SurfaceCounts& counts,
                             const std::vector<Stretch>* stays) const {
  collect(ray, hits, counts, stays);
  LastCell none;
  settle(hits, none);
}

void IsosurfaceTracer::collect(const Ray& ray, std::vector<SurfaceHit>& hits, SurfaceCounts& counts,
                               const std::vector<Stretch>* stays) const {
  hits.clear();
  if (stays && stays->empty())
    return;
  Search search = search_of(ray, stays, hits, counts);
  const auto ended = [](int) {};
  std::optional<RayCells> side_by_side;
  if (is_exact_) {
    side_by_side.emplace(*this, lone_pairs, ended);
    side_by_side->add_ray(search, nullptr);
  }
  accel::for_each_cell_along_ray(
      sampler_.tree(), ray.origin, ray.direction, search.t_min, search.t_max,
      [&](std::uint32_t node) { return needed(node); },
      [&](std::int64_t item) {
        for_each_cell(item, search, [&](std::int64_t flat) {
          if (side_by_side)
            side_by_side->add(flat, 1);
          else
            test_cell(flat, search);
        });
        return search.t_max;
      });
  if (side_by_side)
    side_by_side->flush();
}

unsigned IsosurfaceTracer::needed(std::uint32_t node) const {
  unsigned children = 0;
  for (const Group& group : groups_)
    children |= group.needed(node);
  return children;
}

void IsosurfaceTracer::settle(std::vector<SurfaceHit>& hits, LastCell& last) const {
  put_in_order(hits);
  complete(hits, last);
}

void IsosurfaceTracer::put_in_order(std::vector<SurfaceHit>& hits) {
  std::sort(hits.begin(), hits.end(), [](const SurfaceHit& a, const SurfaceHit& b) {
    if (a.t != b.t)
      return a.t < b.t;
    return a.surface != b.surface ? a.surface < b.surface : a.cell < b.cell;
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const SurfaceHit& hit = hits[i];
    bool twin = false;
    for (std::size_t k = kept; k-- > 0 && !twin;) {
      SurfaceHit& other = hits[k];
      if (hit.t - other.t > twin_distance * std::max(hit.extent, other.extent))
        break;
      if (other.surface != hit.surface || other.cell == hit.cell)
        continue;
      twin = true;
      if (hit.cell < other.cell)
        other = hit;
    }
    if (!twin)
      hits[kept++] = hit;
  }
  hits.resize(kept);
  // Nothing shows behind the first opaque hit.
  for (std::size_t i = 0; i < hits.size(); ++i)
    if (hits[i].opacity >= 1) {
      hits.resize(i + 1);
      break;
    }
}

void IsosurfaceTracer::complete(std::span<SurfaceHit> hits, LastCell& last) const {
  for (SurfaceHit& hit : hits)
    if (lit_ && std::isnan(hit.gradient.x)) {
      if (last.surface != hit.surface || last.flat != hit.cell) {
        last.surface = hit.surface;
        last.flat = hit.cell;
        mesh::CellVertices cell;
        mesh::gather(sampler_.mesh(), hit.cell, cell);
        const ScalarField& field = groups_[surfaces_[std::size_t(hit.surface)].group].field;
        double values[8];
        for (int v = 0; v < cell.count; ++v)
          values[v] = field.load(cell.piece, cell.ids[v]);
        last.cell = TrilinearCell(cell.shape, cell.x, values);
      }
      hit.gradient = last.cell.gradient(hit.parametric);
    }
}

} // namespace insitu::render
