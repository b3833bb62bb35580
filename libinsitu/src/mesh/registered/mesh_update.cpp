#include <algorithm>
#include <cstring>

#include "core/status.h"
#include "mesh/registered/mesh.h"

namespace insitu::mesh {

using core::Error;

namespace {

/// The components of a field on a piece without cells, whose values nobody reads: as many as a
/// field may have.
const std::byte* const no_values[1 << 16] = {};

} // namespace

void Mesh::check_piece(std::size_t index) const {
  const Piece& p = pieces_[index];
  const std::string name = "mesh '" + name_ + "', piece " + std::to_string(index);
  if (!p.has_cells)
    throw Error(INSITU_ERROR_ORDER,
                name + ": has no cells; call insitu_mesh_cells or _block first");
  if (p.view.cell_count == 0) // adds nothing, whatever else was given
    return;
  if (!p.view.implicit_points && !p.has_points)
    throw Error(INSITU_ERROR_ORDER, name + ": has no points; call insitu_mesh_points first");
  const std::int64_t points = p.view.points.layout.count;
  if (p.is_block && !p.view.implicit_points && points != p.view.vertex_count)
    throw Error(INSITU_ERROR_MESH, name + ": the block has " + std::to_string(p.view.vertex_count) +
                                       " vertices, but " + std::to_string(points) +
                                       " points are given");
  if (p.hidden_points.given() && p.hidden_points.layout.count < vertices_of(p))
    throw Error(INSITU_ERROR_MESH, name + ": " + std::to_string(p.hidden_points.layout.count) +
                                       " bytes of hidden points for " +
                                       std::to_string(vertices_of(p)) + " vertices");
  if (p.view.ghosts && p.view.ghost_layout.count < p.view.cell_count)
    throw Error(INSITU_ERROR_MESH, name + ": " + std::to_string(p.view.ghost_layout.count) +
                                       " ghost values for " + std::to_string(p.view.cell_count) +
                                       " cells");
}

void Mesh::check_field(const Field& field) const {
  const std::string name = "mesh '" + name_ + "', field '" + field.name + "'";
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    if (first_cell_[p + 1] == first_cell_[p]) // adds nothing, with values or without
      continue;
    if (p >= field.pieces.size() || field.pieces[p].components.empty())
      throw Error(INSITU_ERROR_FIELD, name + ": piece " + std::to_string(p) + " has no values");
    const bool cells = field.association == INSITU_CELL;
    if (amr_ && !cells)
      throw Error(INSITU_ERROR_FIELD, name + ": on vertices; an adaptive mesh has values of cells "
                                             "(INSITU_CELL)");
    const std::int64_t expected = amr_    ? amr_pieces_[p].cell_count
                                  : cells ? pieces_[p].view.cell_count
                                          : piece_views_[p].vertex_count;
    if (field.pieces[p].layout.count != expected)
      throw Error(INSITU_ERROR_FIELD,
                  name + ", piece " + std::to_string(p) + ": " +
                      std::to_string(field.pieces[p].layout.count) + " values for " +
                      std::to_string(expected) + (cells ? " cells" : " vertices") +
                      (amr_ ? amr_pieces_[p].is_patch ? " of the patch; insitu_mesh_patch says "
                                                        "where it lies after a regrid"
                                                      : " of the leaves; insitu_mesh_leaves says "
                                                        "which they are after a regrid"
                            : ""));
  }
}

bool Mesh::lies_on_device() const {
  bool on_device = false;
  visit_arrays([&](const ExternalArray& array, const std::string&, ArrayKind) {
    on_device = on_device || array.memory == INSITU_DEVICE;
  });
  return on_device;
}

void Mesh::update(const core::Threads* threads) {
  if (amr_) {
    update_adaptive(threads);
    return;
  }
  for (std::size_t p = 0; p < pieces_.size(); ++p)
    check_piece(p);
  piece_views_.clear();
  first_cell_.assign(1, 0);
  first_vertex_.assign(1, 0);
  for (const Piece& p : pieces_) {
    // Before anything is done to each of them, and before sums could overflow.
    if (p.view.cell_count > most_cells - first_cell_.back())
      throw Error(INSITU_ERROR_UNSUPPORTED,
                  "mesh '" + name_ + "', piece " + std::to_string(piece_views_.size()) + ": " +
                      std::to_string(p.view.cell_count) + " cells after the " +
                      std::to_string(first_cell_.back()) +
                      " of the pieces before; a mesh holds at "
                      "most " +
                      std::to_string(most_cells));
    piece_views_.push_back(p.view.cell_count > 0 ? p.view : PieceView{});
    if (p.view.cell_count > 0)
      piece_views_.back().vertex_count = vertices_of(p);
    first_cell_.push_back(first_cell_.back() + p.view.cell_count);
    first_vertex_.push_back(first_vertex_.back() + piece_views_.back().vertex_count);
  }
  update_fields(threads);
  set_views();
}

void Mesh::set_views() {
  view_.pieces = piece_views_.data();
  view_.first_cell = first_cell_.data();
  view_.first_vertex = first_vertex_.data();
  view_.piece_count = std::int32_t(pieces_.size());
  view_.join_pieces = !separate_pieces_;
  hide_earlier(); // of cells that may be others by now, until they are shown again
}

void Mesh::hide_earlier() {
  for (MeshView* const view : {&view_, &shown()}) {
    view->earlier_points = nullptr;
    view->largest_displacement = 0.0;
  }
}

void Mesh::update_fields(const core::Threads* threads) {
  for (const auto& field : fields_) {
    check_field(*field);
    check_pointers(*field, threads);
    field->pieces.resize(pieces_.size());
    field->views.clear();
    for (std::size_t i = 0; i < pieces_.size(); ++i)
      if (first_cell_[i + 1] == first_cell_[i])
        field->views.push_back({no_values, {}, false, nullptr});
      else
        add_view(*field, i, threads);
  }
}

namespace {
constexpr std::int64_t copy_grain = 1 << 14;
}

/// The copies of a field; those of other numbers than it has now are dropped.
EarlierField& Mesh::earlier_field_for(const std::string& name, insitu_association association,
                                      int components) {
  const MeshView& now = view();
  const std::int64_t* first = association == INSITU_CELL ? now.first_cell : now.first_vertex;
  const auto values = std::size_t(first[now.piece_count] * components);
  const auto known = std::find_if(earlier_fields_.begin(), earlier_fields_.end(),
                                  [&](const auto& e) { return e->name == name; });
  EarlierField& to = known != earlier_fields_.end()
                         ? **known
                         : *earlier_fields_.emplace_back(std::make_unique<EarlierField>());
  if (to.association != association || to.components != components ||
      (!to.steps.empty() && to.steps[0]->values.size() != values))
    to.steps.clear();
  to.name = name;
  to.association = association;
  to.components = components;
  return to;
}

void EarlierField::begin_step(int count, const MeshView& mesh, core::Memory& memory) {
  const auto pieces = std::size_t(mesh.piece_count);
  const std::int64_t* first = association == INSITU_CELL ? mesh.first_cell : mesh.first_vertex;
  const int n = components;
  if (steps.size() > std::size_t(count))
    steps.resize(std::size_t(count));
  if (steps.size() < std::size_t(count))
    steps.push_back(std::make_unique<Step>(memory));
  std::rotate(steps.begin(), steps.end() - 1, steps.end()); // the oldest one's room is taken
  Step& to = *steps.front();
  to.values.resize_discard(std::size_t(first[pieces] * n));
  to.bases.assign(std::size_t(n) * pieces, nullptr);
  to.views.clear();
  for (std::size_t p = 0; p < pieces; ++p) {
    const double* values = to.values.data() + first[p] * n;
    const std::byte** bases = to.bases.data() + p * std::size_t(n);
    for (int c = 0; c < n; ++c)
      bases[c] = reinterpret_cast<const std::byte*>(values + c);
    const std::int64_t items = first[p + 1] - first[p];
    const std::int64_t stride = n * std::int64_t(sizeof(double));
    to.views.push_back({bases, {items, {items, 1}, {stride, items * stride, items * stride}}});
  }
}

void Mesh::keep_earlier(const std::vector<KeptField>& fields, const core::Threads& threads) {
  const MeshView& now = view();
  const auto pieces = std::size_t(now.piece_count);
  std::erase_if(earlier_fields_, [&](const auto& e) {
    return std::none_of(fields.begin(), fields.end(),
                        [&](const KeptField& f) { return f.name == e->name; });
  });
  for (const KeptField& kept : fields) {
    const FieldView from = field(kept.name);
    EarlierField& to = earlier_field_for(kept.name, from.association, from.components);
    to.begin_step(kept.steps, now, *memory_);
    const std::int64_t* first = from.association == INSITU_CELL ? now.first_cell : now.first_vertex;
    const int n = from.components;
    for (std::size_t p = 0; p < pieces; ++p) {
      double* values = to.steps[0]->values.data() + first[p] * n;
      const std::int64_t count = first[p + 1] - first[p];
      threads.parallel_for(count, copy_grain, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t i = begin; i < end; ++i)
          for (int c = 0; c < n; ++c)
            values[i * n + c] = from.pieces[p].load(i, c);
      });
    }
  }
  if (stand_in_ && !stand_in_->solver_view()) // its vertices stay where they are
    return;
  earlier_points_.resize_discard(std::size_t(now.vertex_count()));
  for (std::size_t p = 0; p < pieces; ++p)
    threads.parallel_for(
        now.pieces[p].vertex_count, copy_grain, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t i = begin; i < end; ++i)
            earlier_points_[std::size_t(now.first_vertex[p] + i)] = now.pieces[p].point(i);
        });
}

void Mesh::expose_earlier(bool expose, const core::Threads& threads) {
  hide_earlier();
  if (stand_in_ && !stand_in_->solver_view())
    return;
  MeshView& current = shown();
  if (!expose || earlier_points_.size() != std::size_t(current.vertex_count()))
    return;
  double largest = 0.0;
  for (std::int32_t p = 0; p < current.piece_count; ++p) {
    const std::int64_t count = current.pieces[p].vertex_count;
    std::vector<double> most(std::size_t((count + copy_grain - 1) / copy_grain), 0.0);
    threads.parallel_for(count, copy_grain, [&](std::int64_t begin, std::int64_t end) {
      double m = 0.0;
      for (std::int64_t i = begin; i < end; ++i) {
        const math::Vec3d now = current.pieces[p].point(i);
        const math::Vec3d& then = earlier_points_[std::size_t(current.first_vertex[p] + i)];
        for (int a = 0; a < 3; ++a) {
          const double d = now[a] < then[a] ? then[a] - now[a] : now[a] - then[a];
          m = d > m ? d : m;
        }
      }
      most[std::size_t(begin / copy_grain)] = m;
    });
    for (const double m : most)
      largest = m > largest ? m : largest;
  }
  if (largest == 0.0)
    return; // nothing moved: the current coordinates are the earlier ones
  current.earlier_points = earlier_points_.data();
  current.largest_displacement = largest;
}

void Mesh::release_earlier() {
  earlier_points_.release();
  earlier_fields_.clear();
  hide_earlier();
}

TakenStep Mesh::take_earlier() {
  TakenStep taken{std::move(earlier_points_), std::move(earlier_fields_)};
  for (const auto& field : taken.fields)
    field->steps.resize(1);
  release_earlier();
  return taken;
}

std::optional<FieldView> Mesh::earlier_field(const std::string& name) const {
  const std::vector<FieldView> all = earlier_fields(name);
  return all.empty() ? std::nullopt : std::optional(all.front());
}

std::vector<FieldView> Mesh::earlier_fields(const std::string& name) const {
  std::vector<FieldView> views;
  for (const auto& e : earlier_fields_)
    if (e->name == name)
      for (std::size_t step = 0; step < e->steps.size(); ++step)
        views.push_back(e->view(step));
  return views;
}

namespace {

std::string piece_name(std::size_t p) {
  return "piece " + std::to_string(p) + " ";
}

/// Arrays of one thing: one, or one a component.
void visit_components(const std::vector<ExternalArray>& arrays, const std::string& name,
                      Mesh::ArrayKind kind, Mesh::ArrayVisitor visit) {
  for (std::size_t i = 0; i < arrays.size(); ++i)
    visit(arrays[i], arrays.size() == 1 ? name : name + " component " + std::to_string(i), kind);
}

} // namespace

void Mesh::visit_field_piece(const Field& field, std::size_t p, ArrayVisitor visit) {
  if (p < field.pieces.size())
    visit_components(field.pieces[p].arrays, piece_name(p) + "field '" + field.name + "'",
                     ArrayKind::field, visit);
}

void Mesh::visit_field_arrays(const std::string& name, ArrayVisitor visit) const {
  if (const Field* field = find(name))
    for (std::size_t p = 0; p < pieces_.size(); ++p)
      visit_field_piece(*field, p, visit);
}

void Mesh::visit_piece_fields(std::int32_t piece, ArrayVisitor visit) const {
  for (const auto& field : fields_)
    visit_field_piece(*field, std::size_t(piece), visit);
}

void Mesh::visit_arrays(ArrayVisitor visit) const {
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const std::string piece = piece_name(p);
    const Piece& from = pieces_[p];
    if (from.has_cells && from.view.cell_count == 0) // nobody reads them
      continue;
    visit_components(from.points, piece + "points", ArrayKind::geometry, visit);
    const std::pair<const ExternalArray*, const char*> cells[] = {
        {&from.connectivity, "connectivity"},
        {&from.types, "types"},
        {&from.offsets, "offsets"},
        {&from.ghosts, "ghosts"},
        {&from.hidden_points, "hidden points"},
        {&from.amr.levels, "levels"},
        {&from.amr.corners, "corners"}};
    for (const auto& [array, name] : cells)
      if (array->given())
        visit(*array, piece + name, ArrayKind::topology);
    for (int a = 0; a < 3; ++a)
      if (from.axes[a].given())
        visit(from.axes[a], piece + "axis " + std::to_string(a), ArrayKind::geometry);
    visit_piece_fields(std::int32_t(p), visit);
  }
}

std::vector<insitu_audit_entry> Mesh::audit() const {
  std::vector<insitu_audit_entry> entries;
  visit_arrays([&](const ExternalArray& array, const std::string& name, ArrayKind) {
    insitu_audit_entry e{};
    e.size = sizeof e;
    std::strncpy(e.name, name.c_str(), sizeof e.name - 1);
    std::strncpy(e.reason, array.converted.c_str(), sizeof e.reason - 1);
    e.data = array.data;
    e.bytes = array.bytes();
    e.borrowed = array.converted.empty();
    entries.push_back(e);
  });
  audit_blanks(entries);
  return entries;
}

std::int64_t Mesh::bytes_borrowed() const {
  std::int64_t sum = 0;
  visit_arrays([&](const ExternalArray& array, const std::string&, ArrayKind) {
    if (array.converted.empty())
      sum += array.bytes();
  });
  return sum;
}

} // namespace insitu::mesh
