#include "torture/points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "cells/kernels/faces.h"
#include "cells/kernels/kernels.h"
#include "core/random.h"
#include "workload/queries.h"

namespace insitu::bench::torture {

namespace {

using math::Vec3d;

constexpr std::uint64_t seed = 21;

/// Whether each vertex lies on a face that one cell alone has.
std::vector<bool> on_outside(const workload::Mesh& mesh) {
  std::map<std::array<std::int32_t, 4>, int> met; // faces by their sorted ids
  const auto for_each_face = [&](auto&& visit) {
    for (std::int64_t c = 0; c < mesh.cell_count(); ++c) {
      const cells::FaceTable table = cells::face_table(mesh.shape(c));
      for (int f = 0; f < table.face_count; ++f) {
        std::array<std::int32_t, 4> ids{-1, -1, -1, -1};
        for (int v = 0; v < table.faces[f].vertex_count; ++v) {
          const std::int32_t id = mesh.ids(c)[table.faces[f].vertices[v]];
          if (std::find(ids.begin(), ids.end(), id) == ids.end()) // repeated ids collapse a quad
            ids[std::size_t(v)] = id;
        }
        std::sort(ids.begin(), ids.end());
        if (ids[1] >= 0) // three vertices at least
          visit(ids);
      }
    }
  };
  for_each_face([&](const auto& ids) { ++met[ids]; });
  std::vector<bool> outside(std::size_t(mesh.vertex_count()), false);
  for_each_face([&](const auto& ids) {
    if (met[ids] == 1)
      for (const std::int32_t id : ids)
        if (id >= 0)
          outside[std::size_t(id)] = true;
  });
  return outside;
}

class Maker {
public:
  explicit Maker(const workload::Mesh& mesh) : mesh_(mesh), outside_(on_outside(mesh)) {
    low_ = high_ = mesh.point(0);
    for (std::int64_t v = 0; v < mesh.vertex_count(); ++v)
      for (int c = 0; c < 3; ++c) {
        low_[c] = std::min(low_[c], mesh.point(v)[c]);
        high_[c] = std::max(high_[c], mesh.point(v)[c]);
      }
  }

  Point make(std::uint64_t i) {
    item_ = i;
    channel_ = 0;
    Point out;
    out.place = Place(i % place_count);
    out.made_in = std::int32_t(pick(mesh_.cell_count()));
    ids_ = mesh_.ids(out.made_in);
    vertices_ = mesh_.gather(out.made_in, x_);
    const mesh::Shape shape = mesh_.shape(out.made_in);
    const cells::FaceTable table = cells::face_table(shape);
    switch (out.place) {
    case Place::inside: {
      double w[8];
      cells::shape_functions(shape, workload::random_parametric(shape, i), w);
      out.at = {};
      for (int v = 0; v < vertices_; ++v)
        out.at += w[v] * x_[v];
      out.within = true;
      break;
    }
    case Place::face:
    case Place::beside_face:
      on_face(table.faces[pick(table.face_count)], out);
      break;
    case Place::edge:
    case Place::beside_edge: {
      const cells::Edge& e = table.edges[pick(table.edge_count)];
      const double u = unit();
      out.at = (1.0 - u) * x_[e.vertices[0]] + u * x_[e.vertices[1]];
      out.within = within(e.vertices, 2);
      break;
    }
    case Place::vertex:
    case Place::beside_vertex: {
      const auto v = std::uint8_t(pick(vertices_));
      out.at = x_[v];
      out.within = within(&v, 1);
      break;
    }
    case Place::level:
      for (int c = 0; c < 3; ++c)
        out.at[c] = x_[pick(vertices_)][c];
      break;
    case Place::around:
      for (int c = 0; c < 3; ++c)
        out.at[c] = low_[c] + (1.5 * unit() - 0.25) * (high_[c] - low_[c]);
      break;
    }
    if (out.place >= Place::beside_face && out.place <= Place::beside_vertex) {
      double& x = out.at[int(pick(3))];
      x = std::nextafter(x, pick(2) == 0 ? -HUGE_VAL : HUGE_VAL);
    }
    return out;
  }

private:
  std::uint64_t bits() {
    const std::uint64_t channel = channel_++;
    return core::random_bits(seed + channel / 8, item_, channel % 8);
  }
  std::size_t pick(std::int64_t n) { return std::size_t(bits() % std::uint64_t(n)); }
  double unit() { return double(bits() >> 11) * 0x1p-53; }

  void on_face(const cells::Face& f, Point& out) {
    double u = unit(), v = unit();
    const Vec3d &a = x_[f.vertices[0]], &b = x_[f.vertices[1]], &c = x_[f.vertices[2]];
    if (f.vertex_count == 4) {
      out.at = (1.0 - u) * (1.0 - v) * a + u * (1.0 - v) * b + u * v * c +
               (1.0 - u) * v * x_[f.vertices[3]];
    } else {
      if (u + v > 1.0) {
        u = 1.0 - u;
        v = 1.0 - v;
      }
      out.at = (1.0 - u - v) * a + u * b + v * c;
    }
    out.within = within(f.vertices, f.vertex_count);
  }

  bool within(const std::uint8_t* vertices, int count) const {
    return std::any_of(vertices, vertices + count,
                       [&](std::uint8_t v) { return !outside_[std::size_t(ids_[v])]; });
  }

  const workload::Mesh& mesh_;
  std::vector<bool> outside_;
  Vec3d low_, high_;
  std::uint64_t item_ = 0, channel_ = 0;
  Vec3d x_[8];
  const std::int32_t* ids_ = nullptr;
  int vertices_ = 0;
};

} // namespace

const char* name(Place place) {
  constexpr const char* names[] = {"inside",          "on a face",           "on an edge",
                                   "on a vertex",     "beside a face",       "beside an edge",
                                   "beside a vertex", "level with vertices", "around"};
  return names[int(place)];
}

std::vector<Point> make_points(const workload::Mesh& mesh, std::int64_t count) {
  Maker maker(mesh);
  std::vector<Point> out;
  for (std::int64_t i = 0; i < count; ++i)
    out.push_back(maker.make(std::uint64_t(i)));
  return out;
}

} // namespace insitu::bench::torture
