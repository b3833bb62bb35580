#pragma once

#include <memory>
#include <string>
#include <vector>

#include "catalyst/loader/tree.h"

namespace insitu_replay {

struct ReplayOptions;

/// A tree that Catalyst's stub wrote (CATALYST_DATA_DUMP_DIRECTORY), and the bytes of its leaves.
struct Dump {
  insitu::catalyst::Tree tree;
  std::vector<char> bytes;
};

/// Reads PATH, of the form conduit_bin, and its schema, PATH_json. Throws FileError, by the path
/// within the tree where a leaf reaches beyond the file.
std::unique_ptr<Dump> read_dump(const std::string& path);

/// The calls of a run, of all its processes: file names, by process.
struct DumpedRun {
  std::vector<std::string> initialize;
  std::vector<std::vector<std::string>> executes; ///< in the order of the calls
};

/// Whether these are a folder with dumps, or dumps.
bool are_dumps(const std::vector<std::string>& files);
/// Throws FileError where a process's dump is missing.
DumpedRun find_dumps(const std::vector<std::string>& files);

/// Does with the run's calls what libcatalyst-insitu.so did, with one process in the place of all:
/// their domains are the pieces of one mesh. Returns false if an action failed. Throws FileError.
bool replay_dumps(const ReplayOptions& options);

} // namespace insitu_replay
