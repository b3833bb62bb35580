#pragma once

#include <gtest/gtest.h>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "../parallel/threaded_world.h"
#include "advect/pathlines.h"
#include "box_mesh.h"
#include "halo_parts.h"
#include "lane_runs.h"

/// Tracers over processes whose halos the tests make, beside one process.
namespace insitu::test {

/// What is known of a particle at the end, whoever has it.
struct Told {
  std::int64_t id;
  Vec3d x;
  double time, length, step;
  int ending;
  std::int64_t cell; ///< of the whole
  bool operator==(const Told& b) const {
    return id == b.id && same_bits(x.x, b.x.x) && same_bits(x.y, b.x.y) && same_bits(x.z, b.x.z) &&
           same_bits(time, b.time) && same_bits(length, b.length) && same_bits(step, b.step) &&
           ending == b.ending && cell == b.cell;
  }
};
struct Shot { ///< a snapshot
  std::int64_t id;
  std::size_t cycle, number;
  std::int32_t hops;
  Vec3d x;
  std::int64_t cell;
};

struct Ran {
  std::vector<Told> particles; ///< by id
  std::vector<Shot> shots;     ///< by id, cycle and number
  advect::Counts counts;
  advect::Work work;
};

struct Scene {
  std::string name;
  TestMesh mesh;
  advect::TracerSettings settings;
  advect::Effects effects;
  bool moves = false;
  bool turns = false; ///< the flow goes round within the mesh, and so do the seeds
  bool takes_shots = true;
  int many = 0; ///< so many seeds in each cycle, instead of some
  int cycles = 3;
  double interval = 0.4;
};

inline Vec3d flow(const Vec3d& p, int cycle, bool turns) {
  return (1.0 + 0.1 * cycle) * (turns ? Vec3d{-p.y, p.x, 0.2 * p.x * p.y} : swirl(p));
}
/// Where the vertices of a mesh that moves are.
inline Vec3d moved(const Vec3d& p, int cycle) {
  return p + 0.02 * cycle * Vec3d{std::sin(2 * p.y), p.z, 0.5 * p.x};
}
inline std::vector<Vec3d> vertices_at(const Scene& scene, int cycle) {
  std::vector<Vec3d> out;
  for (const Vec3d& p : scene.mesh.vertices)
    out.push_back(scene.moves ? moved(p, cycle) : p);
  return out;
}
inline std::vector<Vec3d> velocity_at(const Scene& scene, int cycle) {
  std::vector<Vec3d> out;
  for (const Vec3d& x : vertices_at(scene, cycle))
    out.push_back(flow(x, cycle, scene.turns));
  return out;
}

/// One process: the whole in one World of one process is the serial run.
inline Ran run_process(const Scene& scene, const HaloPlan& plan, parallel::World& world,
                       bool serial) {
  HaloPart part(plan, world.rank());
  part.set_field("v", velocity_at(scene, 0));
  part.m.commit();
  part.m.mesh.look_for_folds(part.m.threads);
  advect::Tracer tracer(scene.settings, part.m.memory);
  tracer.set_effects(scene.effects);
  const advect::Across across{world, part};
  Ran run;
  double t0 = 0.0;
  std::vector<double> before;
  for (int cycle = 0; cycle < scene.cycles; ++cycle) {
    const double t1 = scene.interval * cycle;
    std::vector<mesh::FieldView> earlier;
    if (cycle > 0) {
      part.m.mesh.keep_earlier({{"v", 1}}, false, part.m.threads);
      part.set_field("v", velocity_at(scene, cycle));
      if (scene.moves)
        part.move(vertices_at(scene, cycle));
      part.m.commit(scene.moves ? INSITU_CHANGED_GEOMETRY | INSITU_CHANGED_FIELDS
                                : INSITU_CHANGED_FIELDS);
      part.m.mesh.look_for_folds(part.m.threads);
      earlier = part.m.mesh.mesh().earlier_fields("v");
      part.m.mesh.show_earlier(part.m.threads);
    } else {
      part.m.mesh.hide_earlier();
    }
    const query::Sampler sampler = part.m.mesh.sampler();
    std::vector<Vec3d> points = scene.many > 0 ? random_points(31 + std::uint64_t(cycle),
                                                               std::size_t(scene.many), -1.05, 1.05)
                                               : seeds();
    for (Vec3d& p : points)
      p = scene.moves ? moved(p, cycle) : scene.turns ? 0.4 * p : p;
    advect::Snapshots shots(
        cycle > 0 ? std::vector<double>{t0 + 0.3 * (t1 - t0), t0 + 0.7 * (t1 - t0), t1}
                  : std::vector<double>{t1},
        part.m.memory);
    const mesh::FieldView velocity = part.m.mesh.mesh().field("v");
    const auto no_cells = [] { return static_cast<query::SomeCells*>(nullptr); };
    advect::Exits exits(sampler, no_cells, INSITU_STANDARD);
    tracer.tell_exits_by(&exits);
    advect::Advance a;
    if (serial) {
      tracer.seed(points, t1);
      a = tracer.advance(sampler, velocity, {earlier, before}, t0, t1, part.m.threads,
                         scene.takes_shots ? &shots : nullptr);
    } else {
      tracer.seed(points, t1, sampler, across);
      a = tracer.advance(across, sampler, velocity, {earlier, before}, t0, t1, part.m.threads,
                         scene.takes_shots ? &shots : nullptr);
    }
    run.counts = a.counts;
    run.work += a.work;
    for (std::size_t k = 0; scene.takes_shots && k < shots.times.size(); ++k)
      for (std::size_t i = 0; i < shots.particles; ++i)
        if (const std::size_t item = shots.item(k, i); shots.present[item])
          run.shots.push_back({tracer.particles().ids[i], std::size_t(cycle), k, shots.hops[i],
                               shots.positions[item], part.global(shots.places[item].cell)});
    tracer.drop_gone();
    t0 = t1;
  }
  const advect::Particles& p = tracer.particles();
  for (std::size_t i = 0; i < p.size(); ++i)
    run.particles.push_back({p.ids[i], p.positions[i], p.times[i], p.lengths[i], p.steps[i],
                             int(p.endings[i]), part.global(p.cells[i])});
  return run;
}

inline Ran run_on(const Scene& scene, const std::vector<int>& process, int processes, int layers,
                  bool serial = false) {
  const HaloPlan plan(scene.mesh, process, processes, layers);
  Ran all;
  std::mutex mutex;
  run_processes(processes, [&](parallel::World& world) {
    Ran run = run_process(scene, plan, world, serial);
    const std::lock_guard lock(mutex);
    all.particles.insert(all.particles.end(), run.particles.begin(), run.particles.end());
    all.shots.insert(all.shots.end(), run.shots.begin(), run.shots.end());
    all.counts = run.counts;
    all.work = run.work;
  });
  std::ranges::sort(all.particles, {}, &Told::id);
  std::ranges::sort(all.shots, [](const Shot& a, const Shot& b) {
    return std::tie(a.id, a.cycle, a.number, b.hops) < std::tie(b.id, b.cycle, b.number, a.hops);
  });
  // Of a moment that was taken again after a hop the last counts.
  const auto again = std::ranges::unique(all.shots, [](const Shot& a, const Shot& b) {
    return a.id == b.id && a.cycle == b.cycle && a.number == b.number;
  });
  all.shots.erase(again.begin(), again.end());
  return all;
}

inline std::vector<int> slabs(const TestMesh& mesh, int processes) {
  std::vector<int> process;
  for (const MeshCell& cell : mesh.cells) {
    const Vec3d x = mesh.vertices[std::size_t(cell.vertices[0])];
    process.push_back(std::clamp(int((0.5 * x.x + 0.5) * processes), 0, processes - 1));
  }
  return process;
}
inline std::vector<int> boxes(const TestMesh& mesh, int processes) {
  std::vector<int> process;
  for (const MeshCell& cell : mesh.cells) {
    const Vec3d x = mesh.vertices[std::size_t(cell.vertices[0])];
    const int octant = (x.x > -0.1) + 2 * (x.y > 0.1) + 4 * (x.z > 0.0);
    process.push_back(octant * processes / 8);
  }
  return process;
}
inline std::vector<int> dealt(const TestMesh& mesh, int processes) {
  Random random(3);
  std::vector<int> process;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    process.push_back(random.below(processes));
  return process;
}

inline void expect_the_same(const Ran& a, const Ran& b, const std::string& how) {
  ASSERT_EQ(a.particles.size(), b.particles.size()) << how;
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < a.particles.size(); ++i)
    if (!(a.particles[i] == b.particles[i]) && wrong++ < 3) {
      const Told &p = a.particles[i], &q = b.particles[i];
      ADD_FAILURE() << how << ": particle " << p.id << "/" << q.id << " ending " << p.ending << "/"
                    << q.ending << " cell " << p.cell << "/" << q.cell << " x " << p.x.x - q.x.x
                    << " " << p.x.y - q.x.y << " " << p.x.z - q.x.z << " time " << p.time - q.time
                    << " length " << p.length - q.length << " step " << p.step - q.step;
    }
  EXPECT_EQ(wrong, 0U) << how;
  ASSERT_EQ(a.shots.size(), b.shots.size()) << how;
  wrong = 0;
  for (std::size_t i = 0; i < a.shots.size(); ++i) {
    const Shot &p = a.shots[i], &q = b.shots[i];
    wrong += !(p.id == q.id && p.cycle == q.cycle && p.number == q.number && p.x == q.x &&
               p.cell == q.cell);
  }
  EXPECT_EQ(wrong, 0U) << how << ", snapshots";
  EXPECT_EQ(a.counts.seeded, b.counts.seeded) << how;
  EXPECT_EQ(a.counts.by_ending, b.counts.by_ending) << how;
  EXPECT_EQ(a.work.steps, b.work.steps) << how;
  EXPECT_EQ(a.work.rejected, b.work.rejected) << how;
  EXPECT_EQ(a.work.forced, b.work.forced) << how;
  EXPECT_EQ(a.work.evaluations, b.work.evaluations) << how;
}

/// layers: of the halo; below 0: all cells.
inline void try_all(const Scene& scene, int layers, std::vector<int> numbers = {1, 2, 3, 4, 8}) {
  const Ran serial = run_on(scene, std::vector<int>(scene.mesh.cells.size()), 1, 0, true);
  for (const int n : numbers) {
    const std::string how =
        scene.name + " on " + std::to_string(n) + ", layers " + std::to_string(layers);
    expect_the_same(serial, run_on(scene, slabs(scene.mesh, n), n, layers), how + ", slabs");
    expect_the_same(serial, run_on(scene, boxes(scene.mesh, n), n, layers), how + ", boxes");
    expect_the_same(serial, run_on(scene, dealt(scene.mesh, n), n, layers), how + ", dealt");
  }
}

inline advect::TracerSettings settings_of(Method method, bool by_faces) {
  advect::TracerSettings settings;
  settings.integrator.method = method;
  settings.integrator.face_aware = by_faces;
  return settings;
}

} // namespace insitu::test
