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
    l->set_alpha(l->t_);
    if (l->crosses_) {
      const std::int64_t cell = l->cell_across(l->beyond_);
      if (cell >= 0)
        guessed_.push_back({l, cell});
      else
        crossing_.push_back(l);
    } else if (l->confined_) {
      ask(*l, *l->own_);
    } else {
      l->walked_ = 0;
      const bool proofs_count = l->keeps_ && l->proof_.counts_for(l->x_);
      if (const std::int64_t cell = proofs_count ? l->first_guess() : -1; cell >= 0) {
        guessed_.push_back({l, cell});
        continue;
      }
      LaneVelocity::Kept* const k = proofs_count ? l->first_to_try(l->x_) : nullptr;
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
    const std::int64_t cell = l->next_guess(l->tried_, l->walked_);
    if (cell >= 0)
      guessed_.push_back({l, cell});
    else if (LaneVelocity::Kept* const k = l->other_to_try(l->tried_, l->x_))
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
    g.lane->foresee(g.cell);
  for (const Guessed& g : guessed_)
    g.lane->expect(g.cell);
  for (const Guessed& g : guessed_)
    ask(*g.lane, g.lane->beside(g.cell));
}

void LaneBatch::ask(LaneVelocity& lane, LaneVelocity::Kept& cell) {
  lane.tried_ = &cell;
  lane.blend(cell);
  asked_[row_of(cell.vertices.shape)].push_back({&lane, &cell});
}

void LaneBatch::try_cells() {
  for (std::vector<Asked>& asked : asked_) {
    if (asked.empty())
      continue;
    queries_.resize(asked.size());
    answers_.resize(asked.size());
    for (std::size_t i = 0; i < asked.size(); ++i) {
      const LaneVelocity& l = *asked[i].lane;
      const LaneVelocity::Kept& k = *asked[i].cell;
      // In place: a copy would wait for the parts to be written.
      LaneQuery& query = queries_[i];
      const Vec3d& x = l.crosses_ ? l.beyond_ : l.x_;
      query.point.x = x.x;
      query.point.y = x.y;
      query.point.z = x.z;
      query.vertices = k.vertices.x;
      query.velocity = k.values != 1 ? k.velocity : nullptr;
      if (l.steps_ == 2) {
        query.weights[0] = l.alpha_;
        query.weights[1] = 1.0 - l.alpha_;
      } else if (l.steps_ > 2) {
        std::copy_n(l.step_weights_, most_steps, query.weights);
      }
    }
    invert_lanes(asked.front().cell->vertices.shape, queries_.data(), int(asked.size()),
                 asked.front().lane->steps_, answers_.data());
    for (std::size_t i = 0; i < asked.size(); ++i) {
      LaneVelocity& l = *asked[i].lane;
      LaneVelocity::Kept& k = *asked[i].cell;
      const LaneAnswer& found = answers_[i];
      const bool proven = found.margin > found.error;
      if (l.crosses_) { // see MeshVelocity::locate
        if (proven) {
          ++l.proven_;
          l.beyond_at_ = {k.cell, found.r};
        } else {
          crossing_.push_back(&l);
        }
        continue;
      }
      if (l.confined_) { // see in_own_cell
        l.own_r_ = found.r;
        l.depth_ = l.depth_at(found.r, found.margin);
        l.sampled_ = found.converged && found.margin > -0.5 ? Sampled::inside : Sampled::outside;
      } else if (proven) {
        l.proven_in(&k);
        l.sampled_ = Sampled::inside;
      } else {
        l.found_outside(found.converged, found.r);
        missed_.push_back(&l);
        continue;
      }
      if (l.sampled_ == Sampled::inside) {
        l.hint_ = k.cell;
        const Vec3d r = l.confined_ ? l.on_own_faces(l.x_, found.r, found.error) : found.r;
        if (k.values == 1 || !(r == found.r))
          l.sampled_ = l.value(k, r, l.v_);
        else {
          l.v_ = found.velocity;
          l.sampled_ = LaneVelocity::finite(l.v_) ? Sampled::inside : Sampled::not_finite;
        }
      }
    }
    asked.clear();
  }
}

void LaneBatch::locate() {
  const std::size_t misses = lost_.size(), all = misses + crossing_.size();
  if (all == 0)
    return;
  const LaneVelocity& first = misses > 0 ? *lost_.front() : *crossing_.front();
  // One by one where hints decide, or each has a geometry of its own; or where the batch itself
  // would cost more.
  constexpr std::size_t few = 2;
  if (!first.keeps_ || first.moves_ || all < few) {
    for (LaneVelocity* l : lost_)
      l->sampled_ = l->located(l->x_, l->v_, nullptr);
    for (LaneVelocity* l : crossing_)
      l->beyond_at_ = l->locate(l->beyond_);
    return;
  }
  points_.clear();
  for (const LaneVelocity* l : lost_)
    points_.push_back(l->x_);
  for (const LaneVelocity* l : crossing_)
    points_.push_back(l->beyond_);
  locations_.resize(all);
  sampler_->locate_serial(points_, locations_, first.options());
  for (std::size_t i = 0; i < misses; ++i)
    lost_[i]->note_unguided();
  for (std::size_t i = misses; i < all; ++i)
    crossing_[i - misses]->unguided_ += crossing_[i - misses]->lacks_guide_;
  for (std::size_t i = 0; i < misses; ++i)
    if (!locations_[i])
      locations_[i] = lost_[i]->beside_mesh(lost_[i]->x_);
  for (std::size_t i = 0; i < misses; ++i)
    if (locations_[i])
      lost_[i]->expect(locations_[i].cell);
  for (std::size_t i = 0; i < misses; ++i)
    lost_[i]->sampled_ = lost_[i]->taken(locations_[i], lost_[i]->v_);
  for (std::size_t i = misses; i < all; ++i)
    crossing_[i - misses]->beyond_at_ = locations_[i];
}

} // namespace insitu::advect
