#include "runs/netcdf/ugrid_heights.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "runs/netcdf/units.h"

namespace insitu_replay {

namespace {

using Variable = NetcdfFile::Variable;

/// The parametric coordinates by their standard names. All give heights above the datum from the
/// height eta of the surface and the depth of the bottom.
enum class Formula { none, sigma, s, s_g1, s_g2 };

Formula formula_of(const NetcdfFile& file, const Variable& v) {
  if (file.text(v, "formula_terms").empty())
    return Formula::none;
  const std::string name = file.text(v, "standard_name");
  return name.starts_with("ocean_sigma_coordinate") || name == "ocean_sigma/general_coordinate"
             ? Formula::sigma
         : name == "ocean_s_coordinate"    ? Formula::s
         : name == "ocean_s_coordinate_g1" ? Formula::s_g1
         : name == "ocean_s_coordinate_g2" ? Formula::s_g2
                                           : Formula::none;
}

bool points_down(const NetcdfFile& file, const Variable& v) {
  const std::string positive = file.text(v, "positive");
  return positive == "down" || (positive.empty() && file.text(v, "standard_name") == "depth");
}

/// "sigma: a eta: b" is a by sigma, b by eta.
std::map<std::string, std::string> terms_of(const NetcdfFile& file, const Variable& v) {
  std::map<std::string, std::string> out;
  std::string key;
  for (const std::string& word : file.words(v, "formula_terms"))
    if (word.back() == ':')
      key = word.substr(0, word.size() - 1);
    else
      out[key] = word;
  return out;
}

/// The variables of a formula; each is of all levels and nodes once it is asked for.
class Terms {
public:
  Terms(const UgridDims& dims, const Variable& v, std::size_t step, int level, std::size_t levels)
      : dims_(dims), v_(v), names_(terms_of(dims.file, v)), step_(step), level_(level),
        levels_(levels) {}

  /// Null if the formula names none.
  const Variable* find(const char* key) const {
    const auto found = names_.find(key);
    return found == names_.end() ? nullptr
                                 : &dims_.file.require(found->second, v_, "formula_terms");
  }

  std::vector<double> operator()(const char* key, std::optional<double> otherwise = {}) const {
    const std::size_t nodes = dims_.topology.nodes();
    const Variable* const of = find(key);
    if (!of && !otherwise)
      dims_.file.fail(v_, std::string("formula_terms has no ") + key);
    if (!of)
      return std::vector<double>(levels_ * nodes, *otherwise);
    const bool along_levels = dims_.has(*of, level_);
    std::vector<double> values = dims_.values(
        *of, {.step = step_, .level = along_levels ? level_ : -1, .item = dims_.topology.node_dim});
    if (!along_levels) { // the same for all levels
      values.reserve(levels_ * nodes);
      for (std::size_t k = 1; k < levels_; ++k)
        for (std::size_t n = 0; n < nodes; ++n)
          values.push_back(values[n]);
    }
    if (values.size() != levels_ * nodes)
      dims_.file.fail(*of, "has " + std::to_string(values.size() / nodes) + " levels, " +
                               std::to_string(levels_) + " expected");
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i]))
        dims_.file.fail(*of, "node " + std::to_string(i % nodes) +
                                 " has no value, which heights of '" + v_.name + "' need");
    return values;
  }

private:
  const UgridDims& dims_;
  const Variable& v_;
  std::map<std::string, std::string> names_;
  std::size_t step_;
  int level_;
  std::size_t levels_;
};

/// The stretching of Song and Haidvogel.
double stretched(double s, double a, double b) {
  return (1 - b) * std::sinh(a * s) / std::sinh(a) +
         b * (std::tanh(a * (s + 0.5)) / (2 * std::tanh(a / 2)) - 0.5);
}

double height_by(Formula formula, double s, double eta, double depth, double depth_c, double c) {
  switch (formula) {
  case Formula::sigma:
    return eta + s * (depth + eta);
  case Formula::s:
    return eta * (1 + s) + depth_c * s + (depth - depth_c) * c;
  case Formula::s_g1: {
    const double still = depth_c * s + (depth - depth_c) * c;
    return still + eta * (1 + still / depth);
  }
  default:
    return eta + (eta + depth) * (depth_c * s + depth * c) / (depth_c + depth);
  }
}

} // namespace

bool gives_heights(const NetcdfFile& file, const Variable& v) {
  if (!NetcdfFile::has_numbers(v))
    return false;
  if (formula_of(file, v) != Formula::none)
    return true;
  const std::string name = file.text(v, "standard_name");
  if (v.name == "zCoordinates") // SCHISM's, which has no attributes that say so
    return true;
  return file.text(v, "formula_terms").empty() && metres_of(file.text(v, "units")) &&
         (!file.text(v, "positive").empty() || file.text(v, "axis") == "Z" || name == "depth" ||
          name == "height" || name == "altitude");
}

std::vector<double> heights_of(const UgridDims& dims, const Variable& v,
                               std::vector<double> numbers, std::size_t step, int level) {
  const NetcdfFile& file = dims.file;
  const Formula formula = formula_of(file, v);
  const std::size_t nodes = dims.topology.nodes(), levels = numbers.size() / nodes;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (!std::isfinite(numbers[i]))
      file.fail(v, "level " + std::to_string(i / nodes) + " has no value at node " +
                       std::to_string(i % nodes));
  if (formula == Formula::none) {
    const double factor =
        metres_of(file.text(v, "units")).value_or(1) * (points_down(file, v) ? -1 : 1);
    for (double& height : numbers)
      height *= factor;
    return numbers;
  }
  const Terms term(dims, v, step, level, levels);
  const std::vector<double> eta = term("eta", 0.0), depth = term("depth");
  std::vector<double> depth_c(numbers.size(), 0.0), c(numbers.size(), 0.0);
  if (formula != Formula::sigma)
    depth_c = term("depth_c");
  if (formula == Formula::s) {
    const std::vector<double> a = term("a"), b = term("b");
    for (std::size_t i = 0; i < c.size(); ++i)
      c[i] = stretched(numbers[i], a[i], b[i]);
  } else if (formula != Formula::sigma) {
    c = term(term.find("C") ? "C" : "c");
  }
  for (std::size_t i = 0; i < numbers.size(); ++i)
    numbers[i] = height_by(formula, numbers[i], eta[i], depth[i], depth_c[i], c[i]);
  return numbers;
}

bool heights_move(const UgridDims& dims, const Variable& v) {
  if (dims.has(v, dims.time_dim))
    return true;
  if (formula_of(dims.file, v) != Formula::none)
    for (const auto& [key, name] : terms_of(dims.file, v))
      if (const Variable* const of = dims.file.find(name); of && dims.has(*of, dims.time_dim))
        return true;
  return false;
}

bool is_alone_along_levels(const NetcdfFile& file, const Variable& v) {
  const Formula formula = formula_of(file, v);
  return formula != Formula::s_g1 && formula != Formula::s_g2;
}

} // namespace insitu_replay
