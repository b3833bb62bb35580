#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "math/vec.h"
#include "scene/names.h"
#include "scene/trigger.h"

/// The frames of a scene; see description.h.
namespace insitu::scene {

/// Each from 0 to 1, as displayed.
struct Color {
  double red = 0, green = 0, blue = 0;
  friend bool operator==(const Color&, const Color&) = default;
};

/// The number drawn of a field: its only component, one of several, or a vector's magnitude.
struct Component {
  int index = -1; ///< -1: the value of a scalar field, the magnitude of a vector field
  bool magnitude() const { return index < 0; }
};

/// A built-in colour map by name, or a file in ParaView's JSON format.
struct ColorMap {
  std::string name = "viridis"; ///< built-in, or the file's name as written
  std::string path; ///< of a file, resolved against the scene file's folder; empty: built-in
  int line = 0;
};

struct ValueRange {
  double low = 0, high = 1; ///< low < high
};

/// The direction is that of a view from `azimuth` degrees around +z, from +x, and `elevation`
/// degrees above the xy plane, towards the mesh's centre from a distance that shows the whole mesh
/// at zoom 1; or a placed camera.
struct Camera {
  double azimuth = 30, elevation = 20, zoom = 1;
  std::optional<math::Vec3d> position; ///< placed; azimuth, elevation and zoom then mean nothing
  std::optional<math::Vec3d> look_at;  ///< nothing: the mesh's centre
  math::Vec3d up{0, 0, 1};
  double fov = 30;                    ///< vertical field of view, degrees
  double orbit_azimuth_per_frame = 0; ///< degrees that the camera goes on around the axis through
                                      ///< what it looks at along `up` with each frame written
  int line = 0;
};

struct OpacityPoint {
  double value = 0, opacity = 0;
};

struct Volume {
  Name field;
  Component component;
  ColorMap colors;
  std::optional<ValueRange> range; ///< nothing: the field's range at each frame
  std::vector<OpacityPoint>
      opacity;         ///< by value; empty: from 0 at the range's low end to 1 at its high end
  bool smooth = false; ///< a cell field is averaged to the vertices first
  std::optional<double> unit_distance; ///< length over which a ray loses the stated opacity;
                                       ///< nothing: a hundredth of the mesh's diagonal
  int line = 0;
};

/// Colours of a surface by a field.
struct ColorBy {
  Name field;
  Component component;
  ColorMap colors;
  std::optional<ValueRange> range;
};

/// See render/isosurface.h.
enum class Normals { cell, smooth, central };
enum class RootSearch { exact, neubauer };

struct Isosurface {
  Name field;
  Component component;
  std::vector<double> values;
  double opacity = 1;
  std::variant<Color, ColorBy> color = Color{0.8, 0.8, 0.8};
  Normals normals = Normals::cell;
  RootSearch search = RootSearch::exact;
  int line = 0;
};

/// The mesh's own boundary.
struct Boundary {
  double opacity = 1;
  std::variant<Color, ColorBy> color = Color{0.8, 0.8, 0.8};
};

/// Triangles of a file.
struct Body {
  std::string path; ///< resolved against the scene file's folder
  double opacity = 1;
  Color color{0.6, 0.6, 0.6};
  int line = 0;
};

/// The mesh's bounding box.
struct BoxOutline {
  Color color{0, 0, 0};
  double width = 1.5; ///< in pixels
};

/// Light on surfaces; see render/light.h.
struct Light {
  enum class Kind { head, directional, point, dome };
  Kind kind = Kind::head;
  math::Vec3d vector; ///< directional: towards the light; point: its position
  Color color{1, 1, 1};
  double intensity = 1; ///< factor on the colour as linear light
};

/// What is cut away; see render/clip.h.
struct Clip {
  enum class Kind { plane, box, sphere };
  Kind kind = Kind::plane;
  math::Vec3d point;  ///< on the plane; the box's lowest corner; the sphere's centre
  math::Vec3d vector; ///< the plane's normal, to where things go; the box's highest corner
  double radius = 0;
  bool keep_inside = true;
};

/// Of ambient occlusion.
struct Occlusion {
  int samples = 16;               ///< rays a hit
  std::optional<double> distance; ///< how far they reach; nothing: a tenth of the mesh's diagonal
};

enum class FrameEffect { lighting, shadows, ambient_occlusion };

struct Frame {
  std::string name;                    ///< of the images, `name_000120.png`; unique in the scene
  Name mesh;                           ///< empty: the first mesh of the session
  std::array<int, 2> size{1024, 1024}; ///< width, height
  Color background{1, 1, 1};
  Camera camera;
  /// A frame has at least one of these.
  std::optional<Volume> volume;
  std::vector<Isosurface> isosurfaces;
  std::optional<Boundary> boundary;
  std::vector<Body> bodies;
  std::optional<BoxOutline> outline;
  std::vector<Light> lights; ///< none: a white one from the viewer
  std::vector<Clip> clips;   ///< what each of them leaves is drawn
  bool scalar_bar = false;
  bool time_label = false;
  std::vector<FrameEffect> effects;
  Occlusion occlusion; ///< if among the effects
  Accuracy accuracy = Accuracy::standard;
  double step = 1; ///< factor on the ray step that `accuracy` chooses
  Trigger trigger; ///< its own, or else the scene's
  int line = 0;
};

} // namespace insitu::scene
