#include <algorithm>

#include "mesh/registered/earlier_parts.h"
#include "mesh/registered/mesh.h"

namespace insitu::mesh {

void EarlierStep::keep(core::Archive& archive) {
  std::size_t count = fields.size();
  archive.value("earlier fields", count);
  fields.resize(count);
  for (Field& field : fields) {
    archive.value("name", field.name);
    archive.value("association", field.association);
    archive.value("components", field.components);
    std::size_t steps = field.steps.size();
    archive.value("steps", steps);
    field.steps.resize(steps);
    for (std::vector<double>& values : field.steps)
      archive.array("values", values);
  }
  archive.array("earlier points", points);
}

EarlierStep Mesh::copy_earlier() const {
  EarlierStep out;
  // What is behind it is copied from its owners; an adaptive mesh of the same cells has it all.
  const MeshView own = is_adaptive() ? view() : own_part(view());
  for (const auto& field : earlier_fields_) {
    out.fields.push_back({field->name, field->association, field->components, {}});
    const std::int64_t values =
        (field->association == INSITU_CELL ? own.cell_count() : own.vertex_count()) *
        field->components;
    for (const auto& step : field->steps)
      out.fields.back().steps.emplace_back(step->values.begin(), step->values.begin() + values);
  }
  if (!earlier_points_.empty())
    out.points.assign(earlier_points_.begin(), earlier_points_.begin() + own.vertex_count());
  if (!earlier_blocks_.empty()) {
    out.points.clear();
    for (const PieceView& block : earlier_blocks_)
      for (std::int64_t i = 0; i < block.vertex_count; ++i)
        out.points.push_back(block.point(i));
  }
  return out;
}

MeshView own_part(const MeshView& mesh) {
  MeshView own = mesh;
  own.piece_count -= own.halo_piece_count;
  own.halo_piece_count = 0;
  return own;
}

void append(EarlierStep& step, const EarlierStep& behind) {
  if (step.fields.empty())
    step.fields = behind.fields;
  else
    for (EarlierStep::Field& field : step.fields)
      for (const EarlierStep::Field& more : behind.fields)
        for (std::size_t s = 0;
             more.name == field.name && s < std::min(field.steps.size(), more.steps.size()); ++s)
          field.steps[s].insert(field.steps[s].end(), more.steps[s].begin(), more.steps[s].end());
  step.points.insert(step.points.end(), behind.points.begin(), behind.points.end());
}

void resize(EarlierStep& step, const MeshView& mesh) {
  for (EarlierStep::Field& field : step.fields)
    for (std::vector<double>& values : field.steps)
      values.resize(
          std::size_t((field.association == INSITU_CELL ? mesh.cell_count() : mesh.vertex_count()) *
                      field.components));
  step.points.resize(std::size_t(mesh.vertex_count()));
}

bool have_same_fields(const EarlierStep& a, const EarlierStep& b) {
  return std::ranges::equal(
      a.fields, b.fields, [](const EarlierStep::Field& f, const EarlierStep::Field& g) {
        return f.name == g.name && f.association == g.association && f.components == g.components &&
               f.steps.size() == g.steps.size();
      });
}

bool EarlierStep::fits(const MeshView& mesh, std::int64_t point_count) const {
  if (std::int64_t(points.size()) != point_count)
    return false;
  for (const Field& field : fields)
    for (const std::vector<double>& values : field.steps)
      if (std::int64_t(values.size()) !=
          (field.association == INSITU_CELL ? mesh.cell_count() : mesh.vertex_count()) *
              field.components)
        return false;
  return true;
}

bool Mesh::set_earlier(const EarlierStep& step) {
  const MeshView& now = view();
  if (!step.fits(now, has_still_vertices() ? 0 : now.vertex_count()))
    return false;
  release_earlier();
  for (const EarlierStep::Field& field : step.fields) {
    EarlierField& to = earlier_field_for(field.name, field.association, field.components);
    for (std::size_t s = field.steps.size(); s-- > 0;) {
      to.begin_step(int(field.steps.size()), now, *memory_);
      std::copy(field.steps[s].begin(), field.steps[s].end(), to.steps[0]->values.begin());
    }
  }
  earlier_points_.resize_discard(step.points.size());
  std::copy(step.points.begin(), step.points.end(), earlier_points_.begin());
  return true;
}

} // namespace insitu::mesh
