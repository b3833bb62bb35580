#include "advect/lanes/lanes.h"

#include <algorithm>
#include <utility>

namespace insitu::advect {

using math::Vec3d;

namespace {

/// Place of a shape in a table.
std::size_t row_of(mesh::Shape shape) {
  using mesh::Shape;
  return shape == Shape::tetrahedron ? 0
         : shape == Shape::pyramid   ? 1
         : shape == Shape::wedge     ? 2
         : shape == Shape::voxel     ? 3
                                     : 4;
}

} // namespace

void LaneBatch::answer(std::span<LaneVelocity* const> lanes) {
  missed_.clear();
  crossing_.clear();
  guessed_.clear();
  for (LaneVelocity* l : lanes) {
    l->moment_.set(l->t_);
    if (l->crosses_) {
      const std::int64_t cell = l->cells_.across(l->confined_.coordinates(), l->beyond_);
      if (cell >= 0)
        guessed_.push_back({l, cell});
      else
        crossing_.push_back(l);
    } else if (l->confined_.is_on()) {
      ask(*l, l->cells_.own(l->moment_));
    } else {
      l->walked_ = 0;
      const bool proofs_count = l->cells_.counts_for(l->x_);
      if (const std::int64_t cell = proofs_count ? l->cells_.first_guess(l->hint_) : -1;
          cell >= 0) {
        guessed_.push_back({l, cell});
        continue;
      }
      KeptCell* const k = proofs_count ? l->cells_.first_to_try(l->x_) : nullptr;
      k ? ask(*l, *k) : missed_.push_back(l);
    }
  }
  ask_guessed();
  lost_.clear();
  std::swap(lost_, missed_);
  try_cells();
  while (!missed_.empty()) {
    try_next();
    try_cells();
  }
  locate();
}

/// Each of the missed in the next cell that may hold it, or it is lost.
void LaneBatch::try_next() {
  guessed_.clear();
  for (LaneVelocity* l : missed_) {
    const std::int64_t cell = l->cells_.next_guess(*l->tried_, l->walked_);
    if (cell >= 0)
      guessed_.push_back({l, cell});
    else if (KeptCell* const k = l->cells_.other_to_try(*l->tried_, l->x_))
      ask(*l, *k);
    else
      lost_.push_back(l);
  }
  missed_.clear();
  ask_guessed();
}

/// Many wait for their cells' data at once.
void LaneBatch::ask_guessed() {
  for (const Guessed& g : guessed_)
    g.lane->cells_.foresee(g.cell);
  for (const Guessed& g : guessed_)
    g.lane->cells_.expect(g.cell, g.lane->moment_);
  for (const Guessed& g : guessed_)
    ask(*g.lane, g.lane->cells_.beside(g.cell, g.lane->moment_));
}

void LaneBatch::ask(LaneVelocity& lane, KeptCell& cell) {
  lane.tried_ = &cell;
  cell.move_to(lane.moment_);
  const std::size_t row = row_of(cell.vertices.shape);
  asked_[row].push_back({&lane, &cell});
  using Known = query::SoundCells::Known;
  if (const query::SoundCells* const sound = lane.cells_.sound_cells();
      sound && cell.sound == Known::unknown &&
      (cell.sound = sound->known(cell.cell)) == Known::unknown)
    unsure_[row].push_back({cell.cell, cell.current(lane.moment_), &cell.sound});
}

/// Of the cells that were asked for.
void LaneBatch::find_sound() {
  for (std::size_t row = 0; row < std::size(unsure_); ++row)
    if (!unsure_[row].empty()) {
      const Asked& asked = asked_[row].front();
      asked.lane->cells_.sound_cells()->find(sampler_->mesh().cell_count(),
                                             asked.cell->vertices.shape, unsure_[row]);
      unsure_[row].clear();
    }
}

void LaneBatch::try_cells() {
  find_sound();
  for (std::vector<Asked>& asked : asked_) {
    if (asked.empty())
      continue;
    queries_.resize(asked.size());
    answers_.resize(asked.size());
    for (std::size_t i = 0; i < asked.size(); ++i) {
      const LaneVelocity& l = *asked[i].lane;
      const KeptCell& k = *asked[i].cell;
      // In place: a copy would wait for the parts to be written.
      LaneQuery& query = queries_[i];
      const Vec3d& x = l.crosses_ ? l.beyond_ : l.x_;
      query.point.x = x.x;
      query.point.y = x.y;
      query.point.z = x.z;
      query.vertices = k.vertices.x;
      query.velocity = k.values != 1 ? k.velocity : nullptr;
      if (l.moment_.steps() == 2) {
        query.weights[0] = l.moment_.alpha();
        query.weights[1] = 1.0 - l.moment_.alpha();
      } else if (l.moment_.steps() > 2) {
        std::copy_n(l.moment_.weights(), most_steps, query.weights);
      }
    }
    invert_lanes(asked.front().cell->vertices.shape, queries_.data(), int(asked.size()),
                 asked.front().lane->moment_.steps(), answers_.data());
    for (std::size_t i = 0; i < asked.size(); ++i) {
      LaneVelocity& l = *asked[i].lane;
      KeptCell& k = *asked[i].cell;
      const LaneAnswer& found = answers_[i];
      const bool confined = !l.crosses_ && l.confined_.is_on();
      const Held how = confined ? Held::no : l.cells_.held(k, l.moment_, found.margin, found.error);
      if (l.crosses_) { // see MeshVelocity::locate
        if (how != Held::no) {
          l.cells_.count(how);
          l.beyond_at_ = {k.cell, found.r};
        } else {
          crossing_.push_back(&l);
        }
        continue;
      }
      if (confined) { // see in_own_cell
        l.sampled_ = l.confined_.found(k, found.converged, found.r, found.margin)
                         ? Sampled::inside
                         : Sampled::outside;
      } else if (how != Held::no) {
        l.cells_.answered(k, how);
        l.sampled_ = Sampled::inside;
      } else {
        l.cells_.found_outside(found.converged, found.r);
        missed_.push_back(&l);
        continue;
      }
      if (l.sampled_ == Sampled::inside) {
        l.note_place(l.x_, k, found.r, found.margin, found.error);
        const Vec3d r =
            confined || how == Held::on_boundary
                ? Confinement::on_faces(k, l.x_, found.r, found.error, l.cells_.takes_boundaries())
                : found.r;
        if (k.values == 1 || !(r == found.r))
          l.sampled_ = k.interpolate(r, l.moment_, l.v_);
        else {
          l.v_ = found.velocity;
          l.sampled_ = Moment::is_finite(l.v_) ? Sampled::inside : Sampled::not_finite;
        }
      }
    }
    asked.clear();
  }
}

/// Of a point that a batch did not find.
query::Location LaneBatch::found_elsewhere(const Vec3d& x, double alpha) const {
  const query::Outlook* const outlook = sampler_->outlook();
  return outlook ? outlook->find(x, alpha) : query::Location{};
}

void LaneBatch::locate() {
  const std::size_t misses = lost_.size(), all = misses + crossing_.size();
  if (all == 0)
    return;
  const LaneVelocity& first = misses > 0 ? *lost_.front() : *crossing_.front();
  // One by one where hints decide, or each has a geometry of its own; or where the batch itself
  // would cost more.
  constexpr std::size_t few = 2;
  if (!first.cells_.serves() || first.moment_.moves() || all < few) {
    for (LaneVelocity* l : lost_)
      l->note_elsewhere([&] { l->sampled_ = l->located(l->x_, l->v_, nullptr); });
    for (LaneVelocity* l : crossing_)
      l->note_elsewhere([&] { l->beyond_at_ = l->locate(l->beyond_); });
    return;
  }
  points_.clear();
  for (const LaneVelocity* l : lost_)
    points_.push_back(l->x_);
  for (const LaneVelocity* l : crossing_)
    points_.push_back(l->beyond_);
  locations_.resize(all);
  sampler_->locate_serial(points_, locations_, first.moment_.options());
  for (std::size_t i = 0; i < misses; ++i)
    lost_[i]->cells_.note_unguided(lost_[i]->cells_.last());
  for (std::size_t i = misses; i < all; ++i)
    crossing_[i - misses]->cells_.note_unguided(crossing_[i - misses]->cells_.own());
  for (std::size_t i = 0; i < misses; ++i)
    if (!locations_[i]) {
      LaneVelocity& lost = *lost_[i];
      lost.note_elsewhere([&] {
        locations_[i] = found_elsewhere(lost.x_, lost.moment_.geometry_alpha());
        if (!locations_[i])
          locations_[i] = lost.beside_mesh(lost.x_);
      });
    }
  for (std::size_t i = 0; i < misses; ++i)
    if (locations_[i])
      lost_[i]->cells_.expect(locations_[i].cell, lost_[i]->moment_);
  for (std::size_t i = 0; i < misses; ++i)
    lost_[i]->sampled_ = lost_[i]->taken(locations_[i], lost_[i]->v_);
  for (std::size_t i = misses; i < all; ++i) {
    LaneVelocity& crossing = *crossing_[i - misses];
    crossing.beyond_at_ = locations_[i];
    if (!locations_[i])
      crossing.note_elsewhere([&] {
        crossing.beyond_at_ = found_elsewhere(crossing.beyond_, crossing.moment_.geometry_alpha());
      });
  }
}

} // namespace insitu::advect
