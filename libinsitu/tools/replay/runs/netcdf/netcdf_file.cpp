#include "runs/netcdf/netcdf_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <netcdf.h>
#include <sstream>

#include "file_error.h"
#include "runs/netcdf/classic_size.h"

namespace insitu_replay {

NetcdfFile::NetcdfFile(const std::string& path) : path_(path) {
  require_whole_netcdf(path);
  check(nc_open(path.c_str(), NC_NOWRITE, &id_), "");
  try {
    read_layout();
  } catch (...) {
    nc_close(id_);
    throw;
  }
}

NetcdfFile::~NetcdfFile() {
  nc_close(id_);
}

void NetcdfFile::check(int status, const std::string& of) const {
  if (status != NC_NOERR)
    throw FileError(path_, (of.empty() ? "" : "variable '" + of + "': ") +
                               std::string("cannot be read: ") + nc_strerror(status));
}

void NetcdfFile::fail(const Variable& v, const std::string& what) const {
  throw FileError(path_, "variable '" + v.name + "': " + what);
}

void NetcdfFile::read_layout() {
  int dims = 0, variables = 0;
  check(nc_inq(id_, &dims, &variables, nullptr, nullptr), "");
  char name[NC_MAX_NAME + 1] = {};
  for (int d = 0; d < dims; ++d) {
    std::size_t length = 0;
    check(nc_inq_dim(id_, d, name, &length), "");
    dim_names_.emplace_back(name);
    lengths_.push_back(length);
  }
  int count = 0;
  check(nc_inq_unlimdims(id_, &count, nullptr), "");
  unlimited_.resize(std::size_t(count));
  check(nc_inq_unlimdims(id_, &count, unlimited_.data()), "");
  for (int v = 0; v < variables; ++v) {
    Variable& to = variables_.emplace_back();
    to.id = v;
    int rank = 0;
    check(nc_inq_var(id_, v, name, &to.type, &rank, nullptr, nullptr), "");
    to.name = name;
    to.dims.resize(std::size_t(rank));
    check(nc_inq_vardimid(id_, v, to.dims.data()), to.name);
  }
}

const NetcdfFile::Variable* NetcdfFile::find(const std::string& name) const {
  const auto found = std::find_if(variables_.begin(), variables_.end(),
                                  [&](const Variable& v) { return v.name == name; });
  return found == variables_.end() ? nullptr : &*found;
}

const NetcdfFile::Variable& NetcdfFile::require(const std::string& name, const Variable& asked_by,
                                                const char* attribute) const {
  const Variable* const found = find(name);
  if (!found)
    fail(asked_by,
         std::string(attribute) + " names the variable '" + name + "', which is not in the file");
  return *found;
}

std::string NetcdfFile::text(const Variable& v, const char* attribute) const {
  nc_type type = NC_NAT;
  std::size_t length = 0;
  if (nc_inq_att(id_, v.id, attribute, &type, &length) != NC_NOERR)
    return {};
  std::string out;
  if (type == NC_CHAR) {
    out.resize(length);
    check(nc_get_att_text(id_, v.id, attribute, out.data()), v.name);
  } else if (type == NC_STRING && length > 0) {
    std::vector<char*> texts(length, nullptr);
    check(nc_get_att_string(id_, v.id, attribute, texts.data()), v.name);
    out = texts[0] ? texts[0] : "";
    nc_free_string(length, texts.data());
  }
  while (!out.empty() && (out.back() == '\0' || out.back() == ' '))
    out.pop_back();
  return out;
}

std::optional<double> NetcdfFile::number(const Variable& v, const char* attribute) const {
  nc_type type = NC_NAT;
  std::size_t length = 0;
  if (nc_inq_att(id_, v.id, attribute, &type, &length) != NC_NOERR || length == 0 ||
      type == NC_CHAR || type == NC_STRING)
    return std::nullopt;
  std::vector<double> numbers(length);
  check(nc_get_att_double(id_, v.id, attribute, numbers.data()), v.name);
  return numbers[0];
}

std::vector<std::string> NetcdfFile::words(const Variable& v, const char* attribute) const {
  std::istringstream in(text(v, attribute));
  std::vector<std::string> out;
  for (std::string word; in >> word;)
    out.push_back(word);
  return out;
}

bool NetcdfFile::is_unlimited(int dim) const {
  return std::find(unlimited_.begin(), unlimited_.end(), dim) != unlimited_.end();
}

bool NetcdfFile::has_numbers(const Variable& v) {
  return v.type >= NC_BYTE && v.type <= NC_UINT64 && v.type != NC_CHAR;
}

/// What stands for no value: as the file says it, or netCDF's own for the type.
std::vector<double> NetcdfFile::fill_values(const Variable& v) const {
  std::vector<double> out;
  for (const char* const key : {"_FillValue", "missing_value"})
    if (const std::optional<double> value = number(v, key))
      out.push_back(*value);
  if (!out.empty())
    return out;
  switch (v.type) {
  case NC_INT:
    return {double(NC_FILL_INT)};
  case NC_INT64:
    return {double(NC_FILL_INT64)};
  case NC_FLOAT:
    return {double(NC_FILL_FLOAT)};
  case NC_DOUBLE:
    return {NC_FILL_DOUBLE};
  default: // small numbers may be any value
    return {};
  }
}

std::vector<double> NetcdfFile::values(const Variable& v, int fixed, std::size_t at) const {
  if (!has_numbers(v))
    fail(v, "holds no numbers");
  std::vector<std::size_t> start, count;
  std::size_t size = 1;
  for (const int dim : v.dims) {
    start.push_back(dim == fixed ? at : 0);
    count.push_back(dim == fixed ? 1 : length(dim));
    size *= count.back();
  }
  std::vector<double> out(size);
  check(nc_get_vara_double(id_, v.id, start.data(), count.data(), out.data()), v.name);
  const std::vector<double> fills = fill_values(v);
  const double scale = number(v, "scale_factor").value_or(1),
               offset = number(v, "add_offset").value_or(0);
  const bool scaled = scale != 1 || offset != 0;
  for (double& value : out)
    if (std::find(fills.begin(), fills.end(), value) != fills.end())
      value = std::numeric_limits<double>::quiet_NaN();
    else if (scaled)
      value = value * scale + offset;
  return out;
}

} // namespace insitu_replay
