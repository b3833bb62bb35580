#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "amr_meshes.h"
#include "amr_session.h"
#include "face_part.h"
#include "flat_part.h"
#include "part_session.h"

/// Solvers of meshes of all kinds, with processes as threads.
namespace insitu::test {

/// What one process of a solver gives of its mesh.
class Solver {
public:
  virtual ~Solver() = default;
  /// The cells; nothing where the process has none.
  virtual void give(mesh::Mesh& to) = 0;
  /// Before each execution: values, and vertices where they are.
  virtual void step(mesh::Mesh& to, int cycle) = 0;
};

/// A session whose mesh 'm' is a solver's. Warnings are failures, but for those that tell of steps
/// shown again.
class SolverSession {
public:
  SolverSession(parallel::World& world, const std::string& scene, const std::string& folder)
      : session_(options_of(scene, folder),
                 std::shared_ptr<parallel::World>(&world, [](auto*) {})) {
    session_.open(options_of(scene, folder));
  }
  api::Session& session() { return session_; }
  commit::CommittedMesh& mesh() { return session_.mesh("m").mesh; }
  /// The solver's cells, or those of another one.
  void take(std::unique_ptr<Solver> solver) {
    solver_ = std::move(solver);
    mesh().mesh().drop_pieces(0);
    solver_->give(mesh().mesh());
  }
  void step(int cycle) { solver_->step(mesh().mesh(), cycle); }
  std::string execute(int cycle) {
    step(cycle);
    return session_.execute(cycle, 0.25 * cycle);
  }

private:
  static insitu_session_options options_of(const std::string& scene, const std::string& folder) {
    insitu_session_options o = insitu_session_options_default();
    o.scene_text = scene.c_str();
    o.output = folder.c_str();
    o.threads = 1;
    o.log = [](insitu_log_level level, const char* message, void*) {
      const std::string_view said = message;
      if (level <= INSITU_LOG_WARNING && said.find("goes on with live steps alone") == said.npos &&
          said.find("numbers of cycles come again") == said.npos)
        ADD_FAILURE() << message;
    };
    return o;
  }

  std::unique_ptr<Solver> solver_;
  api::Session session_;
};

class FaceSolver final : public Solver {
public:
  FaceSolver(const FaceMesh& whole, const FaceDeal& deal, int rank, bool moves)
      : part_(whole, deal, rank), moves_(moves) {}
  void give(mesh::Mesh& to) override {
    if (!part_.empty())
      part_.give(to);
  }
  void step(mesh::Mesh& to, int cycle) override {
    if (part_.empty())
      return;
    if (moves_)
      part_.move(to, cycle);
    part_.give_fields(to, 0.37 * cycle);
  }

private:
  FacePart part_;
  bool moves_;
};

/// Of squares from 0 to 5 along x and y.
class FlatSolver final : public Solver {
public:
  FlatSolver(const Flat& whole, int processes, int rank)
      : part_(whole, flat_slabs(whole, processes), rank) {}
  void give(mesh::Mesh& to) override {
    if (!part_.empty())
      part_.give(to);
  }
  void step(mesh::Mesh& to, int cycle) override {
    if (!part_.empty())
      part_.give_fields(to, 0.37 * cycle, 2.5);
  }

private:
  FlatPart part_;
};

/// Blocks from 0 to 4 along each axis, four along z, one of each kind and a second one that is
/// uniform, which processes have in turns of as many. The curvilinear one moves inside.
class BlockSolver final : public Solver {
public:
  BlockSolver(int processes, int rank) {
    for (int b = rank * 4 / processes; b < (rank + 1) * 4 / processes; ++b)
      blocks_.push_back(std::make_unique<Block>(b));
  }
  void give(mesh::Mesh& to) override {
    const auto array = [](const auto& values, insitu_type type, int components) {
      return insitu_array_of(values.data(), type, std::int64_t(values.size()) / components,
                             components);
    };
    for (std::size_t p = 0; p < blocks_.size(); ++p) {
      Block& block = *blocks_[p];
      const auto piece = std::int32_t(p);
      insitu_block given = insitu_block_default();
      given.kind = block.kind;
      for (int a = 0; a < 3; ++a) {
        given.vertices[a] = counts[a];
        given.spacing[a] = spacing[a];
        given.first[a] = block.kind == INSITU_BLOCK_UNIFORM && a == 2 ? 2 * block.number : 0;
        if (block.kind == INSITU_BLOCK_RECTILINEAR)
          given.coordinates[a] = array(block.axes[a], INSITU_FLOAT64, 1);
      }
      to.set_block(piece, &given);
      if (block.kind == INSITU_BLOCK_CURVILINEAR) {
        const insitu_array points = array(block.points, INSITU_FLOAT64, 3);
        to.set_points(piece, &points, 1);
      }
      insitu_array ids = array(block.cells, INSITU_INT64, 1);
      to.set_global_ids(piece, INSITU_CELL, &ids);
      ids = array(block.vertices, INSITU_INT64, 1);
      to.set_global_ids(piece, INSITU_VERTEX, &ids);
    }
  }
  void step(mesh::Mesh& to, int cycle) override {
    const double t = 0.37 * cycle;
    for (std::size_t p = 0; p < blocks_.size(); ++p) {
      Block& block = *blocks_[p];
      if (block.kind == INSITU_BLOCK_CURVILINEAR && cycle > 0) {
        block.place(cycle);
        to.set_changed(INSITU_CHANGED_GEOMETRY);
      }
      block.fields.begin(block.cells, t);
      for (std::size_t v = 0; v < block.vertices.size(); ++v) {
        const double* const x = &block.points[3 * v];
        block.fields.p.push_back(std::sin(3 * x[0] + t) + x[1] * x[2]);
        block.fields.u.insert(block.fields.u.end(), {2 - x[1], x[0] - 2, 0.1 * std::cos(t)});
      }
      block.fields.give(to, std::int32_t(p));
    }
  }

private:
  static constexpr std::int64_t counts[3] = {5, 5, 3};
  static constexpr double spacing[3] = {1, 1, 0.5};

  struct Block {
    explicit Block(int which)
        : number(which), kind(which == 1   ? INSITU_BLOCK_RECTILINEAR
                              : which == 2 ? INSITU_BLOCK_CURVILINEAR
                                           : INSITU_BLOCK_UNIFORM) {
      for (int a = 0; a < 3; ++a)
        for (int i = 0; i < counts[a]; ++i)
          axes[a].push_back((a == 2 ? double(number) : 0.0) + spacing[a] * i);
      for (std::int64_t v = 0; v < 5 * 5 * 3; ++v)
        vertices.push_back(2 * 5 * 5 * number + v);
      for (std::int64_t cell = 0; cell < 4 * 4 * 2; ++cell)
        cells.push_back(2 * 4 * 4 * number + cell);
      place(0);
    }
    void place(int cycle) {
      points.clear();
      for (std::size_t k = 0; k < 3; ++k) // those on its lower and upper side stay
        for (const double y : axes[1])
          for (const double x : axes[0])
            points.insert(points.end(), {x, y, axes[2][k] + (k == 1 ? 0.03 * cycle : 0.0)});
    }
    int number;
    insitu_block_kind kind;
    std::vector<double> axes[3], points;
    PartFields fields;
    std::vector<std::int64_t> vertices, cells;
  };
  std::vector<std::unique_ptr<Block>> blocks_;
};

class AmrSolver final : public Solver {
public:
  AmrSolver(const AmrMesh& whole, int processes, int rank)
      : part_(whole, INSITU_DUAL, deal_of(0, processes), rank) {}
  void give(mesh::Mesh& to) override { part_.give(to); }
  void step(mesh::Mesh& to, int cycle) override { part_.give_fields(to, 1.0 + 0.25 * cycle); }

private:
  AmrPart part_;
};

/// A kind of mesh: its scene's actions, and the solver of a process.
struct SolverKind {
  std::string name, actions, scalar;
  std::function<std::unique_ptr<Solver>(int processes, int rank)> make;
};

/// With fields p and u at vertices and c in cells, but s and v of an adaptive mesh.
inline std::vector<SolverKind> solver_kinds() {
  const auto actions = [](const std::string& p, const std::string& u, const std::string& c) {
    return "probes:\n"
           "  - {name: gauges, points: [[1, 1, 1], [2.1, 1.3, 0.7], [2, 2, 2], [9, 9, 9]], fields: "
           "[" +
           p + ", " + c +
           "], outside: nearest, output: [csv]}\n"
           "tracers:\n"
           "  - {name: paths, velocity: " +
           u +
           ", seeds: {box: {min: [0.5, 0.5, 0.5], max: [2.6, 2.6, 2.6], counts: [3, 3, 3]}}, "
           "fields: [" +
           p + ", " + c +
           "], output: [csv, vtp]}\n"
           "  - {name: lines, kind: streamline, velocity: " +
           u +
           ", seeds: [[1, 1, 1], [2, 1.5, 1]], until: {duration: 2}}\n"
           "frames:\n"
           "  - {name: seen, size: [24, 24], isosurfaces: [{field: " +
           (c == "v" ? "v, component: 0" : c) +
           ", values: [0.5]}]}\n"
           "  - {name: inside, size: [24, 24], volume: {field: " +
           p + "}}\n";
  };
  const auto faces = std::make_shared<FaceMesh>(fixtures::cut_hexahedra(3, 2));
  const auto flat =
      std::make_shared<Flat>(flat_meshes::flat_mesh(5, flat_meshes::Kind::mixed, true));
  const auto tree = std::make_shared<AmrMesh>(octree());
  const std::string usual = actions("p", "u", "c");
  return {{"polyhedra", usual, "p",
           [faces](int processes, int rank) -> std::unique_ptr<Solver> {
             return std::make_unique<FaceSolver>(*faces, FaceDeal{processes}, rank, true);
           }},
          {"flat", usual, "p",
           [flat](int processes, int rank) -> std::unique_ptr<Solver> {
             return std::make_unique<FlatSolver>(*flat, processes, rank);
           }},
          {"blocks", usual, "p",
           [](int processes, int rank) -> std::unique_ptr<Solver> {
             return std::make_unique<BlockSolver>(processes, rank);
           }},
          {"adaptive", actions("s", "v", "v"), "s",
           [tree](int processes, int rank) -> std::unique_ptr<Solver> {
             return std::make_unique<AmrSolver>(*tree, processes, rank);
           }}};
}

} // namespace insitu::test
