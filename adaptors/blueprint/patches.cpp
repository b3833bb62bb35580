#include <algorithm>
#include <cmath>
#include <map>

#include "attachment.h"

namespace insitu::blueprint {

namespace {

[[noreturn]] void unsupported(const Domain& d, const std::string& what) {
  throw Error(INSITU_ERROR_UNSUPPORTED, d.path + " " + what);
}

std::string text(double x) {
  char out[32];
  std::snprintf(out, sizeof out, "%.17g", x);
  return out;
}

/// How many of the finer spacing make the coarser one, along all axes; 0: no power of two from 2
/// on, up to the roundings of whoever divided.
std::int64_t ratio_of(const std::array<double, 3>& coarse, const std::array<double, 3>& fine,
                      std::size_t dimensions) {
  const double ratio = std::round(coarse[0] / fine[0]);
  if (!(ratio >= 2 && ratio <= double(1 << 30)) || std::exp2(std::round(std::log2(ratio))) != ratio)
    return 0;
  for (std::size_t a = 0; a < dimensions; ++a)
    if (!(std::fabs(coarse[a] - ratio * fine[a]) <= 1e-9 * std::fabs(coarse[a])))
      return 0;
  return static_cast<std::int64_t>(ratio);
}

struct Level {
  std::array<double, 3> spacing;
  const Domain* first;
};

/// The spacings of the levels that are here. Those of a level agree, and the dimensions of all.
std::map<std::int64_t, Level> levels_of(const std::vector<Domain>& domains) {
  std::map<std::int64_t, Level> out;
  for (const Domain& d : domains) {
    if (d.kind != Domain::Kind::block || d.block.kind != INSITU_BLOCK_UNIFORM)
      unsupported(d, "is no uniform block; the domains of an adaptive mesh have to be");
    if (d.dimensions != domains.front().dimensions)
      unsupported(d, "has " + std::to_string(d.dimensions) + " dimensions, " +
                         domains.front().path + " has " +
                         std::to_string(domains.front().dimensions));
    const auto [known, fresh] = out.try_emplace(d.level, Level{d.spacing, &d});
    for (std::size_t a = 0; a < std::size_t(d.dimensions); ++a) {
      const double s = d.spacing[a], of_level = known->second.spacing[a];
      if (!(s > 0) || std::fabs(s - of_level) > 1e-9 * of_level)
        unsupported(d, "has the spacing " + text(s) + " along axis " + std::to_string(a) +
                           ", level " + std::to_string(d.level) + " has " + text(of_level) +
                           " in " + known->second.first->path);
    }
  }
  return out;
}

/// Appends the ratios of the levels from a coarser one here to the next one here, `gap` levels
/// below: where none between them is here, those that nestsets tell, and of the others a half or a
/// quarter each. Returns what is left of the whole ratio, which should be 1.
std::int64_t split(std::int64_t ratio, std::int64_t coarse, std::int64_t gap,
                   const ToldRatios& told, std::vector<std::int32_t>& ratios) {
  std::vector<std::int64_t> known(static_cast<std::size_t>(gap), 0); // 0: not known
  for (std::int64_t l = 0; gap > 1 && l < gap; ++l)
    if (const auto by = told.find({coarse + l, coarse + l + 1}); by != told.end())
      known[static_cast<std::size_t>(l)] = by->second.ratio;
  for (const std::int64_t k : known)
    if (k > 0)
      ratio = ratio % k == 0 ? ratio / k : 0;
  std::int64_t left = std::count(known.begin(), known.end(), 0);
  for (std::int64_t k : known) {
    if (k == 0) {
      --left;
      k = ratio >> left >= 4 ? 4 : 2;
      ratio = ratio % k == 0 ? ratio / k : 0;
    }
    ratios.push_back(static_cast<std::int32_t>(k));
  }
  return ratio;
}

/// The ratios of all levels from the coarsest on, and the coarsest spacing. Where no domain of a
/// level is here, its ratio is that of nestsets, or else a factor of that between its neighbours,
/// and above the coarsest level here 2.
void set_levels(const std::map<std::int64_t, Level>& levels, const ToldRatios& told,
                insitu_amr& lattice, std::vector<std::int32_t>& ratios) {
  const std::int64_t coarsest = levels.begin()->first;
  std::array<double, 3> spacing = levels.begin()->second.spacing;
  for (std::int64_t l = 0; l < coarsest; ++l) {
    const auto known = told.find({l, l + 1});
    ratios.push_back(known == told.end() ? 2 : static_cast<std::int32_t>(known->second.ratio));
    for (double& s : spacing)
      s *= ratios.back();
  }
  for (auto fine = std::next(levels.begin()); fine != levels.end(); ++fine) {
    const auto coarse = std::prev(fine);
    const std::int64_t gap = fine->first - coarse->first;
    const std::int64_t ratio = ratio_of(coarse->second.spacing, fine->second.spacing,
                                        std::size_t(fine->second.first->dimensions));
    if (split(ratio, coarse->first, gap, told, ratios) == 1)
      continue;
    for (const auto& [between, by] : told)
      if (gap > 1 && between.first >= coarse->first && between.second <= fine->first)
        throw Error(INSITU_ERROR_ARGUMENT, by.path + "/ratio/i is " + std::to_string(by.ratio) +
                                               ", and from level " + std::to_string(coarse->first) +
                                               " to level " + std::to_string(fine->first) +
                                               " the spacings make " + std::to_string(ratio));
    unsupported(*fine->second.first,
                "of level " + std::to_string(fine->first) + " has the spacing " +
                    text(fine->second.spacing[0]) + ", level " + std::to_string(coarse->first) +
                    " has " + text(coarse->second.spacing[0]) +
                    "; a half or a quarter a level, along all axes, is supported");
  }
  lattice.level_count = static_cast<std::int32_t>(ratios.size()) + 1;
  std::copy(spacing.begin(), spacing.end(), lattice.spacing);
  const Domain& first = *levels.begin()->second.first;
  std::copy(first.origin.begin(), first.origin.end(), lattice.origin);
  lattice.dimensions = first.dimensions;
}

/// Takes layers of duplicates off a domain, of which a box must be left; its fields become windows.
void trim(Domain& d) {
  if (!d.ghosts)
    return;
  const auto* ghosts = static_cast<const std::uint8_t*>(d.ghosts->data);
  if (d.ghosts->extent[0] != 0 || d.ghosts->stride[0] != 0)
    unsupported(d, "has ghosts with strides; packed ones are supported");
  std::array<std::int64_t, 3> cells{}, low{}, high{};
  for (std::size_t a = 0; a < 3; ++a)
    cells[a] = low[a] = d.extent[a] - 1;
  const bool vtk = d.convention == INSITU_GHOSTS_VTK;
  std::int64_t own = 0, at = 0;
  for (std::int64_t k = 0; k < cells[2]; ++k)
    for (std::int64_t j = 0; j < cells[1]; ++j)
      for (std::int64_t i = 0; i < cells[0]; ++i, ++at) {
        if (vtk ? (ghosts[at] & 1) != 0 : ghosts[at] == 1)
          continue;
        ++own; // coarse cells under finer ones are the library's to find
        const std::array<std::int64_t, 3> ijk{i, j, k};
        for (std::size_t a = 0; a < 3; ++a) {
          low[a] = std::min(low[a], ijk[a]);
          high[a] = std::max(high[a], ijk[a] + 1);
        }
      }
  std::array<std::int64_t, 3> left{};
  for (std::size_t a = 0; a < 3; ++a)
    left[a] = own == 0 ? 0 : high[a] - low[a];
  if (own != left[0] * left[1] * left[2])
    unsupported(d,
                "has " + std::to_string(own) + " cells that are no duplicates, which are no box");
  for (Field& f : d.fields)
    for (insitu_array& a : f.arrays) {
      if (a.extent[0] != 0)
        unsupported(d,
                    "has ghosts, and field " + f.name + " has strides; one of both is supported");
      a = block_of(a, left, low, {1, cells[0], cells[0] * cells[1]});
    }
  for (std::size_t a = 0; a < 3; ++a) {
    d.block.first[a] += low[a];
    d.extent[a] = d.block.vertices[a] = left[a] + 1;
  }
  d.cell_count = own;
  d.ghosts.reset();
}

} // namespace

void make_patches(std::vector<Domain>& domains, insitu_amr& lattice,
                  std::vector<std::int32_t>& ratios, std::vector<std::string>& left_out) {
  ratios.clear();
  if (domains.empty())
    return;
  const ToldRatios told = ratios_of_nestsets(domains);
  set_levels(levels_of(domains), told, lattice, ratios);
  check_ratios(told, ratios);
  for (Domain& d : domains) {
    double finer = 1;
    for (std::int64_t l = 0; l < d.level; ++l)
      finer *= ratios[static_cast<std::size_t>(l)];
    if (d.dimensions == 2) // one cell along k
      d.extent[2] = d.block.vertices[2] = 2;
    for (std::size_t a = 0; a < std::size_t(d.dimensions); ++a) {
      const double spacing = lattice.spacing[a] / finer;
      const double at = (d.origin[a] - lattice.origin[a]) / spacing, place = std::round(at);
      if (!(std::fabs(place) < double(1 << 30)) || std::fabs(at - place) > 1e-3)
        unsupported(d, "begins at " + text(d.origin[a]) + " along axis " + std::to_string(a) +
                           ", which is cell " + text(at) + " of level " + std::to_string(d.level) +
                           " from " + text(lattice.origin[a]) + " on; a whole cell is needed");
      d.block.first[a] = static_cast<std::int64_t>(place);
    }
    d.kind = Domain::Kind::patch;
    for (const Field& f : d.fields)
      if (f.on == INSITU_VERTEX)
        left_out.push_back(d.path + ": field " + f.name +
                           " is on vertices; fields of adaptive meshes are on cells");
    d.fields.erase(std::remove_if(d.fields.begin(), d.fields.end(),
                                  [](const Field& f) { return f.on == INSITU_VERTEX; }),
                   d.fields.end());
    trim(d);
    d.vertex_count = 0;
    d.hidden_points.reset();
  }
  domains.erase(std::remove_if(domains.begin(), domains.end(),
                               [](const Domain& d) { return d.cell_count == 0; }),
                domains.end());
}

} // namespace insitu::blueprint
