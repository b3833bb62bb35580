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
    archive.array("values", field.values);
  }
  archive.array("earlier points", points);
}

EarlierStep Mesh::copy_earlier() const {
  EarlierStep out;
  for (const auto& field : earlier_fields_)
    out.fields.push_back({field->name,
                          field->association,
                          field->components,
                          {field->values.begin(), field->values.end()}});
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
    if (std::int64_t(field.values.size()) !=
        (field.association == INSITU_CELL ? cells : vertices) * field.components)
      return false;
  release_earlier();
  for (const EarlierStep::Field& field : step.fields)
    std::copy(field.values.begin(), field.values.end(),
              earlier_field_for(field.name, field.association, field.components).values.begin());
  earlier_points_.resize_discard(step.points.size());
  std::copy(step.points.begin(), step.points.end(), earlier_points_.begin());
  return true;
}

} // namespace insitu::mesh
