#pragma once

#include <map>
#include <string>
#include <vector>

#include "insitu/insitu.hpp"

#include "solver.h"
#include "unit/output/folder.h"

/// A coupled run for tests: the blast wave on a small cube, a scene, and what came out.
namespace runs {

/// Every file below a folder, by its path in it.
using Files = std::map<std::string, std::string>;
/// But for lock files, which a folder has while its session is open.
Files files_of(const std::string& folder);

/// The names alone, of those with an ending such as ".png".
std::vector<std::string> names_of(const Files& files, const std::string& ending = "");

/// The names of files that are in one folder only or whose bytes differ; empty if there are none.
/// run.js holds seconds: it must be there, but its bytes differ from run to run.
std::vector<std::string> differences(const Files& a, const Files& b);

/// A table as written by the library (no quoted cells): the header and rows of text.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;

  std::size_t column(const std::string& name) const; ///< throws std::out_of_range
  /// An empty cell is NaN.
  double number(std::size_t row, const std::string& name) const;
  const std::string& text(std::size_t row, const std::string& name) const;
};
/// Throws std::runtime_error, naming the line, if rows differ in length or the last is cut.
Table parse_table(const std::string& text);

struct Setup {
  std::string scene = {}; ///< text; empty: none
  std::string output = {};
  int cells = 10;
  int threads = 1;
  bool block = false;
  bool default_scene = false;
};

class Coupled {
public:
  explicit Coupled(const Setup& setup);

  bool execute(); ///< at the solver's cycle
  /// One cycle of the solver, then execute().
  bool step(insitu::Change changed = insitu::geometry | insitu::fields);
  void run(int cycles, insitu::Change changed = insitu::geometry | insitu::fields);

  std::vector<std::string> log; ///< errors and warnings
  sedov::Solver solver;
  insitu::Session session;
  insitu::Mesh mesh;
};

/// A run of some cycles from the start to the session's end.
Files run_to_files(Setup setup, int cycles,
                   insitu::Change changed = insitu::geometry | insitu::fields);

} // namespace runs
