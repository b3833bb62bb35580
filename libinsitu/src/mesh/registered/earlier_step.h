#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/archive.h"
#include "core/memory.h"
#include "math/vec.h"
#include "mesh/view.h"

/// What is kept of steps before the current one, for pathlines.
namespace insitu::mesh {

/// A field to be kept, of so many earlier steps.
struct KeptField {
  std::string name;
  int steps = 1;
};

/// Copies of a field's values at earlier steps on the same cells.
struct EarlierField {
  struct Step {
    explicit Step(core::Memory& memory) : values(memory, INSITU_MEMORY_EARLIER) {}
    core::Buffer<double> values; ///< [item, flat][component]
    std::vector<const std::byte*> bases;
    std::vector<FieldPieceView> views;
  };
  std::string name;
  insitu_association association = INSITU_VERTEX;
  int components = 0;
  std::vector<std::unique_ptr<Step>> steps; ///< the latest first

  /// Room for one step more, with views on it, before the others, of which as many stay as make up
  /// `count` with it. The cells' or vertices' numbers are those of mesh.
  void begin_step(int count, const MeshView& mesh, core::Memory& memory);
  FieldView view(std::size_t step) const {
    return {name.c_str(), association, components, steps[step]->views.data()};
  }
};

/// Coordinates and fields, taken from a mesh whose cells become others.
struct TakenStep {
  core::Buffer<math::Vec3d> points;
  std::vector<std::unique_ptr<EarlierField>> fields; ///< of one step
};

/// What a mesh kept of earlier steps, while it keeps the step after them.
struct StepsAside {
  core::Buffer<math::Vec3d> points;
  std::vector<PieceView> blocks; ///< on axes
  core::Buffer<double> axes;
  std::vector<std::unique_ptr<EarlierField>> fields;
};

/// A copy of what a mesh keeps of earlier steps.
struct EarlierStep {
  struct Field {
    std::string name;
    insitu_association association = INSITU_VERTEX;
    std::int32_t components = 0;
    std::vector<std::vector<double>> steps; ///< the latest first; [item, flat][component]
  };
  std::vector<Field> fields;
  std::vector<math::Vec3d> points; ///< [vertex, flat]; none of an adaptive mesh

  void keep(core::Archive& archive);
  /// Whether its numbers are those of the mesh, `points` so many.
  bool fits(const MeshView& mesh, std::int64_t points) const;
};

} // namespace insitu::mesh
