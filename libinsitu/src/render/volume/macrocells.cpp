#include "render/volume/macrocells.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "accel/tree/tree.h"
#include "core/status.h"
#include "render/volume/cell_columns.h"
#include "render/volume/gridlet_cells.h"
#include "render/volume/possible_values.h"
#include "render/volume/scalar_values.h"

namespace insitu::render {

namespace {

using math::Vec3d;

constexpr double infinity = PossibleValues::infinity;
/// Numbers of a macrocell among Macrocells::extremes().
constexpr std::size_t extremes_alone = 3, extremes_with_size = 4;

/// Some boxes of cells, each standing for `weight` of them, and how many cells there are in all.
struct CellSizes {
  struct One {
    Vec3d extent;
    double weight;
  };
  std::vector<One> picked;
  Vec3d mean;
  double cells = 0;

  explicit CellSizes(const query::Sampler& sampler) {
    const accel::Tree& tree = sampler.tree();
    const mesh::MeshView& mesh = sampler.mesh();
    constexpr std::int64_t most = 4096;
    const std::int64_t items = tree.cell_count(), count = std::min(items, most);
    mesh::CellVertices cell;
    double weights = 0;
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int64_t flat = tree.cells()[i * items / count];
      mesh::gather(mesh, flat, cell);
      const mesh::Box box = mesh::box_of(cell);
      const mesh::PieceView& piece = mesh.pieces[cell.piece];
      const double weight = double(piece.item_cells(flat - mesh.first_cell[cell.piece]).count);
      picked.push_back({box.size(), weight});
      weights += weight;
      mean += weight * picked.back().extent;
    }
    mean = mean / weights;
    cells = weights * (double(items) / double(count));
  }

  /// How many macrocells of this size a cell meets, on average.
  double coverage(const Vec3d& size) const {
    double sum = 0, weights = 0;
    for (const One& one : picked) {
      double met = one.weight;
      for (int a = 0; a < 3; ++a)
        met *= size[a] > 0 ? 1 + one.extent[a] / size[a] : 1.0;
      sum += met;
      weights += one.weight;
    }
    return sum / weights;
  }
};

} // namespace

MacrocellGrid MacrocellGrid::over(const mesh::Box& bounds, const double (&across)[3], double cells,
                                  const MacrocellFineness& fineness) {
  const double cells_each = fineness.cells_each;
  if (!(cells_each > 0))
    throw core::Error(INSITU_ERROR_ARGUMENT, "macrocells of " + std::to_string(cells_each) +
                                                 " cells each; more than 0 expected");
  MacrocellGrid grid;
  grid.counts = {1, 1, 1};
  grid.low = bounds.low;
  const Vec3d extent = bounds.size();
  double left = std::clamp(cells / cells_each, 1.0, fineness.most_macrocells);
  int order[3] = {0, 1, 2};
  std::sort(order, order + 3, [&](int a, int b) { return across[a] < across[b]; });
  double product = across[0] * across[1] * across[2];
  for (int i = 0; i < 3; ++i) { // the axes of few cells first: what they cannot take, others do
    const int a = order[i];
    const double wanted = across[a] * std::pow(left / product, 1.0 / (3 - i));
    // No finer than a quarter of a cell, nor than positions are resolved.
    const double farthest = std::max(std::fabs(grid.low[a]), std::fabs(grid.low[a] + extent[a]));
    const double finest = std::min(4 * across[a], extent[a] * 0x1p40 / std::max(farthest, 1e-300));
    constexpr double rounding = 1e-6; // three layers are three, though roundings make 2.9999999
    grid.counts[a] =
        int(std::floor((1 + rounding) * std::max(1.0, std::min({wanted, finest, left}))));
    left = std::max(1.0, left / grid.counts[a]);
    product /= across[a];
  }
  for (int a = 0; a < 3; ++a)
    grid.size[a] = extent[a] / grid.counts[a];
  return grid;
}

void MacrocellGrid::coarsen(core::FunctionRef<double(const MacrocellGrid&)> coverage) {
  constexpr double most_coverage = 256;
  while (count() > 1 && coverage(*this) > most_coverage) {
    int widest = 0;
    for (int a = 1; a < 3; ++a)
      if (counts[std::size_t(a)] > counts[std::size_t(widest)])
        widest = a;
    int& layers = counts[std::size_t(widest)];
    const double extent = size[widest] * layers;
    layers = (layers + 1) / 2;
    size[widest] = extent / layers;
  }
}

MacrocellGrid Macrocells::grid_of(const query::Sampler& sampler,
                                  const MacrocellFineness& fineness) {
  constexpr double one[3] = {1, 1, 1};
  if (sampler.tree().empty())
    return MacrocellGrid::over({}, one, 0, fineness);
  const CellSizes sizes(sampler);
  const mesh::Box bounds{sampler.tree().bounds_min(), sampler.tree().bounds_max()};
  const Vec3d extent = bounds.size();
  double across[3]; // the mesh's width in mean cells
  for (int a = 0; a < 3; ++a)
    across[a] = sizes.mean[a] > 0 && extent[a] > sizes.mean[a] ? extent[a] / sizes.mean[a] : 1.0;
  MacrocellGrid grid = MacrocellGrid::over(bounds, across, sizes.cells, fineness);
  grid.coarsen([&](const MacrocellGrid& of) { return sizes.coverage(of.size); });
  return grid;
}

namespace {

template <class T>
void lower_to(T& at, T v) {
  const std::atomic_ref<T> value(at);
  T now = value.load(std::memory_order_relaxed);
  while (v < now && !value.compare_exchange_weak(now, v, std::memory_order_relaxed)) {
  }
}

void raise_to(double& at, double v) {
  const std::atomic_ref<double> value(at);
  double now = value.load(std::memory_order_relaxed);
  while (v > now && !value.compare_exchange_weak(now, v, std::memory_order_relaxed)) {
  }
}

/// Which macrocells the boxes of cells meet.
class Raster {
public:
  explicit Raster(const MacrocellGrid& grid) : grid_(grid) {
    for (int a = 0; a < 3; ++a)
      scale_[a] = grid.counts[a] > 1 ? 1.0 / grid.size[a] : 0.0;
  }
  /// The layers along an axis of what reaches from low to high.
  void layers(int a, double low, double high, int& from, int& to) const {
    from = layer(a, (low - grid_.low[a]) * scale_[a] - Macrocells::margin);
    to = layer(a, (high - grid_.low[a]) * scale_[a] + Macrocells::margin);
  }
  template <class Visit>
  void visit(const mesh::Box& box, Visit&& visit) const {
    int from[3], to[3];
    for (int a = 0; a < 3; ++a)
      layers(a, box.low[a], box.high[a], from[a], to[a]);
    for (int k = from[2]; k <= to[2]; ++k)
      for (int j = from[1]; j <= to[1]; ++j)
        for (int i = from[0]; i <= to[0]; ++i)
          visit(std::size_t(grid_.index(i, j, k)));
  }

  const MacrocellGrid& grid() const { return grid_; }

private:
  int layer(int a, double at) const {
    return at > 0 ? (at < grid_.counts[a] ? int(at) : grid_.counts[a] - 1) : 0;
  }
  const MacrocellGrid& grid_;
  double scale_[3];
};

/// A gridlet's cells and what they make of the macrocells that they meet, first of a row of these,
/// then of a layer, then of all, so that each number is compared about once. Of a thread.
struct GridletScratch {
  static constexpr int most = 32; ///< macrocells along an axis
  struct Range {
    double lower = infinity, upper = -infinity;
    void add(double low, double high) {
      lower = low < lower ? low : lower;
      upper = high > upper ? high : upper;
    }
  };
  GridletCells cells;
  Range row[most], layer[most * most], all[most * most * most];

  /// Calls put(macrocell, lower, upper); false, without a call, if they are too many.
  template <class Put>
  bool merge(const Raster& raster, const mesh::GridletsView& view, Put&& put) {
    const mesh::Gridlet& g = cells.gridlet();
    int from[3][mesh::Gridlet::side], to[3][mesh::Gridlet::side], first[3], n[3];
    for (int a = 0; a < 3; ++a) {
      for (int i = 0; i < g.size[a]; ++i)
        raster.layers(a, view.coordinate(g, a, i), view.coordinate(g, a, i + 1), from[a][i],
                      to[a][i]);
      first[a] = from[a][0];
      n[a] = to[a][g.size[a] - 1] - first[a] + 1;
      if (n[a] > most)
        return false;
    }
    // What `range` is to be added to: those of its layers.
    const auto add = [](const Range* range, int count, Range* sums, int low, int high) {
      for (int m = low; m <= high; ++m)
        for (int i = 0; i < count; ++i)
          sums[m * count + i].add(range[i].lower, range[i].upper);
    };
    const int of_layer = n[0] * n[1];
    std::fill_n(all, of_layer * n[2], Range());
    for (int k = 0; k < g.size[2]; ++k) {
      std::fill_n(layer, of_layer, Range());
      for (int j = 0; j < g.size[1]; ++j) {
        std::fill_n(row, n[0], Range());
        for (int i = 0; i < g.size[0]; ++i) {
          const Range cell{cells.lower(i, j, k), cells.upper(i, j, k)};
          add(&cell, 1, row, from[0][i] - first[0], to[0][i] - first[0]);
        }
        add(row, n[0], layer, from[1][j] - first[1], to[1][j] - first[1]);
      }
      add(layer, of_layer, all, from[2][k] - first[2], to[2][k] - first[2]);
    }
    const Range* range = all;
    for (int k = 0; k < n[2]; ++k)
      for (int j = 0; j < n[1]; ++j)
        for (int i = 0; i < n[0]; ++i, ++range)
          if (range->lower <= range->upper)
            put(raster.grid().index(first[0] + i, first[1] + j, first[2] + k), range->lower,
                range->upper);
    return true;
  }
};

} // namespace

bool MacrocellGrid::resolves(const Ray& ray, double far) const {
  for (int a = 0; a < 3; ++a) {
    const double largest = std::fabs(ray.origin[a]) + far * std::fabs(ray.direction[a]) +
                           std::fabs(low[a]) + counts[a] * size[a];
    if (counts[a] > 1 && !(0x1p-48 * largest < Macrocells::margin * size[a]))
      return false;
  }
  return true;
}

Macrocells::Macrocells(const query::Sampler& sampler, const ScalarField& field,
                       const core::Threads& threads, core::Memory& memory,
                       const MacrocellFineness& fineness)
    : Macrocells(sampler, field, grid_of(sampler, fineness), threads, memory) {}

Macrocells::Macrocells(const query::Sampler& sampler, const ScalarField& field,
                       const MacrocellGrid& grid, const core::Threads& threads,
                       core::Memory& memory)
    : grid_(grid), ranges_(memory, INSITU_MEMORY_RANGES), has_nan_(memory, INSITU_MEMORY_RANGES),
      smallest_(memory, INSITU_MEMORY_RANGES) {
  ranges_.resize_discard(std::size_t(grid_.count()));
  has_nan_.resize_discard(std::size_t(grid_.count()));
  refresh(sampler, field, threads);
}

namespace {

/// Integers in the order of numbers that are no NaN; and back.
std::int64_t in_order(double number) {
  const auto bits = std::bit_cast<std::int64_t>(number);
  return bits < 0 ? bits ^ std::numeric_limits<std::int64_t>::max() : bits;
}
double number_of(std::int64_t key) {
  return std::bit_cast<double>(key < 0 ? key ^ std::numeric_limits<std::int64_t>::max() : key);
}

} // namespace

Macrocells::Macrocells(const MacrocellGrid& grid, std::span<const std::int64_t> extremes,
                       core::Memory& memory)
    : grid_(grid), ranges_(memory, INSITU_MEMORY_RANGES), has_nan_(memory, INSITU_MEMORY_RANGES),
      smallest_(memory, INSITU_MEMORY_RANGES) {
  const auto count = std::size_t(grid_.count());
  ranges_.resize_discard(count);
  has_nan_.resize_discard(count);
  const bool with_sizes = extremes.size() == extremes_with_size * count;
  if (with_sizes)
    smallest_.resize_discard(count);
  const std::int64_t* key = extremes.data();
  for (std::size_t i = 0; i < count; ++i) {
    ranges_[i].lower = number_of(*key++);
    ranges_[i].upper = -number_of(*key++);
    has_nan_[i] = *key++ < 0;
    if (with_sizes)
      smallest_[i] = float(number_of(*key++));
  }
}

std::vector<std::int64_t> Macrocells::extremes() const {
  std::vector<std::int64_t> keys;
  keys.reserve((has_sizes() ? extremes_with_size : extremes_alone) * ranges_.size());
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    keys.push_back(in_order(ranges_[i].lower));
    keys.push_back(in_order(-ranges_[i].upper));
    keys.push_back(has_nan_[i] ? -1 : 0);
    if (has_sizes())
      keys.push_back(in_order(double(smallest_[i])));
  }
  return keys;
}

std::vector<std::int64_t> Macrocells::no_extremes(const MacrocellGrid& grid, bool with_sizes) {
  std::vector<std::int64_t> keys;
  for (std::int64_t i = 0; i < grid.count(); ++i) {
    keys.insert(keys.end(), {in_order(infinity), in_order(infinity), 0});
    if (with_sizes)
      keys.push_back(in_order(infinity));
  }
  return keys;
}

void Macrocells::refresh(const query::Sampler& sampler, const ScalarField& field,
                         const core::Threads& threads) {
  const mesh::MeshView& mesh = sampler.mesh();
  threads.parallel_for(grid_.count(), 1 << 16, [&](std::int64_t begin, std::int64_t end) {
    std::fill(ranges_.data() + begin, ranges_.data() + end, Range{infinity, -infinity});
    std::fill(has_nan_.data() + begin, has_nan_.data() + end, std::uint8_t(0));
  });
  const Raster raster(grid_);
  const bool of_cells = field.field.association == INSITU_CELL;
  const std::int64_t own = mesh.own_cell_count();
  const mesh::GridletsView* const gridlets =
      mesh.piece_count > 0 && !of_cells ? mesh.pieces[0].gridlets : nullptr;
  std::optional<VertexNumbers> numbers;
  if (gridlets)
    numbers.emplace(field, 0);
  const auto whole = [&](std::int64_t gridlet) {
    thread_local const auto scratch = std::make_unique<GridletScratch>();
    return numbers && scratch->cells.find(*gridlets, gridlet, *numbers) &&
           scratch->merge(raster, *gridlets, [&](std::int64_t i, double lower, double upper) {
             lower_to(ranges_[std::size_t(i)].lower, lower);
             raise_to(ranges_[std::size_t(i)].upper, upper);
           });
  };
  const ScalarValues numbers_of(field, mesh);
  OwningCells(sampler).for_each(threads, whole, [&](const CellColumns& cells) {
    thread_local const auto numbers_here = std::make_unique<query::ValueBlock>();
    numbers_of.load(cells.cells(), *numbers_here);
    const int vertices = of_cells ? 1 : mesh::vertex_count(cells.shape());
    for (int k = 0; k < int(cells.cells().size()); ++k) {
      if (cells.cells()[std::size_t(k)] >= own)
        continue; // another process knows better what it holds
      PossibleValues values;
      for (int v = 0; v < vertices; ++v)
        values.add(numbers_here->vertex[v][k]);
      values.finish(!of_cells);
      raster.visit(cells.box(k), [&](std::size_t i) {
        lower_to(ranges_[i].lower, values.lower);
        raise_to(ranges_[i].upper, values.upper);
        if (values.nan)
          std::atomic_ref(has_nan_[i]).store(1, std::memory_order_relaxed);
      });
    }
  });
}

void Macrocells::measure(const query::Sampler& sampler, const core::Threads& threads) {
  smallest_.resize_discard(std::size_t(grid_.count()));
  std::fill(smallest_.begin(), smallest_.end(), std::numeric_limits<float>::infinity());
  const Raster raster(grid_);
  const auto none = [](std::int64_t) { return false; };
  OwningCells(sampler).for_each(threads, none, [&](const CellColumns& cells) {
    for (int k = 0; k < int(cells.cells().size()); ++k) {
      const mesh::Box box = cells.box(k);
      double side = infinity;
      for (int a = 0; a < 3; ++a)
        if (box.high[a] > box.low[a])
          side = std::min(side, box.high[a] - box.low[a]);
      raster.visit(box, [&](std::size_t i) { lower_to(smallest_[i], float(side)); });
    }
  });
}

} // namespace insitu::render
