#include "cells/polyhedra/closed_cell.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace insitu::cells {

using math::Vec3d;
using mesh::Shape;

void ClosedCell::refuse(std::int64_t& errors, const std::string& what,
                        FaceFindings& findings) const {
  findings.add(errors, name_ + ", cell " + std::to_string(cell_) + ": " + what);
}

bool ClosedCell::gather(std::int64_t cell, std::span<const std::int64_t> faces,
                        FaceFindings& findings) {
  cell_ = cell;
  if (!take_rings(faces, findings) || !take_vertices(findings) || !match_edges(findings) ||
      !wind(findings))
    return false;
  if (has_volume()) {
    order_rings();
    return true;
  }
  refuse(findings.shape_errors, "has no volume beyond the rounding of its coordinates", findings);
  return false;
}

bool ClosedCell::take_rings(std::span<const std::int64_t> faces, FaceFindings& findings) {
  rings_.clear();
  ring_ids_.clear();
  for (const std::int64_t face : faces) {
    const auto refuse_face = [&](std::int64_t& errors, const std::string& what) {
      refuse(errors, "face " + std::to_string(face) + " " + what, findings);
      return false;
    };
    const auto place = [&](std::int64_t at) {
      return std::to_string(mesh::from_base(at, -given_.index_base));
    };
    FaceRing ring{};
    if (!find_ring(given_, face, ring))
      return refuse_face(
          findings.shape_errors,
          "lies at " + place(ring.first) + " to before " +
              place(std::int64_t(std::uint64_t(ring.first) + std::uint64_t(ring.size))) + " of " +
              std::to_string(ring.ids.count) + " ids");
    if (ring.size < 3)
      return refuse_face(findings.shape_errors,
                         "has " + std::to_string(ring.size) + " vertices, 3 or more expected");
    constexpr std::int64_t most = 1 << 16; // vertices of one face
    if (ring.size > most)
      return refuse_face(findings.shape_errors, "has " + std::to_string(ring.size) +
                                                    " vertices, at most " + std::to_string(most) +
                                                    " expected");
    const std::size_t first = ring_ids_.size();
    for (std::int64_t k = 0; k < ring.size; ++k) {
      const std::int64_t given = ring.id(k);
      const std::int64_t id = mesh::from_base(given, given_.index_base);
      if (id < 0 || id >= piece_.vertex_count)
        return refuse_face(findings.index_errors,
                           "vertex " + std::to_string(k) + " has id " + std::to_string(given) +
                               ", " + std::to_string(given_.index_base) + " to " +
                               std::to_string(piece_.vertex_count - 1 + given_.index_base) +
                               " expected");
      ring_ids_.push_back(id);
    }
    rings_.push_back({std::int32_t(first), std::int32_t(ring.size), face, false});
  }
  if (rings_.size() >= 4)
    return true;
  refuse(findings.shape_errors,
         "has " + std::to_string(rings_.size()) + " faces, 4 or more expected", findings);
  return false;
}

/// In the order of their coordinates.
bool ClosedCell::take_vertices(FaceFindings& findings) {
  sorted_ids_ = ring_ids_;
  std::ranges::sort(sorted_ids_);
  sorted_ids_.erase(std::unique(sorted_ids_.begin(), sorted_ids_.end()), sorted_ids_.end());
  found_.clear();
  for (const std::int64_t id : sorted_ids_) {
    const Vec3d x = piece_.point(id);
    found_.push_back({x, id});
    for (int a = 0; a < 3; ++a)
      if (!std::isfinite(x[a])) {
        refuse(findings.coordinate_errors,
               "vertex id " + std::to_string(id + given_.index_base) + ": coordinate " + "xyz"[a] +
                   " is " + (std::isnan(x[a]) ? "NaN" : "infinite"),
               findings);
        return false;
      }
  }
  std::ranges::sort(found_, {},
                    [](const Found& f) { return std::tuple(f.x.x, f.x.y, f.x.z, f.id); });
  vertices_.clear();
  points_.clear();
  place_of_.resize(found_.size());
  for (const Found& f : found_) {
    place_of_[std::size_t(std::ranges::lower_bound(sorted_ids_, f.id) - sorted_ids_.begin())] =
        std::int32_t(vertices_.size());
    vertices_.push_back(f.id);
    points_.push_back(f.x);
  }
  places_.clear();
  for (const std::int64_t id : ring_ids_)
    places_.push_back(
        place_of_[std::size_t(std::ranges::lower_bound(sorted_ids_, id) - sorted_ids_.begin())]);
  return true;
}

bool ClosedCell::match_edges(FaceFindings& findings) {
  edges_.clear();
  for (std::size_t r = 0; r < rings_.size(); ++r) {
    const Ring& ring = rings_[r];
    for (int k = 0; k < ring.size; ++k) {
      const std::int32_t a = places_[std::size_t(ring.first + k)];
      const std::int32_t b = places_[std::size_t(ring.first + (k + 1 < ring.size ? k + 1 : 0))];
      edges_.push_back({std::min(a, b), std::max(a, b), std::int32_t(r), a < b});
    }
  }
  // A vertex that a ring meets twice is found in its sorted places.
  for (const Ring& ring : rings_) {
    std::vector<std::int32_t>& sorted = parent_; // scratch
    sorted.assign(places_.begin() + ring.first, places_.begin() + ring.first + ring.size);
    std::ranges::sort(sorted);
    const auto twice = std::ranges::adjacent_find(sorted);
    if (twice == sorted.end())
      continue;
    refuse(findings.shape_errors,
           "face " + std::to_string(ring.face) + " has vertex id " +
               std::to_string(vertices_[std::size_t(*twice)] + given_.index_base) + " twice",
           findings);
    return false;
  }
  std::ranges::sort(edges_, {}, [](const Edge& e) { return std::tuple(e.low, e.high, e.ring); });
  for (std::size_t i = 0, next = 0; i < edges_.size(); i = next) {
    for (next = i; next < edges_.size() && edges_[next].low == edges_[i].low &&
                   edges_[next].high == edges_[i].high;)
      ++next;
    if (next - i == 2)
      continue;
    const auto vertex = [&](std::int32_t place) {
      return std::to_string(vertices_[std::size_t(place)] + given_.index_base);
    };
    refuse(findings.shape_errors,
           "is not closed: the edge of the vertex ids " + vertex(edges_[i].low) + " and " +
               vertex(edges_[i].high) + " lies on " + std::to_string(next - i) +
               " of its faces, face " + std::to_string(rings_[std::size_t(edges_[i].ring)].face) +
               " among them; 2 expected",
           findings);
    return false;
  }
  return true;
}

/// Winds all rings alike, and then outward. Rings are joined as their edges say, each with the
/// parity that tells whether it runs against the first ring of its set.
bool ClosedCell::wind(FaceFindings& findings) {
  const std::size_t n = rings_.size();
  parent_.resize(n);
  parity_.assign(n, 0);
  for (std::size_t r = 0; r < n; ++r)
    parent_[r] = std::int32_t(r);
  const auto root = [&](std::int32_t r, std::uint8_t& parity) {
    for (parity = 0; parent_[std::size_t(r)] != r; r = parent_[std::size_t(r)])
      parity ^= parity_[std::size_t(r)];
    return r;
  };
  std::size_t sets = n;
  for (std::size_t i = 0; i < edges_.size(); i += 2) {
    const std::uint8_t turned = edges_[i].ascends == edges_[i + 1].ascends;
    std::uint8_t a_parity, b_parity;
    const std::int32_t a = root(edges_[i].ring, a_parity), b = root(edges_[i + 1].ring, b_parity);
    if (a != b) {
      parent_[std::size_t(std::max(a, b))] = std::min(a, b);
      parity_[std::size_t(std::max(a, b))] = a_parity ^ b_parity ^ turned;
      --sets;
    } else if ((a_parity ^ b_parity) != turned) {
      refuse(findings.shape_errors,
             "has faces that have no outside: they are joined as a Moebius "
             "strip is, at face " +
                 std::to_string(rings_[std::size_t(edges_[i].ring)].face),
             findings);
      return false;
    }
  }
  if (sets != 1) {
    std::size_t apart = 1;
    for (std::uint8_t p; root(std::int32_t(apart), p) == 0;)
      ++apart;
    refuse(findings.shape_errors,
           "has faces that bound " + std::to_string(sets) + " bodies, face " +
               std::to_string(rings_[0].face) + " one of them and face " +
               std::to_string(rings_[apart].face) + " another",
           findings);
    return false;
  }
  double volume = 0.0;
  for (std::size_t r = 0; r < n; ++r) {
    std::uint8_t parity;
    root(std::int32_t(r), parity);
    rings_[r].flipped = parity != 0;
    for (int k = 1; k + 1 < rings_[r].size; ++k) {
      const Vec3d a = points_[std::size_t(at(rings_[r], 0))] - points_[0];
      const Vec3d b = points_[std::size_t(at(rings_[r], k))] - points_[0];
      const Vec3d c = points_[std::size_t(at(rings_[r], k + 1))] - points_[0];
      volume += dot(cross(a, b), c);
    }
  }
  for (Ring& ring : rings_)
    ring.flipped ^= volume < 0.0;
  volume_ = std::abs(volume) / 6.0;
  return true;
}

/// Each ring begins at its first vertex, and rings are in the order of their vertices.
void ClosedCell::order_rings() {
  for (Ring& ring : rings_) {
    const auto begin = places_.begin() + ring.first, end = begin + ring.size;
    if (std::exchange(ring.flipped, false))
      std::reverse(begin, end);
    std::rotate(begin, std::min_element(begin, end), end);
  }
  std::ranges::sort(rings_, [&](const Ring& a, const Ring& b) {
    const auto from = places_.begin();
    return std::lexicographical_compare(from + a.first, from + a.first + a.size, from + b.first,
                                        from + b.first + b.size);
  });
}

/// A volume that moves of the coordinates by their own rounding could make is none.
bool ClosedCell::has_volume() const {
  Vec3d low = points_[0], high = points_[0];
  double largest = 0.0;
  for (const Vec3d& x : points_)
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], x[a]);
      high[a] = std::max(high[a], x[a]);
      largest = std::max(largest, std::abs(x[a]));
    }
  const Vec3d extent = high - low;
  constexpr double eps = std::numeric_limits<double>::epsilon();
  return volume_ > 4.0 * eps * largest * dot(extent, extent);
}

bool ClosedCell::are_joined(int a, int b) const {
  const std::pair<int, int> edge = std::minmax(a, b);
  const auto key = [](const Edge& e) { return std::pair<int, int>(e.low, e.high); };
  const auto at = std::ranges::lower_bound(edges_, edge, {}, key);
  return at != edges_.end() && key(*at) == edge;
}

bool ClosedCell::find_tops(const Ring& ring, int* tops) const {
  std::fill_n(tops, ring.size, -1);
  const auto place_in = [&](int v) {
    for (int k = 0; k < ring.size; ++k)
      if (at(ring, k) == v)
        return k;
    return -1;
  };
  for (std::size_t i = 0; i < edges_.size(); i += 2) {
    const int low = place_in(edges_[i].low), high = place_in(edges_[i].high);
    if ((low < 0) == (high < 0))
      continue;
    int& top = tops[low < 0 ? high : low];
    if (top >= 0)
      return false;
    top = low < 0 ? edges_[i].low : edges_[i].high;
  }
  for (int k = 0; k < ring.size; ++k) {
    if (tops[k] < 0 || std::find(tops, tops + k, tops[k]) != tops + k)
      return false;
    if (k > 0 && !are_joined(tops[k - 1], tops[k]))
      return false;
  }
  return are_joined(tops[0], tops[ring.size - 1]);
}

int ClosedCell::find_ring_of(int size) const {
  for (std::size_t r = 0; r < rings_.size(); ++r)
    if (rings_[r].size == size)
      return int(r);
  return -1;
}

Shape ClosedCell::recognise(std::int64_t ids[8]) const {
  int triangles = 0, quads = 0;
  for (const Ring& ring : rings_) {
    triangles += ring.size == 3;
    quads += ring.size == 4;
  }
  const std::size_t faces = rings_.size(), vertices = vertices_.size();
  if (std::size_t(triangles + quads) != faces)
    return Shape::none;
  int out[8], count = 0;
  const auto put = [&](std::initializer_list<int> places) {
    for (const int place : places)
      out[count++] = place;
  };
  // Triangle 0, 2, 1 and quad 0, 3, 2, 1 are outward, but a wedge's triangle 0, 1, 2 is
  // (cells/kernels/faces.h).
  Shape shape = Shape::none;
  int tops[4];
  const auto apex_of = [&](const Ring& base) { // of the others, where they are one
    for (int v = 0; v < int(vertices); ++v)
      if (std::find(places_.begin() + base.first, places_.begin() + base.first + base.size, v) ==
          places_.begin() + base.first + base.size)
        return v;
    return -1;
  };
  if (faces == 4 && vertices == 4 && quads == 0) {
    const Ring& r = rings_[0];
    put({at(r, 0), at(r, 2), at(r, 1), apex_of(r)});
    shape = Shape::tetrahedron;
  } else if (faces == 5 && vertices == 5 && quads == 1) {
    const Ring& r = rings_[std::size_t(find_ring_of(4))];
    const int apex = apex_of(r);
    for (int k = 0; k < 4; ++k)
      if (!are_joined(apex, at(r, k)))
        return Shape::none;
    put({at(r, 0), at(r, 3), at(r, 2), at(r, 1), apex});
    shape = Shape::pyramid;
  } else if (faces == 5 && vertices == 6 && quads == 3) {
    const Ring& r = rings_[std::size_t(find_ring_of(3))];
    if (!find_tops(r, tops))
      return Shape::none;
    put({at(r, 0), at(r, 1), at(r, 2), tops[0], tops[1], tops[2]});
    shape = Shape::wedge;
  } else if (faces == 6 && vertices == 8 && quads == 6) {
    const Ring& r = rings_[0];
    if (!find_tops(r, tops))
      return Shape::none;
    put({at(r, 0), at(r, 3), at(r, 2), at(r, 1), tops[0], tops[3], tops[2], tops[1]});
    shape = Shape::hexahedron;
  }
  for (int k = 0; k < count; ++k)
    ids[k] = id(out[k]);
  return shape;
}

} // namespace insitu::cells
