#include "advect/lanes.h"

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
  for (LaneVelocity* l : lanes) {
    l->set_alpha(l->t_);
    if (l->crosses_) {
      crossing_.push_back(l);
      continue;
    }
    if (l->confined_)
      ask(*l, l->own_);
    else if (!try_kept(*l, l->last_) && !try_kept(*l, l->last_ ^ 1))
      missed_.push_back(l);
  }
  try_cells();
  // Those that the last cell does not hold, though its box does, may still be in the one before.
  again_.clear();
  std::swap(again_, missed_);
  for (LaneVelocity* l : again_)
    if (l->tried_ != l->last_ || !try_kept(*l, l->last_ ^ 1))
      missed_.push_back(l);
  try_cells();
  locate();
}

void LaneBatch::ask(LaneVelocity& lane, LaneVelocity::Kept& cell) {
  lane.blend(cell);
  asked_[row_of(cell.vertices.shape)].push_back({&lane, &cell});
}

bool LaneBatch::try_kept(LaneVelocity& lane, int which) {
  lane.tried_ = which;
  LaneVelocity::Kept& k = lane.kept_[which];
  if (!lane.keeps_ || !k.may_hold(lane.x_))
    return false;
  ask(lane, k);
  return true;
}

void LaneBatch::try_cells() {
  for (std::vector<Asked>& asked : asked_) {
    if (asked.empty())
      continue;
    queries_.clear();
    answers_.resize(asked.size());
    for (const Asked& a : asked) {
      const LaneVelocity& l = *a.lane;
      const bool at_vertices = a.cell->values != 1;
      LaneQuery query{l.x_, a.cell->vertices.x, at_vertices ? a.cell->velocity : nullptr, {}};
      if (l.steps_ == 2) {
        query.weights[0] = l.alpha_;
        query.weights[1] = 1.0 - l.alpha_;
      } else {
        std::copy_n(l.step_weights_, most_steps, query.weights);
      }
      queries_.push_back(query);
    }
    invert_lanes(asked.front().cell->vertices.shape, queries_.data(), int(asked.size()),
                 asked.front().lane->steps_, answers_.data());
    for (std::size_t i = 0; i < asked.size(); ++i) {
      LaneVelocity& l = *asked[i].lane;
      LaneVelocity::Kept& k = *asked[i].cell;
      const LaneAnswer& found = answers_[i];
      if (l.confined_) { // see in_own_cell
        l.depth_ = l.depth_at(found.r, found.margin);
        l.sampled_ = found.converged && found.margin > -0.5 ? Sampled::inside : Sampled::outside;
      } else if (found.margin > found.error) {
        ++l.proven_;
        l.last_ = l.tried_;
        l.sampled_ = Sampled::inside;
      } else {
        missed_.push_back(&l);
        continue;
      }
      if (l.sampled_ == Sampled::inside) {
        l.hint_ = k.cell;
        if (k.values == 1)
          l.sampled_ = l.value(k, found.r, l.v_);
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
  const std::size_t misses = missed_.size(), all = misses + crossing_.size();
  if (all == 0)
    return;
  const LaneVelocity& first = misses > 0 ? *missed_.front() : *crossing_.front();
  // One by one where hints decide, or each has a geometry of its own; or where the batch itself
  // would cost more.
  constexpr std::size_t few = 2;
  if (!first.keeps_ || first.moves_ || all < few) {
    for (LaneVelocity* l : missed_)
      l->sampled_ = l->located(l->x_, l->v_, nullptr);
    for (LaneVelocity* l : crossing_)
      l->beyond_at_ = l->locate(l->beyond_);
    return;
  }
  points_.clear();
  for (const LaneVelocity* l : missed_)
    points_.push_back(l->x_);
  for (const LaneVelocity* l : crossing_)
    points_.push_back(l->beyond_);
  locations_.resize(all);
  sampler_->locate_serial(points_, locations_, first.options());
  for (std::size_t i = 0; i < misses; ++i)
    missed_[i]->sampled_ = missed_[i]->taken(locations_[i], missed_[i]->v_);
  for (std::size_t i = misses; i < all; ++i)
    crossing_[i - misses]->beyond_at_ = locations_[i];
}

} // namespace insitu::advect
