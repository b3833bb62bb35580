#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "insitu/insitu.h"

#include "workload/mesh.h"
#include "workload/queries.h"

namespace insitu::bench {

enum class Command { help, commit, locate };

struct Options {
  Command command = Command::help;
  workload::Kind kind = workload::Kind::hexahedra;
  std::int64_t cells = 1'000'000;
  double jitter = 0.2;
  std::string mesh_file; ///< replaces kind, cells and jitter
  bool renumber = false;
  workload::Pattern pattern = workload::Pattern::uniform;
  std::int64_t points = 0; ///< 0: as many as cells
  int threads = 1;
  insitu_accuracy accuracy = INSITU_STANDARD;
  int repetitions = 5;
  bool peers = false;
  std::string json_file;
};

/// Arguments that cannot be used; what() names the argument.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

Options parse(int argc, char** argv);
const char* help_text();

} // namespace insitu::bench
