#include "render/structures/structures.h"

#include <algorithm>

#include "core/timer.h"

namespace insitu::render {

void Structures::begin(const query::Sampler& sampler, std::uint64_t geometry, std::uint64_t fields,
                       const core::Threads& threads, std::function<ChartCopies()> copies) {
  if (!sampler_ || geometry != geometry_ || fields != fields_) {
    scalar_ranges_.clear();
    const auto age = [](auto& entries) {
      for (auto& [key, entry] : entries)
        entry.is_fresh = false;
    };
    age(averages_);
    age(value_ranges_);
    age(gradients_);
    age(macrocells_);
    age(majorants_);
    age(primitive_ranges_);
    age(culled_);
  }
  if (geometry != geometry_) {
    vertex_cells_.value.reset();
    cell_widths_.reset();
    copies_.reset();
    averages_.clear();
    value_ranges_.clear();
    gradients_.clear();
    macrocells_.clear();
    majorants_.clear();
    primitive_ranges_.clear();
    culled_.clear();
    triangles_.erase(std::string());
  }
  (void)sampler.facts(&threads); // which all frames ask for, without threads
  sampler_ = std::make_unique<query::Sampler>(sampler);
  threads_ = &threads;
  find_copies_ = std::move(copies);
  geometry_ = geometry;
  fields_ = fields;
}

template <class T>
void Structures::drop_unused(T& entries) {
  std::erase_if(entries, [](const auto& entry) { return !entry.second.used; });
  for (auto& [key, entry] : entries)
    entry.used = false;
}

void Structures::end() {
  if (!vertex_cells_.used)
    vertex_cells_.value.reset();
  vertex_cells_.used = false;
  drop_unused(value_ranges_);
  drop_unused(averages_);
  drop_unused(scalar_ranges_);
  drop_unused(macrocells_);
  drop_unused(majorants_);
  drop_unused(primitive_ranges_);
  drop_unused(culled_);
  drop_unused(gradients_);
  drop_unused(triangles_);
}

Structures::Key Structures::key_of(const ScalarField& field) const {
  bool is_average = false;
  for (const auto& [key, entry] : averages_) // of no pieces nothing is known, nor needed
    is_average = is_average || (entry.value && field.field.pieces &&
                                entry.value->field().field.pieces == field.field.pieces);
  return {field.field.name, field.field.association, range_component(field), is_average};
}

/// The entry's structure, made if it is not there, or given new values if there are some.
template <class T, class Make, class Refresh>
const T& Structures::up_to_date(ValuesEntry<T>& entry, std::int64_t& made, std::int64_t& refreshed,
                                double& seconds, Make&& make, Refresh&& refresh) {
  entry.used = true;
  if (entry.value && entry.is_fresh)
    return *entry.value;
  const core::Timer timer;
  if (!entry.value) {
    entry.value = make();
    ++made;
  } else {
    refresh(*entry.value);
    ++refreshed;
  }
  entry.is_fresh = true;
  seconds += timer.seconds();
  return *entry.value;
}

/// Or null.
const ChartCopies* Structures::copies() {
  if (!copies_ && find_copies_)
    copies_ = find_copies_();
  return copies_ ? &*copies_ : nullptr;
}

const VertexCells& Structures::vertex_cells() {
  vertex_cells_.used = true;
  if (!vertex_cells_.value) {
    const core::Timer timer;
    vertex_cells_.value = std::make_unique<VertexCells>(sampler_->mesh(), sampler_->seams(),
                                                        copies(), *threads_, *memory_);
    ++counts_.vertex_cells;
    seconds_.vertex_cells += timer.seconds();
  }
  return *vertex_cells_.value;
}

const VertexAverage& Structures::average(const ScalarField& cell_field) {
  const mesh::MeshView& mesh = sampler_->mesh();
  const VertexCells& around = vertex_cells();
  return up_to_date(
      averages_[key_of(cell_field)], counts_.averages, counts_.averages_refreshed,
      seconds_.averages,
      [&] {
        return std::make_unique<VertexAverage>(mesh, cell_field, around, *threads_, *memory_);
      },
      [&](VertexAverage& known) { known.refresh(mesh, cell_field, around, *threads_); });
}

std::span<double> Structures::average_values(const ScalarField& cell_field) {
  const Key key = key_of(cell_field);
  average(cell_field);
  return averages_[key].value->values();
}

const accel::ValueRanges& Structures::value_ranges(const ScalarField& vertex_field) {
  const mesh::MeshView& mesh = sampler_->mesh();
  const accel::Tree& tree = sampler_->tree();
  const int component = range_component(vertex_field);
  return up_to_date(
      value_ranges_[key_of(vertex_field)], counts_.value_ranges, counts_.value_ranges_refreshed,
      seconds_.value_ranges,
      [&] {
        return std::make_unique<accel::ValueRanges>(tree, mesh, vertex_field.field, component,
                                                    *threads_, *memory_);
      },
      [&](accel::ValueRanges& known) {
        known.refresh(tree, mesh, vertex_field.field, component, *threads_);
      });
}

ScalarRange Structures::scalar_range(const ScalarField& field) {
  Entry<ScalarRange>& entry = scalar_ranges_[key_of(field)];
  entry.used = true;
  if (!entry.value) {
    entry.value =
        std::make_unique<ScalarRange>(render::scalar_range(sampler_->mesh(), field, *threads_));
    ++counts_.scalar_ranges;
  }
  return *entry.value;
}

Structures::GridKey Structures::with(const Key& key, const MacrocellGrid* grid) {
  std::vector<double> numbers;
  if (grid)
    for (int a = 0; a < 3; ++a)
      for (const double number :
           {grid->low[a], grid->size[a], double(grid->counts[std::size_t(a)])})
        numbers.push_back(number);
  return {key, numbers};
}

const Macrocells& Structures::macrocells(const ScalarField& field, const MacrocellGrid* grid) {
  return up_to_date(
      macrocells_[with(key_of(field), grid)], counts_.macrocells, counts_.macrocells_refreshed,
      seconds_.macrocells,
      [&] {
        return grid ? std::make_unique<Macrocells>(*sampler_, field, *grid, *threads_, *memory_)
                    : std::make_unique<Macrocells>(*sampler_, field, *threads_, *memory_);
      },
      [&](Macrocells& known) { known.refresh(*sampler_, field, *threads_); });
}

const CellWidths& Structures::cell_widths(const mesh::Box& whole) {
  if (!cell_widths_ || !(cell_widths_->first.low == whole.low) ||
      !(cell_widths_->first.high == whole.high)) {
    const core::Timer timer;
    cell_widths_ = {whole, render::cell_widths(*sampler_, whole, *threads_)};
    seconds_.macrocells += timer.seconds();
  }
  return cell_widths_->second;
}

const Macrocells& Structures::macrocells_with_sizes(const ScalarField& field,
                                                    const MacrocellGrid& grid) {
  macrocells(field, &grid);
  Macrocells& cells = *macrocells_[with(key_of(field), &grid)].value;
  if (!cells.has_sizes())
    cells.measure(*sampler_, *threads_);
  return cells;
}

/// The function's own, or one that nobody has asked for in this cycle, which gives its memory.
template <class Map>
typename Map::mapped_type& Structures::entry_of(Map& map, const typename Map::key_type& key,
                                                const TransferFunction& function) {
  const auto [first, last] = map.equal_range(key);
  auto at = std::find_if(first, last, [&](const auto& of) { return of.second.is_of(function); });
  if (at == last)
    at = std::find_if(first, last, [](const auto& of) { return !of.second.used; });
  if (at == last)
    at = map.emplace(key, typename Map::mapped_type{});
  at->second.is_fresh = at->second.is_fresh && at->second.is_of(function);
  at->second.used = true;
  return at->second;
}

const Majorants& Structures::majorants(const ScalarField& field, const TransferFunction& function,
                                       const MacrocellGrid* grid) {
  const Macrocells& cells = macrocells(field, grid);
  FunctionEntry<Majorants>& entry = entry_of(majorants_, with(key_of(field), grid), function);
  if (entry.value && entry.is_fresh)
    return *entry.value;
  const core::Timer timer;
  if (!entry.value)
    entry.value = std::make_unique<Majorants>(cells, function, *threads_, *memory_);
  else
    entry.value->refresh(cells, function, *threads_);
  entry.set(function);
  ++counts_.majorants;
  seconds_.majorants += timer.seconds();
  return *entry.value;
}

const PrimitiveRanges& Structures::primitive_ranges(const ScalarField& field) {
  return up_to_date(
      primitive_ranges_[key_of(field)], counts_.primitive_ranges,
      counts_.primitive_ranges_refreshed, seconds_.primitive_ranges,
      [&] { return std::make_unique<PrimitiveRanges>(*sampler_, field, *threads_, *memory_); },
      [&](PrimitiveRanges& known) { known.refresh(*sampler_, field, *threads_); });
}

const query::CulledCells* Structures::culled(const ScalarField& field,
                                             const TransferFunction& function) {
  if (!PrimitiveRanges::serve(*sampler_, field))
    return nullptr;
  const PrimitiveRanges& ranges = primitive_ranges(field);
  FunctionEntry<query::CulledCells>& entry = entry_of(culled_, key_of(field), function);
  if (entry.value && entry.is_fresh)
    return entry.value.get();
  const core::Timer timer;
  if (!entry.value)
    entry.value = std::make_unique<query::CulledCells>(*memory_);
  ranges.cull(*sampler_, function, *threads_, *entry.value);
  entry.set(function);
  ++counts_.culled;
  seconds_.culled += timer.seconds();
  return entry.value.get();
}

const VertexGradients& Structures::gradients(const ScalarField& vertex_field) {
  (void)vertex_cells();
  return up_to_date(
      gradients_[key_of(vertex_field)], counts_.gradients, counts_.gradients_refreshed,
      seconds_.gradients,
      [&] { return std::make_unique<VertexGradients>(sampler_->mesh(), *memory_); },
      [](VertexGradients& known) { known.forget(); });
}

const TriangleMesh& Structures::boundary() {
  Entry<TriangleMesh>& entry = triangles_[std::string()];
  entry.used = true;
  const mesh::Box bounds = sampler_->facts().bounds; // which other processes may change
  if (!entry.value || !(entry.value->bounds().low == bounds.low) ||
      !(entry.value->bounds().high == bounds.high)) {
    entry.value = TriangleMesh::boundary(sampler_->mesh(), bounds, copies(), *threads_, *memory_);
    ++counts_.boundaries;
  }
  return *entry.value;
}

const TriangleMesh& Structures::body(const TriangleList& list) {
  Entry<TriangleMesh>& entry = triangles_[list.source];
  entry.used = true;
  if (!entry.value) {
    entry.value = TriangleMesh::body(list, *threads_, *memory_);
    ++counts_.bodies;
  }
  return *entry.value;
}

} // namespace insitu::render
