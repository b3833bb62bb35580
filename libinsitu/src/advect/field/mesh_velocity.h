#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "advect/field/box.h"
#include "advect/field/cells_beyond.h"
#include "advect/field/face_on_path.h"
#include "advect/integrate/in_time.h"
#include "advect/integrate/integrate.h"
#include "cells/kernels/faces.h"
#include "cells/kernels/kernels.h"
#include "cells/kernels/on_feature.h"
#include "mesh/view.h"
#include "query/proof.h"
#include "query/sampler.h"
#include "query/walk/beside_mesh.h"
#include "query/walk/face_crossing.h"

namespace insitu::advect {

/// The velocity on a mesh between two committed steps, as integrate() asks for it. At time t, with
/// alpha = (t - t0) / (t1 - t0) in [0, 1], a point is located in (1 - alpha) earlier + alpha
/// current coordinates, and its velocity is interpolated at that place through the steps that are
/// given: (1 - alpha) earlier + alpha current velocity through two (TimeInterpolation says what
/// through more); a part of which there is no earlier state is taken as it is now. The last two
/// cells are kept with their vertices and velocities: a point proven to be in one of them needs no
/// more. One object serves one thread.
class MeshVelocity {
public:
  /// What the arguments refer to must outlive the object.
  MeshVelocity(const query::Sampler& sampler, const mesh::FieldView& now,
               const EarlierSteps& earlier, double t0, double t1, insitu_accuracy accuracy);
  ~MeshVelocity() {
    sampler_->count_certified(proven_);
    sampler_->count_unguided(unguided_);
  }
  MeshVelocity(const MeshVelocity&) = delete;
  MeshVelocity& operator=(const MeshVelocity&) = delete;

  /// Points that the last cell does not hold are then looked for in the cells that this guesses; or
  /// null. It must outlive the object. Where cells overlap, another one may answer.
  void walk_by(const CellsBeyond* beyond) {
    beyond_cells_ = beyond && beyond->knows() ? beyond : nullptr;
    lacks_guide_ = keeps_ && beyond && beyond->lacks_neighbours();
  }

  /// Begins with a new particle; hint: its last cell, or -1.
  void begin(std::int64_t hint);
  /// A particle's position in the mesh's frame, as integrate() has it, and back again.
  math::Vec3d enter(const math::Vec3d& position) const { return position; }
  math::Vec3d position(const math::Vec3d& x) const { return x; }

  Sampled operator()(const math::Vec3d& x, double t, math::Vec3d& v) {
    return ask<false>(x, t, v, nullptr);
  }
  /// The same, and where x lies.
  Sampled sample(const math::Vec3d& x, double t, math::Vec3d& v, query::Location& at) {
    return ask<true>(x, t, v, &at);
  }

  /// The cell of the point asked last, if that was inside.
  std::int64_t asked() const { return hint_; }
  void accepted() { cell_ = hint_; }
  /// The point asked last or, where it lies beyond the mesh by rounding at its cell's size and no
  /// more, the place in the mesh that stands for it.
  math::Vec3d kept_inside(const math::Vec3d& x);
  /// The same for where it is at time t, which is that of the point asked last to rounding: so is
  /// the geometry.
  math::Vec3d kept_inside(const math::Vec3d& x, double t);

  /// How much of the current step there is at time t; of the geometry it is 1 if nothing moved.
  double alpha(double t) const { return times_.alpha(t); }
  double geometry_alpha(double t) const { return moves_ ? alpha(t) : 1.0; }
  const query::Sampler& sampler() const { return *sampler_; }
  double interval() const { return times_.interval(); }
  const StepTimes& times() const { return times_; }

  /// The gradient of a component at a place and time, and the change with time of the velocity at a
  /// place in a cell (0 if the earlier velocity is unknown).
  math::Vec3d gradient(const query::Location& at, int component, double t) const;
  math::Vec3d rate_of_change(const query::Location& at, double t) const;
  insitu_accuracy accuracy() const { return accuracy_; }

  /// The cell of the particle's position (flat id), or -1 if it was never inside.
  std::int64_t cell() const { return cell_; }

  /// The bounding box of that cell; an edge far shorter than the others counts as 1e-6 of the
  /// longest.
  math::Vec3d extent();

  // For steps that end at faces: see CellwiseField.
  bool confine(const math::Vec3d& x, const math::Vec3d& towards, double t);
  void release() { confined_ = false; }
  double depth(const math::Vec3d& x, double t);
  double last_depth() const { return depth_; }
  double face_on(const DenseStep& path, double low, double high);
  bool is_inside_before(const DenseStep& path) const {
    return !moves_ && advect::is_inside_before(own_->vertices, along_, path, own_r_);
  }
  Crossed cross(const math::Vec3d& x, const math::Vec3d& towards, double t);
  /// The parts of cross(): a place a little way on from x, and what follows from where that is.
  math::Vec3d beyond(const math::Vec3d& x, const math::Vec3d& towards, double t);
  Crossed crossed(const math::Vec3d& x, const query::Location& at);
  void go_towards(const math::Vec3d& towards) { towards_ = towards; }
  query::Location locate(const math::Vec3d& x);

  /// See ExitingField. On a moving mesh, the face is where it is when the particle reaches it.
  std::optional<query::Exit> leave(const math::Vec3d& a, const math::Vec3d& b, double t, double dt);

  double way_out(const math::Vec3d& a, const math::Vec3d& b, double t);

  /// The steps through which the velocity is interpolated, from 1: the current one alone.
  int velocity_steps() const { return steps_; }
  bool blends_geometry() const { return moves_; }

protected:
  /// A cell with all that is asked of it.
  struct Kept {
    std::int64_t cell = -1;
    std::int64_t opened = -1; ///< the cell whose ids are there, and its data asked for
    double alpha = 1.0;       ///< of vertices.x
    int values = 0;           ///< of the field: vertices, or 1 of a cell field
    mesh::CellVertices vertices;
    Box box;                             ///< of the vertices; of a mesh that moves, of everything
    math::Vec3d now[8], earlier[8];      ///< coordinates, if the mesh moves
    math::Vec3d velocity[most_steps][8]; ///< at the vertices, at each step, the current one first

    bool may_hold(const math::Vec3d& x) const { return cell >= 0 && box.holds(x); }
  };

  void set_alpha(double t) {
    alpha_ = times_.alpha(t);
    if (steps_ > 2)
      times_.weights(t, steps_, step_weights_);
  }
  query::LocateOptions options() const { return {accuracy_, moves_ ? alpha_ : 1.0}; }
  void blend(Kept& k) const {
    if (moves_ && k.alpha != alpha_) {
      k.alpha = alpha_;
      for (int i = 0; i < k.vertices.count; ++i)
        k.vertices.x[i] =
            alpha_ == 1.0 ? k.now[i] : (1.0 - alpha_) * k.earlier[i] + alpha_ * k.now[i];
    }
  }
  Sampled value(const Kept& k, const math::Vec3d& r, math::Vec3d& v) const {
    double weight[8];
    if (k.values == 1)
      weight[0] = 1.0;
    else
      cells::shape_functions(k.vertices.shape, r, weight);
    v = in_time([&](int step) {
      math::Vec3d u = weight[0] * k.velocity[step][0];
      for (int i = 1; i < k.values; ++i)
        u += weight[i] * k.velocity[step][i];
      return u;
    });
    return finite(v) ? Sampled::inside : Sampled::not_finite;
  }
  /// The velocity at the time asked for, from that of each step.
  template <class At>
  math::Vec3d in_time(At&& at) const {
    if (steps_ == 1)
      return at(0);
    if (steps_ == 2)
      return (1.0 - alpha_) * at(1) + alpha_ * at(0);
    math::Vec3d v = step_weights_[0] * at(0);
    for (int step = 1; step < steps_; ++step)
      v += step_weights_[step] * at(step);
    return v;
  }
  static bool finite(const math::Vec3d& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
  }

  template <bool tells_where>
  Sampled ask(const math::Vec3d& x, double t, math::Vec3d& v, query::Location* at) {
    set_alpha(t);
    if (confined_)
      return in_own_cell(x, v, at);
    if (keeps_ && proof_.counts_for(x)) {
      int walked = 0;
      const std::int64_t first = first_guess();
      Kept* k = first >= 0 ? &beside(first) : first_to_try(x);
      for (; k; k = next_to_try(k, x, walked)) {
        blend(*k);
        const auto map = cells::inverse_map(k->vertices.shape, k->vertices.x, x);
        if (map.margin > map.error) {
          proven_in(k);
          if constexpr (tells_where)
            *at = {k->cell, map.r};
          return value(*k, map.r, v);
        }
        found_outside(map.converged, map.r);
      }
    }
    return located(x, v, at);
  }

  // at: where to say where x lies, or null.
  Sampled located(const math::Vec3d& x, math::Vec3d& v, query::Location* at);
  query::Location beside_mesh(const math::Vec3d& x, double least_reach = 0.0);
  Sampled taken(const query::Location& at, math::Vec3d& v);
  Sampled in_own_cell(const math::Vec3d& x, math::Vec3d& v, query::Location* at);
  // Loading a cell in steps, so that many are waited for at once: asks for its ids; has them, and
  // asks for its coordinates and velocities; has all.
  void foresee(std::int64_t cell) const;
  void open(Kept& k, std::int64_t cell) const;
  void load(Kept& k, std::int64_t cell) const;
  Kept& keep(std::int64_t cell);
  /// Opens the cell that will be kept next, if it is not.
  void expect(std::int64_t cell) {
    if (keeps_ && kept_[0]->cell != cell && kept_[1]->cell != cell && can_keep(cell))
      open(*kept_[last_ ^ 1], cell);
  }
  // The kept cells that may hold a point are tried one after the other: the last, and one that is
  // guessed from where the point lies in it, or the other whose box holds it. Each returns null
  // where the sampler has to be asked.
  Kept* first_to_try(const math::Vec3d& x) const {
    Kept* const last = kept_[last_];
    if (beyond_cells_ && beyond_cells_->knows_most() ? last->cell >= 0 : last->may_hold(x))
      return last;
    return kept_[last_ ^ 1]->may_hold(x) ? kept_[last_ ^ 1] : nullptr;
  }
  /// After one that was tried in vain.
  Kept* next_to_try(const Kept* tried, const math::Vec3d& x, int& walked) {
    const std::int64_t cell = next_guess(tried, walked);
    return cell >= 0 ? &beside(cell) : other_to_try(tried, x);
  }
  /// A cell to go on to from one beyond whose faces a point was just found, or -1.
  std::int64_t next_guess(const Kept* tried, int& walked) const {
    if (!beyond_cells_ || !outside_known_ || walked++ == beyond_cells_->most_guesses())
      return -1;
    const std::int64_t cell = next_cell(*tried, outside_, 0.0);
    return cell == kept_[last_]->cell ? -1 : cell;
  }
  /// Before a new particle's first point: its last cell, or -1.
  std::int64_t first_guess() const {
    return kept_[last_]->cell < 0 && hint_ >= 0 && may_own(hint_) ? hint_ : -1;
  }
  Kept* other_to_try(const Kept* tried, const math::Vec3d& x) const {
    Kept* const other = kept_[last_ ^ 1];
    return tried != other && other->may_hold(x) ? other : nullptr;
  }
  /// This cell, kept beside the last one.
  Kept& beside(std::int64_t cell) {
    Kept& k = *kept_[last_ ^ 1];
    if (k.cell != cell)
      load(k, cell);
    return k;
  }
  void proven_in(Kept* k) {
    ++proven_;
    last_ = k == kept_[last_] ? last_ : last_ ^ 1;
    hint_ = k->cell;
  }
  void found_outside(bool converged, const math::Vec3d& r) {
    outside_known_ = converged;
    outside_ = r;
  }
  std::int64_t next_cell(const Kept& from, const math::Vec3d& r, double near) const;
  std::int64_t cell_across(const math::Vec3d& x) const;
  void take_own(std::int64_t cell);
  /// Coordinates in the own cell, exactly on the faces on which x lies, as owners' are.
  math::Vec3d on_own_faces(const math::Vec3d& x, const math::Vec3d& r, double error) const {
    const mesh::CellVertices& c = own_->vertices;
    return cells::is_near_faces(c.shape, r, control::on_face)
               ? cells::put_on_faces_of(c.shape, c.x, x,
                                        cells::put_on_nearest(c.shape, c.x, x, r, error),
                                        control::on_face)
               : r;
  }
  Crossed enter(const math::Vec3d& x, const query::Location& at);
  math::Vec3d own_extent() const { return edges_of(moves_ ? box_of(own_->vertices) : own_->box); }
  unsigned faces_along(const math::Vec3d& x, const math::Vec3d& towards) const;
  double depth_beside(const math::Vec3d& r) const;
  /// How deep in its own cell a point lies, with these coordinates and this margin there.
  double depth_at(const math::Vec3d& r, double margin) const {
    return along_ == 0 ? margin : depth_beside(r);
  }
  bool can_keep(std::int64_t cell) const;
  bool may_own(std::int64_t cell) const;
  /// The sampler is asked for a point that a neighbour might have held.
  void note_unguided() { unguided_ += lacks_guide_ && kept_[last_]->cell >= 0; }

  const query::Sampler* sampler_;
  mesh::FieldView fields_[most_steps]; ///< at each step, the current one first
  StepTimes times_;
  int steps_; ///< of fields_, that serve
  bool moves_;
  query::ProofRule proof_; ///< of all coordinates between the steps
  bool keeps_;             ///< it counts for some points
  insitu_accuracy accuracy_;
  double alpha_ = 1.0;                   ///< of the point asked last
  double step_weights_[most_steps] = {}; ///< the same, through more than two steps
  std::int64_t hint_ = -1;
  std::int64_t cell_ = -1;
  std::int64_t sized_ = -1; ///< the cell whose extent is kept
  math::Vec3d extent_;
  std::int64_t proven_ = 0; ///< points located without the sampler

  std::int64_t unguided_ = 0; ///< points for which the sampler was asked for want of a guide

  const CellsBeyond* beyond_cells_ = nullptr;
  bool lacks_guide_ = false; ///< beyond_cells_ tells little, and a table would be better
  bool outside_known_ = false;
  math::Vec3d outside_; ///< coordinates in the cell that was tried last
  /// A point beyond the mesh by rounding alone, and the place that stands for it.
  math::Vec3d beside_{std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0}, inside_;
  bool landed_ = false;       ///< the particle has just come to a face of the own cell
  double beside_alpha_ = 1.0; ///< of the geometry that this is so in
  Kept cells_[3];
  Kept* kept_[2] = {&cells_[0], &cells_[1]};
  int last_ = 0; ///< of kept_, that which answered last
  bool confined_ = false;
  Kept* own_ = &cells_[2]; ///< the cell that answers while confined
  math::Vec3d own_r_;      ///< in it, of the point asked last
  /// Faces of it, a bit each, along which the particle goes: they are no ends of its way.
  unsigned along_ = 0;
  math::Vec3d towards_; ///< where it goes, at the face that it comes to
  double depth_ = 0.0;
};

} // namespace insitu::advect
