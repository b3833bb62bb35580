#include "query/nearest/nearest_cells.h"

#include <algorithm>
#include <cmath>

#include "query/chart_image.h"

namespace insitu::query {

using math::Vec3d;

namespace {

/// The least and the greatest squared distance of a box from a place, with room for the roundings
/// of distances to cells in it.
struct Span {
  double least = 0.0, greatest = 0.0;

  Span(const Vec3d& p, const mesh::Box& box, const Metric& metric) {
    for (int a = 0; a < 3; ++a) {
      const double below = box.low[a] - p[a], above = p[a] - box.high[a];
      const double slack = 0x1p-46 * (std::fabs(below) + std::fabs(above));
      const double beside = metric.scale[a] * std::max({below - slack, above - slack, 0.0});
      const double across = metric.scale[a] * (std::max(-below, -above) + slack);
      least += beside * beside;
      greatest += across * across;
    }
  }
};

Metric metric_at(const geo::ChartUnits& units, double latitude, double true_latitude,
                 double vertical) {
  const geo::Radii radii = geo::radii(geo::sin_cos(units, true_latitude).sin);
  const double height = vertical * units.up_per_unit(), per_unit = units.radians_per_unit();
  return {{(radii.across + height) * std::max(geo::sin_cos(units, latitude).cos, 0.0) * per_unit,
           (radii.along + height) * per_unit, std::fabs(units.up_per_unit())}};
}

} // namespace

Images::Images(const Vec3d& p, const ChartImage* chart) : chart_(chart) {
  if (!chart) {
    at[count++] = p;
    return;
  }
  const Vec3d plain = chart->with_longitude(p);
  const Metric metric_there = metric_at(chart->units, p.y, p.y, p.z);
  for (const double turns : {0.0, -1.0, 1.0}) {
    metric[count] = metric_there;
    at[count++] = {plain.x + turns * chart->units.turn(), plain.y, plain.z};
  }
  pole_ = chart->pole_at(p.y);
  if (pole_ == geo::Pole::none || !(std::abs(p.y) <= chart->units.quarter()))
    return;
  at[count] = chart->turned(pole_, p);
  metric[count] = metric_at(chart->units, at[count].y, p.y, p.z);
  ++count;
}

double Images::squared_to(const Vec3d& x) const {
  const int i = count == 4 ? 3 : 0;
  Vec3d step = (i == 3 ? chart_->turned(pole_, x) : x) - at[i];
  if (chart_)
    step.x = std::remainder(step.x, chart_->units.turn());
  const Vec3d way = metric[i].from({}, step);
  return math::dot(way, way);
}

void visit_near(const accel::Tree& tree, const Vec3d& image, const Metric& metric,
                core::FunctionRef<double()> reach, core::FunctionRef<void(std::int64_t)> visit) {
  struct Waiting {
    double least;
    std::uint32_t at;
    bool is_node;
  };
  if (tree.empty())
    return;
  thread_local std::vector<Waiting> waiting;
  const std::size_t bottom = waiting.size();
  waiting.push_back({0.0, 0, true});
  while (waiting.size() > bottom) {
    const Waiting next = waiting.back();
    waiting.pop_back();
    if (next.least > reach())
      continue;
    if (!next.is_node) {
      visit(tree.cells()[next.at]);
      continue;
    }
    const accel::Node& node = tree.nodes()[next.at];
    const auto begin = std::ptrdiff_t(waiting.size());
    for (int c = 0; c < 8; ++c) {
      if (!node.meta[c])
        continue;
      const double least = Span(image, in_mesh(node.child_box(c), tree.origin()), metric).least;
      if (least > reach())
        continue;
      if (node.is_inner(c))
        waiting.push_back({least, node.child_node(c), true});
      else
        for (int k = 0; k < node.child_cell_count(c); ++k)
          waiting.push_back({least, node.child_cells(c) + std::uint32_t(k), false});
    }
    std::sort(waiting.begin() + begin, waiting.end(),
              [](const Waiting& a, const Waiting& b) { return a.least > b.least; });
  }
}

NearestCells::NearestCells(const Sampler& sampler) : sampler_(sampler), tree_(sampler.tree()) {}

/// The cells that begin at `first`, of which there are many in a run.
void NearestCells::look_at_item(std::int64_t first, const Images& images, int i, double farthest,
                                NearestCell& best) const {
  const Vec3d& image = images.at[i];
  const Metric& metric = images.metric[i];
  const mesh::MeshView& view = sampler_.mesh();
  const mesh::PieceView& piece = view.pieces[view.piece_of(first)];
  mesh::CellVertices cell;
  for (std::int64_t flat = first; flat < first + piece.cells_an_item(); ++flat) {
    if (!sampler_.owns(flat))
      continue;
    mesh::gather(view, flat, cell);
    const double most = std::min(farthest * farthest, best.squared);
    if (Span(image, mesh::box_of(cell), metric).least > most)
      continue;
    const NearestOnCell on = nearest_on_cell(cell.shape, cell.x, image, metric, most);
    if (!on.on)
      continue;
    const double squared = images.is_skewed(i) ? images.squared_to(on.point) : on.squared;
    if (squared > most || (squared == best.squared && best.at && flat > best.at.cell))
      continue;
    best = {squared, {flat, cells::parametric_in(cell.shape, cell.x, on.point, on.on)}, on.point};
  }
}

void NearestCells::look(const Images& images, int i, double farthest, NearestCell& best) const {
  visit_near(
      tree_, images.at[i], images.metric[i],
      [&] { return std::min(farthest * farthest, best.squared); },
      [&](std::int64_t flat) { look_at_item(flat, images, i, farthest, best); });
}

NearestCell NearestCells::find(const Vec3d& p, double farthest) const {
  NearestCell best;
  const Images images(p, sampler_.chart());
  for (int i = 0; i < images.count; ++i)
    if (std::isfinite(images.at[i].x + images.at[i].y + images.at[i].z))
      look(images, i, farthest, best);
  return best;
}

void NearestCells::find(const core::Threads& threads, std::span<const Vec3d> points,
                        double farthest, std::span<NearestCell> found) const {
  threads.parallel_for(std::int64_t(points.size()), 16, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = std::size_t(begin); i < std::size_t(end); ++i)
      found[i] = find(points[i], farthest);
  });
}

void add_ranks_near(const Directory& directory, const Images& images, double farthest,
                    bool nearest_alone, std::vector<int>& ranks) {
  thread_local std::vector<double> least; // [rank]
  constexpr double none = std::numeric_limits<double>::infinity();
  least.assign(std::size_t(directory.size()), none);
  double enough = farthest * farthest;
  for (int rank = 0; rank < directory.size(); ++rank)
    for (const mesh::Box& box : directory.boxes(rank))
      for (int i = 0; i < images.count; ++i) {
        const Span span(images.at[i], box, images.metric[i]);
        least[std::size_t(rank)] = std::min(least[std::size_t(rank)], span.least);
        if (nearest_alone && !images.is_skewed(i)) // each box holds a cell
          enough = std::min(enough, span.greatest);
      }
  for (int rank = 0; rank < directory.size(); ++rank)
    if (least[std::size_t(rank)] < none && least[std::size_t(rank)] <= enough)
      ranks.push_back(rank);
}

} // namespace insitu::query
