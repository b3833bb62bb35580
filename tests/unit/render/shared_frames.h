#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "render/structures/structures.h"
#include "unit/parallel/threaded_world.h"
#include "unit/render/parted_mesh.h"

/// Frames of a mesh that is spread over processes, beside those of one process.
namespace insitu::test {

using render::FrameImages;
using render::FramePart;
using render::FrameSettings;
using render::FrameStatistics;
using render::ScalarField;

inline double blob(const Vec3d& p) {
  const Vec3d d = p - Vec3d{0.4, 0.5, 0.6};
  return std::max(0.0, 1 - 4 * dot(d, d));
}
inline double waves(const Vec3d& p) {
  return 0.5 + 0.25 * std::sin(9 * p.x + 2 * p.y) + 0.25 * std::cos(7 * p.z - 3 * p.y);
}

/// How cells are dealt out to so many processes.
struct Partition {
  const char* name;
  std::function<Deal(int processes)> deal;
  int pieces = 1;
};
inline const std::vector<Partition>& partitions() {
  static const std::vector<Partition> all = {
      {"slabs",
       [](int n) {
         return [n](std::size_t, const Vec3d& p) { return std::clamp(int(p.x * n), 0, n - 1); };
       }},
      {"boxes",
       [](int n) {
         return [n](std::size_t, const Vec3d& p) {
           return (int(p.x > 0.45) + 2 * int(p.y > 0.55) + 4 * int(p.z > 0.5)) % n;
         };
       },
       3},
      {"random",
       [](int n) {
         return [n](std::size_t cell, const Vec3d&) {
           return int(core::random_unit(7, cell, 0) * n) % n;
         };
       }},
      {"all on the last", [](int n) { return [n](std::size_t, const Vec3d&) { return n - 1; }; }},
      {"none on the second", [](int n) {
         return [n](std::size_t, const Vec3d& p) {
           const int process = std::clamp(int(p.z * n), 0, n - 1);
           return process == 1 ? 0 : process;
         };
       }}};
  return all;
}

/// What a frame shows, given the fields "f" of vertices and "c" of cells.
using Show = std::function<FrameSettings(const ScalarField& f, const ScalarField& c)>;

struct Drawn {
  std::vector<float> color, depth;
  std::vector<std::int64_t> cell;
  FrameStatistics done;
};

inline Drawn kept(const FrameImages& images) {
  return {{images.color.rgba.begin(), images.color.rgba.end()},
          {images.depth.begin(), images.depth.end()},
          {images.cell.begin(), images.cell.end()},
          {}};
}

/// The frame of a mesh that is whole.
template <class Mesh>
Drawn drawn_of(Mesh& mesh, const Show& show) {
  const ScalarField c = mesh.field("c", INSITU_CELL, waves);
  const FrameSettings settings = show(mesh.field("f", INSITU_VERTEX, blob), c);
  return kept(
      render::render_frame(mesh.sampler(), settings, core::Threads(2), mesh.committed.memory));
}

/// The frame of several processes; make(rank): what a process has of the mesh.
template <class Make>
Drawn drawn_on(int processes, const Make& make, const Show& show, bool with_halo = false,
               std::size_t most_bytes = std::size_t(32) << 20,
               render::Compositing compositing = render::Compositing::exact) {
  Drawn drawn;
  run_processes(processes, [&](parallel::World& world) {
    auto mesh = make(world.rank());
    const ScalarField c = mesh.field("c", INSITU_CELL, waves);
    const ScalarField f = mesh.field("f", INSITU_VERTEX, blob);
    mesh.meet_others(world, with_halo);
    const FrameSettings settings = show(mesh.known(f), mesh.known(c));
    render::Structures structures(mesh.committed.memory);
    const core::Threads threads(1);
    structures.begin(mesh.committed.sampler(), 0, 0, threads);
    FramePart part = mesh.part(world);
    part.most_bytes = most_bytes;
    part.compositing = compositing;
    FrameStatistics done;
    const FrameImages images =
        render::render_shared_frame(part, mesh.sampler(), settings, structures, threads, &done);
    if (world.is_root()) {
      drawn = kept(images);
      drawn.done = done;
    } else {
      EXPECT_TRUE(images.color.rgba.empty());
    }
  });
  return drawn;
}

inline Drawn on_one(const TestMesh& whole, const Show& show) {
  PartedMesh mesh(
      whole, [](std::size_t, const Vec3d&) { return 0; }, 0);
  return drawn_of(mesh, show);
}

inline Drawn on_several(const TestMesh& whole, const Show& show, int processes,
                        const Partition& parts, bool with_halo = false,
                        std::size_t most_bytes = std::size_t(32) << 20,
                        render::Compositing compositing = render::Compositing::exact) {
  return drawn_on(
      processes,
      [&](int rank) { return PartedMesh(whole, parts.deal(processes), rank, parts.pieces); }, show,
      with_halo, most_bytes, compositing);
}

template <class T>
std::size_t differing(const std::vector<T>& a, const std::vector<T>& b) {
  if (a.size() != b.size())
    return std::max(a.size(), b.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    count += std::memcmp(&a[i], &b[i], sizeof(T)) != 0;
  return count;
}

inline void expect_equal(const Drawn& one, const Drawn& several) {
  std::size_t seen = 0; // pixels that are not background
  for (std::size_t i = 0; i < one.color.size(); i += 4)
    seen += one.color[i] > 0;
  EXPECT_GT(seen, one.color.size() / 4 / 20);
  EXPECT_EQ(differing(one.color, several.color), 0u);
  EXPECT_EQ(differing(one.depth, several.depth), 0u);
  EXPECT_EQ(differing(one.cell, several.cell), 0u);
}

/// On two numbers of processes; a test's next seed takes others, and other partitions.
inline void expect_same(const TestMesh& whole, const Show& show, int seed = 0,
                        bool with_halo = false) {
  constexpr int counts[] = {1, 2, 3, 4, 8};
  const Drawn one = on_one(whole, show);
  for (const int k : {0, 1}) {
    const int processes = counts[(seed + 2 * k) % 5];
    const Partition& parts = partitions()[std::size_t(seed + seed / 5 + k) % partitions().size()];
    SCOPED_TRACE(testing::Message() << processes << " processes, " << parts.name);
    expect_equal(one, on_several(whole, show, processes, parts, with_halo));
  }
}

inline FrameSettings frame() {
  FrameSettings s = box_frame(70);
  s.height = 66;
  s.depth = s.cell = true;
  return s;
}

inline render::VolumeSettings soft(const ScalarField& field) {
  render::VolumeSettings volume{
      field,
      {render::ColorMap::built_in("viridis"), 0.0, 1.0, {{0, 0}, {0.3, 0}, {0.6, 0.1}, {1, 0.7}}}};
  volume.unit_distance = 0.1;
  return volume;
}

inline constexpr Shape shapes[] = {Shape::hexahedron, Shape::tetrahedron, Shape::wedge,
                                   Shape::pyramid};

} // namespace insitu::test
