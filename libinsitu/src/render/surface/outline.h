#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/counted_vector.h"
#include "math/vec.h"
#include "mesh/box.h"
#include "render/camera/camera.h"
#include "render/surface/surface_hit.h"

namespace insitu::render {

/// A short line from a place, as long in the image as this many pixels to the right and down.
struct OutlineTick {
  math::Vec3d at;
  std::array<double, 2> by{};
};

/// The edges of a box as lines.
struct OutlineSettings {
  Color color{0, 0, 0};
  double width = 1.5; ///< in pixels
  std::vector<OutlineTick> ticks = {};
  std::optional<mesh::Box> box = std::nullopt; ///< nothing: the mesh's bounding box
};

/// Draws lines of a width in pixels, with smooth borders, as hits among those of surfaces: what is
/// nearer hides them. Lines are nearer by their own width than they are, so that surfaces they lie
/// on do not. They are neither lit nor cut.
class Outline {
public:
  /// The camera must be one that RayGenerator takes, for an image of that size.
  Outline(const OutlineSettings& settings, const Camera& camera, int width, int height,
          const math::Vec3d& low, const math::Vec3d& high, core::Memory& memory);

  /// Adds the lines at pixel (x, y), whose ray this is, to hits in depth order. To be called last:
  /// SurfaceHit::surface is -1.
  void add(int x, int y, const Ray& ray, std::vector<SurfaceHit>& hits) const;

private:
  /// Where a point is seen, in pixels from the image's middle, and how far off along the view.
  struct Seen {
    double x, y, depth;
  };
  struct Line {
    Seen a, b;
    double low[2], high[2]; ///< what it covers, with its width
  };

public:
  static constexpr std::int64_t bytes_a_line = sizeof(Line);

private:
  void add_line(const Seen& a, const Seen& b);
  Seen project(const math::Vec3d& p) const;

  OutlineSettings settings_;
  math::Vec3d position_, forward_, right_, down_;
  double middle_x_, middle_y_;
  double pixel_; ///< its extent, at distance 1 (orthographic: in mesh units)
  bool orthographic_;
  core::CountedVector<Line> lines_;
};

} // namespace insitu::render
