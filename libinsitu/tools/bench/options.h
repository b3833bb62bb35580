#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "insitu/insitu.h"

#include "workload/mesh.h"
#include "workload/queries.h"

namespace insitu::bench {

enum class Command {
  help,
  commit,
  locate,
  torture,
  scale,
  methods,
  amr,
  effects,
  render,
  accuracy,
  paper,
  advect,
  scaling,
  sections
};
const char* name(Command command);

struct Options {
  Command command = Command::help;
  workload::Kind kind = workload::Kind::hexahedra;
  bool kind_given = false; ///< methods measures several shapes unless one is given
  workload::Spacing spacing = workload::Spacing::even;
  std::vector<std::int64_t> cells; ///< sizes of meshes: one, but for scale
  double jitter = 0.2;
  std::string mesh_file; ///< replaces kind, spacing, cells and jitter
  bool shuffled = false;
  workload::Pattern pattern = workload::Pattern::uniform;
  std::int64_t points = 0;                         ///< 0: as many as cells (torture: 2000 a case)
  std::vector<std::int64_t> processes{1, 2, 4, 8}; ///< scaling
  std::vector<std::string> arguments;              ///< as given, the command first
  int fields = 1;
  int threads = 1;
  insitu_accuracy accuracy = INSITU_STANDARD;
  int repetitions = 5;
  bool peers = false;
  std::vector<std::string> peer_names;        ///< only these; empty: all
  std::int64_t peer_points = 0;               ///< so many of the points for peers; 0: all
  bool sizes = false;                         ///< amr: by number of leaves instead
  bool check = false;                         ///< methods: answers alone, on all points
  std::vector<std::string> backends, methods; ///< methods: only these; empty: all
  int size = 512;                  ///< render, effects, paper, scaling: pixels along an edge
  bool full = false;               ///< accuracy, paper: large meshes
  bool quick = false;              ///< paper: small meshes, for a test
  std::string paper;               ///< paper: "morrical", "rathke" or "zellmann"
  int table = 0;                   ///< paper rathke: this one only; 0: all
  std::vector<std::string> sweeps; ///< accuracy: only these; empty: all
  std::string out_folder;          ///< render, accuracy, paper: where files go; or none
  std::string json_file, csv_file, svg_file;
};

/// Arguments that cannot be used; what() names the argument.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

Options parse(int argc, char** argv);
const char* help_text();

} // namespace insitu::bench
