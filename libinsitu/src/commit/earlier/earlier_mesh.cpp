#include "commit/earlier/earlier_mesh.h"

#include <algorithm>

#include "commit/earlier/gathered_adaptive.h"
#include "mesh/one_mesh.h"

namespace insitu::commit {

std::vector<std::unique_ptr<mesh::EarlierField>>
EarlierMesh::fields_of(const mesh::EarlierStep& step, const mesh::MeshView& view,
                       core::Memory& memory) {
  std::vector<std::unique_ptr<mesh::EarlierField>> fields;
  for (const mesh::EarlierStep::Field& from : step.fields) {
    if (from.steps.empty())
      continue;
    mesh::EarlierField& to = *fields.emplace_back(std::make_unique<mesh::EarlierField>());
    to.name = from.name;
    to.association = from.association;
    to.components = from.components;
    to.begin_step(1, view, memory);
    std::copy(from.steps[0].begin(), from.steps[0].end(), to.steps[0]->values.begin());
  }
  return fields;
}

EarlierMesh::EarlierMesh(mesh::TakenStep step, mesh::CellsCopy cells, accel::Tree tree, bool refit,
                         const Kept& kept, std::uint64_t topology_version, core::Memory& memory,
                         const core::Threads& threads)
    : step_(std::move(step)), cells_(std::move(cells)), chart_(kept.chart),
      own_view_(cells_->on(step_.points.data())), view_(&own_view_), tree_(std::move(tree)),
      topology_version_(topology_version) {
  sound_.emplace(memory).begin(kept.are_inverted);
  if (!kept.folds_are_known)
    sound_->forget();
  on_demand_.tree = &fit_;
  on_demand_.sound = &*sound_;
  own_view_.free_of_folds = kept.odd.none();
  own_view_.covers_once = kept.covers_once;
  if (!refit)
    return;
  if (kept.odd.ids.empty()) {
    tree_.mark_odd(own_view_, {}, threads);
    fit_.put_off(threads.count());
  } else {
    tree_.refit(own_view_, threads);
    tree_.mark_odd(own_view_, kept.odd.ids, threads);
  }
}

void EarlierMesh::Fit::do_it() const {
  mesh_.tree_.refit(mesh_.own_view_, core::Threads(threads_));
}

EarlierMesh::EarlierMesh(mesh::TakenStep step, std::unique_ptr<StandIn> made, accel::Tree tree,
                         std::uint64_t topology_version, const core::Threads& threads)
    : step_(std::move(step)), made_(std::move(made)), tree_(std::move(tree)),
      topology_version_(topology_version) {
  std::vector<std::int64_t> first{0};
  for (const mesh::FieldPieceView& piece : step_.fields.front()->steps.front()->views)
    first.push_back(first.back() + piece.layout.count);
  view_ = &made_->keep(std::move(first), threads);
  locator_ = made_->locator();
}

EarlierMesh::~EarlierMesh() = default;

std::unique_ptr<EarlierMesh> EarlierMesh::restored(const mesh::EarlierStep& step,
                                                   mesh::CellsCopy cells,
                                                   const std::optional<query::ChartImage>& chart,
                                                   core::Memory& memory,
                                                   const core::Threads& threads) {
  if (cells.empty())
    return nullptr;
  mesh::TakenStep taken{core::Buffer<math::Vec3d>(memory, INSITU_MEMORY_EARLIER), {}};
  taken.points.resize_discard(step.points.size());
  std::copy(step.points.begin(), step.points.end(), taken.points.begin());
  const mesh::MeshView& view = cells.on(taken.points.data());
  if (!step.fits(view, view.vertex_count()))
    return nullptr;
  taken.fields = fields_of(step, view, memory);
  const bool one = mesh::is_one(view);
  const cells::OddCells odd = one ? cells::find_odd_cells(view, threads) : cells::OddCells{};
  accel::Tree tree(memory);
  tree.build(view, threads, accel::Builder::automatic);
  tree.mark_odd(view, odd.ids, threads);
  tree.release_scratch();
  Kept kept;
  kept.folds_are_known = true;
  kept.odd = odd;
  kept.chart = chart;
  return std::make_unique<EarlierMesh>(std::move(taken), std::move(cells), std::move(tree), false,
                                       kept, 0, memory, threads);
}

/// dual: built of the cells, where these are found by their places in it.
std::unique_ptr<EarlierMesh> EarlierMesh::of_adaptive(EarlierCells& cells, CellsKind kind,
                                                      std::unique_ptr<GatheredDual> dual,
                                                      bool is_flat, core::Memory& memory,
                                                      const core::Threads& threads) {
  using Owned = std::unique_ptr<EarlierMesh>;
  if (kind == CellsKind::dual_by_places)
    return Owned(new EarlierMesh(cells, std::move(dual), memory, threads));
  if (kind == CellsKind::leaves_by_places)
    return Owned(new EarlierMesh(cells, std::make_unique<GatheredLeaves>(cells, memory, threads),
                                 memory, threads));
  mesh::CellsCopy copy = cells.copy(memory, threads);
  copy.set_flat(is_flat);
  Owned mesh = restored(cells.step, std::move(copy), std::nullopt, memory, threads);
  if (mesh)
    mesh->know_sound(threads);
  return mesh;
}

std::unique_ptr<EarlierMesh> EarlierMesh::restored(EarlierCells cells, CellsKind kind, bool is_part,
                                                   core::Memory& memory,
                                                   const core::Threads& threads) {
  auto told = is_part ? std::make_unique<EarlierCells>(cells) : nullptr;
  std::unique_ptr<GatheredDual> dual;
  if (kind == CellsKind::dual_by_places) {
    dual = std::make_unique<GatheredDual>(memory);
    dual->build(cells, threads);
  }
  const bool is_flat = cells.lattice.is_flat != 0;
  std::unique_ptr<EarlierMesh> mesh =
      of_adaptive(cells, kind, std::move(dual), is_flat, memory, threads);
  if (mesh) {
    mesh->own_.cells = mesh->view_->cell_count();
    mesh->told_ = std::move(told);
    mesh->told_kind_ = kind;
  }
  return mesh;
}

std::optional<mesh::FieldView> EarlierMesh::field(const std::string& name) const {
  for (const auto& field : step_.fields)
    if (field->name == name)
      return field->view(0);
  return std::nullopt;
}

} // namespace insitu::commit
