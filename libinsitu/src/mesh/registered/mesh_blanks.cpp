/// Vertices and cells at which fields have no value: land, fill values, hidden points.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/status.h"
#include "mesh/registered/mesh.h"

namespace insitu::mesh {

using core::Error;

void Mesh::add_blank(const std::string& name, double value) {
  (void)own_field(name); // throws if there is none
  refuse_if_adaptive("mesh '" + name_ + "', field '" + name + "', blank value");
  std::vector<double>& blanks = const_cast<Field*>(find(name))->blanks;
  const bool known = std::any_of(blanks.begin(), blanks.end(), [&](double b) {
    return b == value || (std::isnan(b) && std::isnan(value));
  });
  if (known)
    return;
  blanks.push_back(value);
  pending_ |= INSITU_CHANGED_FIELDS;
}

void Mesh::set_hidden_points(std::int32_t piece, const insitu_array* array) {
  const std::string name =
      "mesh '" + name_ + "', piece " + std::to_string(piece) + " hidden points";
  refuse_if_adaptive(name);
  ExternalArray adopted;
  if (array) {
    adopted = adopt(array, name);
    if (adopted.type != INSITU_UINT8 || adopted.components != 1)
      throw Error(INSITU_ERROR_ARGUMENT, name + ": one uint8 a vertex expected, " +
                                             std::to_string(adopted.components) + " of " +
                                             type_name(adopted.type) + " given");
  }
  piece_for(piece).hidden_points = adopted;
  pending_ |= INSITU_CHANGED_FIELDS;
}

bool Mesh::hides_points(const Field& field, std::size_t p) const {
  return field.association == INSITU_VERTEX && p < pieces_.size() &&
         pieces_[p].hidden_points.given();
}

bool Mesh::has_blanks(const Field& field) const {
  bool has = !field.blanks.empty();
  for (std::size_t p = 0; p < pieces_.size(); ++p)
    has = has || hides_points(field, p);
  return has;
}

/// Adds the view of the field's values on a piece: of the solver's own, or of a copy.
void Mesh::add_view(Field& field, std::size_t p, const core::Threads* threads) const {
  FieldPiece& piece = field.pieces[p];
  const bool hides = hides_points(field, p);
  std::vector<double> blanks = field.blanks;
  std::erase_if(blanks, [](double b) { return std::isnan(b); }); // are as they should be
  if (!hides && blanks.empty() && (field.blanks.empty() || field.components == 1)) {
    piece.blanked.reset();
    field.views.push_back(piece.view());
    return;
  }
  const ExternalArray& hidden = pieces_[p].hidden_points;
  bool on_device = hides && hidden.memory != INSITU_HOST;
  for (const ExternalArray& array : piece.arrays)
    on_device |= array.memory != INSITU_HOST;
  if (on_device)
    throw Error(INSITU_ERROR_UNSUPPORTED,
                "mesh '" + name_ + "', field '" + field.name +
                    "': in device memory, where blank values and hidden points are not told");
  if (!piece.blanked)
    piece.blanked = std::make_shared<BlankedValues>(*memory_);
  piece.blanked->make(piece.view(), field.components, blanks, hides ? hidden.data : nullptr,
                      hidden.layout, threads);
  const BlankedValues& copy = *piece.blanked;
  field.views.push_back({copy.components().data(), copy.layout(), copy.is_float32(), nullptr});
}

void Mesh::audit_blanks(std::vector<insitu_audit_entry>& entries) const {
  for (const auto& field : fields_)
    for (std::size_t p = 0; p < field->pieces.size(); ++p)
      if (const auto& copy = field->pieces[p].blanked) {
        insitu_audit_entry e{};
        e.size = sizeof e;
        std::snprintf(e.name, sizeof e.name, "piece %zu field '%s' without blanks", p,
                      field->name.c_str());
        std::snprintf(e.reason, sizeof e.reason, "blank values and hidden points become NaN");
        e.bytes = copy->bytes();
        entries.push_back(e);
      }
}

} // namespace insitu::mesh
