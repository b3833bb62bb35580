#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "advect/field/homes.h"
#include "fixtures/committed.h"

/// A mesh of several processes whose parts have a halo, made by the test itself.
namespace insitu::test {

/// Of each cell of a whole mesh its process; of each process its cells and those of others about
/// them, by ascending cell of the whole.
struct HaloPlan {
  const TestMesh* whole;
  std::vector<int> process;                     ///< [cell]
  std::vector<std::vector<std::int64_t>> cells; ///< [process]

  /// layers: of others' cells about a process's; below 0: all of them.
  HaloPlan(const TestMesh& mesh, std::vector<int> of, int processes, int layers)
      : whole(&mesh), process(std::move(of)), cells(std::size_t(processes)) {
    for (int r = 0; r < processes; ++r) {
      std::vector<bool> in(mesh.cells.size());
      for (std::size_t c = 0; c < in.size(); ++c)
        in[c] = layers < 0 || process[c] == r;
      for (int layer = 0; layer < layers; ++layer)
        in = with_neighbours(in);
      for (std::size_t c = 0; c < in.size(); ++c)
        if (in[c])
          cells[std::size_t(r)].push_back(std::int64_t(c));
    }
  }

private:
  std::vector<bool> with_neighbours(const std::vector<bool>& in) const {
    std::vector<bool> vertices(whole->vertices.size()), out = in;
    const auto each = [&](std::size_t c, auto&& visit) {
      for (int v = 0; v < mesh::vertex_count(whole->cells[c].shape); ++v)
        visit(std::size_t(whole->cells[c].vertices[std::size_t(v)]));
    };
    for (std::size_t c = 0; c < in.size(); ++c)
      if (in[c])
        each(c, [&](std::size_t v) { vertices[v] = true; });
    for (std::size_t c = 0; c < in.size(); ++c)
      each(c, [&](std::size_t v) { out[c] = out[c] || vertices[v]; });
    return out;
  }
};

/// The part of one process as a committed mesh of one piece.
class HaloPart final : public advect::Homes {
public:
  HaloPart(const HaloPlan& plan, int rank) : plan_(&plan), rank_(rank), m(part_of()) {}

  bool is_own(std::int64_t cell) const override { return process(cell) == rank_; }
  mesh::CellName name(std::int64_t cell) const override {
    const int owner = process(cell);
    return {-1, owner, 0, place(owner, global(cell))};
  }
  std::int64_t find(const mesh::CellName& name) const override {
    return place(rank_, plan_->cells[std::size_t(name.rank)][std::size_t(name.cell)]);
  }
  std::int64_t global(std::int64_t cell) const {
    return cell < 0 ? -1 : plan_->cells[std::size_t(rank_)][std::size_t(cell)];
  }

  /// Values of the whole's vertices, [vertex][component].
  void set_field(const std::string& name, const std::vector<Vec3d>& of_whole) {
    std::vector<double>& values = fields_[name];
    const bool known = !values.empty();
    values.resize(3 * vertices_.size());
    for (std::size_t v = 0; v < vertices_.size(); ++v)
      for (int a = 0; a < 3; ++a)
        values[3 * v + std::size_t(a)] = of_whole[std::size_t(vertices_[v])][a];
    const insitu_array array =
        insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(vertices_.size()), 3);
    if (!known)
      m.mesh.mesh().set_field(0, name.c_str(), INSITU_VERTEX, &array, 1);
  }
  void move(const std::vector<Vec3d>& of_whole) {
    for (std::size_t v = 0; v < vertices_.size(); ++v)
      for (int a = 0; a < 3; ++a)
        m.arrays.points[3 * v + std::size_t(a)] = of_whole[std::size_t(vertices_[v])][a];
  }

private:
  int process(std::int64_t cell) const { return plan_->process[std::size_t(global(cell))]; }
  std::int64_t place(int rank, std::int64_t global) const {
    const auto& of = plan_->cells[std::size_t(rank)];
    const auto at = std::ranges::lower_bound(of, global);
    return at != of.end() && *at == global ? at - of.begin() : -1;
  }
  TestMesh part_of() {
    const TestMesh& whole = *plan_->whole;
    TestMesh part;
    std::map<int, int> local;
    const auto& cells = plan_->cells[std::size_t(rank_)];
    for (const std::int64_t c : cells)
      for (int v = 0; v < mesh::vertex_count(whole.cells[std::size_t(c)].shape); ++v)
        local[whole.cells[std::size_t(c)].vertices[std::size_t(v)]] = 0;
    for (auto& [id, at] : local) {
      at = int(vertices_.size());
      vertices_.push_back(id);
      part.vertices.push_back(whole.vertices[std::size_t(id)]);
    }
    for (const std::int64_t c : cells) {
      MeshCell cell = whole.cells[std::size_t(c)];
      for (int v = 0; v < mesh::vertex_count(cell.shape); ++v)
        cell.vertices[std::size_t(v)] = local[cell.vertices[std::size_t(v)]];
      part.cells.push_back(cell);
    }
    return part;
  }

  const HaloPlan* plan_;
  int rank_;
  std::vector<std::int64_t> vertices_; ///< of the whole
  std::map<std::string, std::vector<double>> fields_;

public:
  fixtures::Committed m;
};

} // namespace insitu::test
