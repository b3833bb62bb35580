#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "insitu/insitu.hpp"

namespace insitu_replay {

/// A command line that makes no sense; exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct ReplayOptions {
  bool help = false, version = false, strict = false, plan = false, check = false, validate = false,
       separate_pieces = false, has_frame = false, reverse = false, preview = false;
  std::string scene, probe, out, summary;
  std::string mesh = "mesh";
  insitu::Frame frame = insitu::Frame::cartesian(); ///< of the files' points
  int threads = 0;
  int hold = 0;                   ///< steps, beside the live one
  std::vector<std::size_t> order; ///< of steps, by their places; empty: each once
  struct Blank {
    std::string field; ///< empty: all
    double value = 0;
  };
  std::vector<Blank> blanks;
  std::vector<std::string> files;
};

ReplayOptions parse_arguments(int argc, char** argv);

/// The places of steps, of so many, in the order in which they come. Throws UsageError.
std::vector<std::size_t> places_of(const ReplayOptions& options, std::size_t steps);

extern const char* const help_text;

} // namespace insitu_replay
