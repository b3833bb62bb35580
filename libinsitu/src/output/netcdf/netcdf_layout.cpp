#include "output/netcdf/netcdf_layout.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <netcdf.h>

#include "core/status.h"
#include "output/files/atomic_file.h"
#include "output/files/file_system.h"

namespace insitu::output {

namespace {

/// netCDF-C is not made for several threads; sessions are.
std::mutex& library() {
  static std::mutex mutex;
  return mutex;
}

std::int64_t bytes_of(NetcdfType type) {
  switch (type) {
  case NetcdfType::int8:
  case NetcdfType::text:
    return 1;
  case NetcdfType::int32:
    return 4;
  case NetcdfType::int64:
  case NetcdfType::float64:
    break;
  }
  return 8;
}

nc_type to_netcdf(NetcdfType type) {
  switch (type) {
  case NetcdfType::int8:
    return NC_BYTE;
  case NetcdfType::int32:
    return NC_INT;
  case NetcdfType::int64:
    return NC_INT64;
  case NetcdfType::float64:
    return NC_DOUBLE;
  case NetcdfType::text:
    break;
  }
  return NC_CHAR;
}

/// An open file of netCDF-C; closed in any case.
class Dataset {
public:
  explicit Dataset(std::string path) : path_(std::move(path)) {}
  ~Dataset() {
    if (id >= 0)
      nc_close(id);
  }
  Dataset(const Dataset&) = delete;
  Dataset& operator=(const Dataset&) = delete;

  void check(int status, const std::string& doing) const {
    if (status != NC_NOERR) {
      throw core::Error(INSITU_ERROR_FILE,
                        "cannot " + doing + " '" + path_ + "': " + nc_strerror(status));
    }
  }
  void close() { check(nc_close(std::exchange(id, -1)), "write"); }

  int id = -1;

private:
  std::string path_;
};

void put_attribute(const Dataset& file, int variable, const NetcdfAttribute& a) {
  const char* name = a.name.c_str();
  const std::string doing = "write the attribute '" + a.name + "' of";
  if (const auto* text = std::get_if<std::string>(&a.value)) {
    file.check(nc_put_att_text(file.id, variable, name, text->size(), text->c_str()), doing);
  } else if (const auto* number = std::get_if<double>(&a.value)) {
    file.check(nc_put_att_double(file.id, variable, name, NC_DOUBLE, 1, number), doing);
  } else if (const auto* integer = std::get_if<std::int64_t>(&a.value)) {
    const long long value = *integer;
    file.check(nc_put_att_longlong(file.id, variable, name, NC_INT64, 1, &value), doing);
  } else if (const auto* small = std::get_if<std::int32_t>(&a.value)) {
    file.check(nc_put_att_int(file.id, variable, name, NC_INT, 1, small), doing);
  } else if (const auto* flags = std::get_if<std::vector<std::int8_t>>(&a.value)) {
    file.check(nc_put_att_schar(file.id, variable, name, NC_BYTE, flags->size(),
                                reinterpret_cast<const signed char*>(flags->data())),
               doing);
  }
}

void define(const Dataset& file, const NetcdfLayout& layout, std::vector<int>& variables) {
  std::map<std::string, int> dimensions;
  int record = 0;
  file.check(nc_def_dim(file.id, layout.record_dimension.c_str(), NC_UNLIMITED, &record), "write");
  for (const auto& [name, length] : layout.dimensions) {
    file.check(nc_def_dim(file.id, name.c_str(), std::size_t(length), &dimensions[name]),
               "write the dimension '" + name + "' of");
  }
  for (const NetcdfVariable& v : layout.variables) {
    std::vector<int> shape;
    if (v.per_record)
      shape.push_back(record);
    for (const std::string& name : v.dimensions)
      shape.push_back(dimensions.at(name));
    int id = 0;
    file.check(nc_def_var(file.id, v.name.c_str(), to_netcdf(v.type), int(shape.size()),
                          shape.data(), &id),
               "write the variable '" + v.name + "' of");
    variables.push_back(id);
    for (const NetcdfAttribute& a : v.attributes)
      put_attribute(file, id, a);
  }
  for (const NetcdfAttribute& a : layout.attributes)
    put_attribute(file, NC_GLOBAL, a);
}

void put_values(const Dataset& file, int id, const NetcdfVariable& v) {
  int status = NC_NOERR;
  if (v.type == NetcdfType::float64) {
    status = nc_put_var_double(file.id, id, v.doubles.data());
  } else if (v.type == NetcdfType::text) {
    status = nc_put_var_text(file.id, id, v.text.c_str());
  } else {
    const std::vector<long long> values(v.integers.begin(), v.integers.end());
    status = nc_put_var_longlong(file.id, id, values.data());
  }
  file.check(status, "write the variable '" + v.name + "' of");
}

} // namespace

std::int64_t NetcdfLayout::record_bytes() const {
  std::int64_t bytes = 0;
  for (const NetcdfVariable& v : variables) {
    if (!v.per_record)
      continue;
    std::int64_t count = 1;
    for (const std::string& name : v.dimensions)
      for (const auto& [known, length] : dimensions)
        count *= known == name ? length : 1;
    bytes += (count * bytes_of(v.type) + 3) / 4 * 4;
  }
  return bytes;
}

std::string NetcdfLayout::free_name(const std::string& name) const {
  std::string clean;
  for (const char c : name) {
    const bool letter = (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
    const bool other = (c >= '0' && c <= '9') || c == '.' || c == '@' || c == '+' || c == '-';
    if (clean.empty() && !letter && !(c >= '0' && c <= '9'))
      clean = "_";
    if (letter || other || !clean.starts_with('_') || clean.size() > 1)
      clean += letter || other ? c : '_';
  }
  clean.resize(std::min<std::size_t>(clean.size(), NC_MAX_NAME - 8));
  if (clean.empty())
    clean = "_";
  const auto taken = [&](const std::string& candidate) {
    return std::any_of(variables.begin(), variables.end(),
                       [&](const NetcdfVariable& v) { return v.name == candidate; });
  };
  std::string free = clean;
  for (int n = 2; taken(free); ++n)
    free = clean + "_" + std::to_string(n);
  return free;
}

std::string netcdf_head(const std::string& path, const NetcdfLayout& layout) {
  // Made in the unfinished file's place: should the process be killed here, it is removed like it.
  AtomicFile place(path);
  {
    const std::lock_guard<std::mutex> lock(library());
    Dataset file(path);
    file.check(nc_create(place.part().c_str(), NC_CLOBBER | NC_64BIT_DATA, &file.id), "write");
    std::vector<int> variables;
    define(file, layout, variables);
    file.check(nc_enddef(file.id), "write");
    for (std::size_t i = 0; i < variables.size(); ++i)
      if (!layout.variables[i].per_record)
        put_values(file, variables[i], layout.variables[i]);
    file.close();
  }
  std::ifstream in(place.part(), std::ios::binary);
  std::string head((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in || head.size() < 12)
    throw core::Error(INSITU_ERROR_FILE, "cannot read '" + place.part() + "'");
  return head;
}

std::int64_t NetcdfSummary::dimension(const std::string& name) const {
  for (const auto& [known, length] : dimensions)
    if (known == name)
      return length;
  return 0;
}

bool NetcdfSummary::keeps_before(std::optional<std::int64_t> from) const {
  return records > 0 && (!from || (last < first ? first > *from : first < *from));
}

NetcdfSummary summarize_netcdf(const std::string& path) {
  const std::lock_guard<std::mutex> lock(library());
  Dataset file(path);
  file.check(nc_open(path.c_str(), NC_NOWRITE, &file.id), "read");
  NetcdfSummary out;
  int dimensions = 0, variables = 0;
  file.check(nc_inq(file.id, &dimensions, &variables, nullptr, nullptr), "read");
  char name[NC_MAX_NAME + 1];
  for (int d = 0; d < dimensions; ++d) {
    std::size_t length = 0;
    file.check(nc_inq_dim(file.id, d, name, &length), "read");
    out.dimensions.emplace_back(name, std::int64_t(length));
  }
  for (int v = 0; v < variables; ++v) {
    file.check(nc_inq_varname(file.id, v, name), "read");
    out.variables.emplace_back(name);
  }
  int record = -1, of_first = -1;
  file.check(nc_inq_unlimdim(file.id, &record), "read");
  if (record >= 0)
    out.records = out.dimensions[std::size_t(record)].second;
  const bool counted = out.records > 0 && variables > 0 &&
                       nc_inq_varndims(file.id, 0, &of_first) == NC_NOERR && of_first == 1;
  const std::size_t begin = 0, end = std::size_t(out.records) - 1;
  long long first = 0, last = 0;
  if (counted && nc_get_var1_longlong(file.id, 0, &begin, &first) == NC_NOERR &&
      nc_get_var1_longlong(file.id, 0, &end, &last) == NC_NOERR) {
    out.first = first;
    out.last = last;
  }
  return out;
}

} // namespace insitu::output
