#include "commit/standins/adaptive.h"

#include <utility>

#include "commit/halo/halo.h"
#include "core/status.h"
#include "core/timer.h"

namespace insitu::commit {

void Adaptive::require(const std::string& mesh_name, const query::LocatorPick& pick,
                       bool on_device) const {
  const std::string name = "mesh '" + mesh_name + "' is adaptive: ";
  if (on_device)
    throw core::Error(INSITU_ERROR_UNSUPPORTED, name + "its arrays in device memory are not read");
  if (pick.method != accel::Method::bvh || pick.backend != accel::Backend::cpu)
    throw core::Error(INSITU_ERROR_UNSUPPORTED, name + "it is located by bvh on the CPU, not by " +
                                                    accel::name(pick.method) + " on " +
                                                    accel::name(pick.backend));
}

std::optional<cells::Validation> Adaptive::validate(const mesh::Mesh& mesh,
                                                    const core::Threads& threads) const {
  cells::Validation found;
  found.counts = insitu_validation_default();
  found.counts.cells = mesh.adaptive().cell_count();
  amr::LeafMap leaves(*memory_);
  try {
    leaves.build(mesh.adaptive(), threads);
    found.counts.ghost_cells = leaves.masked_count();
  } catch (const core::Error& e) {
    found.findings = e.what();
  }
  return found;
}

bool Adaptive::is_due(const mesh::Mesh& mesh, std::uint32_t changed) const {
  return !locator_ || stands() != (mesh.reconstruction() == INSITU_DUAL) ||
         (changed & ~std::uint32_t(INSITU_CHANGED_FIELDS)) != 0;
}

StandIn::Found Adaptive::commit(mesh::Mesh& mesh, const insitu_frame& /*frame*/,
                                std::uint32_t changed, const core::Threads& threads,
                                const core::Log& /*log*/) {
  const bool due = is_due(mesh, changed);
  if (std::exchange(is_ready_, false)) {
    mesh.set_masked(leaves().masked_count() > 0 ? masked_.data() : nullptr);
    return {true, std::nullopt};
  }
  if (due && mesh.adaptive().is_part && mesh.reconstruction() == INSITU_DUAL)
    put_off(mesh, threads);
  else if (due)
    build(mesh, threads);
  else if (dual_)
    dual_->fields_changed();
  return {due, std::nullopt};
}

void Adaptive::make_on_all(mesh::Mesh& mesh, parallel::World& world, const Halo& halo,
                           const IsBefore& is_before, const core::Threads& threads) {
  const DualCells::Neighbours neighbours{world, halo.lent_leaves(), halo.outermost(), is_before};
  build(mesh, threads, &neighbours);
  is_before_ = is_before;
  is_ready_ = true;
}

/// From here on there are no cells until others are in place.
void Adaptive::begin(mesh::Mesh& mesh) {
  is_ready_ = false;
  is_before_ = nullptr;
  mesh.set_stand_in(nullptr);
  locator_.reset();
  later_.forget();
}

void Adaptive::build_leaves(const mesh::Mesh& mesh, const core::Threads& threads) {
  if (!leaves_)
    leaves_ = std::make_unique<amr::LeafMap>(*memory_);
  leaves_->build(mesh.adaptive(), threads);
}

void Adaptive::make_dual(const mesh::Mesh& mesh, const core::Threads& threads,
                         const DualCells::Neighbours* neighbours) {
  if (!dual_)
    dual_ = std::make_unique<DualCells>(*memory_);
  dual_->build(mesh, threads, amr::Cubes::counts, neighbours);
}

void Adaptive::choose_locator() {
  if (!dual_)
    locator_ = std::make_unique<query::LeafLocator>(*leaves_);
  else if (dual_->dual().has_gridlets())
    locator_ = std::make_unique<query::DualLocator>(
        query::DualPlaces{&dual_->places(), &dual_->dual().corners()});
  else
    locator_ = std::make_unique<query::TreeLocator>();
}

void Adaptive::put_in_place(mesh::Mesh& mesh, const core::Threads& threads) {
  own_cells_ = mesh.adaptive().own_cell_count();
  mask(mesh.adaptive(), threads);
  mesh.set_masked(leaves().masked_count() > 0 ? masked_.data() : nullptr);
  if (dual_)
    mesh.set_stand_in(this);
}

void Adaptive::build(mesh::Mesh& mesh, const core::Threads& threads,
                     const DualCells::Neighbours* neighbours) {
  const core::Timer timer;
  begin(mesh);
  const auto agreed = [&](auto&& work) {
    if (neighbours)
      neighbours->world.agree_after(work);
    else
      work();
  };
  if (mesh.reconstruction() == INSITU_NEAREST) {
    dual_.reset();
    agreed([&] {
      build_leaves(mesh, threads);
      leaves_->number_bricks(threads);
    });
  } else {
    leaves_.reset();
    make_dual(mesh, threads, neighbours);
  }
  agreed([&] {
    choose_locator();
    put_in_place(mesh, threads);
  });
  build_s_ = timer.seconds();
}

/// The leaves are looked at now, and what is wrong with them is told.
void Adaptive::put_off(mesh::Mesh& mesh, const core::Threads& threads) {
  const core::Timer timer;
  begin(mesh);
  build_leaves(mesh, threads);
  if (!dual_)
    dual_ = std::make_unique<DualCells>(*memory_);
  put_in_place(mesh, threads);
  later_.put_off(mesh, threads.count());
  build_s_ = timer.seconds();
}

const mesh::MeshView& Adaptive::keep(std::vector<std::int64_t> first_cell,
                                     const core::Threads& threads) {
  if (dual_)
    return view();
  kept_ = std::make_unique<LeavesCopy>(*leaves_, std::move(first_cell), *memory_, threads);
  return kept_->view();
}

void Adaptive::mask(const mesh::AmrView& mesh, const core::Threads& threads) {
  const amr::LeafMap& map = leaves();
  if (map.masked_count() == 0) {
    masked_.release();
    return;
  }
  const std::int64_t words = (mesh.cell_count() + 63) / 64;
  masked_.resize_discard(std::size_t(words));
  threads.parallel_for(words, 256, [&](std::int64_t begin, std::int64_t end) {
    std::int32_t piece = 0;
    for (std::int64_t w = begin; w < end; ++w) {
      std::uint64_t bits = 0;
      for (std::int64_t flat = 64 * w; flat < std::min(64 * w + 64, mesh.cell_count()); ++flat) {
        while (flat < mesh.first_cell[piece] || flat >= mesh.first_cell[piece + 1])
          piece = flat < mesh.first_cell[piece] ? 0 : piece + 1;
        const mesh::AmrCell cell = mesh.cell(mesh.pieces[piece], flat - mesh.first_cell[piece]);
        bits |= std::uint64_t(map.at(cell.depth, cell.index) != std::uint32_t(flat)) << (flat & 63);
      }
      masked_[std::size_t(w)] = bits;
    }
  });
}

query::Location Adaptive::in_leaf(const amr::LeafMap::Leaf& leaf, const math::Vec3d& p) const {
  const mesh::Lattice& lattice = leaves().lattice();
  query::Location own{std::int64_t(leaf.id), {}};
  for (int a = 0; a < 3; ++a) {
    const double low = lattice.place(a, leaf.cell.depth, 2 * leaf.cell.index[a]);
    const double high = lattice.place(a, leaf.cell.depth, 2 * leaf.cell.index[a] + 2);
    own.parametric[a] = (p[a] - low) / (high - low);
  }
  if (lattice.is_flat != 0)
    own.parametric.z = 0.5;
  return own;
}

query::Location Adaptive::own(const query::Location& at, const math::Vec3d& p) const {
  if (!at || !dual_)
    return at;
  const amr::LeafMap::Leaf leaf = is_before_ ? leaves().first(p, is_before_) : leaves().lowest(p);
  return leaf ? in_leaf(leaf, p) : query::Location{}; // between the boundary and its rounding
}

query::Location Adaptive::own_here(const query::Location& at, const math::Vec3d& p) const {
  if (!dual_)
    return at && at.cell < own_cells_ ? at : query::Location{};
  const amr::LeafMap::Leaf leaf = at ? leaves().lowest(p) : amr::LeafMap::Leaf();
  return leaf && leaf.id < own_cells_ ? in_leaf(leaf, p) : query::Location{};
}

std::optional<StandIn::MadeCell> Adaptive::made_cell(std::int64_t flat) const {
  if (!dual_ || !is_before_)
    return std::nullopt;
  return MadeCell{number(flat), dual_->first_leaf(flat, is_before_)};
}

std::int64_t Adaptive::find_made(std::int64_t number) const {
  return dual_ && is_before_ ? dual_->order().find(dual_->dual(), number) : -1;
}

std::optional<StandIn::Held> Adaptive::held() const {
  if (!dual_ || waits())
    return std::nullopt;
  return Held{"dual mesh", amr_info()->bytes,
              dual_->dual().has_gridlets()
                  ? "built at the last regrid; cubes lie in gridlets"
                  : "built at the last regrid; without gridlets, as most of its cells stitch"};
}

std::optional<insitu_amr_info> Adaptive::amr_info() const {
  later_.complete();
  insitu_amr_info info = insitu_amr_info_default();
  info.leaves = leaves().leaf_count();
  info.masked = leaves().masked_count();
  info.bytes = std::int64_t(masked_.bytes()) + (leaves_ ? leaves_->bytes() : 0);
  info.build_s = build_s_;
  if (dual_) {
    const amr::DualCounts& counts = dual_->dual().counts();
    info.gridlets = counts.gridlets;
    info.cubes = counts.cubes;
    info.stitching = counts.stitching();
    info.folded = counts.folded;
    info.repaired = counts.repaired;
    info.by_places = dual_->dual().has_gridlets();
    info.bytes += dual_->dual().bytes() + dual_->places().bytes();
  }
  return info;
}

} // namespace insitu::commit
