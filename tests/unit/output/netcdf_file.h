#pragma once

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <netcdf.h>

/// A netCDF file as netCDF-C reads it, all of it.
namespace test {

struct NetcdfFile {
  struct Variable {
    nc_type type = NC_NAT;
    std::vector<std::string> dimensions;
    std::map<std::string, std::string> texts; ///< attributes
    std::map<std::string, std::vector<double>> numbers;
    std::vector<double> doubles;
    std::vector<long long> integers; ///< of integer types
    std::string text;
  };
  std::map<std::string, std::size_t> dimensions;
  std::string unlimited;
  std::map<std::string, Variable> variables;
  std::map<std::string, std::string> texts; ///< of the file

  explicit NetcdfFile(const std::string& path) {
    int id = -1;
    check(nc_open(path.c_str(), NC_NOWRITE, &id), path);
    try {
      read(id);
    } catch (...) {
      nc_close(id);
      throw;
    }
    nc_close(id);
  }
  const Variable& operator[](const std::string& name) const { return variables.at(name); }
  std::size_t records() const { return dimensions.at(unlimited); }

private:
  static void check(int status, const std::string& what) {
    if (status != NC_NOERR)
      throw std::runtime_error(what + ": " + nc_strerror(status));
  }

  static void read_attributes(int id, int variable, int count,
                              std::map<std::string, std::string>& texts,
                              std::map<std::string, std::vector<double>>* numbers) {
    char name[NC_MAX_NAME + 1];
    for (int a = 0; a < count; ++a) {
      check(nc_inq_attname(id, variable, a, name), "attribute");
      nc_type type = NC_NAT;
      std::size_t length = 0;
      check(nc_inq_att(id, variable, name, &type, &length), name);
      if (type == NC_CHAR) {
        std::string value(length, '\0');
        check(nc_get_att_text(id, variable, name, value.data()), name);
        texts[name] = value;
      } else if (numbers) {
        std::vector<double> values(length);
        check(nc_get_att_double(id, variable, name, values.data()), name);
        (*numbers)[name] = values;
      }
    }
  }

  void read(int id) {
    int dimension_count = 0, variable_count = 0, attribute_count = 0, record = -1;
    check(nc_inq(id, &dimension_count, &variable_count, &attribute_count, &record), "file");
    char name[NC_MAX_NAME + 1];
    std::vector<std::string> names;
    for (int d = 0; d < dimension_count; ++d) {
      std::size_t length = 0;
      check(nc_inq_dim(id, d, name, &length), "dimension");
      names.emplace_back(name);
      dimensions[name] = length;
    }
    unlimited = record >= 0 ? names[std::size_t(record)] : "";
    read_attributes(id, NC_GLOBAL, attribute_count, texts, nullptr);
    for (int v = 0; v < variable_count; ++v) {
      Variable variable;
      int shape[NC_MAX_VAR_DIMS], rank = 0, attributes = 0;
      check(nc_inq_var(id, v, name, &variable.type, &rank, shape, &attributes), "variable");
      std::size_t count = 1;
      for (int d = 0; d < rank; ++d) {
        variable.dimensions.push_back(names[std::size_t(shape[d])]);
        count *= dimensions[variable.dimensions.back()];
      }
      read_attributes(id, v, attributes, variable.texts, &variable.numbers);
      if (variable.type == NC_CHAR) {
        variable.text.resize(count);
        check(nc_get_var_text(id, v, variable.text.data()), name);
      } else if (variable.type == NC_DOUBLE) {
        variable.doubles.resize(count);
        check(nc_get_var_double(id, v, variable.doubles.data()), name);
      } else {
        variable.integers.resize(count);
        check(nc_get_var_longlong(id, v, variable.integers.data()), name);
      }
      variables[name] = variable;
    }
  }
};

} // namespace test
