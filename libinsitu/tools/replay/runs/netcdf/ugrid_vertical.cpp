#include "runs/netcdf/ugrid_vertical.h"

#include <algorithm>
#include <cmath>

#include "runs/netcdf/ugrid_heights.h"

namespace insitu_replay {

namespace {

using Variable = NetcdfFile::Variable;

/// Values of cells as values of nodes: the means of the cells around each.
std::vector<double> at_nodes(const UgridTopology& t, const std::vector<double>& of_cells,
                             std::size_t levels) {
  std::vector<double> sum(levels * t.nodes(), 0.0);
  std::vector<double> count(t.nodes(), 0.0);
  for (std::size_t c = 0; c < t.cells(); ++c)
    for (std::int64_t i = t.offsets[c]; i < t.offsets[c + 1]; ++i) {
      const auto node = std::size_t(t.ids[std::size_t(i)]);
      count[node] += 1;
      for (std::size_t k = 0; k < levels; ++k)
        sum[k * t.nodes() + node] += of_cells[k * t.cells() + c];
    }
  for (std::size_t i = 0; i < sum.size(); ++i)
    sum[i] /= std::max(count[i % t.nodes()], 1.0);
  return sum;
}

/// The one dimension along which a variable's heights go; -1 if it has none or several.
int level_of(const UgridDims& dims, const Variable& v) {
  const std::vector<int> others = dims.others(v);
  return others.size() == 1 && !dims.has(v, dims.topology.cell_dim) ? others[0] : -1;
}

/// The bounds of layers as the numbers between them; empty if there are none, or layers do not
/// follow each other.
std::vector<double> bounds_of(const UgridDims& dims, const Variable& v, int level) {
  const std::string name = dims.file.text(v, "bounds");
  const Variable* const of = name.empty() ? nullptr : dims.file.find(name);
  if (!of || v.dims.size() != 1 || of->dims.size() != 2 || of->dims[0] != level ||
      dims.file.length(of->dims[1]) != 2 || !is_alone_along_levels(dims.file, v))
    return {};
  const std::vector<double> pairs = dims.file.values(*of);
  std::vector<double> out{pairs.empty() ? 0 : pairs[0]};
  for (std::size_t k = 0; 2 * k + 1 < pairs.size(); ++k) {
    if (pairs[2 * k] != out.back())
      return {};
    out.push_back(pairs[2 * k + 1]);
  }
  return out;
}

} // namespace

std::vector<int> UgridDims::others(const Variable& v) const {
  std::vector<int> out;
  for (const int dim : v.dims)
    if (dim != time_dim && dim != topology.node_dim && dim != topology.cell_dim)
      out.push_back(dim);
  return out;
}

bool UgridDims::has(const Variable& v, int dim) const {
  return dim >= 0 && std::find(v.dims.begin(), v.dims.end(), dim) != v.dims.end();
}

std::vector<double> UgridDims::values(const Variable& v, const Slab& slab) const {
  const std::vector<double> read = file.values(v, time_dim, slab.step);
  const bool of_cells = slab.item == topology.node_dim && has(v, topology.cell_dim);
  const int along = of_cells ? topology.cell_dim : slab.item;
  const std::size_t levels = slab.level < 0 ? 1 : file.length(slab.level),
                    items = along < 0 ? 1 : file.length(along);
  std::size_t stride = 1, of_level = 0, of_item = 0, first = 0;
  for (std::size_t d = v.dims.size(); d-- > 0;) {
    const int dim = v.dims[d];
    if (dim == slab.level)
      of_level = stride;
    else if (dim == along)
      of_item = stride;
    else if (dim == slab.part)
      first = slab.component * stride;
    else if (dim != time_dim && file.length(dim) != 1)
      file.fail(v, "has the dimension '" + file.name_of_dim(dim) + "', which is not expected");
    stride *= dim == time_dim ? 1 : file.length(dim);
  }
  std::vector<double> out(levels * items);
  for (std::size_t k = 0; k < levels; ++k)
    for (std::size_t i = 0; i < items; ++i)
      out[k * items + i] = read[first + k * of_level + i * of_item];
  return of_cells ? at_nodes(topology, out, levels) : out;
}

std::unique_ptr<UgridVertical> UgridVertical::find(const UgridDims& dims,
                                                   const std::function<Along(int)>& along,
                                                   std::vector<std::string>& notes) {
  struct Candidate {
    const Variable* v;
    int level;
    std::size_t length;
    bool has_values;
  };
  std::vector<Candidate> candidates;
  for (const Variable& v : dims.file.variables()) {
    const int level = level_of(dims, v);
    if (level < 0)
      continue;
    const Along values = along(level);
    const bool has_values = values.nodes || values.cells;
    if (gives_heights(dims.file, v))
      candidates.push_back({&v, level, dims.file.length(level), has_values});
    else if (has_values && !dims.file.text(v, "formula_terms").empty())
      notes.push_back("variable '" + v.name + "': heights by the " +
                      dims.file.text(v, "standard_name") + " are not known");
  }
  auto out = std::make_unique<UgridVertical>();
  for (const Candidate& a : candidates)
    for (const Candidate& b : candidates)
      if (!out->layer_ && b.length == a.length + 1 && (a.has_values || b.has_values)) {
        out->layer_ = a.v;
        out->layer_dim = a.level;
        out->interface_ = b.v;
        out->interface_dim = b.level;
        out->layers = a.length;
      }
  const auto only = std::find_if(candidates.begin(), candidates.end(),
                                 [](const Candidate& c) { return c.has_values; });
  if (only == candidates.end())
    return nullptr;
  if (!out->layer_) {
    out->bounds_ = bounds_of(dims, *only->v, only->level);
    if (!out->bounds_.empty() || !along(only->level).nodes) {
      out->layer_ = only->v;
      out->layer_dim = only->level;
      out->layers = only->length;
    } else {
      out->interface_ = only->v;
      out->interface_dim = only->level;
      out->layers = only->length - 1;
    }
    if (out->layers < (out->bounds_.empty() && out->layer_ ? 2u : 1u)) {
      notes.push_back("variable '" + only->v->name + "': " + std::to_string(only->length) +
                      " level without bounds tells no layers");
      return nullptr;
    }
  }
  out->moves = heights_move(dims, out->interface_ ? *out->interface_ : *out->layer_);
  return out;
}

std::vector<double> UgridVertical::heights(const UgridDims& dims, const Variable& v,
                                           std::size_t step) const {
  const int level = &v == interface_ ? interface_dim : layer_dim;
  return heights_of(dims, v,
                    dims.values(v, {.step = step, .level = level, .item = dims.topology.node_dim}),
                    step, level);
}

std::vector<double> UgridVertical::middles(const UgridDims& dims, std::size_t step) const {
  return heights(dims, *layer_, step);
}

std::vector<double> UgridVertical::interfaces(const UgridDims& dims, std::size_t step) const {
  if (interface_)
    return heights(dims, *interface_, step);
  const std::size_t nodes = dims.topology.nodes();
  if (!bounds_.empty()) {
    std::vector<double> numbers;
    for (const double bound : bounds_)
      numbers.insert(numbers.end(), nodes, bound);
    return heights_of(dims, *layer_, std::move(numbers), step, layer_dim);
  }
  // Half way between the layers, and as far beyond the first and the last.
  const std::vector<double> z = middles(dims, step);
  std::vector<double> out((layers + 1) * nodes);
  for (std::size_t n = 0; n < nodes; ++n) {
    for (std::size_t k = 1; k < layers; ++k)
      out[k * nodes + n] = (z[(k - 1) * nodes + n] + z[k * nodes + n]) / 2;
    out[n] = 2 * z[n] - out[nodes + n];
    out[layers * nodes + n] = 2 * z[(layers - 1) * nodes + n] - out[(layers - 1) * nodes + n];
  }
  return out;
}

} // namespace insitu_replay
