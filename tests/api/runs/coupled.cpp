#include "coupled.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <stdexcept>

#include "output/files/file_lock.h"

namespace runs {

namespace fs = std::filesystem;

Files files_of(const std::string& folder) {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().extension() != insitu::output::lock_suffix)
      files[fs::relative(entry.path(), folder).string()] = test::content(entry.path().string());
  return files;
}

std::vector<std::string> names_of(const Files& files, const std::string& ending) {
  std::vector<std::string> names;
  for (const auto& [name, content] : files)
    if (name.ends_with(ending))
      names.push_back(name);
  return names;
}

std::vector<std::string> differences(const Files& a, const Files& b) {
  std::vector<std::string> names;
  for (const auto& [name, content] : a)
    if (!b.count(name) || (name != "run.js" && b.at(name) != content))
      names.push_back(name);
  for (const auto& [name, content] : b)
    if (!a.count(name))
      names.push_back(name);
  return names;
}

std::size_t Table::column(const std::string& name) const {
  const auto found = std::find(columns.begin(), columns.end(), name);
  if (found == columns.end())
    throw std::out_of_range("no column '" + name + "'");
  return std::size_t(found - columns.begin());
}

const std::string& Table::text(std::size_t row, const std::string& name) const {
  return rows.at(row)[column(name)];
}

double Table::number(std::size_t row, const std::string& name) const {
  const std::string& cell = text(row, name);
  if (cell.empty())
    return std::numeric_limits<double>::quiet_NaN();
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  if (end != cell.c_str() + cell.size())
    throw std::runtime_error("'" + cell + "' in column '" + name + "' is not a number");
  return value;
}

Table parse_table(const std::string& text) {
  Table table;
  if (text.empty() || text.back() != '\n')
    throw std::runtime_error(text.empty() ? "the table is empty" : "its last line is cut");
  for (std::size_t begin = 0, line = 1; begin < text.size(); ++line) {
    const std::size_t end = text.find('\n', begin);
    std::vector<std::string> cells;
    for (std::size_t at = begin; at <= end;) {
      const std::size_t comma = std::min(text.find(',', at), end);
      cells.push_back(text.substr(at, comma - at));
      at = comma + 1;
    }
    if (line == 1)
      table.columns = cells;
    else
      table.rows.push_back(cells);
    if (cells.size() != table.columns.size())
      throw std::runtime_error("line " + std::to_string(line) + " has " +
                               std::to_string(cells.size()) + " cells, the header " +
                               std::to_string(table.columns.size()));
    begin = end + 1;
  }
  return table;
}

namespace {

sedov::Config cube(int cells) {
  sedov::Config config;
  config.cells.fill(cells);
  return config;
}

insitu::Options options_of(const Setup& setup, std::vector<std::string>& log) {
  insitu::Options o;
  o.scene_text = setup.scene;
  o.output = setup.output;
  o.threads = setup.threads;
  o.default_scene = setup.default_scene;
  o.log = [&log](insitu::LogLevel, const char* message) { log.emplace_back(message); };
  return o;
}

} // namespace

Coupled::Coupled(const Setup& setup)
    : solver(cube(setup.cells)), session(options_of(setup, log)), mesh(session.mesh("hydro")) {
  mesh.points(solver.x, solver.y, solver.z);
  if (setup.block)
    mesh.block(setup.cells + 1, setup.cells + 1, setup.cells + 1);
  else
    mesh.hexahedra(solver.connectivity);
  mesh.cell_field("density", solver.density);
  mesh.cell_field("pressure", solver.pressure);
  mesh.vertex_field("velocity", {solver.u, solver.v, solver.w});
}

bool Coupled::execute() {
  return session.execute(solver.cycle(), solver.time());
}

bool Coupled::step(insitu::Change changed) {
  solver.advance();
  mesh.changed(changed);
  return execute();
}

void Coupled::run(int cycles, insitu::Change changed) {
  while (solver.cycle() < cycles)
    if (!step(changed))
      throw std::runtime_error(std::string("execute: ") + insitu_last_message());
}

Files run_to_files(Setup setup, int cycles, insitu::Change changed) {
  const test::Folder folder;
  setup.output = folder.path();
  Coupled run(setup);
  if (!run.execute())
    throw std::runtime_error(std::string("execute: ") + insitu_last_message());
  run.run(cycles, changed);
  run.session.close();
  return files_of(folder.path());
}

} // namespace runs
