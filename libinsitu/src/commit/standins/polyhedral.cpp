#include "commit/standins/polyhedral.h"

#include <algorithm>
#include <cstdio>
#include <limits>

#include "cells/checks/folds.h"
#include "core/status.h"
#include "mesh/ghosts.h"

namespace insitu::commit {

struct Polyhedral::Piece {
  explicit Piece(core::Memory& memory)
      : parts(memory), made(memory), ghosts(memory, INSITU_MEMORY_POLYHEDRA) {}

  cells::Parts parts;
  cells::MadePoints made;
  core::Buffer<std::uint8_t> ghosts; ///< [part], if the solver gave any
  mesh::PartsView view;
};

/// A field on the parts.
struct Polyhedral::Gathered {
  struct Values {
    explicit Values(core::Memory& memory) : bytes(memory, INSITU_MEMORY_POLYHEDRA) {}
    core::Buffer<std::byte> bytes;
    std::vector<const std::byte*> bases; ///< [component]
  };
  std::string name;
  bool fresh = false;
  std::vector<Values> values; ///< [piece]
  std::vector<mesh::FieldPieceView> views;
};

Polyhedral::Polyhedral(core::Memory& memory) : memory_(&memory) {}

Polyhedral::~Polyhedral() = default;

void Polyhedral::require(const std::string& mesh_name, const query::LocatorPick& pick,
                         bool on_device) const {
  if (on_device || pick.backend != accel::Backend::cpu)
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      "mesh '" + mesh_name +
                          "' has cells given by faces: it is located on the CPU, in host memory, "
                          "not by " +
                          accel::name(pick.method) + " on " + accel::name(pick.backend));
}

bool Polyhedral::is_due(const mesh::Mesh& /*mesh*/, std::uint32_t changed) const {
  return !built_ || (changed & INSITU_CHANGED_TOPOLOGY) != 0;
}

StandIn::Found Polyhedral::commit(mesh::Mesh& mesh, const insitu_frame& /*frame*/,
                                  std::uint32_t changed, const core::Threads& threads,
                                  const core::Log& log) {
  Found found;
  own_ = &mesh.own_view();
  threads_ = &threads;
  found.other_cells = is_due(mesh, changed);
  if (found.other_cells || (changed & INSITU_CHANGED_GEOMETRY)) {
    mesh.set_changed(INSITU_CHANGED_TOPOLOGY); // until it is done
    mesh.set_stand_in(nullptr);
    built_ = false;
    if (found.other_cells) {
      fields_.clear();
      for (std::int32_t p = 0; p < own_->piece_count - own_->halo_piece_count; ++p)
        mesh.set_parts(p, nullptr);
      const cells::FaceFindings findings = cut(mesh, threads);
      if (findings.count() > 0)
        throw core::Error(INSITU_ERROR_MESH, findings.text());
    }
    place_vertices(threads);
    built_ = true;
  }
  fields_.values_changed();
  set_views(); // the solver's pieces may lie elsewhere
  for (std::size_t p = 0; p < parts_.size(); ++p)
    if (parts_[p])
      mesh.set_parts(std::int32_t(p), &parts_[p]->view);
  mesh.set_stand_in(this);
  if (!found.other_cells)
    return found;
  found.validation = validated(mesh.name(), threads);
  log.info("mesh '" + mesh.name() + "': " + std::to_string(own_->own_cell_count()) +
           " cells, some of them given by faces, are located as " +
           std::to_string(view_.cell_count()) + ", " + std::to_string(bytes()) + " bytes");
  return found;
}

cells::FaceFindings Polyhedral::cut(const mesh::Mesh& mesh, const core::Threads& threads) {
  const mesh::MeshView& own = mesh.own_view();
  cells::FaceFindings findings;
  parts_.clear();
  parts_.resize(std::size_t(own.piece_count));
  for (std::int32_t p = 0; p < own.piece_count - own.halo_piece_count; ++p) {
    const mesh::FacesView* const faces = mesh.faces(p);
    if (!faces)
      continue;
    auto piece = std::make_unique<Piece>(*memory_);
    piece->parts.cut(*faces, own.pieces[p],
                     "mesh '" + mesh.name() + "', piece " + std::to_string(p), threads, findings);
    piece->view.first = piece->parts.first();
    parts_[std::size_t(p)] = std::move(piece);
  }
  if (findings.count() > 0)
    parts_.clear();
  return findings;
}

void Polyhedral::place_vertices(const core::Threads& threads) {
  for (std::size_t p = 0; p < parts_.size(); ++p)
    if (parts_[p])
      parts_[p]->made.place(own_->pieces[p], parts_[p]->parts, threads);
}

void Polyhedral::set_views() {
  const mesh::MeshView& own = *own_;
  pieces_.assign(own.pieces, own.pieces + own.piece_count);
  first_cell_.assign(1, 0);
  first_vertex_.assign(1, 0);
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    if (Piece* const piece = parts_[p].get()) {
      mesh::PieceView& v = pieces_[p];
      v = piece->parts.view(own.pieces[p]);
      piece->made.put_in(v);
      if (own.pieces[p].ghosts) {
        piece->ghosts.resize_discard(std::size_t(v.cell_count));
        for (std::int64_t part = 0; part < v.cell_count; ++part) {
          const std::int64_t cell = piece->parts.cell_of(part);
          piece->ghosts[std::size_t(part)] = own.pieces[p].exists(cell)                ? 0
                                             : mesh::is_duplicate(own.pieces[p], cell) ? 1
                                                                                       : 2;
        }
        mesh::set_ghosts(v, piece->ghosts.data(), 3);
      }
      piece->view.piece = &v;
    }
    first_cell_.push_back(first_cell_.back() + pieces_[p].cell_count);
    first_vertex_.push_back(first_vertex_.back() + pieces_[p].vertex_count);
  }
  if (first_cell_.back() > mesh::most_cells)
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      std::to_string(own.cell_count()) + " cells are located as " +
                          std::to_string(first_cell_.back()) +
                          ", those given by faces in parts; a mesh holds at most " +
                          std::to_string(mesh::most_cells));
  const mesh::MeshView before = view_;
  view_ = own;
  view_.pieces = pieces_.data();
  view_.first_cell = first_cell_.data();
  view_.first_vertex = first_vertex_.data();
  // What commits have found out since the vertices moved last.
  view_.one_mesh = before.one_mesh;
  view_.free_of_folds = before.free_of_folds;
  view_.covers_once = before.covers_once;
  view_.earlier_points = nullptr;
  view_.largest_displacement = 0.0;
}

mesh::FieldView Polyhedral::field(const mesh::FieldView& own) {
  const Gathered& g = fields_.find(
      own, [] { return std::make_unique<Gathered>(); }, [&](Gathered& to) { gather(own, to); });
  return {g.name.c_str(), own.association, own.components, g.views.data(), own.has_blanks};
}

void Polyhedral::gather(const mesh::FieldView& own, Gathered& to) const {
  to.views.assign(own.pieces, own.pieces + own_->piece_count);
  while (to.values.size() < parts_.size())
    to.values.emplace_back(*memory_);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    if (!parts_[p])
      continue;
    const cells::Parts& parts = parts_[p]->parts;
    if (own.association == INSITU_VERTEX ? parts.made_count() > 0 : !parts.are_the_cells())
      gather_piece(own, std::int32_t(p), to);
  }
}

void Polyhedral::gather_piece(const mesh::FieldView& own, std::int32_t p, Gathered& to) const {
  const Piece& piece = *parts_[std::size_t(p)];
  const mesh::FieldPieceView& from = own.pieces[p];
  const mesh::PieceView& view = pieces_[std::size_t(p)];
  const int n = own.components;
  const bool of_cells = own.association == INSITU_CELL;
  const std::int64_t count = of_cells ? view.cell_count : view.vertex_count;
  const std::int64_t size = from.is_float32 ? 4 : 8;
  Gathered::Values& values = to.values[std::size_t(p)];
  values.bytes.resize_discard(std::size_t(count * n * size));
  const auto fill = [&](auto* items) {
    if (!of_cells)
      return piece.made.extend(from, n, piece.parts, *threads_, items);
    threads_->parallel_for(count, 1 << 14, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t part = begin; part < end; ++part)
        for (int c = 0; c < n; ++c)
          items[part * n + c] =
              std::remove_reference_t<decltype(*items)>(from.load(piece.parts.cell_of(part), c));
    });
  };
  if (from.is_float32)
    fill(reinterpret_cast<float*>(values.bytes.data()));
  else
    fill(reinterpret_cast<double*>(values.bytes.data()));
  values.bases.clear();
  for (int c = 0; c < n; ++c)
    values.bases.push_back(values.bytes.data() + c * size);
  to.views[std::size_t(p)] = {
      values.bases.data(), {count, {count, 1}, {n * size, 0, 0}, true}, from.is_float32, nullptr};
}

StandIn::Place Polyhedral::place(std::int64_t flat) const {
  const std::int32_t p = view_.piece_of(flat);
  const std::int64_t part = flat - view_.first_cell[p];
  const auto& piece = parts_[std::size_t(p)];
  if (!piece)
    return {own_->first_cell[p] + part};
  const std::int64_t cell = piece->parts.cell_of(part);
  return {own_->first_cell[p] + cell, 0,
          std::int32_t(part - piece->parts.first()[std::size_t(cell)])};
}

std::int64_t Polyhedral::find(const Place& place) const {
  const std::int32_t p = own_->piece_of(place.own);
  const std::int64_t cell = place.own - own_->first_cell[p];
  const auto& piece = parts_[std::size_t(p)];
  if (!piece)
    return view_.first_cell[p] + cell;
  const std::uint32_t* const first = piece->parts.first();
  return first[cell] + place.copy < first[cell + 1] ? view_.first_cell[p] + first[cell] + place.copy
                                                    : -1;
}

query::Location Polyhedral::own(const query::Location& at, const math::Vec3d& /*p*/) const {
  if (!at || at.cell >= view_.cell_count()) // of other cells
    return {};
  const std::int32_t p = view_.piece_of(at.cell);
  const auto& piece = parts_[std::size_t(p)];
  query::Location own{place(at.cell).own, at.parametric};
  if (!piece)
    return own;
  const std::int64_t cell = own.cell - own_->first_cell[p];
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  if (piece->parts.first()[cell + 1] - piece->parts.first()[cell] > 1)
    own.parametric = {nan, nan, nan};
  return own;
}

/// Counts the solver's cells, for those of which a part is odd.
void Polyhedral::count_odd_cells(insitu_validation& counts) const {
  counts.inverted_cells = counts.zero_volume_cells = counts.folded_cells = counts.collapsed_cells =
      0;
  cells::CellBlock block;
  mesh::CellVertices x;
  std::int64_t last[2] = {-1, -1}; // the cells that were counted as folded, and as collapsed
  for (std::int64_t flat = 0; flat < view_.cell_count(); ++flat) {
    const std::int32_t p = view_.piece_of(flat);
    if (!view_.pieces[p].exists(flat - view_.first_cell[p]))
      continue;
    mesh::gather(view_, flat, x);
    block.count = 1;
    block.set(x.count, 0, x.x);
    const cells::CellKinds kinds = cells::kinds_of(x.shape, block);
    const std::int64_t cell = place(flat).own;
    const bool has_shape = !parts_[std::size_t(p)];
    counts.inverted_cells += has_shape && kinds.inverted;
    counts.zero_volume_cells += has_shape && kinds.flat;
    const bool folded = kinds.folded || (!has_shape && kinds.inverted);
    if (folded && std::exchange(last[0], cell) != cell)
      ++counts.folded_cells;
    if (kinds.collapsed && std::exchange(last[1], cell) != cell)
      ++counts.collapsed_cells;
  }
}

/// The parts, looked at; the warning tells of the solver's cells.
cells::Validation Polyhedral::validated(const std::string& mesh_name,
                                        const core::Threads& threads) const {
  cells::Validation found = cells::validate(mesh_name, view_, threads);
  if (!found.findings.empty() || found.warning.empty())
    return found;
  insitu_validation counts = found.counts;
  count_odd_cells(counts);
  found.warning.clear();
  if (counts.inverted_cells + counts.zero_volume_cells + counts.folded_cells +
          counts.collapsed_cells ==
      0)
    return found;
  found.warning = "mesh '" + mesh_name + "': of " + std::to_string(own_->own_cell_count()) +
                  " cells " + std::to_string(counts.inverted_cells) + " are inverted, " +
                  std::to_string(counts.zero_volume_cells) + " have no volume, " +
                  std::to_string(counts.folded_cells) +
                  " are folded, or given by faces that no point found in them sees all, " +
                  std::to_string(counts.collapsed_cells) + " have coincident vertices";
  std::string names;
  int named = 0;
  for (std::size_t p = 0; p < parts_.size(); ++p)
    for (std::size_t i = 0; parts_[p] && i < parts_[p]->made.without_centre().size(); ++i)
      if (named++ < 4)
        names += (names.empty() ? "; the first of these: cell " : ", cell ") +
                 std::to_string(parts_[p]->made.without_centre()[i]) + " of piece " +
                 std::to_string(p);
  found.warning += names;
  return found;
}

std::optional<cells::Validation> Polyhedral::validate(const mesh::Mesh& mesh,
                                                      const core::Threads& threads) const {
  Polyhedral tried(*memory_);
  tried.own_ = &mesh.own_view();
  cells::Validation found;
  found.counts = insitu_validation_default();
  const cells::FaceFindings findings = tried.cut(mesh, threads);
  if (findings.count() == 0) {
    tried.place_vertices(threads);
    tried.set_views();
    found = tried.validated(mesh.name(), threads);
    if (!found.warning.empty())
      tried.count_odd_cells(found.counts);
  }
  insitu_validation& counts = found.counts;
  counts.index_errors += findings.index_errors;
  counts.shape_errors += findings.shape_errors;
  counts.coordinate_errors += findings.coordinate_errors;
  if (findings.count() > 0)
    found.findings = findings.text();
  counts.cells = mesh.own_view().cell_count();
  counts.ghost_cells = 0;
  for (std::int32_t p = 0; p < mesh.own_view().piece_count; ++p) {
    const mesh::PieceView& piece = mesh.own_view().pieces[p];
    for (std::int64_t c = 0; piece.may_not_exist() && c < piece.cell_count; ++c)
      counts.ghost_cells += !piece.exists(c);
  }
  return found;
}

void Polyhedral::audit(std::vector<insitu_audit_entry>& entries) const {
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    if (!parts_[p])
      continue;
    const cells::Parts& parts = parts_[p]->parts;
    insitu_audit_entry e{};
    e.size = sizeof e;
    std::snprintf(e.name, sizeof e.name, "piece %d cells cut from faces", int(p));
    std::snprintf(e.reason, sizeof e.reason, "%lld cells, %lld of them made vertices",
                  static_cast<long long>(parts.part_count()),
                  static_cast<long long>(parts.made_count()));
    e.bytes = parts.bytes() + parts_[p]->made.bytes() + std::int64_t(parts_[p]->ghosts.bytes());
    entries.push_back(e);
  }
}

std::int64_t Polyhedral::bytes() const {
  std::int64_t sum = 0;
  for (const auto& p : parts_)
    if (p)
      sum += p->parts.bytes() + p->made.bytes() + std::int64_t(p->ghosts.bytes());
  for (const auto& f : fields_)
    for (const auto& v : f->values)
      sum += std::int64_t(v.bytes.bytes());
  return sum;
}

} // namespace insitu::commit
