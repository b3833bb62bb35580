#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <span>

#include "advect/effects/drift.h"
#include "advect/field/chart_motion.h"
#include "advect/field/mesh_velocity.h"

namespace insitu::advect {

/// The velocity on a geodetic mesh: metres per second east, north and up in the field, rates of
/// ChartMotion's coordinates for integrate(), lengths in metres. One object serves one thread.
class ChartVelocity {
public:
  /// As MeshVelocity's; the sampler has a chart. drifts: added, in metres per second.
  ChartVelocity(const query::Sampler& sampler, const mesh::FieldView& now,
                const EarlierSteps& earlier, double t0, double t1, insitu_accuracy accuracy,
                std::span<const Drift> drifts = {})
      : images_(sampler.among_images()), space_(sampler.chart()), motion_(sampler.chart()),
        inner_(images_, now, earlier, t0, t1, accuracy), drifts_(drifts) {}

  void walk_by(const CellsBeyond* beyond) { inner_.walk_by(beyond); }
  void begin(std::int64_t hint) {
    inner_.begin(hint);
    sized_ = -1;
    confined_ = false;
  }
  /// A particle's position in the mesh's frame, as integrate() has it, and back again.
  math::Vec3d enter(const math::Vec3d& position) {
    known_.x.x = std::numeric_limits<double>::quiet_NaN();
    return motion_.enter(position);
  }
  math::Vec3d position(const math::Vec3d& x) const { return motion_.position(x); }
  /// For a particle that comes from a mark; and its position there.
  void enter_as(const KeptVelocity& kept) {
    known_.x.x = std::numeric_limits<double>::quiet_NaN();
    motion_.go_by(geo::Pole(kept.chart.pole));
  }
  math::Vec3d position_as(const KeptVelocity& kept, const math::Vec3d& x) const {
    ChartMotion there = motion_;
    there.go_by(geo::Pole(kept.chart.pole));
    return there.position(x);
  }

  // Over several processes: see MeshVelocity.
  void travel_by(Journey* journey) { inner_.travel_by(journey); }
  Journey* journey() const { return inner_.journey(); }
  KeptVelocity keep() const {
    KeptVelocity kept = inner_.keep();
    kept.chart = {sized_,
                  extent_,
                  known_.x,
                  known_.image,
                  anchor_.x,
                  anchor_.image,
                  std::int8_t(motion_.pole()),
                  confined_};
    return kept;
  }
  void go_on_from(const KeptVelocity& kept) {
    inner_.go_on_from(kept);
    sized_ = kept.chart.sized;
    extent_ = kept.chart.extent;
    known_ = {kept.chart.known_x, kept.chart.known_image};
    anchor_ = {kept.chart.anchor_x, kept.chart.anchor_image};
    motion_.go_by(geo::Pole(kept.chart.pole));
    confined_ = kept.chart.confined;
  }
  /// From now on positions are in the coordinates in which another mesh's velocity has them.
  void go_by(const ChartVelocity& other) {
    if (!motion_.go_by(other.motion_))
      return;
    known_.x.x = std::numeric_limits<double>::quiet_NaN();
    sized_ = -1;
  }

  Sampled operator()(const math::Vec3d& x, double t, math::Vec3d& v) {
    math::Vec3d image, metres;
    if (confined_)
      image = on_sheet(x);
    else if (!motion_.image(x, image))
      return Sampled::outside;
    query::Location at;
    Sampled sampled;
    sampled = drifts_.empty() ? inner_(image, t, metres) : inner_.sample(image, t, metres, at);
    if (sampled == Sampled::outside && motion_.is_west_by_rounding(x) && inner_.cell() >= 0) {
      image.x = motion_.west();
      sampled = inner_.sample(image, t, metres, at);
    }
    if (sampled != Sampled::inside)
      return sampled;
    for (const Drift& drift : drifts_)
      metres += drift_at(drift, at, t, x, image);
    return of_rates(sampled, motion_.rates(x, image, pole_of(inner_.asked()), metres), v);
  }
  void accepted() { inner_.accepted(); }
  std::int64_t cell() const { return inner_.cell(); }
  /// See MeshVelocity; kept_at: of a point among the cells.
  math::Vec3d kept_at(const math::Vec3d& point) { return inner_.kept_inside(point); }
  math::Vec3d kept_inside(const math::Vec3d& x) {
    return kept(x, [&](const math::Vec3d& image) { return inner_.kept_inside(image); });
  }
  math::Vec3d kept_inside(const math::Vec3d& x, double t) {
    return kept(x, [&](const math::Vec3d& image) { return inner_.kept_inside(image, t); });
  }

  /// Between two steps of integrate().
  void settle(math::Vec3d& x, math::Vec3d& rate) {
    const math::Vec3d image = confined_ ? on_sheet(x) : math::Vec3d{};
    if (motion_.settle(x, rate))
      sized_ = -1;
    if (confined_)
      anchor_ = {x, image};
  }
  double length(const math::Vec3d& x, const math::Vec3d& d) const { return motion_.length(x, d); }

  /// Of the cell of the particle's position, in its coordinates; see ChartMotion.
  math::Vec3d extent() {
    if (sized_ != inner_.cell()) {
      sized_ = inner_.cell();
      mesh::CellVertices c;
      mesh::gather(images_.mesh(), sized_, c);
      extent_ = motion_.extent(c, pole_of(sized_));
    }
    return extent_;
  }

  // See CellwiseField. The own cell is asked in its sheet of images, wherever its way leads.
  bool confine(const math::Vec3d& x, const math::Vec3d& towards, double t) {
    math::Vec3d image;
    release();
    if (!motion_.image(x, image) || !inner_.confine(image, direction(x, image, towards), t))
      return false;
    anchor_ = {x, image};
    return confined_ = true;
  }
  void release() {
    confined_ = false;
    inner_.release();
  }
  double depth(const math::Vec3d& x, double t) { return inner_.depth(on_sheet(x), t); }
  double last_depth() const { return inner_.last_depth(); }
  Crossed cross(const math::Vec3d& x, const math::Vec3d& towards, double t) {
    math::Vec3d from = on_sheet(x), image;
    const math::Vec3d on = inner_.beyond(from, direction(x, from, towards), t);
    const math::Vec3d there = motion_.from_image(x, from, on);
    query::Location at;
    if (motion_.image(there, image)) {
      at = inner_.locate(image);
      if (space_.is_other_sheet(on, image)) {
        from = image;
        inner_.go_towards(direction(there, image, towards));
      }
    }
    const Crossed crossed = inner_.crossed(from, at);
    if (crossed == Crossed::into_next)
      anchor_ = {there, image};
    return crossed;
  }

  /// See ExitingField. The normal is that of the face in the coordinates of the cells.
  std::optional<query::Exit> leave(const math::Vec3d& a, const math::Vec3d& b, double t,
                                   double dt) {
    math::Vec3d from;
    if (!motion_.image(a, from))
      return std::nullopt;
    auto exit = inner_.leave(from, motion_.along(a, from, b), t, dt);
    if (exit) {
      const math::Vec3d image = exit->inside;
      exit->inside = motion_.from_image(a, from, image);
      known_ = {exit->inside, image};
      if (a.z == b.z && !blends_geometry()) // at a wall, rounding of the exit is no way down
        if (const math::Vec3d level{image.x, image.y, a.z};
            images_.locate(level, exit->owner, {inner_.accuracy()}))
          known_.image = level;
    }
    return exit;
  }

  double geometry_alpha(double t) const { return inner_.geometry_alpha(t); }
  int velocity_steps() const { return inner_.velocity_steps(); }
  bool blends_geometry() const { return inner_.blends_geometry(); }

  // Points among the cells, for a Mover: see DriftVelocity.
  Space space() const { return space_; }
  bool point(const math::Vec3d& x, math::Vec3d& point) const {
    if (x == known_.x) { // on a face, where it was left, and not beside it by rounding
      point = known_.image;
      return true;
    }
    return motion_.image(x, point);
  }
  math::Vec3d place(const math::Vec3d& point) {
    known_ = {motion_.enter_image(point), point};
    sized_ = -1;
    return known_.x;
  }
  /// The point's place in the mesh's frame; nothing changes by that.
  math::Vec3d in_frame(const math::Vec3d& point) const {
    ChartMotion there = motion_;
    const math::Vec3d x = there.enter_image(point);
    return there.position(x);
  }
  /// Whether a point's place comes back as that of a cell, in the mesh's frame too.
  bool comes_back(const math::Vec3d& point, std::int64_t cell, double alpha) {
    const math::Vec3d x = place(point);
    if (!motion_.is_turned())
      return true;
    const query::LocateOptions options{inner_.accuracy(), alpha};
    math::Vec3d image;
    return motion_.image(x, image) && images_.locate(image, cell, options) &&
           motion_.image(motion_.enter(motion_.position(x)), image) &&
           images_.locate(image, cell, options);
  }
  Sampled sample(const math::Vec3d& point, double t, math::Vec3d& v, query::Location& at) {
    if (const Sampled s = inner_.sample(point, t, v, at); s != Sampled::inside)
      return s;
    for (const Drift& drift : drifts_) {
      const math::Vec3d u = velocity_of(drift, images_, at, inner_.times(), t);
      v += is_field_of_vectors(drift) ? u : space_.from_east_north(point, u);
    }
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z) ? Sampled::inside
                                                                          : Sampled::not_finite;
  }
  const MeshVelocity& flow() const { return inner_; }
  math::Vec3d rate_of_change(const query::Location& at, double t) const {
    return inner_.rate_of_change(at, t);
  }
  math::Vec3d gradient(const query::Location& at, int component, double t) const {
    return inner_.gradient(at, component, t);
  }

private:
  static Sampled of_rates(Sampled sampled, const math::Vec3d& rates, math::Vec3d& v) {
    v = rates;
    const bool finite = std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    return sampled == Sampled::inside && !finite ? Sampled::not_finite : sampled;
  }

  /// Where x is kept, by the image that inside(image) keeps.
  template <class Inside>
  math::Vec3d kept(const math::Vec3d& x, Inside&& inside_of) {
    math::Vec3d image;
    if (confined_)
      image = on_sheet(x);
    else if (!motion_.image(x, image))
      return x;
    const bool is_west =
        !confined_ && motion_.is_west_by_rounding(x) && !images_.locate(image, cell());
    if (is_west)
      image.x = motion_.west();
    const math::Vec3d inside = inside_of(image);
    if (inside == image && !is_west)
      return x;
    const math::Vec3d y = is_west ? inside : motion_.from_image(x, image, inside);
    known_ = {y, inside};
    return y;
  }

  geo::Pole pole_of(std::int64_t cell) const {
    const mesh::MeshView& mesh = images_.mesh();
    return geo::Pole(mesh.pieces[mesh.piece_of(cell)].pole);
  }

  math::Vec3d on_sheet(const math::Vec3d& x) const {
    return motion_.along(anchor_.x, anchor_.image, x);
  }
  /// Where a way goes from an image of x.
  math::Vec3d direction(const math::Vec3d& x, const math::Vec3d& image,
                        const math::Vec3d& towards) {
    const double cells = cells_crossed(towards, extent());
    const double part = cells > 0.0 && std::isfinite(cells) ? 1e-3 / cells : 0.0;
    return motion_.along(x, image, x + part * towards) - image;
  }

  static bool is_field_of_vectors(const Drift& drift) {
    return drift.field && drift.field->now.components > 1;
  }

  /// Along the east and north of the image's chart, as fields of three components are there.
  math::Vec3d drift_at(const Drift& drift, const query::Location& at, double t,
                       const math::Vec3d& x, const math::Vec3d& image) const {
    const math::Vec3d v = velocity_of(drift, images_, at, inner_.times(), t);
    return is_field_of_vectors(drift) ? v : motion_.turned(x, image, pole_of(at.cell), v);
  }

  query::Sampler images_;
  Space space_;
  ChartMotion motion_;
  MeshVelocity inner_; ///< at images
  std::span<const Drift> drifts_;
  std::int64_t sized_ = -1; ///< the cell whose extent is kept
  math::Vec3d extent_;
  struct Imaged {
    math::Vec3d x, image;
  };
  Imaged known_{{std::numeric_limits<double>::quiet_NaN(), 0, 0}, {}}; ///< a place, and its image
  bool confined_ = false;                                              ///< to one cell
  Imaged anchor_;                                                      ///< on its sheet
};

} // namespace insitu::advect
