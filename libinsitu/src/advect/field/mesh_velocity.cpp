#include "advect/field/mesh_velocity.h"

#include <utility>

namespace insitu::advect {

using math::Vec3d;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
/// So far beyond a face, in cells, that it goes along, a particle is still in its own cell.
constexpr double beyond_along = 10.0 * control::on_face;

} // namespace

MeshVelocity::MeshVelocity(const query::Sampler& sampler, const mesh::FieldView& now,
                           const EarlierSteps& earlier, double t0, double t1,
                           insitu_accuracy accuracy)
    : sampler_(&sampler), fields_{now}, times_(t0, t1, earlier.before),
      steps_(times_.usable(1 + earlier.fields.size())),
      moves_(sampler.mesh().earlier_points && t1 != t0),
      proof_(sampler.mesh(), sampler.tree(), {accuracy, moves_ ? 0.0 : 1.0}),
      keeps_(proof_.for_some()), accuracy_(accuracy) {
  for (int step = 1; step < steps_; ++step)
    fields_[step] = earlier.fields[std::size_t(step - 1)];
}

void MeshVelocity::begin(std::int64_t hint) {
  const std::int64_t cells = sampler_->mesh().cell_count();
  hint_ = hint < cells ? hint : -1; // the mesh may have become smaller
  cell_ = sized_ = -1;
  confined_ = false;
  // What is kept of another particle's way must not decide where cells overlap.
  kept_[0]->cell = kept_[1]->cell = kept_[0]->opened = kept_[1]->opened = own_->opened = -1;
}

MeshVelocity::Kept& MeshVelocity::keep(std::int64_t cell) {
  for (int i = 0; i < 2; ++i)
    if (kept_[i]->cell == cell) {
      last_ = i;
      return *kept_[i];
    }
  last_ ^= 1;
  load(*kept_[last_], cell);
  return *kept_[last_];
}

/// By the sampler: the point is in no cell that is kept, or cannot be proven to be.
Sampled MeshVelocity::located(const Vec3d& x, Vec3d& v, query::Location* where) {
  note_unguided();
  query::Location at = sampler_->locate(x, keeps_ ? -1 : hint_, options());
  if (!at)
    at = beside_mesh(x);
  if (where)
    *where = at;
  return taken(at, v);
}

/// Of a point that no cell holds: where it is in the mesh, if it is beyond it by rounding alone.
/// Not of one that was never in a cell.
query::Location MeshVelocity::beside_mesh(const Vec3d& x, double least_reach) {
  Vec3d inside = x;
  const double reach =
      std::max(least_reach,
               query::rounding_in(sampler_->mesh(), cell_ >= 0 ? cell_ : hint_, options().alpha));
  const query::Location at = query::bring_inside(*sampler_, inside, reach, options());
  if (at) {
    beside_ = x;
    beside_alpha_ = alpha_;
    inside_ = inside;
  }
  return at;
}

Vec3d MeshVelocity::kept_inside(const Vec3d& x) {
  if (x == beside_ && (!moves_ || alpha_ == beside_alpha_))
    return inside_;
  // What goes along faces of its own cell may be beyond the mesh by rounding; what has come to a
  // face, by what it may stop short of or beyond it.
  const bool landed = std::exchange(landed_, false);
  if (!confined_ || (along_ == 0 && !landed && depth_ > control::on_face))
    return x;
  for (Kept* k : {own_, kept_[0], kept_[1]})
    if (k->cell >= 0) {
      blend(*k);
      if (cells::decide(k->vertices.shape, k->vertices.x, x))
        return x;
    }
  if (sampler_->locate(x, own_->cell, options()))
    return x;
  const Vec3d extent = own_extent();
  const double cells = 2.0 * (along_ != 0 ? beyond_along : control::on_face);
  return beside_mesh(x, cells * std::max({extent.x, extent.y, extent.z})) ? inside_ : x;
}

Vec3d MeshVelocity::kept_inside(const Vec3d& x, double t) {
  const Vec3d y = kept_inside(x);
  if (!moves_ || alpha(t) == alpha_)
    return y;
  set_alpha(t);
  return sampler_->locate(y, cell_, options()) || !beside_mesh(y) ? y : inside_;
}

/// The velocity at a place that was located, whose cell is kept.
Sampled MeshVelocity::taken(const query::Location& at, Vec3d& v) {
  if (!at)
    return Sampled::outside;
  hint_ = at.cell;
  if (keeps_ && can_keep(at.cell)) {
    Kept& k = keep(at.cell);
    return value(k, at.parametric, v);
  }
  double u[3 * most_steps];
  sampler_->interpolate(std::span(fields_, std::size_t(steps_)), at, u);
  v = in_time([&](int step) { return Vec3d{u[3 * step], u[3 * step + 1], u[3 * step + 2]}; });
  return finite(v) ? Sampled::inside : Sampled::not_finite;
}

Vec3d MeshVelocity::gradient(const query::Location& at, int component, double t) const {
  const auto of = [&](int step) {
    return sampler_->gradient(fields_[step], component, at, geometry_alpha(t));
  };
  if (steps_ == 1)
    return of(0);
  double w[most_steps];
  times_.weights(t, steps_, w);
  Vec3d sum = w[0] * of(0);
  for (int step = 1; step < steps_; ++step)
    sum += w[step] * of(step);
  return sum;
}

Vec3d MeshVelocity::rate_of_change(const query::Location& at, double t) const {
  if (steps_ == 1)
    return {};
  double u[3 * most_steps], w[most_steps];
  sampler_->interpolate(std::span(fields_, std::size_t(steps_)), at, u);
  times_.rates(t, steps_, w);
  Vec3d sum;
  for (int step = 0; step < steps_; ++step)
    sum += w[step] * Vec3d{u[3 * step], u[3 * step + 1], u[3 * step + 2]};
  return sum;
}

Vec3d MeshVelocity::extent() {
  if (sized_ != cell_) {
    sized_ = cell_;
    for (const Kept* k : {own_, kept_[last_]})
      if (!moves_ && k->cell == cell_) {
        extent_ = edges_of(k->box);
        return extent_;
      }
    mesh::CellVertices c;
    mesh::gather(sampler_->mesh(), cell_, c, moves_ ? alpha_ : 1.0);
    extent_ = edges_of(box_of(c));
  }
  return extent_;
}

// ---------------------------------------------------------------------------- faces

/// The cell's own interpolation goes on for half a cell beyond its faces.
Sampled MeshVelocity::in_own_cell(const Vec3d& x, Vec3d& v, query::Location* where) {
  blend(*own_);
  const auto map = cells::inverse_map(own_->vertices.shape, own_->vertices.x, x);
  own_r_ = map.r;
  depth_ = depth_at(map.r, map.margin);
  if (!map.converged || !(map.margin > -0.5))
    return Sampled::outside;
  hint_ = own_->cell;
  const Vec3d r = on_own_faces(x, map.r, map.error);
  if (where)
    *where = {own_->cell, r};
  return value(*own_, r, v);
}

double MeshVelocity::depth(const Vec3d& x, double t) {
  set_alpha(t);
  blend(*own_);
  const auto map = cells::inverse_map(own_->vertices.shape, own_->vertices.x, x);
  own_r_ = map.r;
  return map.converged ? depth_at(map.r, map.margin) : -1.0;
}

double MeshVelocity::face_on(const DenseStep& path, double low, double high) {
  if (moves_) // and the face with it
    return -1.0;
  const PlaceOnPath found = face_on_path(own_->vertices, along_, path, low, high, own_r_);
  if (found.theta >= 0.0)
    own_r_ = found.r;
  return found.theta;
}

namespace {

/// A vector this way that crosses so much of a cell.
Vec3d part_of_cell(const Vec3d& towards, const Vec3d& extent, double cells) {
  const double crossed = cells_crossed(towards, extent);
  return crossed > 0.0 && std::isfinite(crossed) ? (cells / crossed) * towards : Vec3d{};
}

} // namespace

/// The faces of the own cell on which x lies and along which it goes.
unsigned MeshVelocity::faces_along(const Vec3d& x, const Vec3d& towards) const {
  constexpr double way = 1e-3, slope = 1e-7; // in cells
  const mesh::CellVertices& c = own_->vertices;
  const Vec3d on = x + part_of_cell(towards, own_extent(), way);
  const auto here = cells::inverse_map(c.shape, c.x, x),
             there = cells::inverse_map(c.shape, c.x, on);
  if (!here.converged || !there.converged)
    return 0;
  double n[8], m[8];
  cells::shape_functions(c.shape, here.r, n);
  cells::shape_functions(c.shape, there.r, m);
  unsigned faces = 0;
  for (int f = 0; f < cells::face_table(c.shape).face_count; ++f) {
    const double from = cells::parametric_distance(c.shape, f, n);
    const double change = cells::parametric_distance(c.shape, f, m) - from;
    if (std::abs(from) <= control::on_face && std::abs(change) <= way * slope)
      faces |= 1U << f;
  }
  return faces;
}

/// The least distance from a face of the own cell but for those it goes along, unless it is this
/// far beyond one.
double MeshVelocity::depth_beside(const Vec3d& r) const {
  constexpr double beyond = beyond_along;
  const mesh::Shape shape = own_->vertices.shape;
  double n[8], depth = infinity;
  cells::shape_functions(shape, r, n);
  for (int f = 0; f < cells::face_table(shape).face_count; ++f) {
    const double d = cells::parametric_distance(shape, f, n);
    if ((along_ >> f & 1U) == 0)
      depth = std::min(depth, d);
    else if (d < -beyond)
      depth = std::min(depth, d + beyond);
  }
  return depth;
}

bool MeshVelocity::confine(const Vec3d& x, const Vec3d& towards, double t) {
  confined_ = false;
  along_ = 0;
  set_alpha(t);
  query::Location at = sampler_->locate(x, hint_, options());
  if (!at || !can_keep(at.cell))
    return false;
  take_own(at.cell);
  if (depth(x, t) < 1e-9) { // on a face: of the cells there, the one that is entered
    at = sampler_->locate(x + part_of_cell(towards, own_extent(), 1e-7), at.cell, options());
    if (at && at.cell != own_->cell && can_keep(at.cell))
      take_own(at.cell);
    blend(*own_);
    along_ = faces_along(x, towards);
  }
  return confined_ = true;
}

Vec3d MeshVelocity::beyond(const Vec3d& x, const Vec3d& towards, double t) {
  set_alpha(t);
  blend(*own_);
  towards_ = towards;
  return x + part_of_cell(towards, own_extent(), 1e-7);
}

/// The cell that holds a point a little way beyond a face of the own cell, at the point asked last.
query::Location MeshVelocity::locate(const Vec3d& x) {
  if (const std::int64_t cell = cell_across(x); cell >= 0) {
    Kept& k = beside(cell);
    blend(k);
    if (const query::Location at = query::try_cell(k.vertices, cell, x)) {
      ++proven_;
      return at;
    }
  }
  unguided_ += lacks_guide_;
  return sampler_->locate(x, own_->cell, options());
}

Crossed MeshVelocity::enter(const Vec3d& x, const query::Location& at) {
  landed_ = true;
  if (!at)
    return Crossed::to_boundary;
  if (!can_keep(at.cell))
    return Crossed::nowhere;
  take_own(at.cell);
  blend(*own_);
  hint_ = own_->cell;
  // Still on another face than that it came through?
  double n[8];
  cells::shape_functions(own_->vertices.shape, at.parametric, n);
  along_ = 0;
  for (int f = 0; f < cells::face_table(own_->vertices.shape).face_count; ++f)
    if (std::abs(cells::parametric_distance(own_->vertices.shape, f, n)) <= control::on_face) {
      along_ = faces_along(x, towards_);
      break;
    }
  return Crossed::into_next;
}

Crossed MeshVelocity::cross(const Vec3d& x, const Vec3d& towards, double t) {
  return crossed(x, locate(beyond(x, towards, t)));
}

/// at: of a place a little way on from x.
Crossed MeshVelocity::crossed(const Vec3d& x, const query::Location& at) {
  if (!at || at.cell != own_->cell)
    return enter(x, at);
  // Almost along the face, or a little short of it.
  const auto map = cells::inverse_map(own_->vertices.shape, own_->vertices.x, x);
  if (map.converged) {
    const query::FaceCrossing face = query::nearest_face(own_->vertices, own_->cell, map.r);
    const Vec3d extent = own_extent();
    for (double part = 1e-8; part < 1e-4; part *= 10.0) {
      const query::Location out = sampler_->locate(
          face.point + part_of_cell(face.normal, extent, part), own_->cell, options());
      if (!out || out.cell != own_->cell)
        return enter(x, out);
    }
  }
  return Crossed::nowhere;
}

double MeshVelocity::way_out(const Vec3d& a, const Vec3d& b, double t) {
  set_alpha(t);
  const auto exit = query::leave_mesh(*sampler_, cell_, a, b, options());
  if (!exit)
    return -1.0;
  // What goes along a wall, and leaves further on, may by rounding be out of it at once.
  constexpr double no_way = control::on_face, some_way = 1e-3; // cells
  const double cells = cells_crossed(b - a, extent());
  if (exit->t * cells < no_way && cells > 0.0) {
    const Vec3d on = a + std::min(0.5, some_way / cells) * (b - a);
    if (sampler_->locate(on, cell_, options()) || beside_mesh(on))
      return -1.0;
  }
  return exit->t;
}

std::optional<query::Exit> MeshVelocity::leave(const Vec3d& a, const Vec3d& b, double t,
                                               double dt) {
  set_alpha(t);
  auto exit = query::leave_mesh(*sampler_, cell_, a, b, options());
  if (exit && moves_) {
    // With the face where it is at part u of the way, it is left at part g(u): u = g(u) is wanted,
    // and g is as good as linear over so short a way.
    const auto left_at = [&](double u) {
      set_alpha(t + u * dt);
      const query::Location at = sampler_->locate(a, cell_, options());
      auto later = at ? query::leave_mesh(*sampler_, at.cell, a, b, options()) : std::nullopt;
      if (later)
        exit = later;
      return bool(later);
    };
    const double g0 = exit->t;
    bool met = g0 == 0.0 || left_at(g0);
    if (met && g0 > 0.0) {
      const double u = g0 / (1.0 - (exit->t - g0) / g0);
      met = u >= 0.0 && u <= 1.0 && left_at(u);
      exit->t = u;
    }
    if (!met) { // the place where the face is when the particle is where it is
      set_alpha(t);
      if (!(exit = query::leave_mesh(*sampler_, cell_, a, b, options())))
        return exit;
      exit->t = 0.0;
    }
  }
  if (exit)
    cell_ = hint_ = exit->owner;
  return exit;
}

} // namespace insitu::advect
