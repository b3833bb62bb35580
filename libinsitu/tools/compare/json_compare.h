#pragma once

#include <string>
#include <vector>

#include "compare/verdict.h"

namespace insitu::compare {

struct JsonOptions {
  Tolerance tolerance;
  /// Names are keys ("seconds": wherever it stands) or whole paths ("steps[3].seconds").
  std::vector<NamedTolerance> keys;
  std::vector<std::string> ignored; ///< with all that is below them
};

/// Compares two JSON texts value by value. Order of keys does not matter, order of lists does; null
/// and NaN are the same. Throws core::Error (INSITU_ERROR_FILE) naming the file and line of what
/// cannot be parsed.
Verdict compare_json(const std::string& a, const std::string& name_a, const std::string& b,
                     const std::string& name_b, const JsonOptions& options);

} // namespace insitu::compare
