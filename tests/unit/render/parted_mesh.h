#pragma once

#include <functional>
#include <list>
#include <map>
#include <vector>

#include "fixtures/committed.h"
#include "render/processes/frame_part.h"
#include "render/processes/whole_facts.h"
#include "unit/render/render_mesh.h"

/// Meshes that are dealt out to processes.
namespace insitu::test {

/// The process of a cell, by its number and the mean of its vertices.
using Deal = std::function<int(std::size_t cell, const Vec3d& middle)>;

inline Vec3d middle_of(const TestMesh& mesh, const MeshCell& cell) {
  Vec3d middle;
  const int count = mesh::vertex_count(cell.shape);
  for (int v = 0; v < count; ++v)
    middle += mesh.vertices[std::size_t(cell.vertices[std::size_t(v)])] / double(count);
  return middle;
}

/// Cells of a mesh, by ascending number, with vertices of their own.
inline TestMesh picked(const TestMesh& whole, const std::vector<std::size_t>& cells) {
  TestMesh part;
  std::map<std::int32_t, std::int32_t> ids;
  for (const std::size_t c : cells) {
    MeshCell cell = whole.cells[c];
    for (int v = 0; v < mesh::vertex_count(cell.shape); ++v) {
      std::int32_t& id = cell.vertices[std::size_t(v)];
      const auto [at, is_new] = ids.emplace(id, std::int32_t(part.vertices.size()));
      if (is_new)
        part.vertices.push_back(whole.vertices[std::size_t(id)]);
      id = at->second;
    }
    part.cells.push_back(cell);
  }
  return part;
}

/// What one process has of a mesh: the cells that are dealt to it, in so many pieces.
class PartedMesh {
public:
  PartedMesh(const TestMesh& whole, const Deal& deal, int process, int pieces = 1) : committed(1) {
    for (std::size_t c = 0; c < whole.cells.size(); ++c)
      if (deal(c, middle_of(whole, whole.cells[c])) == process)
        numbers.push_back(std::int64_t(c));
    for (int p = 0; p < pieces && !numbers.empty(); ++p) {
      const std::size_t begin = numbers.size() * std::size_t(p) / std::size_t(pieces);
      const std::size_t end = numbers.size() * std::size_t(p + 1) / std::size_t(pieces);
      parts.push_back(picked(
          whole, {numbers.begin() + std::ptrdiff_t(begin), numbers.begin() + std::ptrdiff_t(end)}));
      arrays_.emplace_back(parts.back());
      const insitu_array x = arrays_.back().point_array();
      const insitu_cells c = arrays_.back().cells();
      committed.mesh.mesh().set_points(std::int32_t(p), &x, 1);
      committed.mesh.mesh().set_cells(std::int32_t(p), &c);
      const insitu_array ids =
          insitu_array_of(numbers.data() + begin, INSITU_INT64, std::int64_t(end - begin), 1);
      committed.mesh.mesh().set_global_ids(std::int32_t(p), INSITU_CELL, &ids);
    }
    committed.commit();
  }

  /// f at vertices, or at the middles of cells. Without cells the field has no values.
  render::ScalarField field(const char* name, insitu_association association,
                            const std::function<double(const Vec3d&)>& f) {
    if (numbers.empty())
      return {{name, association, 1, nullptr, false}, -1};
    std::int32_t p = 0;
    for (const TestMesh& part : parts) {
      std::vector<double>& values = values_.emplace_back();
      if (association == INSITU_VERTEX)
        for (const Vec3d& x : part.vertices)
          values.push_back(f(x));
      else
        for (const MeshCell& cell : part.cells)
          values.push_back(f(middle_of(part, cell)));
      const insitu_array a =
          insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(values.size()), 1);
      committed.mesh.mesh().set_field(p++, name, association, &a, 1);
    }
    committed.commit(INSITU_CHANGED_FIELDS);
    return {committed.mesh.mesh().field(name), -1};
  }

  /// Gives the mesh the cells of others around its own, and the facts of the whole. Collective.
  void meet_others(parallel::World& world, bool with_halo) {
    if (with_halo)
      committed.mesh.update_halo(world, committed.threads, committed.log);
    committed.mesh.set_whole_facts(
        render::whole_facts(world, mesh::find_facts(committed.mesh.mesh().view(), nullptr)));
  }
  /// The field again, after meet_others().
  render::ScalarField known(const render::ScalarField& field) const {
    if (numbers.empty())
      return field;
    return {committed.mesh.mesh().field(field.field.name), field.component};
  }
  render::FramePart part(parallel::World& world) const {
    const mesh::Mesh& mesh = committed.mesh.mesh();
    const std::int64_t own = mesh.view().own_cell_count();
    return {world, own, [&mesh](std::int64_t flat) { return mesh.global_id(INSITU_CELL, flat); }};
  }

  query::Sampler sampler() const { return committed.mesh.own_sampler(); }

  fixtures::Committed committed;
  std::vector<std::int64_t> numbers; ///< of its cells
  std::list<TestMesh> parts;

private:
  std::list<fixtures::SolverArrays> arrays_;
  std::list<std::vector<double>> values_;
};

} // namespace insitu::test
