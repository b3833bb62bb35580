#include "compare/netcdf_compare.h"

#include <algorithm>
#include <limits>
#include <map>
#include <netcdf.h>

#include "core/status.h"

namespace insitu::compare {

namespace {

[[noreturn]] void unusable(const std::string& what) {
  throw core::Error(INSITU_ERROR_FILE, what);
}

/// The values of a variable or an attribute, by its type.
struct Values {
  nc_type type = NC_NAT;
  std::string text;                ///< NC_CHAR
  std::vector<long long> integers; ///< whole numbers
  std::vector<double> doubles;     ///< the others

  std::size_t size() const {
    return type == NC_CHAR ? text.size() : is_whole() ? integers.size() : doubles.size();
  }
  bool is_whole() const { return type != NC_FLOAT && type != NC_DOUBLE && type != NC_CHAR; }
  double number(std::size_t i) const { return is_whole() ? double(integers[i]) : doubles[i]; }
  bool same(std::size_t i, const Values& other, const Tolerance& tolerance) const {
    if (is_whole() && other.is_whole()) { // doubles do not tell large ones apart
      return integers[i] == other.integers[i] ||
             ((tolerance.relative > 0 || tolerance.absolute > 0) &&
              same_number(number(i), other.number(i), tolerance));
    }
    return same_number(number(i), other.number(i), tolerance);
  }
};

using Attributes = std::map<std::string, Values>;

struct Variable {
  std::string name;
  int id = -1;
  std::vector<std::string> dimensions;
  std::vector<std::size_t> shape;
  Attributes attributes;
};

const char* type_name(nc_type type) {
  switch (type) {
  case NC_BYTE:
    return "int8";
  case NC_CHAR:
    return "text";
  case NC_SHORT:
    return "int16";
  case NC_INT:
    return "int32";
  case NC_FLOAT:
    return "float32";
  case NC_DOUBLE:
    return "float64";
  case NC_UBYTE:
    return "uint8";
  case NC_USHORT:
    return "uint16";
  case NC_UINT:
    return "uint32";
  case NC_INT64:
    return "int64";
  default:
    return nullptr; // NC_UINT64 too: long long does not hold it
  }
}

class File {
public:
  explicit File(const std::string& path) : path_(path) {
    check(nc_open(path.c_str(), NC_NOWRITE, &id_), "");
    try {
      read();
    } catch (...) {
      nc_close(id_);
      throw;
    }
  }
  ~File() { nc_close(id_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  const Variable* find(const std::string& name) const {
    const auto found = std::find_if(variables.begin(), variables.end(),
                                    [&](const Variable& v) { return v.name == name; });
    return found == variables.end() ? nullptr : &*found;
  }

  Values values(const Variable& v) const {
    Values out;
    check(nc_inq_vartype(id_, v.id, &out.type), v.name);
    std::size_t count = 1;
    for (const std::size_t n : v.shape)
      count *= n;
    require_known(out.type, v.name);
    if (out.type == NC_CHAR) {
      out.text.resize(count);
      check(nc_get_var_text(id_, v.id, out.text.data()), v.name);
    } else if (out.is_whole()) {
      out.integers.resize(count);
      check(nc_get_var_longlong(id_, v.id, out.integers.data()), v.name);
    } else {
      out.doubles.resize(count);
      check(nc_get_var_double(id_, v.id, out.doubles.data()), v.name);
    }
    return out;
  }

  std::vector<Variable> variables;
  std::map<std::string, std::size_t> dimensions;
  std::string unlimited;
  Attributes attributes;

private:
  void check(int status, const std::string& of) const {
    if (status != NC_NOERR) {
      unusable("cannot read '" + path_ + "'" + (of.empty() ? "" : ", '" + of + "'") + ": " +
               nc_strerror(status));
    }
  }

  void require_known(nc_type type, const std::string& of) const {
    if (!type_name(type)) {
      unusable("'" + path_ + "', '" + of +
               "': numbers up to 64 bits with a sign and text are "
               "compared; this is of another type");
    }
  }

  Attributes read_attributes(int variable, int count, const std::string& of) const {
    Attributes out;
    char name[NC_MAX_NAME + 1];
    for (int a = 0; a < count; ++a) {
      check(nc_inq_attname(id_, variable, a, name), of);
      const std::string full = of + ":" + name;
      Values v;
      std::size_t length = 0;
      check(nc_inq_att(id_, variable, name, &v.type, &length), full);
      require_known(v.type, full);
      if (v.type == NC_CHAR) {
        v.text.resize(length);
        check(nc_get_att_text(id_, variable, name, v.text.data()), full);
      } else if (v.is_whole()) {
        v.integers.resize(length);
        check(nc_get_att_longlong(id_, variable, name, v.integers.data()), full);
      } else {
        v.doubles.resize(length);
        check(nc_get_att_double(id_, variable, name, v.doubles.data()), full);
      }
      out[name] = std::move(v);
    }
    return out;
  }

  void read() {
    int dimension_count = 0, variable_count = 0, attribute_count = 0, record = -1;
    check(nc_inq(id_, &dimension_count, &variable_count, &attribute_count, &record), "");
    char name[NC_MAX_NAME + 1];
    std::vector<std::string> names;
    for (int d = 0; d < dimension_count; ++d) {
      std::size_t length = 0;
      check(nc_inq_dim(id_, d, name, &length), "");
      names.emplace_back(name);
      dimensions[name] = length;
    }
    unlimited = record >= 0 ? names[std::size_t(record)] : "";
    attributes = read_attributes(NC_GLOBAL, attribute_count, "");
    for (int v = 0; v < variable_count; ++v) {
      Variable variable;
      int shape[NC_MAX_VAR_DIMS], rank = 0, count = 0;
      check(nc_inq_var(id_, v, name, nullptr, &rank, shape, &count), "");
      variable.name = name;
      variable.id = v;
      for (int d = 0; d < rank; ++d) {
        variable.dimensions.push_back(names[std::size_t(shape[d])]);
        variable.shape.push_back(dimensions[variable.dimensions.back()]);
      }
      variable.attributes = read_attributes(v, count, variable.name);
      variables.push_back(std::move(variable));
    }
  }

  std::string path_;
  int id_ = -1;
};

std::string text_of(const Values& v) {
  if (v.type == NC_CHAR)
    return "'" + v.text + "'";
  std::string out;
  for (std::size_t i = 0; i < v.size(); ++i) {
    out += (i ? ", " : "") +
           (v.is_whole() ? std::to_string(v.integers[i]) : number_text(v.doubles[i]));
  }
  return out;
}

class Comparison {
public:
  Comparison(const File& a, const File& b, const NetcdfOptions& options)
      : a_(a), b_(b), options_(options) {}

  Verdict run() {
    check_names();
    compare_dimensions();
    compare_attributes(a_.attributes, b_.attributes, "");
    std::size_t count = 0;
    for (const Variable& v : a_.variables) {
      if (ignored(v.name))
        continue;
      if (const Variable* other = b_.find(v.name)) {
        compare_attributes(v.attributes, other->attributes, v.name);
        compare_values(v, *other);
        ++count;
      } else {
        verdict_.differ("variable '" + v.name + "' is missing in the second file");
      }
    }
    for (const Variable& v : b_.variables)
      if (!ignored(v.name) && !a_.find(v.name))
        verdict_.differ("variable '" + v.name + "' is missing in the first file");
    if (verdict_.same)
      verdict_.lines.push_back("same: " + count_text(count, "variable"));
    return verdict_;
  }

private:
  bool ignored(const std::string& name) const {
    return std::find(options_.ignored.begin(), options_.ignored.end(), name) !=
           options_.ignored.end();
  }

  void check_names() const {
    if (options_.lenient)
      return;
    std::vector<std::string> named = options_.ignored;
    for (const NamedTolerance& variable : options_.variables)
      named.push_back(variable.name);
    for (const std::string& name : named)
      if (name.find(':') == std::string::npos && !a_.find(name) && !b_.find(name))
        unusable("no variable '" + name + "' in either file");
  }

  void compare_dimensions() {
    for (const auto& [name, length] : a_.dimensions) {
      const auto other = b_.dimensions.find(name);
      if (other == b_.dimensions.end()) {
        verdict_.differ("dimension '" + name + "' is missing in the second file");
      } else if (other->second != length) {
        verdict_.differ("dimension '" + name + "' has " + std::to_string(length) + " -> " +
                        std::to_string(other->second));
      }
    }
    for (const auto& [name, length] : b_.dimensions)
      if (!a_.dimensions.contains(name))
        verdict_.differ("dimension '" + name + "' is missing in the first file");
  }

  void compare_attributes(const Attributes& a, const Attributes& b, const std::string& of) {
    for (const auto& [name, value] : a) {
      const std::string full = of + ":" + name;
      const auto other = b.find(name);
      if (ignored(full))
        continue;
      if (other == b.end()) {
        verdict_.differ("attribute '" + full + "' is missing in the second file");
        continue;
      }
      bool same = value.type == other->second.type && value.size() == other->second.size() &&
                  value.text == other->second.text;
      for (std::size_t i = 0; same && value.type != NC_CHAR && i < value.size(); ++i)
        same = value.same(i, other->second, {});
      if (!same) {
        verdict_.differ("attribute '" + full + "': " + text_of(value) + " -> " +
                        text_of(other->second));
      }
    }
    for (const auto& [name, value] : b)
      if (!a.contains(name) && !ignored(of + ":" + name))
        verdict_.differ("attribute '" + of + ":" + name + "' is missing in the first file");
  }

  /// Lengths that differ are told of the dimensions; here whether the variables can be compared.
  bool comparable(const Variable& a, const Variable& b) const {
    if (a.dimensions != b.dimensions)
      return false;
    for (std::size_t d = 0; d < a.shape.size(); ++d) {
      const bool grows = d == 0 && a.dimensions[0] == a_.unlimited && a_.unlimited == b_.unlimited;
      if (a.shape[d] != b.shape[d] && !grows)
        return false;
    }
    return true;
  }

  static std::string place(const Variable& v, std::size_t index) {
    std::string out;
    for (std::size_t d = v.shape.size(); d-- > 0;) {
      out = v.dimensions[d] + " " + std::to_string(index % v.shape[d]) +
            (out.empty() ? "" : ", " + out);
      index /= v.shape[d];
    }
    return out.empty() ? "it" : out;
  }

  void compare_values(const Variable& a, const Variable& b) {
    if (!comparable(a, b)) {
      verdict_.differ("variable '" + a.name + "' has another shape");
      return;
    }
    const Values x = a_.values(a), y = b_.values(b);
    if (x.type != y.type) {
      verdict_.differ("variable '" + a.name + "' is " + type_name(x.type) + " -> " +
                      type_name(y.type));
      return;
    }
    const std::size_t count = std::min(x.size(), y.size());
    Tolerance tolerance = options_.tolerance;
    for (const NamedTolerance& variable : options_.variables)
      tolerance = variable.name == a.name ? variable.tolerance : tolerance;
    const bool exact = tolerance.relative == 0 && tolerance.absolute == 0;
    std::size_t moved = 0, worst_at = 0;
    double worst = -1;
    for (std::size_t i = 0; i < count; ++i) {
      if (x.type == NC_CHAR ? x.text[i] == y.text[i] : x.same(i, y, tolerance))
        continue;
      ++moved;
      // Where nothing is admitted, the largest change is the worst.
      const double far =
          x.type == NC_CHAR ? 0
                            : excess(x.number(i), y.number(i), exact ? Tolerance{0, 1} : tolerance);
      if (far > worst) {
        worst = far;
        worst_at = i;
      }
    }
    if (moved > 0) {
      const std::string change =
          x.type == NC_CHAR
              ? std::string("'") + x.text[worst_at] + "' -> '" + y.text[worst_at] + "'"
              : change_text(x.number(worst_at), y.number(worst_at));
      verdict_.differ("variable '" + a.name + "' moved in " + std::to_string(moved) + " of " +
                      count_text(count, "value") + ", most at " + place(a, worst_at) + ": " +
                      change);
    }
  }

  const File& a_;
  const File& b_;
  const NetcdfOptions& options_;
  Verdict verdict_;
};

} // namespace

Verdict compare_netcdf(const std::string& a, const std::string& b, const NetcdfOptions& options) {
  const File first(a), second(b);
  return Comparison(first, second, options).run();
}

} // namespace insitu::compare
