#include "scene/run/action.h"

#include <cstdio>

#include "core/status.h"
#include "core/suggest.h"

namespace insitu::scene {

namespace {

std::string at(const std::string& file, int line) {
  return line > 0 ? file + ":" + std::to_string(line) + ": " : std::string();
}

} // namespace

commit::CommittedMesh& find_mesh(MeshList meshes, const Name& name, const std::string& scene_file) {
  if (meshes.empty())
    throw core::Error(INSITU_ERROR_SCENE, "the session has no mesh");
  if (name.empty())
    return *meshes.front();
  std::vector<std::string> names;
  for (commit::CommittedMesh* m : meshes) {
    if (m->mesh().name() == name.text)
      return *m;
    names.push_back(m->mesh().name());
  }
  throw core::Error(INSITU_ERROR_SCENE, at(scene_file, name.line) + "the session has no mesh '" +
                                            name.text + "'" + core::did_you_mean(name.text, names));
}

namespace {

template <class Find>
mesh::FieldView at_line_of(const Name& name, const std::string& scene_file, Find&& find) {
  try {
    return find();
  } catch (const core::Error& e) {
    throw core::Error(e.status(), at(scene_file, name.line) + e.what());
  }
}

} // namespace

mesh::FieldView find_field(const commit::CommittedMesh& mesh, const Name& name,
                           const std::string& scene_file) {
  return at_line_of(name, scene_file, [&] { return mesh.mesh().field(name.text); });
}

mesh::FieldView find_own_field(const commit::CommittedMesh& mesh, const Name& name,
                               const std::string& scene_file) {
  return at_line_of(name, scene_file, [&] { return mesh.mesh().own_field(name.text); });
}

bool names_pieces(const mesh::Mesh& mesh) {
  return mesh.is_adaptive() || mesh.own_view().piece_count > 1;
}

OwnCell own_cell(const mesh::MeshView& mesh, std::int64_t flat) {
  if (flat < 0 || flat >= mesh.cell_count())
    return {};
  const std::int32_t piece = mesh.piece_of(flat);
  return {piece, flat - mesh.first_cell[piece], flat};
}

OwnCell own_cell(const commit::CommittedMesh& mesh, std::int64_t flat, const math::Vec3d& at) {
  return own_cell(mesh.mesh().own_view(), mesh.own({flat, {}}, at).cell);
}

void require_columns(const output::AppendTable& table, const std::vector<std::string>& open,
                     const std::vector<std::string>& now) {
  if (open == now)
    return;
  const auto line = [](const std::vector<std::string>& columns) {
    const std::string text = output::csv_header(columns);
    return "'" + text.substr(0, text.size() - 1) + "'";
  };
  throw core::Error(INSITU_ERROR_FIELD, "the table '" + table.path() + "' has the columns " +
                                            line(open) + "; this cycle has " + line(now) +
                                            ": fields changed during the run");
}

void OnePieceNote::say(bool several, const std::string& path, const core::Log& log) {
  if (!several || said_)
    return;
  said_ = true;
  log.warning("'" + path +
              "' was opened when the mesh had one piece and names no pieces; from here on its "
              "cells are counted through all pieces");
}

namespace {

std::size_t waiting_bytes(output::AppendTable& table) {
  return table.rows().text().size();
}
std::size_t waiting_bytes(output::NetcdfTable& table) {
  return table.rows().bytes().size();
}

template <class Table>
void flush_or_drop(Table& table) {
  constexpr std::size_t most_waiting = std::size_t(1) << 26;
  try {
    table.flush();
  } catch (const core::Error& e) {
    const std::size_t waiting = waiting_bytes(table);
    if (waiting <= most_waiting)
      throw;
    table.rows().clear();
    throw core::Error(e.status(), std::string(e.what()) + "; rows of " + std::to_string(waiting) +
                                      " bytes that waited for room are lost");
  }
}

} // namespace

void flush_table(output::AppendTable& table) {
  flush_or_drop(table);
}
void flush_table(output::NetcdfTable& table) {
  flush_or_drop(table);
}

insitu_accuracy to_api(Accuracy accuracy) {
  switch (accuracy) {
  case Accuracy::fast:
    return INSITU_FAST;
  case Accuracy::standard:
    return INSITU_STANDARD;
  case Accuracy::exact:
    break;
  }
  return INSITU_EXACT;
}

std::vector<std::string> component_names(const mesh::FieldView& field) {
  if (field.components == 1)
    return {field.name};
  std::vector<std::string> names;
  for (int c = 0; c < field.components; ++c)
    names.push_back(std::string(field.name) + "_" +
                    (field.components <= 3 ? std::string(1, "xyz"[c]) : std::to_string(c)));
  return names;
}

std::string cycle_path(const Environment& environment, const std::string& name, std::int64_t cycle,
                       const std::string& extension) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "_%06lld", static_cast<long long>(cycle));
  return environment.output + "/" + name + digits + extension;
}

} // namespace insitu::scene
