#pragma once

#include <optional>
#include <string>
#include <vector>

namespace insitu_replay {

/// A netCDF file that is read. What is wrong throws FileError with the file's name, and the
/// variable's.
class NetcdfFile {
public:
  struct Variable {
    std::string name;
    int id = -1, type = 0;
    std::vector<int> dims; ///< the slowest first
  };

  explicit NetcdfFile(const std::string& path);
  ~NetcdfFile();
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  const std::string& path() const { return path_; }
  const std::vector<Variable>& variables() const { return variables_; }
  /// Null if there is none of that name.
  const Variable* find(const std::string& name) const;
  /// asked_by: the variable whose attribute names it.
  const Variable& require(const std::string& name, const Variable& asked_by,
                          const char* attribute) const;

  /// An attribute; empty if it is not there or is no text.
  std::string text(const Variable& v, const char* attribute) const;
  /// The first number of an attribute.
  std::optional<double> number(const Variable& v, const char* attribute) const;
  /// The words of a text.
  std::vector<std::string> words(const Variable& v, const char* attribute) const;

  std::size_t length(int dim) const { return lengths_[std::size_t(dim)]; }
  const std::string& name_of_dim(int dim) const { return dim_names_[std::size_t(dim)]; }
  bool is_unlimited(int dim) const;
  static bool has_numbers(const Variable& v);

  /// The values of a variable of numbers, with scale_factor and add_offset applied; NaN where it
  /// has a fill value. fixed: along this dimension of the file the place `at` alone.
  std::vector<double> values(const Variable& v, int fixed = -1, std::size_t at = 0) const;

  [[noreturn]] void fail(const Variable& v, const std::string& what) const;

private:
  void check(int status, const std::string& of) const;
  std::vector<double> fill_values(const Variable& v) const;
  void read_layout();

  std::string path_;
  int id_ = -1;
  std::vector<Variable> variables_;
  std::vector<std::size_t> lengths_;
  std::vector<std::string> dim_names_;
  std::vector<int> unlimited_;
};

} // namespace insitu_replay
