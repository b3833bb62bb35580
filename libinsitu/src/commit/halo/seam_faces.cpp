#include "commit/halo/seam_faces.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <unordered_map>

#include "cells/kernels/faces.h"
#include "commit/committed_mesh.h"
#include "core/random.h"
#include "geo/chart.h"

namespace insitu::commit {

using math::Vec3d;

namespace {

/// Where the vertices of a mesh are, whose coordinates may be longitudes and latitudes.
class Places {
public:
  /// Of a mesh with a stand-in, or null.
  explicit Places(const StandIn* stand_in)
      : units_(stand_in && stand_in->chart() ? &stand_in->chart()->units : nullptr) {}

  /// The same bits for what is whole turns apart, and at a pole.
  Vec3d one(Vec3d x) const {
    if (!units_)
      return x;
    if (std::abs(x.y) == units_->quarter())
      x.x = 0.0;
    x.x = std::remainder(x.x, units_->turn());
    if (x.x == -0.5 * units_->turn())
      x.x = -x.x;
    return x;
  }
  /// In the solver's unit of length; from the centre of the Earth in metres.
  Vec3d place(const Vec3d& x) const {
    if (!units_)
      return x;
    const Vec3d normal = geo::normal_of(*units_, x);
    const double across = geo::radii(normal.z).across, height = x.z * units_->up_per_unit();
    return {(across + height) * normal.x, (across + height) * normal.y,
            (across * (1 - geo::eccentricity_squared) + height) * normal.z};
  }

private:
  const geo::ChartUnits* units_;
};

struct Face {
  int count = 0;
  std::array<Vec3d, 4> x{};  ///< the vertices, in the order of their coordinates
  std::array<Vec3d, 4> at{}; ///< where these are
  std::int64_t cell = 0;     ///< flat

  Vec3d middle() const {
    Vec3d sum;
    for (int v = 0; v < count; ++v)
      sum += at[std::size_t(v)];
    return sum / double(count);
  }
  double diameter() const {
    double most = 0.0;
    for (int a = 0; a < count; ++a)
      for (int b = 0; b < a; ++b)
        most = std::max(most, norm(at[std::size_t(a)] - at[std::size_t(b)]));
    return most;
  }
  static double norm(const Vec3d& d) { return std::sqrt(dot(d, d)); }
};

Face face_of(const mesh::MeshView& view, const Places& places, std::int64_t flat, int number) {
  mesh::CellVertices cell;
  mesh::gather(view, flat, cell);
  const cells::FaceTable table = cells::face_table(cell.shape);
  const cells::Face& vertices = table.faces[number];
  Face face;
  face.count = vertices.vertex_count;
  face.cell = flat;
  for (int v = 0; v < face.count; ++v) { // in its place among those before
    const Vec3d x = places.one(cell.x[vertices.vertices[v]]);
    std::size_t at = std::size_t(v);
    for (; at > 0 &&
           std::tie(x.x, x.y, x.z) < std::tie(face.x[at - 1].x, face.x[at - 1].y, face.x[at - 1].z);
         --at)
      face.x[at] = face.x[at - 1];
    face.x[at] = x;
  }
  for (int v = 0; v < face.count; ++v)
    face.at[std::size_t(v)] = places.place(face.x[std::size_t(v)]);
  return face;
}

/// Faces by hashes of their vertices, of which none but those that are alike to the bit are taken
/// to be equal: of a million faces two others are in one of 10^7 cases.
class FacesByHash {
public:
  explicit FacesByHash(std::size_t faces)
      : mask_(std::bit_ceil(2 * faces + 1) - 1), slots_(mask_ + 1, Slot{0, none}) {}

  /// Returns the hash of the cell's vertices.
  std::uint64_t add(const mesh::MeshView& view, const Places& places, std::int64_t flat) {
    mesh::CellVertices cell;
    mesh::gather(view, flat, cell);
    std::uint64_t of_vertex[8], of_cell = 0;
    for (int v = 0; v < cell.count; ++v)
      of_cell += of_vertex[v] = hash_of(places.one(cell.x[v]));
    const cells::FaceTable table = cells::face_table(cell.shape);
    for (int f = 0; f < table.face_count; ++f) {
      std::uint64_t sum = 0; // in whatever order they are
      for (int v = 0; v < table.faces[f].vertex_count; ++v)
        sum += of_vertex[table.faces[f].vertices[v]];
      std::size_t at = std::size_t(sum ^ (sum >> 32)) & mask_;
      while (slots_[at].face != none && slots_[at].hash != sum)
        at = (at + 1) & mask_;
      slots_[at] = {sum, slots_[at].face == none ? 8 * flat + f : matched};
    }
    return of_cell;
  }
  /// Calls f(cell, number of its face) for those that occur once, in the order of cells.
  template <class F>
  void for_unmatched(F&& f) const {
    std::vector<std::int64_t> faces;
    for (const Slot& slot : slots_)
      if (slot.face >= 0)
        faces.push_back(slot.face);
    std::ranges::sort(faces);
    for (const std::int64_t face : faces)
      f(face >> 3, int(face & 7));
  }

private:
  static constexpr std::int64_t none = -1, matched = -2;
  struct Slot {
    std::uint64_t hash;
    std::int64_t face; ///< 8 times the cell, and its face
  };
  /// Mixed well, as sums of hashes are compared.
  static std::uint64_t hash_of(const Vec3d& x) {
    std::uint64_t hash = 0;
    for (int a = 0; a < 3; ++a) // both zeros are one
      hash = core::splitmix64(hash ^ std::bit_cast<std::uint64_t>(x[a] + 0.0));
    return hash;
  }

  std::size_t mask_;
  std::vector<Slot> slots_;
};

/// Whether every vertex of one face has one of the other nearby.
bool are_near(const Face& a, const Face& b, double tolerance) {
  if (a.count != b.count)
    return false;
  const double within = tolerance * std::max(a.diameter(), b.diameter());
  return std::all_of(a.at.begin(), a.at.begin() + a.count, [&](const Vec3d& x) {
    return std::any_of(b.at.begin(), b.at.begin() + b.count,
                       [&](const Vec3d& y) { return Face::norm(x - y) <= within; });
  });
}

/// Faces by where their middles lie, in cubes in most of which a face has all that are near.
class FacesByPlace {
public:
  /// tolerance: in a face's diameter, of which `largest` is the largest one.
  FacesByPlace(std::span<const Face> faces, double tolerance, double largest)
      : faces_(faces), tolerance_(tolerance), reach_(2.0 * tolerance * largest),
        width_(std::min(64.0 * tolerance, 1.0) * largest) {
    static_assert(SeamMismatches::most_tolerance <= 0.25); // a reach to both sides is a width
    by_cube_.reserve(faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f)
      by_cube_.emplace(key(cube(faces[f].middle())), f);
  }
  /// The first face near this one; or null.
  const Face* near(const Face& face) const {
    const Face* first = nullptr;
    const Vec3d middle = face.middle(), by{reach_, reach_, reach_};
    const Cube low = cube(middle - by), high = cube(middle + by);
    for (int corner = 0; corner < 8; ++corner) {
      Cube at = low;
      bool is_within = true;
      for (std::size_t a = 0; a < 3; ++a) {
        at[a] += corner >> a & 1;
        is_within &= at[a] <= high[a];
      }
      if (!is_within)
        continue;
      const auto [from, to] = by_cube_.equal_range(key(at));
      for (auto i = from; i != to; ++i)
        if (are_near(face, faces_[i->second], tolerance_) &&
            (!first || faces_[i->second].cell < first->cell))
          first = &faces_[i->second];
    }
    return first;
  }

private:
  using Cube = std::array<double, 3>;
  Cube cube(const Vec3d& x) const {
    return {std::floor(x.x / width_), std::floor(x.y / width_), std::floor(x.z / width_)};
  }
  static std::size_t key(const Cube& cube) {
    std::size_t hash = 0;
    for (const double c : cube)
      hash = hash * 0x9e3779b97f4a7c15u + std::hash<double>()(c + 0.0);
    return hash;
  }

  std::span<const Face> faces_;
  double tolerance_, reach_, width_;
  std::unordered_multimap<std::size_t, std::size_t> by_cube_;
};

std::string told(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

} // namespace

SeamMismatches find_seam_mismatches(const CommittedMesh& mesh) {
  SeamMismatches found;
  found.tolerance = mesh.seam_tolerance;
  const mesh::MeshView& view = mesh.lent_view();
  const std::int64_t own_cells = view.own_cell_count();
  if (view.halo_piece_count == 0 || !mesh.halo())
    return found;
  const Places places(mesh.stand_in());
  std::vector<std::int64_t> cells;
  for (std::int64_t flat = 0; flat < view.cell_count(); ++flat)
    if (flat >= own_cells || mesh.halo()->is_at_seam(mesh.own_of_lent(flat)))
      cells.push_back(flat);
  const auto name = [&](std::int64_t flat) { return mesh.name(mesh.own_of_lent(flat)); };
  FacesByHash by_hash(6 * cells.size());
  std::unordered_map<std::uint64_t, std::int64_t> own; // by their vertices
  for (const std::int64_t flat : cells) {
    const std::uint64_t hash = by_hash.add(view, places, flat);
    if (flat < own_cells)
      own.emplace(hash, flat);
    else if (const auto same = own.find(hash); same != own.end())
      found.twice.add(name(same->second), name(flat));
  }
  if (found.tolerance == 0.0)
    return found;
  std::vector<Face> faces;
  by_hash.for_unmatched(
      [&](std::int64_t flat, int number) { faces.push_back(face_of(view, places, flat, number)); });
  const auto others =
      std::ranges::find_if(faces, [&](const Face& f) { return f.cell >= own_cells; });
  double largest = 0.0;
  for (const Face& face : faces)
    largest = std::max(largest, face.diameter());
  if (largest == 0.0 || others == faces.begin() || others == faces.end())
    return found;
  const FacesByPlace by_place(std::span(others, faces.end()), found.tolerance, largest);
  for (const Face& face : std::span(faces.begin(), others))
    if (const Face* const other = by_place.near(face))
      found.add(name(face.cell), name(other->cell));
  return found;
}

std::string describe(const SeamMismatches& found, parallel::World& world) {
  return describe(found,
                  " faces on seams lie within " + told(found.tolerance) +
                      " of their size (seam_tolerance) of another process's face and do not "
                      "match it to the bit",
                  ": points between them have no owner, or one on each side", world);
}

std::string describe_twice(const SeamMismatches& found, parallel::World& world) {
  return describe(found.twice, " cells are cells of another process, too, to the bit",
                  ": they count twice; all but one of these are to be ghosts", world);
}

std::string describe_gaps(const CellPairs& found, parallel::World& world) {
  return describe(found,
                  " faces of cells are one cell or two away from another process's cells, and no "
                  "cell of any process lies between them",
                  ": unless the domain has a slot there, a layer is missing", world);
}

} // namespace insitu::commit
