#include "compare/run.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <set>
#include <sstream>

#include "compare/exr_compare.h"
#include "compare/image_compare.h"
#include "compare/json_compare.h"
#include "compare/netcdf_compare.h"
#include "compare/options.h"
#include "compare/table_compare.h"
#include "core/status.h"

namespace insitu::compare {

namespace {

namespace fs = std::filesystem;

std::string read_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (!in || (in.peek() != std::ifstream::traits_type::eof() && !(text << in.rdbuf())))
    throw core::Error(INSITU_ERROR_FILE, "cannot read '" + path + "'");
  return text.str();
}

/// png, exr, csv, json, nc, or empty for what is not compared.
std::string kind_of(const fs::path& path) {
  const std::string ending = path.extension().string();
  return ending == ".png" || ending == ".exr" || ending == ".csv" || ending == ".json" ||
                 ending == ".nc"
             ? ending.substr(1)
             : "";
}

Verdict compare_files(const Options& options, const std::string& kind) {
  if (kind == "png") {
    ImageVerdict verdict =
        compare_images(output::read_png(options.a), output::read_png(options.b), options.image);
    if (!options.difference.empty() && verdict.difference.width > 0)
      output::write_png(options.difference, verdict.difference);
    return verdict;
  }
  if (kind == "exr") {
    return compare_exr(
        options.a, options.b,
        {options.tolerance, options.columns, options.ignored, options.image.max_share});
  }
  if (kind == "csv") {
    return compare_tables(
        parse_csv(read_text(options.a), options.a), parse_csv(read_text(options.b), options.b),
        {options.tolerance, options.columns, options.ignored, options.keys, options.folders});
  }
  if (kind == "nc") {
    if (!options.keys.empty() && !options.folders) {
      throw core::Error(INSITU_ERROR_ARGUMENT,
                        "--key: matches rows of .csv tables; records of netCDF "
                        "files are compared in their order");
    }
    return compare_netcdf(options.a, options.b,
                          {options.tolerance, options.columns, options.ignored, options.folders});
  }
  return compare_json(read_text(options.a), options.a, read_text(options.b), options.b,
                      {options.tolerance, options.columns, options.ignored});
}

class Report {
public:
  Report(bool quiet, std::ostream& out) : quiet_(quiet), out_(out) {}

  void add(const std::string& title, const Verdict& verdict) {
    same_ = same_ && verdict.same;
    if (quiet_)
      return;
    out_ << title << ": " << (verdict.same ? "" : "DIFFERENT\n");
    for (const std::string& line : verdict.lines)
      out_ << (verdict.same ? "" : "  ") << line << '\n';
  }

  bool same() const { return same_; }

private:
  bool quiet_;
  std::ostream& out_;
  bool same_ = true;
};

std::set<std::string> files_in(const std::string& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && !kind_of(entry.path()).empty())
      names.insert(fs::relative(entry.path(), folder).generic_string());
  return names;
}

/// Each file of either folder against the one of the same name in the other. One that cannot be
/// read does not hide what the others say.
int compare_folders(const Options& options, Report& report, std::ostream& err) {
  std::set<std::string> names = files_in(options.a);
  names.merge(files_in(options.b));
  if (names.empty()) {
    throw core::Error(INSITU_ERROR_FILE, "neither '" + options.a + "' nor '" + options.b +
                                             "' holds a .png, .exr, .csv, .json or .nc file");
  }
  bool unusable = false;
  for (const std::string& name : names) {
    Options one = options;
    one.folders = true;
    one.a = (fs::path(options.a) / name).string();
    one.b = (fs::path(options.b) / name).string();
    one.difference =
        options.difference.empty() ? "" : (fs::path(options.difference) / name).string();
    const std::string kind = kind_of(name);
    if (!options.kind.empty() && options.kind != kind)
      continue;
    Verdict verdict;
    if (!fs::exists(one.a) || !fs::exists(one.b)) {
      verdict.differ("missing in the " + std::string(fs::exists(one.a) ? "second" : "first") +
                     " folder");
      report.add(name, verdict);
      continue;
    }
    try {
      report.add(name, compare_files(one, kind));
    } catch (const core::Error& error) {
      err << "insitu-compare: " << error.what() << '\n';
      unusable = true;
    }
  }
  return unusable ? 2 : report.same() ? 0 : 1;
}

int compare(const Options& options, std::ostream& out, std::ostream& err) {
  Report report(options.quiet, out);
  const bool folder_a = fs::is_directory(options.a), folder_b = fs::is_directory(options.b);
  if (folder_a && folder_b)
    return compare_folders(options, report, err);
  if (folder_a || folder_b) {
    throw core::Error(INSITU_ERROR_FILE, "'" + (folder_a ? options.a : options.b) +
                                             "' is a folder, '" +
                                             (folder_a ? options.b : options.a) + "' is not");
  }
  const std::string kind_a = options.kind.empty() ? kind_of(options.a) : options.kind;
  const std::string kind_b = options.kind.empty() ? kind_of(options.b) : options.kind;
  if (kind_a.empty() || kind_a != kind_b) {
    throw core::Error(INSITU_ERROR_FILE,
                      "'" + options.a + "' and '" + options.b +
                          "': two .png, .exr, .csv, .json or .nc files expected, or --kind");
  }
  report.add(options.a + " -> " + options.b, compare_files(options, kind_a));
  return report.same() ? 0 : 1;
}

} // namespace

int run(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err) {
  try {
    const Options options = parse_options(arguments);
    if (options.help) {
      out << usage;
      return 0;
    }
    return compare(options, out, err);
  } catch (const std::exception& error) {
    err << "insitu-compare: " << error.what() << '\n';
    return 2;
  }
}

} // namespace insitu::compare
