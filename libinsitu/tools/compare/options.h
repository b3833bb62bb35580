#pragma once

#include <string>
#include <vector>

#include "compare/image_compare.h"
#include "compare/verdict.h"

namespace insitu::compare {

struct Options {
  std::string a, b;
  std::string kind; ///< png, exr, csv, json, nc, or empty: by the file name
  Tolerance tolerance;
  std::vector<NamedTolerance> columns;
  std::vector<std::string> ignored;
  std::vector<std::string> keys;
  ImageOptions image;
  std::string difference; ///< where the difference image goes; empty: nowhere
  bool folders = false;   ///< one of many files: options for columns of others are no mistake
  bool quiet = false;
  bool help = false;
};

/// Throws core::Error (INSITU_ERROR_ARGUMENT) naming the option and what was expected.
Options parse_options(const std::vector<std::string>& arguments);

extern const char* const usage;

} // namespace insitu::compare
