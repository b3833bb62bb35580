#include "commit/standins/geodetic.h"

#include <algorithm>
#include <cstdio>

#include "commit/standins/geodetic_copies.h"
#include "core/status.h"
#include "mesh/ghosts.h"
#include "mesh/piece_borders.h"

namespace insitu::commit {

using geo::Pole;

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
                              (changed & INSITU_CHANGED_TOPOLOGY) != 0, threads);
    built_ = true;
    if (has_copies())
      mesh.set_stand_in(this);
    if (found.other_cells && has_copies())
      log.info("mesh '" + mesh.name() + "': " + std::to_string(hidden_cells()) +
               " cells wrap around or hold a pole; " + std::to_string(copied_cells()) +
               " copies of cells there, " + std::to_string(bytes()) + " bytes");
  } else {
    fields_.values_changed();
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
bool Geodetic::build(const mesh::Mesh& mesh, const geo::ChartUnits& units, bool other_cells,
                     const core::Threads& threads) {
  own_ = &mesh.own_view();
  fields_.values_changed();
  const ChartSearch search(mesh.name(), *own_, units, threads);
  has_whole_ = has_whole_ && search.facts() == facts_;
  facts_ = search.facts();
  if (!has_whole_ && (other_cells || !knows_others_))
    whole_ = facts_;
  else if (!has_whole_)
    whole_.add(facts_);
  ChartFacts chart = whole_;
  chart.west = std::min(chart.west, west_);
  ChartCells found = search.find(chart);
  image_ = found.image;
  std::vector<std::unique_ptr<Copies>> copies;
  for (const bool of_halo : {false, true}) {
    for (const Pole pole : {Pole::none, Pole::north, Pole::south}) {
      std::vector<ChartCopy> cells;
      for (const ChartCopy& c : found.copies)
        if (c.pole == pole && (c.cell >= own_->own_cell_count()) == of_halo)
          cells.push_back(c);
      if (cells.empty())
        continue;
      Copies& to = *copies.emplace_back(std::make_unique<Copies>(*memory_));
      to.pole = pole;
      to.is_halo = of_halo;
      copy(*own_, cells, to);
    }
    if (!of_halo)
      own_copies_ = copies.size();
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
        (*mask)[std::size_t(c)] = piece.exists(c) ? 0 : mesh::is_duplicate(piece, c) ? 1 : 2;
    });
    for (; next != end; ++next)
      (*mask)[std::size_t(*next - own.first_cell[p])] = 2;
  }
}

void Geodetic::set_views(const mesh::MeshView& own) {
  pieces_.clear();
  const auto add = [&](std::int32_t first, std::int32_t end) {
    for (std::int32_t p = first; p < end; ++p) {
      pieces_.push_back(own.pieces[p]);
      if (const auto& mask = masks_[std::size_t(p)])
        mesh::set_ghosts(pieces_.back(), mask->data(), 3);
    }
  };
  const std::int32_t solvers = own.piece_count - own.halo_piece_count;
  add(0, solvers);
  for (std::size_t k = 0; k < own_copies_; ++k)
    pieces_.push_back(copies_[k]->view());
  add(solvers, own.piece_count);
  for (std::size_t k = own_copies_; k < copies_.size(); ++k)
    pieces_.push_back(copies_[k]->view());
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
  view_.halo_piece_count = view_.piece_count - solvers - std::int32_t(own_copies_);
  view_.one_mesh = solvers == 1;
  view_.is_flat = own.is_flat;
  view_.plane = own.plane;
}

query::Location Geodetic::own(const query::Location& at, const math::Vec3d& /*p*/) const {
  return at ? query::Location{place(at.cell).own, at.parametric} : at;
}

Geodetic::Of Geodetic::piece_of(std::int32_t piece) const {
  const std::int32_t solvers = own_->piece_count - own_->halo_piece_count;
  std::int32_t behind = piece - solvers;
  if (behind < 0)
    return {nullptr, piece};
  if (behind >= std::int32_t(own_copies_)) {
    behind -= std::int32_t(own_copies_);
    if (behind < own_->halo_piece_count)
      return {nullptr, solvers + behind};
    behind += std::int32_t(own_copies_) - own_->halo_piece_count;
  }
  return {copies_[std::size_t(behind)].get(), -1};
}

StandIn::Place Geodetic::place(std::int64_t flat) const {
  if (!has_copies() || flat < own_->own_cell_count())
    return {flat};
  const std::int32_t p = view_.piece_of(flat);
  const std::int64_t cell = flat - view_.first_cell[p];
  const Of of = piece_of(p);
  if (!of.copies)
    return {own_->first_cell[of.piece] + cell};
  const auto i = std::size_t(cell);
  const auto& cells = of.copies->cells;
  return {cells[i], 1 + std::int32_t(of.copies->pole), i > 0 && cells[i - 1] == cells[i]};
}

std::int64_t Geodetic::own_vertex(std::int64_t flat) const {
  if (!has_copies())
    return flat;
  const std::int32_t p = mesh::piece_of_vertex(view_, flat);
  const std::int64_t vertex = flat - view_.first_vertex[p];
  const Of of = piece_of(p);
  return of.copies ? of.copies->keys[std::size_t(vertex)].vertex
                   : own_->first_vertex[of.piece] + vertex;
}

std::int64_t Geodetic::find(const Place& place) const {
  const std::int32_t solvers = own_->piece_count - own_->halo_piece_count;
  const bool is_halo = place.own >= own_->own_cell_count();
  if (!has_copies())
    return place.chart == 0 ? place.own : -1;
  if (place.chart == 0)
    return is_halo ? place.own - own_->own_cell_count() +
                         view_.first_cell[std::size_t(solvers) + own_copies_]
                   : place.own;
  for (std::size_t k = 0; k < copies_.size(); ++k) {
    const Copies& copies = *copies_[k];
    if (copies.is_halo != is_halo || 1 + std::int32_t(copies.pole) != place.chart)
      continue;
    const auto cells = copies.cells.span();
    const auto at = std::ranges::lower_bound(cells, place.own) + place.copy;
    if (at >= cells.end() || *at != place.own)
      return -1;
    const std::size_t piece =
        std::size_t(solvers) + k + (is_halo ? std::size_t(own_->halo_piece_count) : 0);
    return view_.first_cell[piece] + (at - cells.begin());
  }
  return -1;
}

bool Geodetic::set_whole_chart(const ChartFacts& whole) {
  const bool others = !(whole == whole_);
  whole_ = whole;
  has_whole_ = knows_others_ = true;
  return others;
}

void Geodetic::take_chart(const StandIn& of, bool is_part) {
  const auto* const from = dynamic_cast<const Geodetic*>(&of);
  if (!from)
    return;
  facts_ = from->facts_;
  whole_ = from->whole_;
  has_whole_ = from->has_whole_ || !is_part;
  knows_others_ = from->knows_others_;
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

} // namespace insitu::commit
