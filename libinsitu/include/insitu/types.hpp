/** @file types.hpp
 *  Enumerations, frames and results for insitu.hpp, which includes this file. */
#ifndef INSITU_TYPES_HPP
#define INSITU_TYPES_HPP

#include "insitu/array.hpp"
#include "insitu/c/probe.h"

namespace insitu {

/** What changed since the last commit. Values combine with |. */
enum Change : std::uint32_t {
  fields = INSITU_CHANGED_FIELDS,     /**< values of fields changed */
  geometry = INSITU_CHANGED_GEOMETRY, /**< coordinates of vertices changed */
  topology = INSITU_CHANGED_TOPOLOGY, /**< cells, pieces or ghosts changed (implies the two
                                           above) */
  everything = INSITU_CHANGED_ALL
};

constexpr Change operator|(Change a, Change b) noexcept {
  return static_cast<Change>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}

enum class Association { vertex = INSITU_VERTEX, cell = INSITU_CELL };

/** Cell shapes, with VTK's numbers and VTK's order of points. */
enum class Shape {
  triangle = INSITU_TRIANGLE,
  pixel = INSITU_PIXEL,
  quad = INSITU_QUAD,
  tetrahedron = INSITU_TETRAHEDRON,
  voxel = INSITU_VOXEL,
  hexahedron = INSITU_HEXAHEDRON,
  wedge = INSITU_WEDGE,
  pyramid = INSITU_PYRAMID
};

/** Returns the number of vertices of a cell of that shape. */
constexpr int vertex_count(Shape shape) noexcept {
  return shape == Shape::triangle      ? 3
         : shape == Shape::tetrahedron ? 4
         : shape == Shape::pixel       ? 4
         : shape == Shape::quad        ? 4
         : shape == Shape::pyramid     ? 5
         : shape == Shape::wedge       ? 6
                                       : 8;
}

enum class Accuracy { fast = INSITU_FAST, standard = INSITU_STANDARD, exact = INSITU_EXACT };

/** How points find their cells; see insitu_method. */
enum class Method {
  automatic = INSITU_METHOD_AUTO,
  bvh = INSITU_METHOD_BVH,
  user_geometry = INSITU_METHOD_USER_GEOMETRY,
  replicated_faces = INSITU_METHOD_REPLICATED_FACES,
  shared_faces = INSITU_METHOD_SHARED_FACES,
  shared_bilinear_faces = INSITU_METHOD_SHARED_BILINEAR_FACES
};
enum class Backend {
  automatic = INSITU_BACKEND_AUTO,
  cpu = INSITU_BACKEND_CPU,
  cuda = INSITU_BACKEND_CUDA,
  optix = INSITU_BACKEND_OPTIX
};

/** Why a point has the owner that it has; see insitu_reason. */
enum class Reason : std::uint8_t {
  outside = INSITU_REASON_OUTSIDE,
  certified = INSITU_REASON_CERTIFIED,
  exact = INSITU_REASON_EXACT,
  on_face = INSITU_REASON_ON_FACE,
  on_edge = INSITU_REASON_ON_EDGE,
  on_vertex = INSITU_REASON_ON_VERTEX
};

/** How the library reads ghost arrays; see insitu_ghost_convention. */
enum class GhostConvention { vtk = INSITU_GHOSTS_VTK, ascent = INSITU_GHOSTS_ASCENT };

/** How samples of an adaptive mesh follow from the cells' values; see insitu_reconstruction. */
enum class Reconstruction { dual = INSITU_DUAL, nearest = INSITU_NEAREST };

/** The lattices of an adaptive mesh's levels; see insitu_amr. */
struct AmrLevels {
  std::array<double, 3> origin{
      {0.0, 0.0, 0.0}}; /**< the lower corner of cell (0, 0, 0) of every level */
  std::array<double, 3> spacing{{1.0, 1.0, 1.0}}; /**< the spacing of the coarsest level;
                                                       positive */
  std::vector<std::int32_t> ratios = {}; /**< the ratio, 2 or 4, of each level to the next finer
                                            one, from the coarsest on: one fewer than levels */
  int count = 1;             /**< number of levels if ratios is empty; all ratios are then 2 */
  bool finest_first = false; /**< whether level 0 is the finest, not the coarsest */
  Reconstruction reconstruction = Reconstruction::dual;
  int dimensions = 3; /**< 2: the mesh is flat, in the plane of origin[2]; patches have one cell
                           along k, and other third numbers are of no account */
};

/** What the corners of leaves count; see insitu_leaves. */
struct LeafLattice {
  int corner_bits = -1;                          /**< -1: corners count cells of the leaf's own
                                                      level */
  std::array<std::int64_t, 3> offset{{0, 0, 0}}; /**< added to corners, in the same cells */
};

/** Numbers of layers of ghost cells that the arrays of a patch's fields hold around the patch,
 *  along i, j, k; see insitu_patch. */
struct PatchGhosts {
  std::array<int, 3> before{{0, 0, 0}}, after{{0, 0, 0}};
};

using AmrInfo = insitu_amr_info;
using CommitReport = insitu_commit_report;
using AuditEntry = insitu_audit_entry;
using LocatorInfo = insitu_locator_info;
using ProbeAnswers = insitu_probe_answers;

/** Units of geodetic frames; see insitu_frame. */
enum class Angle { degrees = INSITU_DEGREES, radians = INSITU_RADIANS };
enum class Length { metres = INSITU_METRES, kilometres = INSITU_KILOMETRES };
enum class Vertical { up = INSITU_UP, down = INSITU_DOWN };

/** The frame of reference of a mesh, or of the points of a query. */
class Frame {
public:
  /** Makes the frame of the solver's own coordinates. */
  static Frame cartesian() noexcept { return Frame(INSITU_FRAME_CARTESIAN); }
  /** Makes the frame of ECEF metres on WGS84. */
  static Frame geocentric() noexcept { return Frame(INSITU_FRAME_GEOCENTRIC); }
  /** Makes a frame of longitude, latitude and a height or depth on WGS84; without arguments in
   *  degrees and metres, with heights. */
  static Frame geodetic(Vertical vertical = Vertical::up, Angle angle = Angle::degrees,
                        Length length = Length::metres) noexcept {
    Frame f(INSITU_FRAME_GEODETIC);
    f.frame_.angle = static_cast<insitu_angle>(angle);
    f.frame_.length = static_cast<insitu_length>(length);
    f.frame_.vertical = static_cast<insitu_vertical>(vertical);
    return f;
  }
  /** Makes a frame of metres east, north and up of an origin, given in degrees and metres. */
  static Frame enu(double longitude, double latitude, double height) noexcept {
    Frame f(INSITU_FRAME_ENU);
    f.frame_.origin[0] = longitude;
    f.frame_.origin[1] = latitude;
    f.frame_.origin[2] = height;
    return f;
  }
  /** Makes a frame of easting, northing and a height or depth, in metres, in a zone from 1 to
   *  60. */
  static Frame utm(int zone, bool north, Vertical vertical = Vertical::up) noexcept {
    Frame f(INSITU_FRAME_UTM);
    f.frame_.utm_zone = zone;
    f.frame_.utm_north = north ? 1 : 0;
    f.frame_.vertical = static_cast<insitu_vertical>(vertical);
    return f;
  }
  const insitu_frame& get() const noexcept { return frame_; }

private:
  explicit Frame(insitu_frame_kind kind) noexcept : frame_(insitu_frame_default()) {
    frame_.kind = kind;
  }
  insitu_frame frame_;
};

struct LocateOptions {
  Accuracy accuracy = Accuracy::standard;
  std::int64_t cell_base = 0;   /**< 0 or 1: the id of the first cell of a piece */
  const Frame* frame = nullptr; /**< frame of the points, which must live through the call; null:
                                     the mesh's */
  bool reasons = false;         /**< whether the call fills Locations::reasons */
  bool everywhere = false;      /**< whether cells of all processes may hold the points; the call is
                                     then collective (INSITU_SCOPE_EVERYWHERE), and fills
                                     Locations::ranks and Locations::global_cells */
  bool nearest = false;         /**< whether points outside get the nearest cell
                                     (INSITU_OUTSIDE_NEAREST); fills Locations::distances and
                                     Locations::nearest */
  double greatest_distance = 0.0; /**< how far that cell may be; 0: any distance */
};

/** Where points lie, one item a point, in the points' order. */
struct Locations {
  std::vector<std::uint8_t> found;  /**< [size()] 1 inside the mesh, 0 outside */
  std::vector<std::int64_t> cells;  /**< [size()] the owner's id; cell_base - 1 outside */
  std::vector<std::int32_t> pieces; /**< [size()] the owner's piece; -1 outside */
  std::vector<double> parametric;   /**< [size()][3] VTK's parametric coordinates; NaN outside
                                         and in polyhedra */
  std::vector<Reason> reasons;      /**< [size()] why the points have these owners; empty unless
                                         asked for */
  std::vector<std::int32_t> ranks;  /**< [size()] the owner's process, -1 outside; of queries
                                         everywhere */
  std::vector<std::int64_t> global_cells; /**< [size()] the owner's global id, -1 outside or without
                                               global ids; of queries everywhere */
  std::vector<double> distances; /**< [size()] to the cell that answers, 0 inside; if asked for the
                                      nearest */
  std::vector<double> nearest;   /**< [size()][3] the cell's nearest point, in the mesh's frame; if
                                      asked for */

  std::size_t size() const noexcept { return found.size(); }
};

/** Vertices near points, `most` a point, in order of distance; see insitu_vertices_args. */
struct NearestVertices {
  std::size_t most = 1;
  std::vector<std::int64_t> vertices;        /**< [points][most] -1 where there are no more */
  std::vector<std::int32_t> pieces, ranks;   /**< [points][most] -1 where there are no more */
  std::vector<std::int64_t> global_vertices; /**< [points][most] -1 also without global ids */
  std::vector<double> distances;             /**< [points][most] NaN where there are no more */
  std::vector<double> places;                /**< [points][most][3] coordinates of the vertices */
};

/** Locations of points, and the values of one field there. */
struct Samples : Locations {
  int components = 1;
  std::vector<double> values; /**< [size()][components]; NaN outside */

  double operator()(std::size_t point, int component = 0) const {
    return values[point * static_cast<std::size_t>(components) +
                  static_cast<std::size_t>(component)];
  }
};

/** The values of one field. */
struct FieldValues {
  std::string name;
  int components = 1;
  std::vector<double> values; /**< [points][components]; NaN outside */
};

/** Locations of points, and the values of several fields there. */
struct FieldSamples : Locations {
  std::vector<FieldValues> values; /**< one item a field, in the order asked for */
};

struct FieldInfo {
  int components;
  Association association;
};

/** What validation found. */
struct Validation {
  insitu_validation counts;
  bool accepted;        /**< false: a commit refuses the mesh */
  std::string findings; /**< the first errors, if a commit refuses the mesh; else empty */
};

} // namespace insitu

#endif // INSITU_TYPES_HPP
