#include "output/annotate/box_ticks.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "output/annotate/overlay_style.h"

namespace insitu::output {

namespace {

using math::Vec3d;

/// Which of an axis' two faces is turned to the viewer: 0 the lower, 1 the upper, -1 neither.
int seen_face(const render::Camera& camera, const Vec3d& forward, int axis, const Vec3d& low,
              const Vec3d& high) {
  if (camera.orthographic_height > 0)
    return std::fabs(forward[axis]) < 1e-9 ? -1 : forward[axis] < 0;
  const double at = camera.position[axis];
  return at > high[axis] ? 1 : at < low[axis] ? 0 : -1;
}

struct Edge {
  Vec3d from, to;
  std::array<double, 2> a, b; ///< as seen
  double length() const { return std::hypot(b[0] - a[0], b[1] - a[1]); }
  std::array<double, 2> middle() const { return {0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])}; }
  bool runs_across() const { return std::fabs(b[0] - a[0]) >= std::fabs(b[1] - a[1]); }
};

/// Edges that run across the image before those that run upwards; then the lowest, or the leftmost.
bool is_better(const Edge& a, const Edge& b) {
  if (a.runs_across() != b.runs_across())
    return a.runs_across();
  return a.runs_across() ? a.middle()[1] > b.middle()[1] : a.middle()[0] < b.middle()[0];
}

/// The edge of an axis that gets the ticks.
std::optional<Edge> outer_edge(const render::RayGenerator& rays, const int (&faces)[3], int axis,
                               const Vec3d& low, const Vec3d& high) {
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  std::optional<Edge> best;
  for (int side = 0; side < 4; ++side) {
    const int side_b = side & 1, side_c = side >> 1;
    if ((faces[b] == side_b) == (faces[c] == side_c))
      continue; // both faces are seen, or none: not at the border
    Edge edge;
    edge.from = low;
    edge.from[b] = side_b ? high[b] : low[b];
    edge.from[c] = side_c ? high[c] : low[c];
    edge.to = edge.from;
    edge.to[axis] = high[axis];
    const auto from = rays.project(edge.from), to = rays.project(edge.to);
    if (!from || !to)
      continue;
    edge.a = *from;
    edge.b = *to;
    if (!best || is_better(edge, *best))
      best = edge;
  }
  return best;
}

/// Whether a rectangle meets another.
struct Rectangle {
  double left, top, right, bottom;
  bool meets(const Rectangle& o) const {
    return left < o.right && o.left < right && top < o.bottom && o.top < bottom;
  }
};

class Labels {
public:
  Labels(core::Image& image, const Overlay& overlay)
      : image_(image), height_(overlay_text_height(image.width, image.height)),
        style_(style_on(overlay.background, height_)) {}

  int height() const { return height_; }

  /// How far a text reaches along a direction, from its middle, twice.
  double extent(const std::string& text, const std::array<double, 2>& along) const {
    return std::fabs(along[0]) * text_width(text, height_) + std::fabs(along[1]) * 0.7 * height_;
  }

  /// A text around a place, unless it meets another or the image's border.
  void draw(const std::string& text, double x, double y) {
    const double half = 0.5 * text_width(text, height_);
    const Rectangle place{x - half - 0.2 * height_, y - 0.45 * height_, x + half + 0.2 * height_,
                          y + 0.45 * height_};
    if (place.left < 0 || place.top < 0 || place.right > image_.width ||
        place.bottom > image_.height)
      return;
    for (const Rectangle& other : taken_)
      if (place.meets(other))
        return;
    taken_.push_back(place);
    draw_text(image_, int(std::lround(x - half)),
              int(std::lround(y - double(text_middle(height_)))), text, style_);
  }

private:
  core::Image& image_;
  int height_;
  TextStyle style_;
  std::vector<Rectangle> taken_;
};

} // namespace

BoxTicks box_ticks(const render::Camera& camera, int width, int height, const Vec3d& low,
                   const Vec3d& high) {
  BoxTicks found;
  const render::RayGenerator rays(camera, width, height);
  const render::CameraAxes axes(camera);
  const auto centre = rays.project(0.5 * (low + high));
  int faces[3];
  for (int a = 0; a < 3; ++a)
    faces[a] = seen_face(camera, axes.forward, a, low, high);
  const int text = overlay_text_height(width, height);
  for (int axis = 0; axis < 3 && centre; ++axis) {
    if (!(high[axis] > low[axis]))
      continue;
    const std::optional<Edge> edge = outer_edge(rays, faces, axis, low, high);
    if (!edge || !(edge->length() > 2 * text))
      continue;
    BoxTicks::Axis to;
    to.axis = axis;
    to.middle = edge->middle();
    const double dx = (edge->b[0] - edge->a[0]) / edge->length(),
                 dy = (edge->b[1] - edge->a[1]) / edge->length();
    const bool turn = -dy * (to.middle[0] - (*centre)[0]) + dx * (to.middle[1] - (*centre)[1]) < 0;
    to.outwards = turn ? std::array{dy, -dx} : std::array{-dy, dx};
    to.values =
        tick_values(low[axis], high[axis], std::clamp(int(edge->length() / (4 * text)), 2, 9));
    to.labels = tick_labels(to.values);
    const double length = 0.5 * text;
    for (const double value : to.values) {
      Vec3d at = edge->from;
      at[axis] = value;
      const auto seen = rays.project(at);
      if (!seen)
        continue;
      to.ends.push_back(
          {(*seen)[0] + length * to.outwards[0], (*seen)[1] + length * to.outwards[1]});
      found.lines.push_back({at, {length * to.outwards[0], length * to.outwards[1]}});
    }
    if (to.ends.size() == to.values.size())
      found.axes.push_back(std::move(to));
  }
  return found;
}

void draw_box_labels(core::Image& image, const BoxTicks& ticks, const Overlay& overlay) {
  Labels labels(image, overlay);
  const double gap = 0.35 * labels.height();
  for (const BoxTicks::Axis& axis : ticks.axes)
    for (std::size_t i = 0; i < axis.values.size(); ++i) {
      const double off = gap + 0.5 * labels.extent(axis.labels[i], axis.outwards);
      labels.draw(axis.labels[i], axis.ends[i][0] + off * axis.outwards[0],
                  axis.ends[i][1] + off * axis.outwards[1]);
    }
  for (const BoxTicks::Axis& axis : ticks.axes) {
    double widest = 0;
    for (const std::string& label : axis.labels)
      widest = std::max(widest, labels.extent(label, axis.outwards));
    const std::string name(1, "xyz"[axis.axis]);
    const double off =
        0.5 * labels.height() + 2 * gap + widest + 0.5 * labels.extent(name, axis.outwards);
    labels.draw(name, axis.middle[0] + off * axis.outwards[0],
                axis.middle[1] + off * axis.outwards[1]);
  }
}

} // namespace insitu::output
