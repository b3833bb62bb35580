#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "insitu/insitu.h"

#include "accel/locator.h"
#include "advect/integrate/settings.h"
#include "math/vec.h"
#include "query/locator_choice.h"
#include "scene/expression/trigger.h"
#include "scene/parse/frame_description.h"
#include "scene/parse/names.h"
#include "scene/parse/tracer_effects_description.h"

/// What a scene asks for, as plain data: parse_scene_file() or default_scene() makes it, and the
/// runner executes it. Every member has here the default that a scene file gets where it says
/// nothing; doc/scene.md describes the keys. Numbers are finite and within the limits of that page.
/// Names of fields and meshes stand as they are written, since only the runner knows the mesh; each
/// name has its line for "file:line: ..." messages. Lines count from 1; 0 is "not in a file".
namespace insitu::scene {

// ---------------------------------------------------------------------------------------- points

/// The frame in which positions are given. Kind `mesh` stands for the own coordinates of the mesh,
/// whatever they are.
struct FrameOfReference {
  enum class Kind { mesh, cartesian, geocentric, geodetic, east_north_up, utm };
  Kind kind = Kind::mesh;
  double longitude = 0, latitude = 0, height = 0; ///< for east_north_up: the origin
                                                  ///< (degrees, metres)
  bool depth = false; ///< for geodetic: whether the third number is a depth, positive down
  int zone = 0;       ///< for utm: the zone, 1 to 60
  bool north = true;  ///< for utm: whether the hemisphere is the northern one
  int line = 0;
};

struct PointList {
  std::vector<math::Vec3d> points;
};
struct PointFile {
  std::string path; ///< path resolved against the folder of the scene file; read_points_file()
                    ///< reads it
};
/// `count` points lie in equal steps from `from` to `to`, both included; a single point lies in the
/// middle.
struct Line {
  math::Vec3d from, to;
  std::int64_t count = 2;
};
/// The points lie as on a Line. Where the frame is geodetic, the line is the shortest path on the
/// ellipsoid (with the third number in equal steps); in every other frame it is straight.
struct Transect {
  math::Vec3d from, to;
  std::int64_t count = 2;
};
/// counts[0] x counts[1] points lie in the parallelogram origin + s u + t v, with s and t from 0 to
/// 1 in equal steps.
struct Plane {
  math::Vec3d origin, u, v;
  std::array<std::int64_t, 2> counts{2, 2};
};
/// counts[0] x counts[1] x counts[2] points lie in the box, in equal steps from face to face, x
/// fastest.
struct Box {
  math::Vec3d min, max;
  std::array<std::int64_t, 3> counts{2, 2, 2};
};
/// `count` points are spread evenly through the ball.
struct Sphere {
  math::Vec3d center;
  double radius = 1;
  std::int64_t count = 1;
};
/// A curtain stands upright: `count` stations lie in equal steps of length along the path through
/// `through` (x, y, 0), its first and last place included, and each station has the levels, which
/// are third numbers of the frame. From place to place the path is the shortest one on the
/// ellipsoid where the frame is geodetic, and straight in every other frame.
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
  std::string name; ///< name of the output file, unique in the scene
  Name mesh;        ///< empty: the first mesh of the session
  PointSource points;
  int points_line = 0;
  FrameOfReference frame;
  std::vector<Name> fields; ///< empty: all fields of the mesh
  Attached attached = Attached::lab;
  insitu_accuracy accuracy = INSITU_EXACT;
  insitu_outside outside = INSITU_OUTSIDE_NONE; ///< what points that no cell holds get
  double greatest_distance = 0.0;               ///< 0: any
  std::vector<TableFormat> output{TableFormat::csv};
  Trigger trigger; ///< the trigger of the probe itself, or else that of the scene
  int line = 0;
};

// ---------------------------------------------------------------------------------------- tracers

enum class TracerKind { streamline, pathline, streakline };
enum class IntegrationMethod { euler, rk4, bs32, dopri5 };
enum class TracerDirection { forward, backward, both };

/// Lengths of steps are in the time of the solver. Where no step, smallest step or largest step is
/// given, it follows from the size of the cell and the velocity in it.
struct IntegratorOptions {
  IntegrationMethod method = IntegrationMethod::dopri5;
  /// Whether steps end at the faces of cells. Where it is not given, the steps of embedded pairs
  /// (bs32, dopri5) do, where they can.
  std::optional<bool> face_aware;
  std::optional<double> step;     ///< for euler and rk4: every step; for pairs: the first step
  double tolerance = 1e-6;        ///< for pairs: error of the position of a particle per unit time
  std::optional<double> min_step; ///< for pairs
  std::optional<double> max_step; ///< for pairs
  advect::AtMinStep at_min_step = advect::AtMinStep::end; ///< what happens at a min_step that is
                                                          ///< given
  std::int64_t max_steps = 10000;                         ///< steps of one particle in one cycle
};

/// Limits at which a particle stops and has "expired".
struct TracerLimits {
  std::optional<double>
      duration; ///< time along the line; for path- and streaklines: the age of the particle
  std::optional<double> length; ///< length of the line
};

/// When all seeds of path- and streaklines begin. Where neither every nor interval is given, they
/// begin once, at the first cycle at which `when` holds.
struct Release {
  std::optional<std::int64_t> every; ///< at each cycle that is a multiple of this number
  std::optional<double> interval;    ///< at the time of the first cycle, and after every further
                                     ///< interval
  std::optional<double> until;       ///< no seeds begin after this time
  std::optional<Expression> when;    ///< seeds begin only at cycles where this holds
  int line = 0;                      ///< line of `when`
  bool once() const { return !every && !interval; }
};

/// What tracks may record of the way of a particle over the ellipsoid.
enum class TrackGeodesic { path_length, release_distance, release_bearing };

/// When particles are written, at times between steps too. Where neither `at` nor `interval` is
/// given, they are written when the tracer is due.
struct OutputTimes {
  std::vector<double> at;         ///< times in ascending order
  std::optional<double> interval; ///< particles are written at `from`, and after every further
                                  ///< interval
  std::optional<double> from;     ///< first time; not given: the time of the first cycle
  std::optional<double> until;    ///< particles are not written after this time
};

/// Even distances of the vertices of a streamline. Where neither is given, vertices are a twentieth
/// of a cell or more apart.
struct VertexSpacing {
  std::optional<double> length, time; ///< a scene gives one of length and time at most
};

struct Tracer {
  std::string name; ///< name of the output files, unique in the scene
  Name mesh;        ///< empty: the first mesh of the session
  PointSource seeds;
  int seeds_line = 0;
  FrameOfReference frame;
  TracerKind kind = TracerKind::pathline;
  Release release; ///< release of the seeds; for a streakline every cycle, unless the file gives
                   ///< another one
  Name velocity;   ///< name of a field of three components
  advect::TimeInterpolation time_interpolation = advect::TimeInterpolation::linear; ///< of velocity
  IntegratorOptions integrator;
  OutputTimes times;                                    ///< for path- and streaklines
  TracerDirection direction = TracerDirection::forward; ///< for streamlines
  VertexSpacing spacing;                                ///< for streamlines
  TracerLimits until;
  TracerEffects effects;                ///< for path- and streaklines
  Attached attached = Attached::lab;    ///< body: for path- and streaklines, which then have no
                                        ///< velocity
  std::vector<Name> fields;             ///< fields that are recorded along the tracks; empty: none
  std::vector<TrackGeodesic> geodesics; ///< for path- and streaklines, recorded after the fields
  insitu_accuracy accuracy = INSITU_STANDARD;
  std::vector<TableFormat> output{TableFormat::csv}; ///< csv, vtp or netcdf (netcdf not for
                                                     ///< streamlines)
  Trigger trigger; ///< the trigger of the tracer itself, or else that of the scene, at which
                   ///< streamlines are computed and tracks are written
  int line = 0;
};

// ---------------------------------------------------------------------------------------- scene

struct LocatorOptions {
  query::LocatorChoice choice;
  accel::Builder builder = accel::Builder::automatic;
  int line = 0;
};

/// When the state of the tracers is written, and how many such files are kept.
struct CheckpointOptions {
  std::optional<std::int64_t> every; ///< cycles from one checkpoint to the next; an empty optional:
                                     ///< no checkpoints
  std::int64_t keep = 2;
};

/// When the committed meshes are written.
struct RecordOptions {
  std::optional<std::int64_t> every; ///< cycles from one record to the next; an empty optional: no
                                     ///< records
};

struct SceneDescription {
  std::string file;                  ///< path of the scene file, for messages
  std::string text;                  ///< what was parsed
  std::string words;                 ///< its keys and scalars, one after the other
  std::vector<std::string> warnings; ///< warnings of the parser, such as keys that were retired
  std::string output = "out";        ///< output folder, relative to the working directory
  LocatorOptions locator;
  double seam_tolerance = 1e-6; ///< see commit::CommittedMesh
  CheckpointOptions checkpoint;
  RecordOptions record;
  int held_steps = 0; ///< steps that are held beside the live one
  bool page = true; ///< whether the run has its page
  Trigger trigger;  ///< default of the items below, each of which holds the trigger that counts for
                    ///< it
  std::vector<Probe> probes;
  std::vector<Tracer> tracers;
  std::vector<Frame> frames;
};

/// Returns the scene of a session that names none: the volume of `scalar_field` of `mesh` (empty:
/// the first mesh) from an automatic camera, with scalar bar and time label, one frame every tenth
/// cycle.
SceneDescription default_scene(const std::string& scalar_field, const std::string& mesh = {});

} // namespace insitu::scene
