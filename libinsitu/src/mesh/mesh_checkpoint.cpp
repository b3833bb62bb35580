#include <algorithm>

#include "mesh/mesh.h"

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
  return out;
}

bool Mesh::set_earlier(const EarlierStep& step) {
  const MeshView& now = view();
  const std::int64_t vertices = now.first_vertex[now.piece_count],
                     cells = now.first_cell[now.piece_count];
  if (std::int64_t(step.points.size()) != (stand_in_ ? 0 : vertices))
    return false;
  for (const EarlierStep::Field& field : step.fields)
    for (const std::vector<double>& values : field.steps)
      if (std::int64_t(values.size()) !=
          (field.association == INSITU_CELL ? cells : vertices) * field.components)
        return false;
  release_earlier();
  for (const EarlierStep::Field& field : step.fields) {
    EarlierField& to = earlier_field_for(field.name, field.association, field.components);
    for (std::size_t s = field.steps.size(); s-- > 0;) {
      begin_step(to, int(field.steps.size()));
      std::copy(field.steps[s].begin(), field.steps[s].end(), to.steps[0]->values.begin());
    }
  }
  earlier_points_.resize_discard(step.points.size());
  std::copy(step.points.begin(), step.points.end(), earlier_points_.begin());
  return true;
}

} // namespace insitu::mesh
