#pragma once

#include <cstring>
#include <deque>
#include <limits>
#include <vector>

#include "advect/lanes/lanes.h"
#include "analytic.h"
#include "fixtures/committed.h"

/// Particles one by one and in lanes, and meshes for them.
namespace insitu::test {

using advect::IntegratorSettings;
using advect::LaneVelocity;
using advect::Method;

inline constexpr double infinity = std::numeric_limits<double>::infinity();

struct Flow {
  const mesh::FieldView& now;
  advect::EarlierSteps earlier = nullptr;
  double t0 = 0.0, t1 = 0.0;
};

struct Ends {
  std::vector<advect::State> states;
  std::vector<insitu_ending> endings;
  std::vector<std::int64_t> cells;
  advect::Work work;
};

inline Ends one_by_one(const query::Sampler& sampler, const Flow& flow,
                       const IntegratorSettings& settings, const std::vector<Vec3d>& seeds,
                       double to, const advect::CellsBeyond* beyond) {
  Ends ends;
  advect::MeshVelocity field(sampler, flow.now, flow.earlier, flow.t0, flow.t1, INSITU_STANDARD);
  field.walk_by(beyond);
  for (const Vec3d& seed : seeds) {
    field.begin(-1);
    const Outcome r = run(field, settings, seed, to);
    ends.states.push_back(r.p);
    ends.endings.push_back(r.ending);
    ends.cells.push_back(field.cell());
    ends.work += r.work;
  }
  return ends;
}

inline Ends in_lanes(const query::Sampler& sampler, const Flow& flow,
                     const IntegratorSettings& settings, const std::vector<Vec3d>& seeds, double to,
                     const advect::CellsBeyond* beyond) {
  Ends ends;
  ends.states.resize(seeds.size());
  ends.endings.resize(seeds.size());
  ends.cells.resize(seeds.size());
  advect::run_lanes(
      sampler, 0, std::int64_t(seeds.size()),
      [&](std::deque<LaneVelocity>& lanes) {
        lanes.emplace_back(sampler, flow.now, flow.earlier, flow.t0, flow.t1, INSITU_STANDARD)
            .walk_by(beyond);
      },
      [&](std::int64_t i, std::size_t, LaneVelocity& field) {
        field.begin(-1);
        advect::State& p = ends.states[std::size_t(i)];
        p.x = seeds[std::size_t(i)];
        return advect::integration(field, settings, to, infinity, p, ends.work, advect::Visitor());
      },
      [&](std::int64_t i, std::size_t, LaneVelocity& field, const advect::Stepping& stepping) {
        ends.endings[std::size_t(i)] = stepping.ending();
        ends.cells[std::size_t(i)] = field.cell();
      });
  return ends;
}

inline bool same_bits(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

inline std::size_t different(const Ends& a, const Ends& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.states.size(); ++i) {
    const advect::State &p = a.states[i], &q = b.states[i];
    const bool same = same_bits(p.x.x, q.x.x) && same_bits(p.x.y, q.x.y) &&
                      same_bits(p.x.z, q.x.z) && same_bits(p.time, q.time) &&
                      same_bits(p.length, q.length) && a.endings[i] == b.endings[i] &&
                      a.cells[i] == b.cells[i];
    count += !same;
  }
  return count;
}

inline Vec3d swirl(const Vec3d& p) {
  return {-p.y + 0.3 * std::sin(5 * p.z), p.x - 0.2 * p.z, 0.4 * std::cos(4 * p.x) - 0.1};
}

/// More than there are lanes, some outside, some that leave.
inline std::vector<Vec3d> seeds() {
  std::vector<Vec3d> points = random_points(31, 3 * advect::LaneBatch::lane_count + 5, -1.1, 1.1);
  points.push_back({0, 0, 0});
  points.push_back({1, 1, 1});
  points.push_back({-1, 0.25, 0.5});
  return points;
}

/// A mesh with the velocity swirl().
struct Swirling {
  fixtures::Committed m;
  std::vector<double> v;

  explicit Swirling(const TestMesh& mesh, const std::vector<std::uint8_t>& ghosts = {}) : m(mesh) {
    for (const Vec3d& p : mesh.vertices)
      for (int a = 0; a < 3; ++a)
        v.push_back(swirl(p)[a]);
    const insitu_array array =
        insitu_array_of(v.data(), INSITU_FLOAT64, std::int64_t(mesh.vertices.size()), 3);
    m.mesh.mesh().set_field(0, "velocity", INSITU_VERTEX, &array, 1);
    if (!ghosts.empty()) {
      const insitu_array g =
          insitu_array_of(ghosts.data(), INSITU_UINT8, std::int64_t(ghosts.size()), 1);
      m.mesh.mesh().set_ghosts(0, &g, INSITU_GHOSTS_VTK);
    }
    m.commit();
    m.mesh.look_for_folds(m.threads);
  }
  query::Sampler sampler() const { return m.sampler(); }
  mesh::FieldView field() { return m.mesh.mesh().field("velocity"); }
};

/// Of blocks along each axis, about the box of seeds(). The fixtures' tetrahedra are mirrored by
/// halves, which proofs take for folds: unless asked for, they are turned.
inline TestMesh mesh_of(MeshKind kind, int size, bool mirrored = false) {
  Random random(5);
  TestMesh mesh = make_mesh({.kind = kind, .size = size, .jitter = 0.15}, random);
  for (Vec3d& p : mesh.vertices)
    p = (2.0 / size) * p - Vec3d{1, 1, 1};
  for (MeshCell& cell : mesh.cells) {
    const auto x = mesh.cell_vertices(cell);
    if (!mirrored && cell.shape == mesh::Shape::tetrahedron &&
        dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])) < 0)
      std::swap(cell.vertices[2], cell.vertices[3]);
  }
  return mesh;
}

inline constexpr MeshKind all_kinds[] = {MeshKind::hexahedra,  MeshKind::voxels,
                                         MeshKind::wedges,     MeshKind::pyramids,
                                         MeshKind::tetrahedra, MeshKind::mixed};

} // namespace insitu::test
