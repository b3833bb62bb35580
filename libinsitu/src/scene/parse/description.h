#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "accel/locator.h"
#include "advect/integrate/settings.h"
#include "math/vec.h"
#include "query/locator_choice.h"
#include "scene/expression/trigger.h"
#include "scene/parse/frame_description.h"
#include "scene/parse/names.h"
#include "scene/parse/tracer_effects_description.h"

/// What a scene asks for, as plain data: made by parse_scene_file() or default_scene(), executed by
/// the runner. Every member stands here with the default that a scene file gets where it says
/// nothing; doc/scene.md describes the keys. Numbers are finite and within its limits.
/// Names of fields and meshes are as written: only the runner knows the mesh, so each has its line
/// for "file:line: ..." messages. Lines count from 1; 0 is "not in a file".
namespace insitu::scene {

// ---------------------------------------------------------------------------------------- points

/// The frame that positions are given in. `mesh` is the mesh's own coordinates, whatever they are.
struct FrameOfReference {
  enum class Kind { mesh, cartesian, geocentric, geodetic, east_north_up, utm };
  Kind kind = Kind::mesh;
  double longitude = 0, latitude = 0, height = 0; ///< east_north_up: the origin (degrees, metres)
  bool depth = false; ///< geodetic: the third number is a depth, positive down
  int zone = 0;       ///< utm: 1 to 60
  bool north = true;  ///< utm: the hemisphere
  int line = 0;
};

struct PointList {
  std::vector<math::Vec3d> points;
};
struct PointFile {
  std::string path; ///< resolved against the scene file's folder; read by read_points_file()
};
/// `count` points in equal steps from `from` to `to`, both included; a single one lies in the
/// middle.
struct Line {
  math::Vec3d from, to;
  std::int64_t count = 2;
};
/// As a line, along the shortest path on the ellipsoid where the frame is geodetic (the third
/// number in equal steps), and straight in every other frame.
struct Transect {
  math::Vec3d from, to;
  std::int64_t count = 2;
};
/// counts[0] x counts[1] points of the parallelogram origin + s u + t v with s and t from 0 to 1 in
/// equal steps.
struct Plane {
  math::Vec3d origin, u, v;
  std::array<std::int64_t, 2> counts{2, 2};
};
/// counts[0] x counts[1] x counts[2] points of the box, in equal steps from face to face, x
/// fastest.
struct Box {
  math::Vec3d min, max;
  std::array<std::int64_t, 3> counts{2, 2, 2};
};
/// `count` points spread evenly through the ball.
struct Sphere {
  math::Vec3d center;
  double radius = 1;
  std::int64_t count = 1;
};
/// Upright: `count` stations in equal steps of length along the path through `through` (x, y, 0),
/// its first and last place included, and at each station the levels, the frame's third numbers.
/// The path is the shortest one on the ellipsoid from place to place where the frame is geodetic,
/// and straight in every other frame.
struct Curtain {
  std::vector<math::Vec3d> through;
  std::int64_t count = 2;
  std::vector<double> levels; ///< strictly ascending or descending
};
using PointSource = std::variant<PointList, PointFile, Line, Transect, Plane, Box, Sphere, Curtain>;

// ---------------------------------------------------------------------------------------- probes

enum class TableFormat { csv, vtp, json, netcdf };

/// Whether points stay where they are, or go with the material of a moving mesh.
enum class Attached { lab, body };

struct Probe {
  std::string name; ///< of the output file; unique in the scene
  Name mesh;        ///< empty: the first mesh of the session
  PointSource points;
  int points_line = 0;
  FrameOfReference frame;
  std::vector<Name> fields; ///< empty: all fields of the mesh
  Attached attached = Attached::lab;
  Accuracy accuracy = Accuracy::exact;
  std::vector<TableFormat> output{TableFormat::csv};
  Trigger trigger; ///< its own, or else the scene's
  int line = 0;
};

// ---------------------------------------------------------------------------------------- tracers

enum class TracerKind { streamline, pathline, streakline };
enum class IntegrationMethod { euler, rk4, bs32, dopri5 };
enum class TracerDirection { forward, backward, both };

/// Lengths of steps are in the solver's time. A step, a smallest or a largest step that is not
/// given follows from the cell's size and the velocity in it.
struct IntegratorOptions {
  IntegrationMethod method = IntegrationMethod::dopri5;
  /// Steps end at the faces of cells; not given: those of pairs, where they can.
  std::optional<bool> face_aware;
  std::optional<double> step;     ///< euler, rk4: of every step; pairs: of the first
  double tolerance = 1e-6;        ///< pairs: error of a particle's position per unit time
  std::optional<double> min_step; ///< pairs
  std::optional<double> max_step; ///< pairs
  advect::AtMinStep at_min_step = advect::AtMinStep::end; ///< of a min_step that is given
  std::int64_t max_steps = 10000;                         ///< of one particle in one cycle
};

/// Where a particle stops of its own: it "expired".
struct TracerLimits {
  std::optional<double>
      duration; ///< time along the line; of path- and streaklines: the particle's age
  std::optional<double> length; ///< length of the line
};

/// When all seeds of path- and streaklines begin; neither every nor interval: once, at the first
/// cycle (where `when` holds).
struct Release {
  std::optional<std::int64_t> every; ///< at each cycle that is a multiple of this
  std::optional<double> interval;    ///< at the first cycle's time, and this much later each time
  std::optional<double> until;       ///< not after this time
  std::optional<Expression> when;    ///< only at cycles where this holds
  int line = 0;                      ///< of `when`
  bool once() const { return !every && !interval; }
};

/// What may be recorded of a particle's way over the ellipsoid.
enum class TrackGeodesic { path_length, release_distance, release_bearing };

/// When particles are written, at times between steps too; neither `at` nor `interval`: when due.
struct OutputTimes {
  std::vector<double> at;         ///< ascending
  std::optional<double> interval; ///< from `from` on, so much later each time
  std::optional<double> from;     ///< else the time of the first cycle
  std::optional<double> until;    ///< not after this time
};

/// Even distances of a streamline's vertices; neither: a twentieth of a cell or more.
struct VertexSpacing {
  std::optional<double> length, time; ///< one of them at most
};

struct Tracer {
  std::string name; ///< of the output files; unique in the scene
  Name mesh;        ///< empty: the first mesh of the session
  PointSource seeds;
  int seeds_line = 0;
  FrameOfReference frame;
  TracerKind kind = TracerKind::pathline;
  Release release; ///< a streakline's, unless the file says: every cycle
  Name velocity;   ///< a field of three components
  advect::TimeInterpolation time_interpolation = advect::TimeInterpolation::linear; ///< of it
  IntegratorOptions integrator;
  OutputTimes times;                                    ///< of path- and streaklines
  TracerDirection direction = TracerDirection::forward; ///< of streamlines
  VertexSpacing spacing;                                ///< of streamlines
  TracerLimits until;
  TracerEffects effects;                ///< of path- and streaklines
  Attached attached = Attached::lab;    ///< body: path- and streaklines, without velocity
  std::vector<Name> fields;             ///< recorded along the tracks; empty: none
  std::vector<TrackGeodesic> geodesics; ///< of path- and streaklines, after the fields
  Accuracy accuracy = Accuracy::standard;
  std::vector<TableFormat> output{TableFormat::csv}; ///< csv, vtp, netcdf (no streamlines)
  Trigger trigger; ///< its own, or else the scene's: streamlines are computed, tracks are written
  int line = 0;
};

// ---------------------------------------------------------------------------------------- scene

struct LocatorOptions {
  query::LocatorChoice choice;
  accel::Builder builder = accel::Builder::automatic;
  int line = 0;
};

/// When the state of the tracers is written, and how many such files stay.
struct CheckpointOptions {
  std::optional<std::int64_t> every; ///< cycles; nothing: never
  std::int64_t keep = 2;
};

struct SceneDescription {
  std::string file;                  ///< for messages
  std::vector<std::string> warnings; ///< of reading it: keys that were retired
  std::string output = "out";        ///< folder, relative to the working directory
  LocatorOptions locator;
  CheckpointOptions checkpoint;
  bool page = true; ///< the page of the run
  Trigger trigger;  ///< default of the items below, which hold the one that counts for them
  std::vector<Probe> probes;
  std::vector<Tracer> tracers;
  std::vector<Frame> frames;
};

/// The scene of a session that names none: the volume of `scalar_field` of `mesh` (empty: the
/// first) from an automatic camera with scalar bar and time label, one frame every tenth cycle.
SceneDescription default_scene(const std::string& scalar_field, const std::string& mesh = {});

const char* accuracy_name(Accuracy accuracy);

} // namespace insitu::scene
