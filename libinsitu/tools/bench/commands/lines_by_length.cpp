#include "commands/lines_by_length.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "advect/field/mesh_velocity.h"

namespace insitu::bench {

using math::Vec3d;

namespace {

/// A velocity's direction, so that time is the way along a line.
class Direction {
public:
  explicit Direction(advect::MeshVelocity& velocity) : v_(&velocity) {}
  advect::Sampled operator()(const Vec3d& x, double t, Vec3d& v) {
    const advect::Sampled sampled = (*v_)(x, t, v);
    if (sampled == advect::Sampled::inside)
      v = v / advect::length_of(v);
    return sampled;
  }
  void accepted() { v_->accepted(); }
  Vec3d extent() { return v_->extent(); }
  bool confine(const Vec3d& x, const Vec3d& w, double t) { return v_->confine(x, w, t); }
  void release() { v_->release(); }
  double depth(const Vec3d& x, double t) { return v_->depth(x, t); }
  double last_depth() const { return v_->last_depth(); }
  advect::Crossed cross(const Vec3d& x, const Vec3d& w, double t) { return v_->cross(x, w, t); }

private:
  advect::MeshVelocity* v_;
};

} // namespace

double LinesByLength::across(const std::vector<Vec3d>& ends, const std::vector<Vec3d>& truth,
                             const std::vector<bool>& whole) const {
  double sum = 0.0;
  std::int64_t n = 0;
  for (std::size_t i = 0; i < ends.size(); ++i)
    if (whole.empty() || whole[i]) {
      const Vec3d d = ends[i] - truth[i];
      const double along = dot(d, direction_at(truth[i]));
      sum += std::max(dot(d, d) - along * along, 0.0);
      ++n;
    }
  return n > 0 ? std::sqrt(sum / double(n)) : 0.0;
}

double LinesByLength::across(const PeerLines& peer, const std::vector<Vec3d>& seeds,
                             double length) const {
  std::vector<double> lengths(seeds.size(), length);
  std::vector<Vec3d> truth;
  for (int round = 0; round < 3; ++round) {
    truth = ends(seeds, lengths);
    for (std::size_t i = 0; i < lengths.size(); ++i)
      lengths[i] += dot(peer.ends[i] - truth[i], direction_at(truth[i]));
  }
  return across(peer.ends, truth, peer.whole);
}

/// Integrated to 1e-13 by faces.
std::vector<Vec3d> LinesByLength::ends(const std::vector<Vec3d>& seeds,
                                       const std::vector<double>& lengths) const {
  advect::IntegratorSettings exact;
  exact.face_aware = true;
  exact.tolerance = 1e-13;
  exact.max_steps = 1'000'000;
  const query::Sampler sampler = mesh_->sampler();
  const mesh::FieldView field = mesh_->mesh().field("velocity");
  std::vector<Vec3d> out(seeds.size());
  threads_->parallel_for(
      std::int64_t(seeds.size()), 256, [&](std::int64_t begin, std::int64_t end) {
        advect::MeshVelocity velocity(sampler, field, nullptr, 0, 0, INSITU_STANDARD);
        Direction direction(velocity);
        advect::Work work;
        for (auto i = std::size_t(begin); i < std::size_t(end); ++i) {
          advect::State p;
          p.x = seeds[i];
          velocity.begin(-1);
          advect::integrate(direction, exact, lengths[i], std::numeric_limits<double>::infinity(),
                            p, work, [](const advect::State&) {});
          out[i] = p.x;
        }
      });
  return out;
}

/// Of the flow, unit; 0 outside.
Vec3d LinesByLength::direction_at(const Vec3d& x) const {
  double v[3] = {};
  const query::Sampler sampler = mesh_->sampler();
  if (const query::Location at = sampler.locate(x))
    sampler.interpolate(mesh_->mesh().field("velocity"), at, v);
  const Vec3d u{v[0], v[1], v[2]};
  const double speed = advect::length_of(u);
  return speed > 0.0 ? u / speed : Vec3d{};
}

} // namespace insitu::bench
