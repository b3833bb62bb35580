#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace insitu::compare {

/// The program without its main: returns the exit code (0 same, 1 different, 2 unusable input). The
/// verdict goes to `out`, errors to `err`.
int run(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err);

} // namespace insitu::compare
