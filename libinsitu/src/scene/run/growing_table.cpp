#include "scene/run/growing_table.h"

#include "core/status.h"

namespace insitu::scene {

std::vector<std::string> component_names(const mesh::FieldView& field) {
  if (field.components == 1)
    return {field.name};
  std::vector<std::string> names;
  for (int c = 0; c < field.components; ++c)
    names.push_back(std::string(field.name) + "_" +
                    (field.components <= 3 ? std::string(1, "xyz"[c]) : std::to_string(c)));
  return names;
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

} // namespace insitu::scene
