#include "commit/standins/geodetic.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/status.h"
#include "mesh/ghosts.h"

namespace insitu::commit {

using geo::Pole;
using math::Vec3d;

namespace {

/// A vertex of a copy: the solver's, moved by whole turns.
struct Key {
  std::int64_t vertex; ///< flat
  int turns;
  auto operator<=>(const Key&) const = default;
};

/// The cosine and sine that take a vector's east and north to another chart's.
struct Turn {
  double c, s;
};

/// At a place whose true directions are known.
Turn turn_of(const query::ChartImage& image, Pole pole, const Vec3d& east, const Vec3d& turned) {
  const geo::ChartPlace there =
      geo::place_of(image.units, pole, {turned.x - image.offset(pole), turned.y, turned.z});
  return {dot(east, there.east), dot(east, there.north)};
}

/// The ids as a hexahedron's: turned over, a voxel has no axes.
constexpr int voxel_order[] = {0, 1, 3, 2, 4, 5, 7, 6};

} // namespace

/// The cells of one chart.
struct Geodetic::Copies {
  explicit Copies(core::Memory& memory)
      : points(memory, INSITU_MEMORY_CHART), ids(memory, INSITU_MEMORY_CHART),
        offsets(memory, INSITU_MEMORY_CHART), types(memory, INSITU_MEMORY_CHART),
        keys(memory, INSITU_MEMORY_CHART), cells(memory, INSITU_MEMORY_CHART),
        vertex_turns(memory, INSITU_MEMORY_CHART), cell_turns(memory, INSITU_MEMORY_CHART) {}

  Pole pole = Pole::none;
  core::Buffer<Vec3d> points;
  core::Buffer<std::int64_t> ids, offsets;
  core::Buffer<std::uint8_t> types;
  core::Buffer<Key> keys;                      ///< [vertex] ascending
  core::Buffer<std::int64_t> cells;            ///< [cell] the solver's, flat
  core::Buffer<Turn> vertex_turns, cell_turns; ///< of vectors; at poles

  std::int64_t bytes() const {
    return std::int64_t(points.bytes() + ids.bytes() + offsets.bytes() + types.bytes() +
                        keys.bytes() + cells.bytes() + vertex_turns.bytes() + cell_turns.bytes());
  }
  bool same_cells(const Copies& b) const {
    return pole == b.pole && std::ranges::equal(cells.span(), b.cells.span()) &&
           std::ranges::equal(keys.span(), b.keys.span()) &&
           std::ranges::equal(ids.span(), b.ids.span());
  }
  mesh::PieceView view() const {
    mesh::PieceView p;
    p.layout = mesh::CellLayout::mixed;
    p.cell_count = std::int64_t(cells.size());
    p.vertex_count = std::int64_t(points.size());
    p.connectivity = {reinterpret_cast<const std::byte*>(ids.data()), std::int64_t(ids.size()), 8,
                      false};
    p.id_stride = 8;
    p.offsets = {reinterpret_cast<const std::byte*>(offsets.data()), std::int64_t(offsets.size()),
                 8, false};
    p.types = reinterpret_cast<const std::byte*>(types.data());
    for (int a = 0; a < 3; ++a)
      p.points.component[a] = reinterpret_cast<const std::byte*>(points.data()) + 8 * a;
    p.points.layout = {p.vertex_count, {p.vertex_count, 1}, {24, 0, 0}, true};
    p.pole = std::int8_t(pole);
    return p;
  }
};

/// A field's values at the copies.
struct Geodetic::Gathered {
  std::string name;
  bool fresh = false;
  std::vector<core::Buffer<double>> values; ///< [chart][item][component]
  std::vector<std::vector<const std::byte*>> bases;
  std::vector<mesh::FieldPieceView> views; ///< [piece of view()]
};

Geodetic::Geodetic(core::Memory& memory) : memory_(&memory) {}

Geodetic::~Geodetic() = default;

void Geodetic::require(const std::string& mesh_name, const query::LocatorPick& pick,
                       bool on_device) const {
  if (on_device || pick.backend != accel::Backend::cpu)
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      "mesh '" + mesh_name +
                          "' is geodetic: it is located on the CPU, in host memory, not by " +
                          accel::name(pick.method) + " on " + accel::name(pick.backend));
}

bool Geodetic::is_due(const mesh::Mesh& /*mesh*/, std::uint32_t changed) const {
  return !built_ || (changed & (INSITU_CHANGED_TOPOLOGY | INSITU_CHANGED_GEOMETRY)) != 0;
}

StandIn::Found Geodetic::commit(mesh::Mesh& mesh, const insitu_frame& frame, std::uint32_t changed,
                                const core::Threads& threads, const core::Log& log) {
  Found found;
  if (changed & INSITU_CHANGED_TOPOLOGY) { // nothing is read through ids that were not looked at
    found.validation = cells::validate(mesh.name(), mesh.own_view(), threads);
    if (!found.validation->findings.empty())
      throw core::Error(INSITU_ERROR_MESH, found.validation->findings);
  }
  if (is_due(mesh, changed)) {
    mesh.set_changed(INSITU_CHANGED_TOPOLOGY); // until it is done
    mesh.set_stand_in(nullptr);
    built_ = false;
    found.other_cells = build(mesh,
                              {frame.angle == INSITU_RADIANS, frame.length == INSITU_KILOMETRES,
                               frame.vertical == INSITU_DOWN},
                              threads);
    built_ = true;
    if (has_copies())
      mesh.set_stand_in(this);
    if (found.other_cells && has_copies())
      log.info("mesh '" + mesh.name() + "': " + std::to_string(hidden_cells()) +
               " cells wrap around or hold a pole; " + std::to_string(copied_cells()) +
               " copies of cells there, " + std::to_string(bytes()) + " bytes");
  } else {
    fields_changed();
  }
  if (has_copies())
    found.validation.reset(); // it is of cells that are hidden, too
  return found;
}

void Geodetic::audit(std::vector<insitu_audit_entry>& entries) const {
  if (!has_copies())
    return;
  insitu_audit_entry e{};
  e.size = sizeof e;
  std::snprintf(e.name, sizeof e.name, "copies of %lld cells",
                static_cast<long long>(copied_cells()));
  std::snprintf(e.reason, sizeof e.reason,
                "located beyond the seam of longitude or on a pole's chart");
  e.bytes = bytes();
  entries.push_back(e);
}

/// True if the cells it stands in for are others than before (from none on).
bool Geodetic::build(const mesh::Mesh& mesh, const geo::ChartUnits& units,
                     const core::Threads& threads) {
  own_ = &mesh.own_view();
  fields_changed();
  ChartCells found = find_chart_cells(mesh.name(), *own_, units, threads);
  image_ = found.image;
  std::vector<std::unique_ptr<Copies>> copies;
  for (const Pole pole : {Pole::none, Pole::north, Pole::south}) {
    std::vector<ChartCopy> cells;
    for (const ChartCopy& c : found.copies)
      if (c.pole == pole)
        cells.push_back(c);
    if (!cells.empty())
      copy(*own_, cells, pole, *copies.emplace_back(std::make_unique<Copies>(*memory_)));
  }
  const auto same = [](const auto& a, const auto& b) { return a->same_cells(*b); };
  const bool others = hidden_ != found.hidden || !std::ranges::equal(copies_, copies, same);
  copies_ = std::move(copies);
  hidden_ = std::move(found.hidden);
  if (others)
    fields_.clear();
  hide(*own_, threads);
  set_views(*own_);
  return others;
}

void Geodetic::copy(const mesh::MeshView& own, const std::vector<ChartCopy>& cells, Pole pole,
                    Copies& to) const {
  const geo::ChartUnits& units = image_.units;
  to.pole = pole;
  mesh::CellVertices c;
  const auto turns_of = [&](const ChartCopy& copy, const Vec3d& x) {
    return pole == Pole::none ? turns_to(units, copy.first, x.x) + copy.turns : 0;
  };
  for (const ChartCopy& cell : cells) {
    mesh::gather(own, cell.cell, c);
    for (int v = 0; v < c.count; ++v)
      to.keys.push_back({own.first_vertex[c.piece] + c.ids[v], turns_of(cell, c.x[v])});
  }
  std::ranges::sort(to.keys);
  to.keys.resize(std::size_t(std::ranges::unique(to.keys).begin() - to.keys.begin()));

  for (const Key& key : to.keys) {
    const std::int32_t p = std::int32_t(
        std::upper_bound(own.first_vertex, own.first_vertex + own.piece_count, key.vertex) -
        own.first_vertex - 1);
    const Vec3d x = own.pieces[p].point(key.vertex - own.first_vertex[p]);
    if (pole == Pole::none) {
      to.points.push_back({x.x + key.turns * units.turn(), x.y, x.z});
      continue;
    }
    to.points.push_back(image_.turned(pole, x));
    // The direction east of the vertex' own longitude, at the pole too.
    to.vertex_turns.push_back(turn_of(image_, pole, geo::place_of(units, Pole::none, x).east,
                                      to.points[to.points.size() - 1]));
  }

  to.offsets.push_back(0);
  for (const ChartCopy& cell : cells) {
    mesh::gather(own, cell.cell, c);
    const bool voxel = c.shape == mesh::Shape::voxel;
    Vec3d middle{};
    for (int i = 0; i < c.count; ++i) {
      const int v = voxel ? voxel_order[i] : i;
      const Key key{own.first_vertex[c.piece] + c.ids[v], turns_of(cell, c.x[v])};
      const Key* const at = std::lower_bound(to.keys.begin(), to.keys.end(), key);
      to.ids.push_back(at - to.keys.begin());
      middle += geo::normal_of(units, c.x[v]);
    }
    to.offsets.push_back(std::int64_t(to.ids.size()));
    to.types.push_back(std::uint8_t(voxel ? mesh::Shape::hexahedron : c.shape));
    to.cells.push_back(cell.cell);
    if (pole != Pole::none)
      to.cell_turns.push_back(turn_of(image_, pole, geo::east_north(middle).east, [&] {
        Vec3d q = geo::chart_point(units, pole, middle, 0.0);
        q.x += image_.offset(pole);
        return q;
      }()));
  }
}

void Geodetic::hide(const mesh::MeshView& own, const core::Threads& threads) {
  masks_.resize(std::size_t(own.piece_count));
  auto next = hidden_.begin();
  for (std::int32_t p = 0; p < own.piece_count; ++p) {
    const auto end = std::lower_bound(next, hidden_.end(), own.first_cell[p + 1]);
    auto& mask = masks_[std::size_t(p)];
    if (next == end) {
      mask.reset();
      continue;
    }
    if (!mask)
      mask = std::make_unique<core::Buffer<std::uint8_t>>(*memory_, INSITU_MEMORY_CHART);
    const mesh::PieceView& piece = own.pieces[p];
    mask->resize_discard(std::size_t(piece.cell_count));
    threads.parallel_for(piece.cell_count, 1 << 16, [&](std::int64_t begin, std::int64_t stop) {
      for (std::int64_t c = begin; c < stop; ++c)
        (*mask)[std::size_t(c)] = piece.owns(c) ? 0 : mesh::is_duplicate(piece, c) ? 1 : 2;
    });
    for (; next != end; ++next)
      (*mask)[std::size_t(*next - own.first_cell[p])] = 2;
  }
}

void Geodetic::set_views(const mesh::MeshView& own) {
  pieces_.assign(own.pieces, own.pieces + own.piece_count);
  for (std::int32_t p = 0; p < own.piece_count; ++p)
    if (const auto& mask = masks_[std::size_t(p)])
      mesh::set_ghosts(pieces_[std::size_t(p)], mask->data(), 3);
  for (const auto& c : copies_)
    pieces_.push_back(c->view());
  first_cell_.assign(1, 0);
  first_vertex_.assign(1, 0);
  for (const mesh::PieceView& p : pieces_) {
    first_cell_.push_back(first_cell_.back() + p.cell_count);
    first_vertex_.push_back(first_vertex_.back() + p.vertex_count);
  }
  view_ = {};
  view_.pieces = pieces_.data();
  view_.first_cell = first_cell_.data();
  view_.first_vertex = first_vertex_.data();
  view_.piece_count = std::int32_t(pieces_.size());
  view_.one_mesh = own.piece_count == 1;
}

query::Location Geodetic::own(const query::Location& at, const math::Vec3d& /*p*/) const {
  return at ? query::Location{own_cell(at.cell), at.parametric} : at;
}

std::int64_t Geodetic::own_cell(std::int64_t flat) const {
  if (!own_ || flat < own_->cell_count())
    return flat;
  const std::int32_t p = view_.piece_of(flat);
  return copies_[std::size_t(p - own_->piece_count)]
      ->cells[std::size_t(flat - view_.first_cell[p])];
}

std::int64_t Geodetic::copied_cells() const {
  std::int64_t sum = 0;
  for (const auto& c : copies_)
    sum += std::int64_t(c->cells.size());
  return sum;
}

std::int64_t Geodetic::bytes() const {
  std::int64_t sum = 0;
  for (const auto& c : copies_)
    sum += c->bytes();
  for (const auto& mask : masks_)
    sum += mask ? std::int64_t(mask->bytes()) : 0;
  for (const auto& f : fields_)
    for (const auto& v : f->values)
      sum += std::int64_t(v.bytes());
  return sum;
}

void Geodetic::fields_changed() {
  for (const auto& f : fields_)
    f->fresh = false;
}

mesh::FieldView Geodetic::field(const mesh::FieldView& own) {
  const std::lock_guard lock(mutex_);
  const auto known =
      std::ranges::find_if(fields_, [&](const auto& f) { return f->name == own.name; });
  Gathered& g =
      known != fields_.end() ? **known : *fields_.emplace_back(std::make_unique<Gathered>());
  if (!g.fresh) {
    g.name = own.name;
    gather(own, g);
    g.fresh = true;
  }
  return {g.name.c_str(), own.association, own.components, g.views.data(), own.has_blanks};
}

void Geodetic::gather(const mesh::FieldView& own, Gathered& to) const {
  const int n = own.components;
  const bool of_cells = own.association == INSITU_CELL;
  to.views.assign(own.pieces, own.pieces + own_->piece_count);
  while (to.values.size() < copies_.size())
    to.values.emplace_back(*memory_, INSITU_MEMORY_CHART);
  to.bases.assign(copies_.size(), {});
  const std::int64_t* const first = of_cells ? own_->first_cell : own_->first_vertex;
  for (std::size_t k = 0; k < copies_.size(); ++k) {
    const Copies& from = *copies_[k];
    const std::size_t count = of_cells ? from.cells.size() : from.keys.size();
    core::Buffer<double>& values = to.values[k];
    values.resize_discard(count * std::size_t(n));
    for (std::size_t i = 0; i < count; ++i) {
      const std::int64_t flat = of_cells ? from.cells[i] : from.keys[i].vertex;
      const auto p = std::upper_bound(first, first + own_->piece_count, flat) - first - 1;
      double* const at = values.data() + i * std::size_t(n);
      for (int c = 0; c < n; ++c)
        at[c] = own.pieces[p].load(flat - first[p], c);
      if (n != 3 || from.pole == Pole::none)
        continue;
      const Turn turn = of_cells ? from.cell_turns[i] : from.vertex_turns[i];
      const double east = at[0], north = at[1];
      at[0] = turn.c * east - turn.s * north;
      at[1] = turn.s * east + turn.c * north;
    }
    for (int c = 0; c < n; ++c)
      to.bases[k].push_back(reinterpret_cast<const std::byte*>(values.data() + c));
    const auto items = std::int64_t(count);
    const std::int64_t stride = 8 * n;
    to.views.push_back({to.bases[k].data(), {items, {items, 1}, {stride, 0, 0}, true}, false});
  }
}

} // namespace insitu::commit
