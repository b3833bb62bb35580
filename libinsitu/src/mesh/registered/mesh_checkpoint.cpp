#include <algorithm>

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
  for (const auto& field : earlier_fields_) {
    out.fields.push_back({field->name, field->association, field->components, {}});
    for (const auto& step : field->steps)
      out.fields.back().steps.emplace_back(step->values.begin(), step->values.end());
  }
  out.points.assign(earlier_points_.begin(), earlier_points_.end());
  if (!earlier_blocks_.empty()) {
    out.points.clear();
    for (const PieceView& block : earlier_blocks_)
      for (std::int64_t i = 0; i < block.vertex_count; ++i)
        out.points.push_back(block.point(i));
  }
  return out;
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
  if (!step.fits(now, stand_in_ && !stand_in_->solver_view() ? 0 : now.vertex_count()))
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
