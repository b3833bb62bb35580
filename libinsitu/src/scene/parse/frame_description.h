#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "insitu/insitu.h"

#include "math/vec.h"
#include "output/annotate/time_label.h"
#include "render/camera/camera.h"
#include "render/clip.h"
#include "render/color/color_map.h"
#include "render/color/transfer_function.h"
#include "render/light.h"
#include "render/path/path_settings.h"
#include "render/processes/compositing.h"
#include "render/surface/cell_roots.h"
#include "render/surface/normals.h"
#include "render/volume/culling.h"
#include "scene/expression/trigger.h"
#include "scene/parse/names.h"

/// The frames of a scene; see description.h. Colours are linear, as the renderer takes them.
namespace insitu::scene {

/// The number drawn of a field: its only component, one of several, or a vector's magnitude.
struct Component {
  int index = -1; ///< -1: the value of a scalar field, the magnitude of a vector field
  bool magnitude() const { return index < 0; }
};

struct ValueRange {
  double low = 0, high = 1; ///< low < high
};

/// A built-in colour map by name, or a file in ParaView's JSON format, and the values that its
/// colours stretch over.
struct ColorMapChoice {
  std::string name = "viridis"; ///< built-in, or the file's name as written
  std::string path; ///< of a file, resolved against the scene file's folder; empty: built-in
  std::optional<ValueRange> range;    ///< nothing: the field's range at each frame
  std::optional<render::Scale> scale; ///< nothing: the file's, or linear
  /// Linear; nothing: the file's, or as render::ColorMap says.
  std::optional<render::Color> below, above, nan;
  int line = 0;
};

/// The direction is that of a view from `azimuth` degrees around +z, from +x, and `elevation`
/// degrees above the xy plane, towards the mesh's centre from a distance that shows the whole mesh
/// at zoom 1; or a placed camera. On Earth, that is of a geocentric frame, angles are about the
/// vertical in the mesh's middle, from east and from the horizon.
struct Viewpoint {
  bool on_earth = false;
  double azimuth = 30, elevation = 20, zoom = 1;
  bool has_angles = false;             ///< else a flat mesh is looked at from above
  std::optional<math::Vec3d> position; ///< placed; azimuth, elevation and zoom then mean nothing
  std::optional<math::Vec3d> look_at;  ///< nothing: the mesh's centre
  math::Vec3d up{0, 0, 1};
  double fov = 30;          ///< vertical field of view, degrees
  bool looks_down = false;  ///< placed by longitude and latitude, and nothing said to look at
  bool up_is_given = false; ///< else a camera placed so has its own
};

/// A viewpoint that the camera reaches at a cycle or a time.
struct CameraKey : Viewpoint {
  double at = 0;
};

struct Camera : Viewpoint {
  bool orthographic = false;
  std::optional<double> orthographic_height; ///< nothing: so that the mesh fits
  render::Fit fit = render::Fit::sphere;     ///< of what is automatic
  double orbit_azimuth_per_frame = 0; ///< degrees that the camera goes on around the axis through
                                      ///< what it looks at along `up` with each frame written
  std::vector<CameraKey> path; ///< places ascend; all placed, or none; empty: the camera stands
  bool path_by_time = false;   ///< else by cycle
  int line = 0;
};

/// One of several cameras of a frame; its images are `frame_name_000120.png`.
struct NamedCamera {
  std::string name;
  Camera camera;
};

using render::OpacityPoint;

/// The number of a field that is drawn or colours a surface, and its colours.
struct ColorBy {
  Name field;
  Component component;
  ColorMapChoice colors;
};
using SurfaceColor = std::variant<render::Color, ColorBy>;

struct Volume : ColorBy {
  std::vector<OpacityPoint>
      opacity;            ///< by value; empty: from 0 at the range's low end to 1 at its high end
  double nan_opacity = 0; ///< of values that are not numbers
  bool smooth = false;    ///< a cell field is averaged to the vertices first
  std::optional<double> unit_distance; ///< length over which a ray loses the stated opacity;
                                       ///< nothing: a hundredth of the mesh's diagonal
  /// All values between two samples count; not with a tolerance. Without a word
  /// decide_frame() chooses.
  std::optional<bool> preintegrated;
  bool shading = false;            ///< lit by the field's gradient
  std::optional<double> tolerance; ///< of opacity and colour; nothing: even steps
  render::Culling culling = render::Culling::never;
  int line = 0;
};

struct Isosurface {
  Name field;
  Component component;
  std::vector<double> values;
  double opacity = 1;
  SurfaceColor color = render::linear_of_srgb(0.8, 0.8, 0.8);
  render::Normals normals = render::Normals::cell;
  render::RootSearch search = render::RootSearch::exact;
  int line = 0;
};

/// The mesh's own boundary.
struct Boundary {
  double opacity = 1;
  SurfaceColor color = render::linear_of_srgb(0.8, 0.8, 0.8);
};

/// Triangles of a file.
struct Body {
  std::string path; ///< resolved against the scene file's folder
  double opacity = 1;
  render::Color color = render::linear_of_srgb(0.6, 0.6, 0.6);
  int line = 0;
};

/// The mesh's bounding box.
struct BoxOutline {
  render::Color color{0, 0, 0};
  double width = 1.5; ///< in pixels
  bool ticks = false; ///< with numbers, along the outer edges
};

/// What stands above the bar of a frame's first colours.
struct ScalarBar {
  std::string title; ///< empty: the name of the field
  std::string unit;  ///< empty: none is written
};

/// Of ambient occlusion.
struct Occlusion {
  int samples = 16;               ///< rays a hit
  std::optional<double> distance; ///< how far they reach; nothing: a tenth of the mesh's diagonal
};

enum class FrameEffect {
  lighting,
  shadows,
  volume_shadows,
  ambient_occlusion,
  single_scattering,
  multiple_scattering
};

/// How a volume is path traced.
struct PathTracing : render::PathTracingSettings {
  bool accumulate = false; ///< goes on with the samples of the frame before while all is the same
  int line = 0;
};

/// The mesh, which must be on Earth, is drawn in geocentric coordinates.
struct Geocentric {
  double exaggeration = 1;            ///< factor on heights above the ellipsoid
  std::optional<render::Color> globe; ///< of land, where the mesh does not cover the ellipsoid
  std::optional<double> graticule;    ///< degrees between meridians and between parallels
  int line = 0;
};

enum class ImageKind { color, depth, cell };
enum class ImageFormat { png, exr };

/// `name`, `name_depth`, `name_cell`, `name_mesh_cell`: what files of that image begin with.
std::string image_stem(const std::string& name, ImageKind kind, const std::string& mesh = "");

/// What a frame shows of one mesh: at least one of these, unless it is the frame's only mesh.
struct FrameLayer {
  Name mesh; ///< empty: the first mesh of the session
  std::optional<Volume> volume;
  std::vector<Isosurface> isosurfaces;
  std::optional<Boundary> boundary;
};

struct Frame {
  std::string name;                     ///< of the images, `name_000120.png`; unique in the scene
  std::array<int, 2> size{1024, 1024};  ///< width, height
  int samples_per_pixel = 1;            ///< rays, whose colours are averaged
  std::optional<Geocentric> geocentric; ///< nothing: drawn in its own coordinates
  render::Color background = render::linear_of_srgb(1, 1, 1);
  double background_alpha = 1; ///< of what stands behind everything; below 1 the image keeps alpha
  Camera camera;
  std::vector<NamedCamera> cameras; ///< instead of `camera`, unless empty; names are unique
  std::vector<ImageKind> images{ImageKind::color}; ///< at least one, each once
  std::vector<ImageFormat> formats{ImageFormat::png};
  /// Of the meshes that it shows; of a frame without `meshes` the only one. A frame has something
  /// in one of them, bodies or an outline.
  std::vector<FrameLayer> layers = std::vector<FrameLayer>(1);
  std::vector<Body> bodies;
  std::optional<BoxOutline> outline;
  std::vector<render::Light> lights;           ///< none: a white one from the viewer
  std::vector<render::Clip> clips;             ///< what each of them leaves is drawn
  std::optional<ScalarBar> scalar_bar;         ///< an empty optional: none is drawn
  std::optional<output::TimeLabel> time_label; ///< an empty optional: none is drawn
  bool axes = false;                           ///< draws where x, y and z point
  std::vector<FrameEffect> effects;
  bool has_effects_key = false; ///< else surfaces of one colour and isosurfaces are lit
  Occlusion occlusion;          ///< if among the effects
  std::optional<PathTracing> path_tracing; ///< also there where an effect asks for it
  insitu_accuracy accuracy = INSITU_STANDARD;
  double step = 1; ///< factor on the ray step that `accuracy` chooses
  render::Compositing compositing = render::Compositing::exact; ///< of several processes
  Trigger trigger; ///< its own, or else the scene's
  int line = 0;

  /// Whether images keep the alpha of what is drawn, because the background lets light through.
  bool keeps_alpha() const { return background_alpha < 1; }
};

/// The meshes that have an image of that kind each, by their names; "": one image is of the whole
/// frame. Of several meshes each has one of its cells.
std::vector<std::string> image_meshes(const Frame& frame, ImageKind kind);

/// Returns the frame's `cameras`, or else its `camera`, without a name.
std::vector<NamedCamera> cameras_of(const Frame& frame);

/// What is coloured by fields of a mesh: its volume, its isosurfaces, its boundary, as far as they
/// are there and have no colour of their own. The pointers point into the layer.
std::vector<const ColorBy*> colorings_of(const FrameLayer& layer);
/// Of all meshes.
std::vector<const ColorBy*> colorings_of(const Frame& frame);

} // namespace insitu::scene
