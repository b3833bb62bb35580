/// The step before a change of topology, where it is spread over processes.
#include <algorithm>
#include <limits>

#include "commit/earlier/adaptive_cells.h"
#include "commit/earlier/earlier_mesh.h"
#include "commit/earlier/gathered_adaptive.h"
#include "commit/halo/cells_near.h"
#include "core/status.h"
#include "query/directory.h"

namespace insitu::commit {

using math::Vec3d;
using mesh::CellName;
using parallel::Parcel;

/// Knows where others had cells that are not here.
class EarlierMesh::Beyond final : public query::Outlook {
public:
  Beyond(std::vector<mesh::Box> here, query::Directory others, int rank)
      : here_(std::move(here)), others_(std::move(others)), rank_(rank) {}

  bool is_beyond(const Vec3d& point) const override {
    return std::ranges::none_of(here_, [&](const mesh::Box& box) { return box.holds(point); }) &&
           !ranks_at(point, 0.0).empty();
  }
  query::Location find(const Vec3d& point, double alpha) const override {
    return asked_ && is_beyond(point) ? asked_->find(point, alpha) : query::Location{};
  }
  std::optional<Vec3d> nearest(const Vec3d& point, double reach, double alpha) const override {
    return asked_ && is_beyond(point) ? asked_->nearest(point, reach, alpha) : std::nullopt;
  }
  std::vector<int> ranks_at(const Vec3d& point, double) const override {
    std::vector<int> ranks;
    for (int r = 0; r < others_.size(); ++r)
      if (r != rank_ && others_.may_hold(r, point))
        ranks.push_back(r);
    return ranks;
  }
  void ask(const query::Outlook* who) const override { asked_ = who; }

private:
  std::vector<mesh::Box> here_;
  query::Directory others_;
  int rank_;
  mutable const query::Outlook* asked_ = nullptr;
};

namespace {

/// The boxes of a view's first cells that are this process's, exactly, of many that follow each
/// other.
std::vector<mesh::Box> exact_boxes(const mesh::MeshView& view, std::int64_t cells) {
  constexpr auto most = std::int64_t(query::Directory::most_boxes);
  const std::int64_t grain = std::max<std::int64_t>((cells + most - 1) / most, 1);
  std::vector<mesh::Box> boxes;
  std::int64_t last = -1; // of the box that is made
  mesh::CellVertices c;
  for (std::int64_t flat = 0; flat < cells; ++flat) {
    const std::int32_t piece = view.piece_of(flat);
    if (!view.pieces[piece].owns(flat - view.first_cell[piece]))
      continue;
    mesh::gather(view, flat, c);
    const mesh::Box box = mesh::box_of(c);
    if (flat / grain == last)
      boxes.back().extend(box);
    else
      boxes.push_back(box);
    last = flat / grain;
  }
  return boxes;
}

bool are_same(const query::ChartImage& a, const query::ChartImage& b) {
  return a.units == b.units && a.west == b.west && a.north_from == b.north_from &&
         a.south_from == b.south_from;
}

/// The chart on which the processes that have the step before have it; units: of all. Collective.
query::ChartImage chart_before(const std::optional<query::ChartImage>& here,
                               const geo::ChartUnits& units, parallel::World& world) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  query::ChartImage chart{units, infinity, infinity, infinity};
  if (here)
    chart = *here;
  double least[] = {chart.west, chart.north_from, chart.south_from};
  world.reduce(std::span(least), parallel::Reduction::least);
  chart.west = least[0];
  chart.north_from = least[1];
  chart.south_from = least[2];
  return chart;
}

/// Adds boxes of images on a chart that hold what a box on the one that followed it holds.
void add_images(const mesh::Box& box, const query::ChartImage& now, const query::ChartImage& before,
                std::vector<mesh::Box>& to) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double turn = now.units.turn(), quarter = now.units.quarter();
  const double last = now.west + 1.5 * turn, south = now.west + 13.0 / 6 * turn; // as pole_of()
  const auto add = [&](double west, double east, double low, double high) {
    to.push_back({{west, low, box.low.z}, {east, high, box.high.z}});
  };
  const auto add_pole = [&](geo::Pole pole) {
    add(before.offset(pole) - 0.3 * turn, before.offset(pole) + 0.3 * turn, -infinity, infinity);
  };
  const double rounding = 1e-9 * quarter;
  bool north_too = false, south_too = false;
  if (box.low.x <= last) {
    for (const double by : {-turn, 0.0, turn})
      add(box.low.x + by, std::min(box.high.x, last) + by, box.low.y, box.high.y);
    north_too = box.high.y >= before.north_from - rounding;
    south_too = box.low.y <= before.south_from + rounding;
  }
  if (box.high.x > last && box.low.x <= south) {
    add(before.west - turn, before.west + 1.5 * turn, now.north_from - rounding, quarter);
    north_too = true;
  }
  if (box.high.x > south) {
    add(before.west - turn, before.west + 1.5 * turn, -quarter, now.south_from + rounding);
    south_too = true;
  }
  if (north_too)
    add_pole(geo::Pole::north);
  if (south_too)
    add_pole(geo::Pole::south);
}

} // namespace

const Adaptive* EarlierMesh::adaptive() const {
  return dynamic_cast<const Adaptive*>(made_.get());
}

CellsKind EarlierMesh::kind() const {
  return told_ ? told_kind_ : adaptive() ? kind_of(*adaptive()) : CellsKind::cells;
}

DualReach EarlierMesh::reach() const {
  if (gathered_)
    return gathered_->reach();
  const DualCells* const dual = adaptive() ? adaptive()->dual_cells() : nullptr;
  return dual ? DualReach{&dual->dual().corners(), &dual->places()} : DualReach{};
}

/// This process's own cells that meet the boxes, ascending.
std::vector<std::int64_t> EarlierMesh::own_cells_in(std::span<const mesh::Box> boxes) const {
  const mesh::MeshView& view = *view_;
  std::vector<std::int64_t> cells;
  mesh::CellVertices c;
  for (const std::int64_t item : cells_near(view, tree_, boxes)) {
    const std::int32_t p = view.piece_of(item);
    const mesh::PieceView& piece = view.pieces[p];
    for (std::int64_t flat = item; flat < item + piece.cells_an_item() && flat < own_.cells;
         ++flat) {
      if (!piece.owns(flat - view.first_cell[p]))
        continue;
      mesh::gather(view, flat, c);
      const mesh::Box box = mesh::box_of(c);
      if (std::ranges::any_of(boxes, [&](const mesh::Box& of) { return mesh::meet(of, box); }))
        cells.push_back(flat);
    }
  }
  return cells;
}

/// Of these cells and vertices, flat.
void EarlierMesh::tell_values(std::span<const std::int64_t> cells,
                              std::span<const std::int64_t> vertices, mesh::EarlierStep& to) const {
  const mesh::MeshView& view = *view_;
  for (const auto& field : step_.fields) {
    const bool of_cells = field->association == INSITU_CELL;
    const std::int64_t* const first = of_cells ? view.first_cell : view.first_vertex;
    const mesh::FieldView from = field->view(0);
    std::vector<double> values;
    for (const std::int64_t item : of_cells ? cells : vertices) {
      const auto p = std::upper_bound(first, first + view.piece_count + 1, item) - first - 1;
      for (int c = 0; c < field->components; ++c)
        values.push_back(from.pieces[p].load(item - first[p], c));
    }
    to.fields.push_back({field->name, field->association, field->components, {std::move(values)}});
  }
}

/// This process's own cells that meet the boxes, with all that was kept of them.
EarlierCells EarlierMesh::cells_in(std::span<const mesh::Box> boxes) const {
  if (told_)
    return told_->in(boxes);
  const mesh::MeshView& view = *view_;
  const Adaptive* const adaptive = this->adaptive();
  const std::vector<std::int64_t> cells = own_cells_in(boxes);
  EarlierCells told;
  for (const std::int64_t flat : cells) {
    const std::int32_t p = view.piece_of(flat);
    mesh::CellVertices c;
    mesh::gather(view, flat, c);
    CellName& name = told.names.emplace_back();
    const StandIn::Place at =
        own_.places.empty() ? StandIn::Place{flat} : own_.places[std::size_t(flat)];
    if (adaptive)
      name = name_of(*adaptive, own_, flat);
    else
      name = {own_.global.empty() ? -1 : own_.global[std::size_t(at.own)],
              -1,
              0,
              at.own,
              at.chart,
              at.copy};
    told.types.push_back(std::uint8_t(c.shape));
    told.poles.push_back(view.pieces[p].pole);
    for (int v = 0; v < c.count; ++v) {
      told.ids.push_back(view.first_vertex[p] + c.ids[v]);
      told.step.points.push_back(c.x[v]);
    }
    told.offsets.push_back(std::int64_t(told.ids.size()));
  }
  std::vector<std::int64_t> order(told.ids.size()), vertices;
  for (std::size_t k = 0; k < order.size(); ++k)
    order[k] = std::int64_t(k);
  std::ranges::sort(order, {}, [&](std::int64_t k) { return told.ids[std::size_t(k)]; });
  std::vector<Vec3d> points;
  for (const std::int64_t k : order) {
    std::int64_t& id = told.ids[std::size_t(k)];
    if (vertices.empty() || vertices.back() != id) {
      vertices.push_back(id);
      points.push_back(told.step.points[std::size_t(k)]);
    }
    id = std::int64_t(vertices.size()) - 1;
  }
  told.step.points = std::move(points);
  tell_values(cells, vertices, told.step);
  if (kind() >= CellsKind::leaves_by_places)
    add_places(*adaptive, view, cells, boxes, told);
  return told;
}

/// Of adaptive cells that were gathered, and are found by their places.
EarlierMesh::EarlierMesh(EarlierCells& cells, std::unique_ptr<GatheredAdaptive> gathered,
                         core::Memory& memory, const core::Threads& threads)
    : step_{core::Buffer<Vec3d>(memory, INSITU_MEMORY_EARLIER), {}}, gathered_(std::move(gathered)),
      locator_(&gathered_->locator()), view_(&gathered_->view()), tree_(memory),
      topology_version_(0) {
  step_.fields = fields_of(cells.step, *view_, memory);
  tree_.build(*view_, threads, accel::Builder::automatic);
  tree_.mark_odd(*view_, {}, threads);
  tree_.release_scratch();
}

/// The cells are right by construction.
void EarlierMesh::know_sound(const core::Threads& threads) {
  own_view_.free_of_folds = own_view_.covers_once = true;
  tree_.mark_odd(own_view_, {}, threads);
  sound_.reset();
}

std::unique_ptr<EarlierMesh> EarlierMesh::gathered(const EarlierMesh* here, const accel::Tree& now,
                                                   const query::ChartImage* chart,
                                                   parallel::World& world, core::Memory& memory,
                                                   const core::Threads& threads) {
  std::int64_t facts[] = {here ? std::int64_t(here->kind()) : 0, chart != nullptr,
                          here && here->view_->is_flat};
  world.reduce(std::span(facts), parallel::Reduction::greatest);
  const auto kind = CellsKind(facts[0]);
  std::optional<query::ChartImage> before;
  if (facts[1])
    before = chart_before(here ? here->chart_ : std::nullopt,
                          chart ? chart->units : geo::ChartUnits{}, world);
  std::vector<mesh::Box> wanted, own;
  world.agree_after([&] {
    if (here) {
      here->fit_.complete();
      own = exact_boxes(*here->view_, here->own_.cells);
    }
    const auto want = [&](const mesh::Box& box, bool is_now) {
      const Vec3d little = 0.05 * box.size(); // steps are tried beside cells, too
      const mesh::Box wider{box.low - little, box.high + little};
      if (is_now && chart && !are_same(*chart, *before))
        add_images(wider, *chart, *before, wanted);
      else
        wanted.push_back(wider);
    };
    for (const mesh::Box& box : query::boxes_of(now))
      want(box, true);
    for (const mesh::Box& box : own)
      want(box, false);
  });
  query::Directory all, owned;
  all.gather(wanted, world);
  owned.gather(own, world);
  std::vector<Parcel> parcels;
  world.agree_after([&] {
    for (int r = 0; r < world.size() && here; ++r)
      parcels.push_back(here->cells_in(all.boxes(r)).parcel(r));
  });
  const std::vector<Parcel> received = world.exchange(parcels);
  EarlierCells cells;
  std::unique_ptr<GatheredDual> dual;
  world.agree_after([&] {
    std::vector<EarlierCells> parts;
    for (const Parcel& parcel : received)
      parts.push_back(EarlierCells::read(parcel));
    cells = EarlierCells::joined(parts);
    if (kind == CellsKind::dual_by_places) {
      dual = std::make_unique<GatheredDual>(memory);
      dual->build(cells, threads);
    }
  });
  if (dual)
    dual->share(here ? here->reach() : DualReach{}, world);
  std::unique_ptr<EarlierMesh> mesh;
  world.agree_after([&] {
    if (kind != CellsKind::cells) {
      mesh = of_adaptive(cells, kind, std::move(dual), facts[2] != 0, memory, threads);
    } else {
      mesh::CellsCopy copy = cells.copy(memory, threads);
      copy.set_one_mesh(before.has_value());
      copy.set_flat(facts[2] != 0);
      mesh = restored(cells.step, std::move(copy), before, memory, threads);
    }
    if (!mesh)
      return;
    mesh->beyond_ = std::make_shared<Beyond>(std::move(wanted), std::move(owned), world.rank());
    if (mesh->gathered_)
      mesh->gathered_->watch_by(mesh->beyond_.get());
  });
  return mesh;
}

} // namespace insitu::commit
