#include "compare/options.h"

#include <cmath>
#include <map>

#include "core/status.h"
#include "core/suggest.h"

namespace insitu::compare {

const char* const usage =
    R"(usage: insitu-compare A B [options]

Compares two files, or all files of two folders, and says what moved, by how much and where.
A is the reference. Exit code: 0 same, 1 different, 2 unusable input.

  --kind png|exr|csv|json|nc    else by the file name
  --quiet                       print nothing; the exit code says it
  --help                        print this

tables (.csv), JSON, netCDF (.nc), images of numbers (.exr)
  --tolerance-relative R        numbers may differ by R times the larger one (0)
  --tolerance-absolute D        and by D (0)
  --column NAME:R:D             other tolerances for a column, key, variable, channel, or path such as
                                steps[3].time
  --ignore-column NAME          leave out a column, a variable, a key and what is below it, or an
                                attribute: variable:attribute, or :attribute of the file
  --key NAME                    match rows of a table by this column (more than once: by several)

images (.png; of .exr the share alone)
  --max-pixel E                 colour difference a pixel may have, CIEDE2000 (1)
  --max-share F                 share of the pixels that may have more, 0 to 1 (0)
  --min-similarity S            least mean structural similarity, up to 1 (0.95)
  --difference FILE.png         where pixels moved; a folder if A and B are folders

Not-a-number, null and an empty cell are equal to each other.
)";

namespace {

[[noreturn]] void refuse(const std::string& what) {
  throw core::Error(INSITU_ERROR_ARGUMENT, what);
}

double number_of(const std::string& option, const std::string& text) {
  double value = 0;
  if (!parse_number(text, value) || !(value >= 0) || std::isinf(value))
    refuse(option + " '" + text + "': a number of 0 or more expected");
  return value;
}

NamedTolerance column_of(const std::string& option, const std::string& text) {
  const std::size_t second = text.rfind(':');
  const std::size_t first =
      second == std::string::npos || second == 0 ? std::string::npos : text.rfind(':', second - 1);
  if (first == std::string::npos || first == 0)
    refuse(option + " '" + text + "': name:relative:absolute expected, such as pressure:1e-6:0");
  return {text.substr(0, first),
          {number_of(option, text.substr(first + 1, second - first - 1)),
           number_of(option, text.substr(second + 1))}};
}

} // namespace

Options parse_options(const std::vector<std::string>& arguments) {
  Options options;
  std::vector<std::string> files;
  const std::map<std::string, void (*)(Options&, const std::string&, const std::string&)> valued = {
      {"--kind",
       [](Options& o, const std::string& name, const std::string& v) {
         if (v != "png" && v != "exr" && v != "csv" && v != "json" && v != "nc")
           refuse(name + " '" + v + "': png, exr, csv, json or nc expected");
         o.kind = v;
       }},
      {"--tolerance-relative",
       [](Options& o, const std::string& name, const std::string& v) {
         o.tolerance.relative = number_of(name, v);
       }},
      {"--tolerance-absolute",
       [](Options& o, const std::string& name, const std::string& v) {
         o.tolerance.absolute = number_of(name, v);
       }},
      {"--column", [](Options& o, const std::string& name,
                      const std::string& v) { o.columns.push_back(column_of(name, v)); }},
      {"--ignore-column",
       [](Options& o, const std::string&, const std::string& v) { o.ignored.push_back(v); }},
      {"--key", [](Options& o, const std::string&, const std::string& v) { o.keys.push_back(v); }},
      {"--max-pixel", [](Options& o, const std::string& name,
                         const std::string& v) { o.image.max_pixel = number_of(name, v); }},
      {"--max-share",
       [](Options& o, const std::string& name, const std::string& v) {
         o.image.max_share = number_of(name, v);
         if (o.image.max_share > 1)
           refuse(name + " '" + v + "': a share from 0 to 1 expected");
       }},
      {"--min-similarity",
       [](Options& o, const std::string& name, const std::string& v) {
         o.image.min_similarity = number_of(name, v);
         if (o.image.min_similarity > 1)
           refuse(name + " '" + v + "': a similarity from 0 to 1 expected");
       }},
      {"--difference",
       [](Options& o, const std::string&, const std::string& v) { o.difference = v; }},
  };
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (argument == "--help" || argument == "-h") {
      options.help = true;
      return options;
    }
    if (argument == "--quiet") {
      options.quiet = true;
    } else if (!argument.starts_with("--")) {
      files.push_back(argument);
    } else {
      const auto found = valued.find(argument);
      if (found == valued.end()) {
        std::vector<std::string> known;
        for (const auto& [name, action] : valued)
          known.push_back(name);
        refuse("no option '" + argument + "'" + core::did_you_mean(argument, known) +
               " (see insitu-compare --help)");
      }
      if (i + 1 == arguments.size())
        refuse(argument + ": a value expected");
      found->second(options, argument, arguments[++i]);
    }
  }
  if (files.size() != 2) {
    refuse("two files or folders expected, " + std::to_string(files.size()) +
           " given (see insitu-compare --help)");
  }
  options.a = files[0];
  options.b = files[1];
  return options;
}

} // namespace insitu::compare
