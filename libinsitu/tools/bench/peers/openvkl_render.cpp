#include <algorithm>
#include <cmath>

#include "peers/openvkl_device.h"
#include "peers/openvkl_parts.h"
#include "render/volume/volume.h"

namespace insitu::bench {

namespace {

using render::RayState;

constexpr int side = 4, width = side * side; ///< rays abreast

/// The lattice, the classification and the blending are render::VolumeMarcher's; what is looked for
/// at the samples is Open VKL's.
class Frame : public OpenVklFrame {
public:
  Frame(const workload::Mesh& mesh, const std::vector<double>& field, const query::Sampler& sampler,
        const render::FrameSettings& settings)
      : mesh_(mesh, field), settings_(settings),
        rays_(settings.camera, settings.width, settings.height), starts_(sampler, *settings.volume),
        step_(starts_.step()), classify_(settings.volume->function, step_,
                                         render::unit_distance_of(sampler, *settings.volume)) {}

  void build() override {
    context_.reset();
    mesh_.build();
    context_ = OpenVkl<VKLIntervalIteratorContext>(vklNewIntervalIteratorContext(mesh_.sampler()));
    vklCommit(*context_);
    throw_openvkl_error();
    iterator_.resize(vklGetIntervalIteratorSize16(passed(*context_)));
  }

  core::Image draw(OpenVklMarch march) override {
    samples_ = 0;
    core::Image image(settings_.width, settings_.height);
    for (int y = 0; y < settings_.height; y += side)
      for (int x = 0; x < settings_.width; x += side) {
        for (int i = 0; i < width; ++i) {
          states_[i].begin(rays_(x + i % side, y + i / side));
          starts_.start(states_[i]);
          if (x + i % side >= settings_.width || y + i / side >= settings_.height)
            states_[i].next = states_[i].end;
          else if (states_[i].is_thin)
            take_thin(states_[i]);
        }
        if (march == OpenVklMarch::intervals)
          by_intervals();
        else
          by_packet();
        for (int i = 0; i < width; ++i)
          if (x + i % side < settings_.width && y + i / side < settings_.height)
            put(states_[i], image.pixel(x + i % side, y + i / side));
      }
    return image;
  }
  std::int64_t samples() const override { return samples_; }

private:
  void put(const RayState& s, float* pixel) const {
    const float through = 1.0f - s.alpha;
    pixel[0] = s.color.r + through * settings_.background.r;
    pixel[1] = s.color.g + through * settings_.background.g;
    pixel[2] = s.color.b + through * settings_.background.b;
    pixel[3] = 1.0f;
  }
  static vkl_vec3f point(const RayState& state, double t) {
    const math::Vec3d p = state.ray.origin + t * state.ray.direction;
    return {float(p.x), float(p.y), float(p.z)};
  }
  /// The first and the last sample stand for all up to the bounds.
  void gather(RayState& state, std::int64_t i, float value) const {
    gather(state, i == state.first ? state.near : double(i) * step_,
           i + 1 == state.end ? state.far : double(i + 1) * step_, value);
  }
  void gather(RayState& state, double from, double to, float value) const {
    if (std::isnan(value))
      return;
    render::ColorSample s = classify_(double(value));
    if (const double part = (to - from) / step_; std::fabs(part - 1.0) > 1e-6)
      s.alpha = render::Classifier::partial(s.alpha, part);
    if (s.alpha > 0.0f)
      state.blend(s.color, s.alpha);
  }
  /// Rays that pass between two samples take one in the middle.
  void take_thin(RayState& state) {
    const vkl_vec3f p = point(state, 0.5 * (state.near + state.far));
    gather(state, state.near, state.far, vklComputeSample(passed(mesh_.sampler()), &p));
    ++samples_;
  }

  void by_packet() {
    std::int64_t stop[width];
    for (int i = 0; i < width; ++i)
      stop[i] = states_[i].end;
    march_to(stop);
  }

  void by_intervals() {
    std::int64_t stop[width];
    alignas(64) int valid[width], more[width];
    alignas(64) float times[width] = {};
    vkl_vvec3f16 origin, direction;
    vkl_vrange1f16 range;
    bool any = false;
    for (int i = 0; i < width; ++i) {
      const RayState& s = states_[i];
      valid[i] = s.next < s.end ? -1 : 0;
      any = any || valid[i];
      origin.x[i] = float(s.ray.origin.x), direction.x[i] = float(s.ray.direction.x);
      origin.y[i] = float(s.ray.origin.y), direction.y[i] = float(s.ray.direction.y);
      origin.z[i] = float(s.ray.origin.z), direction.z[i] = float(s.ray.direction.z);
      range.lower[i] = float(double(s.next) * step_);
      range.upper[i] = float(double(s.end) * step_);
    }
    if (!any)
      return;
    const VKLIntervalIterator16 iterator = vklInitIntervalIterator16(
        valid, passed(*context_), &origin, &direction, &range, times, iterator_.data());
    VKLInterval16 interval;
    for (;;) {
      vklIterateInterval16(valid, iterator, &interval, more);
      any = false;
      for (int i = 0; i < width; ++i) {
        RayState& s = states_[i];
        stop[i] = s.next;
        valid[i] = valid[i] && more[i] && !s.is_saturated() ? -1 : 0;
        if (!valid[i])
          continue;
        any = true;
        const auto index = [&](float t) {
          return std::int64_t(std::ceil(double(t) / step_ - 0.5));
        };
        s.next = std::clamp(index(interval.tRange.lower[i]), s.next, s.end);
        stop[i] = std::clamp(index(interval.tRange.upper[i]), s.next, s.end);
      }
      if (!any)
        return;
      march_to(stop);
    }
  }

  /// All rays abreast, each up to its own stop.
  void march_to(const std::int64_t* stop) {
    alignas(64) int valid[width];
    alignas(64) float values[width];
    vkl_vvec3f16 points;
    for (;;) {
      int active = 0;
      for (int i = 0; i < width; ++i) {
        RayState& s = states_[i];
        valid[i] = s.next < stop[i] && !s.is_saturated() ? -1 : 0;
        if (!valid[i])
          continue;
        const vkl_vec3f p = point(s, (double(s.next) + 0.5) * step_);
        points.x[i] = p.x, points.y[i] = p.y, points.z[i] = p.z;
        ++active;
      }
      if (active == 0)
        return;
      vklComputeSample16(valid, passed(mesh_.sampler()), &points, values);
      samples_ += active;
      for (int i = 0; i < width; ++i)
        if (valid[i]) {
          gather(states_[i], states_[i].next, values[i]);
          ++states_[i].next;
        }
    }
  }

  OpenVklMesh mesh_;
  const render::FrameSettings& settings_;
  render::RayGenerator rays_;
  render::VolumeMarcher starts_; ///< says where samples lie, no more
  double step_;
  render::Classifier classify_;
  OpenVkl<VKLIntervalIteratorContext> context_;
  std::vector<char> iterator_;
  RayState states_[width];
  std::int64_t samples_ = 0;
};

} // namespace

std::unique_ptr<OpenVklFrame> make_openvkl_frame(const workload::Mesh& mesh,
                                                 const std::vector<double>& field,
                                                 const query::Sampler& sampler,
                                                 const render::FrameSettings& settings) {
  return std::make_unique<Frame>(mesh, field, sampler, settings);
}

} // namespace insitu::bench
