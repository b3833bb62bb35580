#pragma once

#include <cstdint>
#include <optional>

#include "advect/field/cell_cache.h"
#include "advect/field/confinement.h"
#include "advect/field/journey.h"
#include "advect/field/kept_velocity.h"
#include "advect/field/mesh_boundary.h"
#include "advect/field/moment.h"
#include "advect/integrate/integrate.h"

namespace insitu::advect {

/// The velocity on a mesh between two committed steps, as integrate() asks for it: the velocity of
/// a Moment, in the cells of a CellCache, to one of which a Confinement may keep the particle, up
/// to the MeshBoundary. One object serves one thread.
class MeshVelocity {
public:
  /// What the arguments refer to must outlive the object.
  MeshVelocity(const query::Sampler& sampler, const mesh::FieldView& now,
               const EarlierSteps& earlier, double t0, double t1, insitu_accuracy accuracy)
      : moment_(sampler, now, earlier, t0, t1, accuracy), cells_(moment_) {}

  /// See CellCache.
  void walk_by(const CellsBeyond* beyond) { cells_.walk_by(beyond); }
  /// For callers that ask for no more than velocities: on a mesh that moves a particle on a face of
  /// its cell is in that cell, to rounding, whichever cell is the owner there. Ways are then rates.
  void take_boundaries() { cells_.take_boundaries(moment_); }

  /// Begins with a new particle; hint: its last cell, or -1.
  void begin(std::int64_t hint);
  /// See KeptVelocity; go_on_from(): of another object for the same mesh and fields, as it is after
  /// begin().
  KeptVelocity keep() const {
    return {moment_.keep(), cells_.keep(), confined_, boundary_, place_,
            hint_,          cell_,         sized_,    extent_,   {}};
  }
  void go_on_from(const KeptVelocity& kept) {
    moment_.go_on_from(kept.moment);
    cells_.go_on_from(kept.cells, moment_);
    confined_ = kept.confined;
    boundary_ = kept.boundary;
    place_ = kept.place;
    hint_ = kept.hint;
    cell_ = kept.cell;
    sized_ = kept.sized;
    extent_ = kept.extent;
  }

  /// Who takes the particle from process to process, or null; see Journey.
  void travel_by(Journey* journey) { journey_ = journey; }
  Journey* journey() const { return journey_; }

  /// A particle's position in the mesh's frame, as integrate() has it, and back again.
  math::Vec3d enter(const math::Vec3d& position) const { return position; }
  math::Vec3d position(const math::Vec3d& x) const { return x; }
  /// For a particle that comes from a mark, as integrate() has it; and its position there.
  void enter_as(const KeptVelocity&) const {}
  math::Vec3d position_as(const KeptVelocity&, const math::Vec3d& x) const { return x; }

  Sampled operator()(const math::Vec3d& x, double t, math::Vec3d& v) {
    return ask<false>(x, t, v, nullptr);
  }
  /// The same, and where x lies.
  Sampled sample(const math::Vec3d& x, double t, math::Vec3d& v, query::Location& at) {
    return ask<true>(x, t, v, &at);
  }

  /// The cell of the point asked last, if that was inside.
  std::int64_t asked() const { return hint_; }
  void accepted() {
    cell_ = hint_;
    confined_.begin_step();
  }
  /// The cell of the particle's position (flat id), or -1 if it was never inside.
  std::int64_t cell() const { return cell_; }
  /// The bounding box of that cell; an edge far shorter than the others counts as 1e-6 of the
  /// longest.
  math::Vec3d extent();
  /// The point asked last or, where it lies beyond the mesh by rounding at its cell's size and no
  /// more, the place in the mesh that stands for it.
  math::Vec3d kept_inside(const math::Vec3d& x);
  /// The same for where it is at time t, which is that of the point asked last to rounding: so is
  /// the geometry.
  math::Vec3d kept_inside(const math::Vec3d& x, double t);

  // See Moment.
  double alpha(double t) const { return moment_.alpha_at(t); }
  double geometry_alpha(double t) const { return moment_.geometry_alpha_at(t); }
  const query::Sampler& sampler() const { return moment_.sampler(); }
  double interval() const { return times().interval(); }
  const StepTimes& times() const { return moment_.times(); }
  insitu_accuracy accuracy() const { return moment_.accuracy(); }
  int velocity_steps() const { return moment_.steps(); }
  bool blends_geometry() const { return moment_.moves(); }
  math::Vec3d gradient(const query::Location& at, int component, double t) const {
    return moment_.gradient(at, component, t);
  }
  math::Vec3d rate_of_change(const query::Location& at, double t) const {
    return moment_.rate_of_change(at, t);
  }

  // For steps that end at faces: see CellwiseField and Confinement.
  bool confine(const math::Vec3d& x, const math::Vec3d& towards, double t) {
    moment_.set(t);
    return confined_.start(cells_, moment_, x, towards, hint_, place_);
  }
  /// Whether confine() leaves the velocity at the particle as it is.
  bool is_answered() const { return confined_.is_answered(); }
  void release() {
    if (confined_.is_on() && cells_.takes_boundaries())
      cells_.give_back_own();
    confined_.release();
  }
  double depth(const math::Vec3d& x, double t) {
    moment_.set(t);
    return confined_.depth(cells_.own(moment_), x);
  }
  double last_depth() const { return confined_.last_depth(); }
  double face_on(const DenseStep& path, double low, double high) {
    if (moment_.moves()) // and the face with it
      return -1.0;
    return confined_.face_on(cells_.own(), path, low, high);
  }
  bool is_inside_before(const DenseStep& path) const {
    return moment_.moves() ? confined_.stays_clear()
                           : confined_.is_inside_before(cells_.own(), path);
  }
  /// At the end of a way by cells: whether x, the point asked last, is in the own cell, which then
  /// is that of the particle.
  bool stays_in_own(const math::Vec3d& x, double t);
  Crossed cross(const math::Vec3d& x, const math::Vec3d& towards, double t) {
    return crossed(x, locate(beyond(x, towards, t)));
  }
  // The parts of cross().
  math::Vec3d beyond(const math::Vec3d& x, const math::Vec3d& towards, double t) {
    moment_.set(t);
    return confined_.beyond(cells_, moment_, x, towards);
  }
  query::Location locate(const math::Vec3d& x) { return confined_.locate(cells_, moment_, x); }
  Crossed crossed(const math::Vec3d& x, const query::Location& at);
  void go_towards(const math::Vec3d& towards) { confined_.go_towards(towards); }

  /// See ExitingField. On a moving mesh, the face is where it is when the particle reaches it.
  std::optional<query::Exit> leave(const math::Vec3d& a, const math::Vec3d& b, double t, double dt);
  double way_out(const math::Vec3d& a, const math::Vec3d& b, double t);

protected:
  template <bool tells_where>
  Sampled ask(const math::Vec3d& x, double t, math::Vec3d& v, query::Location* at) {
    moment_.set(t);
    if (confined_.is_on())
      return in_own_cell(x, v, at);
    Sampled sampled;
    const auto found = [&](const KeptCell& k, const auto& map, Held how) {
      note_place(x, k, map.r, map.margin, map.error);
      const math::Vec3d r =
          how == Held::inside ? map.r : Confinement::on_faces(k, x, map.r, map.error, true);
      if constexpr (tells_where)
        *at = {k.cell, r};
      sampled = k.interpolate(r, moment_, v);
    };
    if (cells_.counts_for(x) && cells_.prove(x, hint_, moment_, found))
      return sampled;
    return located(x, v, at);
  }

  /// A kept cell answers for x, the point asked last.
  void note_place(const math::Vec3d& x, const KeptCell& k, const math::Vec3d& r, double margin,
                  double error) {
    hint_ = k.cell;
    place_.cell = k.cell;
    place_.x = x;
    place_.alpha = moment_.geometry_alpha();
    place_.r = r;
    place_.margin = margin;
    place_.error = error;
  }
  bool is_kept_in_mesh(const math::Vec3d& x);
  bool is_beside_kept(const math::Vec3d& x);
  // where: the place at which to say where x lies, or null.
  Sampled in_own_cell(const math::Vec3d& x, math::Vec3d& v, query::Location* where);
  Sampled located(const math::Vec3d& x, math::Vec3d& v, query::Location* where);
  Sampled taken(const query::Location& at, math::Vec3d& v);
  /// See MeshBoundary.
  query::Location beside_mesh(const math::Vec3d& x, double least_reach = 0.0) {
    return boundary_.beside(moment_, x, cell_ >= 0 ? cell_ : hint_, least_reach);
  }

  Moment moment_; ///< of the point asked last
  CellCache cells_;
  Confinement confined_;
  MeshBoundary boundary_;
  PlaceInCell place_;       ///< of the point asked last, if a kept cell answered
  std::int64_t hint_ = -1;  ///< the cell of the point asked last
  std::int64_t cell_ = -1;  ///< the cell of the particle's position
  std::int64_t sized_ = -1; ///< the cell whose extent is kept
  math::Vec3d extent_;
  Journey* journey_ = nullptr;
};

} // namespace insitu::advect
