#include "advect/across/far_cells.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "query/on_demand.h"
#include "query/proof.h"
#include "query/sound_cells.h"
#include "query/walk/beside_mesh.h"

namespace insitu::advect {

using math::Vec3d;

namespace {

/// Ids between the pieces of a chart.
constexpr std::int64_t apart = std::int64_t(1) << 40;

} // namespace

std::vector<std::int64_t> FarCells::facts(const query::Sampler& here,
                                          std::span<const InTime> fields) {
  std::vector<std::int64_t> facts{here.mesh().earlier_points != nullptr, here.chart() != nullptr};
  for (const InTime& field : fields) { // what its values are of, how many, and earlier steps
    facts.push_back(field.now->pieces ? 1 + std::int64_t(field.now->association) : 0);
    facts.push_back(field.now->pieces ? field.now->components : 0);
    facts.push_back(field.earlier ? std::int64_t(field.earlier->size()) : 0);
  }
  return facts;
}

FarCells::FarCells(const query::Sampler& here, const Homes& homes, query::Directory others,
                   int rank, std::span<const InTime> fields, std::span<const std::int64_t> facts)
    : here_(here.with_outlook(nullptr).among_images()), sampler_(here), rank_(rank),
      directory_(std::move(others)), homes_(*this, &homes) {
  begin(fields, facts);
}

FarCells::FarCells(const query::Sampler& here, std::span<const InTime> fields,
                   std::span<const std::int64_t> facts)
    : here_(here.with_outlook(nullptr).among_images()), sampler_(here), beyond_(here.outlook()),
      homes_(*this, nullptr) {
  begin(fields, facts);
  if (beyond_)
    beyond_->ask(this);
}

FarCells::~FarCells() {
  if (beyond_)
    beyond_->ask(nullptr);
}

/// The views begin as those that are here, with no cell behind them.
void FarCells::begin(std::span<const InTime> fields, std::span<const std::int64_t> facts) {
  const mesh::MeshView& mesh = here_.mesh();
  moves_ = facts[0] != 0;
  far_.resize(facts[1] ? 3 : 1);
  first_ = mesh.cell_count();
  view_ = mesh;
  pieces_.assign(mesh.pieces, mesh.pieces + mesh.piece_count);
  pieces_.resize(pieces_.size() + far_.size());
  first_cell_.assign(mesh.first_cell, mesh.first_cell + mesh.piece_count + 1);
  first_vertex_.assign(mesh.first_vertex, mesh.first_vertex + mesh.piece_count + 1);
  first_cell_.resize(pieces_.size() + 1, first_);
  first_vertex_.resize(pieces_.size() + 1, mesh.vertex_count());
  view_.piece_count += std::int32_t(far_.size());
  view_.halo_piece_count += std::int32_t(far_.size());
  if (moves_ && !mesh.earlier_points) { // no cells here
    earlier_.reserve(1);
    earlier_.resize(std::size_t(mesh.vertex_count()));
    view_.earlier_points = earlier_.data();
  }
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const InTime& field = fields[f];
    const std::int64_t* const of = facts.data() + 2 + 3 * f;
    if (!field.now->pieces && of[0] > 0) {
      field.now->association = insitu_association(of[0] - 1);
      field.now->components = int(of[1]);
    }
    if (field.earlier) {
      field.earlier->resize(std::size_t(of[2]), *field.now);
      std::ranges::for_each(*field.earlier, [&](mesh::FieldView& view) { take_field(view); });
    }
    take_field(*field.now);
  }
  set_views();
  sampler_ = sampler_.on(view_).with_outlook(beyond_ ? beyond_ : this);
  // What is found out about cells is kept of those that are here, and of no others.
  if (const query::SoundCells* const sound = here_.sound_cells(moves_); sound && first_ > 0)
    sound->find(first_, mesh::Shape::tetrahedron, {});
  double longest = 0.0;
  for (int r = 0; r < directory_.size(); ++r)
    for (const mesh::Box& box : directory_.boxes(r)) {
      const Vec3d size = box.size();
      longest = std::max({longest, size.x, size.y, size.z});
    }
  near_ = 1e-7 * longest;
}

void FarCells::set_views() {
  const mesh::MeshView& mesh = here_.mesh();
  const auto bytes = [](const auto& vector) {
    return reinterpret_cast<const std::byte*>(vector.data());
  };
  for (std::size_t k = 0; k < far_.size(); ++k) {
    const Piece& piece = far_[k];
    const std::size_t p = first_piece() + k;
    mesh::PieceView& v = pieces_[p];
    v.layout = mesh::CellLayout::mixed;
    v.is_halo = true;
    v.pole = std::int8_t(k);
    v.cell_count = std::int64_t(piece.types.size());
    v.vertex_count = std::int64_t(piece.points.size());
    v.connectivity = {bytes(piece.connectivity), std::int64_t(piece.connectivity.size()),
                      sizeof(std::int32_t), true};
    v.id_stride = sizeof(std::int32_t);
    v.offsets = {bytes(piece.offsets), std::int64_t(piece.offsets.size()), sizeof(std::int64_t),
                 false};
    v.types = bytes(piece.types);
    for (int a = 0; a < 3; ++a)
      v.points.component[a] = bytes(piece.points) + std::size_t(a) * sizeof(double);
    v.points.layout = {v.vertex_count, {v.vertex_count, 1}, {sizeof(Vec3d), 0, 0}, true};
    first_cell_[p + 1] =
        k + 1 < far_.size() ? first_cell_[p] + apart : first_cell_[p] + v.cell_count;
    first_vertex_[p + 1] = first_vertex_[p] + v.vertex_count;
    for (const auto& field : fields_) {
      Field::Of& of = field->of[k];
      const auto components = std::size_t(field->view.components);
      of.components.resize(components);
      for (std::size_t c = 0; c < components; ++c)
        of.components[c] = bytes(of.values) + c * sizeof(double);
      const auto count = std::int64_t(of.values.size() / std::max<std::size_t>(components, 1));
      field->pieces[p] = {
          of.components.data(),
          {count, {count, 1}, {std::int64_t(components * sizeof(double)), 0, 0}, true},
          false,
          nullptr};
    }
  }
  view_.pieces = pieces_.data();
  view_.first_cell = first_cell_.data();
  view_.first_vertex = first_vertex_.data();
  if (moves_ && view_.vertex_count() > mesh.vertex_count()) {
    const auto here = std::size_t(mesh.vertex_count());
    if (earlier_.size() < here)
      earlier_.assign(mesh.earlier_points, mesh.earlier_points + here);
    earlier_.resize(here);
    for (const Piece& piece : far_)
      earlier_.insert(earlier_.end(), piece.earlier.begin(), piece.earlier.end());
    view_.earlier_points = earlier_.data();
  }
}

void FarCells::take_field(mesh::FieldView& view) {
  Field& field = *fields_.emplace_back(std::make_unique<Field>());
  field.view = view;
  field.pieces.resize(pieces_.size());
  if (view.pieces)
    std::copy_n(view.pieces, first_piece(), field.pieces.begin());
  field.of.resize(far_.size());
  field.view.pieces = field.pieces.data();
  view = field.view;
}

bool FarCells::is_beyond(const Vec3d& point) const {
  if (beyond_)
    return beyond_->is_beyond(point);
  for (int r = 0; r < directory_.size(); ++r)
    if (r != rank_ && directory_.may_hold(r, point))
      return true;
  return false;
}

query::Location FarCells::find(const Vec3d& point, double alpha) const {
  if (!is_beyond(point))
    return {};
  if (const query::Location at = inside(point, alpha))
    return at;
  const auto known = known_.find({point, alpha, 0.0});
  if (known == known_.end())
    throw query::Elsewhere(*this, point, alpha);
  return known->second.at;
}

/// In a cell that has come and answers alone, or none.
query::Location FarCells::inside(const Vec3d& point, double alpha) const {
  mesh::CellVertices c;
  for (const Group& group : groups_)
    for (std::size_t k = 0; k < group.boxes.size() && group.all.holds(point); ++k) {
      if (!group.boxes[k].holds(point))
        continue;
      mesh::gather(view_, group.cells[k], c, alpha);
      if (const query::Location at = query::try_cell(c, group.cells[k], point))
        return at;
    }
  return {};
}

std::optional<Vec3d> FarCells::nearest(const Vec3d& point, double reach, double alpha) const {
  if (beyond_ ? !beyond_->is_beyond(point) : ranks_at(point, reach).empty())
    return std::nullopt;
  // Who was asked for the place itself has said whether it comes near to it.
  const auto missed = known_.find({point, alpha, 0.0});
  if (reach <= near_ && missed != known_.end() && !missed->second.is_near)
    return std::nullopt;
  const auto known = known_.find({point, alpha, reach});
  if (known == known_.end())
    throw query::Elsewhere(*this, point, alpha, reach);
  return known->second.nearest;
}

std::vector<int> FarCells::ranks_at(const Vec3d& point, double reach) const {
  if (beyond_)
    return beyond_->ranks_at(point, reach);
  std::vector<int> ranks;
  for (int r = 0; r < directory_.size(); ++r)
    if (r != rank_ && std::ranges::any_of(directory_.boxes(r), [&](const mesh::Box& box) {
          return wider_box(box, reach).holds(point);
        }))
      ranks.push_back(r);
  return ranks;
}

FarCells::Answer FarCells::answer(const Vec3d& point, double alpha, double reach,
                                  insitu_accuracy accuracy) const {
  Answer answer;
  const query::LocateOptions options{accuracy, alpha};
  if (reach == 0.0) {
    answer.at = here_.locate(point, -1, options);
    answer.holds = answer.at && homes_.is_own(answer.at.cell);
    if (answer.holds)
      return answer;
  }
  Vec3d inside = point;
  const bool is_near =
      bool(query::bring_inside(here_, inside, reach == 0.0 ? near_ : reach, options));
  answer.is_near = is_near;
  if (is_near)
    answer.nearest = inside;
  return answer;
}

bool FarCells::Asked::operator==(const Asked& b) const {
  return point == b.point && alpha == b.alpha && reach == b.reach;
}

std::size_t FarCells::Hash::operator()(const Asked& asked) const {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  for (const double part :
       {asked.point.x, asked.point.y, asked.point.z, asked.alpha, asked.reach}) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(part + 0.0)) * 0x9e3779b97f4a7c15ull;
    hash ^= hash >> 29;
  }
  return std::size_t(hash);
}

bool FarCells::AllHomes::is_own(std::int64_t cell) const {
  return !here_ || (!cells_.is_far(cell) && here_->is_own(cell));
}

CellName FarCells::AllHomes::name(std::int64_t cell) const {
  if (!here_)
    return {};
  if (!cells_.is_far(cell))
    return here_->name(cell);
  const auto p = std::size_t(cells_.view_.piece_of(cell));
  return cells_.far_[p - cells_.first_piece()].names[std::size_t(cell - cells_.first_cell_[p])];
}

std::int64_t FarCells::AllHomes::find(const CellName& name) const {
  const std::int64_t cell = here_ ? here_->find(name) : -1;
  if (cell >= 0)
    return cell;
  const auto far = cells_.by_name_.find(name);
  return far != cells_.by_name_.end() ? far->second : -1;
}

void add_fields(std::vector<Drift>& drifts, std::vector<FarCells::InTime>& to) {
  for (Drift& drift : drifts)
    if (drift.field)
      to.push_back({&drift.field->now, &drift.field->earlier});
}

void add_fields(Effects& effects, std::vector<FarCells::InTime>& to) {
  add_fields(effects.drifts, to);
  if (effects.diffusion)
    for (Coefficient* const c : {&effects.diffusion->horizontal, &effects.diffusion->vertical})
      if (c->field)
        to.push_back({&c->field->now, &c->field->earlier});
  for (mesh::FieldView& field : effects.removes_by)
    to.push_back({&field, nullptr});
}

} // namespace insitu::advect
