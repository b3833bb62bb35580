#include "query/sampler.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "accel/tree/tree.h"
#include "mesh/one_mesh.h"
#include "query/batch/candidates.h"
#include "query/batch/guessed_batches.h"
#include "query/batch/order.h"
#include "query/batch/tree_locator.h"
#include "query/chart_image.h"
#include "query/elsewhere.h"
#include "query/lattice/culled_cells.h"
#include "query/on_demand.h"
#include "query/point_query.h"
#include "query/proof.h"
#include "query/seams.h"

namespace insitu::query {

using math::Vec3d;

namespace {

/// How many points were answered for which reason, until it is added to what all threads count.
class Tally {
public:
  explicit Tally(LocateCounts* to) : to_(to) {}
  ~Tally() {
    if (to_)
      to_->add(by_reason_);
  }
  Tally(const Tally&) = delete;
  Tally& operator=(const Tally&) = delete;

  void note(const Answered& answered) {
    // Eight at a time where they are alike, else in turns: counting one waits for the last one.
    static_assert(sizeof(Reason) == 1);
    std::int32_t counts[4][reason_count] = {};
    const Reason* const why = answered.reasons.data();
    const std::size_t n = answered.reasons.size();
    for (std::size_t k = 0; k < n; k += 8) {
      std::uint64_t next = 0;
      std::memcpy(&next, why + k, std::min<std::size_t>(8, n - k));
      if (n - k >= 8 && next == 0x0101010101010101u * (next & 0xff))
        counts[0][next & 0xff] += 8;
      else
        for (std::size_t i = k; i < std::min(k + 8, n); ++i)
          ++counts[i & 3][int(why[i])];
    }
    for (const auto& turn : counts)
      for (int reason = 0; reason < reason_count; ++reason)
        by_reason_[reason] += turn[reason];
  }

private:
  LocateCounts* to_;
  std::int64_t by_reason_[reason_count] = {};
};

/// reasons may be empty.
void store(const Answered& answered, std::span<Location> locations,
           std::span<std::uint8_t> reasons) {
  for (std::size_t k = 0; k < answered.locations.size(); ++k)
    locations[answered.item(k)] = answered.locations[k];
  for (std::size_t k = 0; k < answered.reasons.size() && !reasons.empty(); ++k)
    reasons[answered.item(k)] = std::uint8_t(answered.reasons[k]);
}

} // namespace

Sampler::Sampler(const mesh::MeshView& mesh, const accel::Tree& tree, SpatialOrder* order,
                 LocateCounts* counts, const PointLocator* locator, const ChartImage* chart,
                 const accel::FaceNeighbours* neighbours, const OnDemand* on_demand)
    : mesh_(&mesh), tree_(&tree), order_(order), counts_(counts),
      locator_(locator ? locator : &TreeLocator::plain()), chart_(chart), neighbours_(neighbours),
      on_demand_(on_demand) {}

const accel::Tree& Sampler::tree() const {
  if (on_demand_)
    for (const PutOff* work : {on_demand_->tree, on_demand_->displacement})
      if (work)
        work->complete();
  return *tree_;
}

const accel::OddSlots& Sampler::odd() const {
  return tree_->odd();
}

const SoundCells* Sampler::sound_cells(bool moves) const {
  return on_demand_ && on_demand_->sound && !mesh_->free_of_folds && mesh::is_one(*mesh_) &&
                 on_demand_->sound->serves(moves)
             ? on_demand_->sound
             : nullptr;
}

const LoneCells* Sampler::lone_cells(const LocateOptions& options) const {
  return on_demand_ && options.accuracy == INSITU_EXACT && options.alpha == 1.0 &&
                 !mesh_->covers_once
             ? on_demand_->lone
             : nullptr;
}

PointQuery Sampler::point_query(const LocateOptions& options) const {
  const LoneCells* const lone = lone_cells(options);
  return {*mesh_, tree(), options, lone && lone->are_known() ? lone : nullptr};
}

mesh::MeshFacts Sampler::facts(const core::Threads* threads) const {
  mesh::MeshFacts facts =
      on_demand_ ? on_demand_->facts.of(*mesh_, threads) : mesh::find_facts(*mesh_, threads);
  if (chart_)
    chart_->cut(facts.bounds);
  return facts;
}

bool Sampler::exists(std::int64_t flat) const {
  const std::int32_t piece = mesh_->piece_of(flat);
  return mesh_->pieces[piece].exists(flat - mesh_->first_cell[piece]);
}

bool Sampler::owns(std::int64_t flat) const {
  const std::int32_t piece = mesh_->piece_of(flat);
  return mesh_->pieces[piece].owns(flat - mesh_->first_cell[piece]);
}

Location Sampler::locate(const Vec3d& given, std::int64_t hint, const LocateOptions& options,
                         Reason* reason) const {
  const Vec3d p = chart_ ? (*chart_)(given) : given;
  Reason why = Reason::outside;
  Location at;
  std::int64_t guess = -1;
  if (!locator_->find(p, hint, at, why, guess)) {
    if (guess >= 0 && guess < mesh_->cell_count() &&
        ProofRule(*mesh_, odd(), options).counts_for(p) && exists(guess)) {
      mesh::CellVertices cell;
      mesh::gather(*mesh_, guess, cell, options.alpha);
      if ((at = try_cell(cell, guess, p)))
        why = Reason::certified;
    }
    if (!at)
      at = point_query(options).locate(p, why);
  }
  if (seams_)
    settle_at_seam(p, options, at, why);
  if (counts_)
    counts_->add(why);
  if (reason)
    *reason = why;
  return at || !outlook_ ? at : outlook_->find(p, options.alpha);
}

/// A point that is not strictly inside of its cell, which touches another process's, may be in one
/// of those as well; in `exact` one that is inside too, since cells may overlap. Looks at all cells
/// that hold it, and returns whether another one than `at` is the first, or none that is here
/// can be known to be.
bool Sampler::settle_at_seam(const Vec3d& p, const LocateOptions& options, Location& at,
                             Reason& reason) const {
  const auto is_inside = [&] { return reason == Reason::certified || reason == Reason::exact; };
  if (!at || (is_inside() && (options.accuracy != INSITU_EXACT || mesh_->covers_once)) ||
      !seams_->is_at_seam(at.cell))
    return false;
  const PointQuery query = point_query(options);
  float lower[3], upper[3];
  if (!query.box_rule().box(p, lower, upper))
    return false;
  // A place on the boundary of other processes' cells alone may be owned by one that is not here:
  // all that touch a cell of this process are.
  bool other = false, is_here = owns(at.cell) || !outlook_ || !outlook_->is_beyond(p);
  mesh::CellVertices cell;
  for (const Candidate& c : query.candidates_in(lower, upper)) {
    const std::int64_t flat = query.tree.cells()[c.slot];
    const bool is_first = seams_->is_before(flat, at.cell), is_own = !is_here && owns(flat);
    if (!is_first && !is_own)
      continue;
    mesh::gather(*mesh_, flat, cell, options.alpha);
    const cells::Decision why = cells::decide(cell.shape, cell.x, p);
    is_here = is_here || (why && is_own);
    if (why && is_first) {
      at = {flat, cells::parametric_in(cell.shape, cell.x, p, why)};
      reason = why.reason();
      other = true;
    }
  }
  if (!is_here && !is_inside()) {
    at = {};
    reason = Reason::outside;
    other = true;
  }
  return other;
}

/// Of points of this call; the result is valid until the thread's next call.
Answered Sampler::settle_at_seams(const Answered& answered, std::span<const Vec3d> points,
                                  const LocateOptions& options) const {
  thread_local std::vector<Location> locations;
  thread_local std::vector<Reason> reasons;
  const auto copy = [&] {
    locations.assign(answered.locations.begin(), answered.locations.end());
    reasons.assign(answered.reasons.begin(), answered.reasons.end());
  };
  bool copied = false;
  for (std::size_t k = 0; k < answered.locations.size(); ++k) {
    Location at = answered.locations[k];
    Reason why = answered.reasons[k];
    if (!at || !seams_->is_at_seam(at.cell))
      continue;
    const Vec3d& given = points[answered.item(k)];
    if (!settle_at_seam(chart_ ? (*chart_)(given) : given, options, at, why))
      continue;
    if (!std::exchange(copied, true))
      copy();
    locations[k] = at;
    reasons[k] = why;
  }
  Answered settled = answered;
  if (copied) {
    settled.locations = locations;
    settled.reasons = reasons;
  }
  return settled;
}

Sampler Sampler::among(const CulledCells& cells) const {
  Sampler some = *this;
  some.tree_ = &cells.tree();
  some.locator_ = &cells.locator();
  return some;
}

void Sampler::count(Reason reason, std::int64_t points) const {
  std::int64_t by_reason[reason_count] = {};
  by_reason[int(reason)] = points;
  if (counts_ && points > 0)
    counts_->add(by_reason);
}

void Sampler::locate_serial(std::span<const Vec3d> points, std::span<Location> locations,
                            const LocateOptions& options, std::span<std::uint8_t> reasons) const {
  std::vector<Vec3d> images(chart_ ? std::min<std::size_t>(batch_size, points.size()) : 0);
  Tally tally(counts_);
  if (const LoneCells* const lone = lone_cells(options))
    lone->note(points.size());
  locator_->with_batches(point_query(options), [&](Batches& batches) {
    for (std::size_t first = 0; first < points.size(); first += batch_size) {
      const std::size_t n = std::min<std::size_t>(batch_size, points.size() - first);
      std::span<const Vec3d> batch = points.subspan(first, n);
      if (chart_) {
        std::ranges::transform(batch, images.begin(), *chart_);
        batch = std::span<const Vec3d>(images).first(n);
      }
      Answered answered = batches.run(batch);
      tally.note(answered);
      answered.first = first;
      store(seams_ ? settle_at_seams(answered, points, options) : answered, locations, reasons);
    }
  });
}

void Sampler::locate(const core::Threads& threads, std::span<const Vec3d> points,
                     std::span<Location> locations, const LocateOptions& options,
                     std::span<std::uint8_t> reasons) const {
  visit(threads, points, options,
        [&](const Answered& answered) { store(answered, locations, reasons); });
}

void Sampler::visit(const core::Threads& threads, std::span<const Vec3d> points,
                    const LocateOptions& options, PutAnswers put) const {
  if (locator_->visit(threads, points, options, counts_, put))
    return;
  constexpr auto grain = std::int64_t(GuessedBatches::grain);
  static_assert(grain % batch_size == 0);
  if (const LoneCells* const lone = lone_cells(options)) {
    lone->note(points.size());
    tree();
    lone->find_if_due(*mesh_, threads);
  }
  const PointQuery query = point_query(options);
  const bool sorts = order_ && is_incoherent(points, query.tree);
  // So many at a time that numbers of points fit 32 bits and the memory stays bounded.
  constexpr std::size_t slice = std::size_t(1) << 22;
  for (std::size_t from = 0; from < points.size(); from += slice) {
    const std::span<const Vec3d> part = points.subspan(from, std::min(slice, points.size() - from));
    const auto sorted =
        sorts ? order_->sort(threads, part, query.tree) : std::span<const accel::morton::Coded>();
    threads.parallel_for(
        std::int64_t(part.size()), grain, [&](std::int64_t begin, std::int64_t end) {
          const auto grain_begin = std::size_t(begin), grain_end = std::size_t(end);
          Tally tally(counts_);
          locator_->with_batches(query, [&](Batches& batches) {
            const auto give = [&](Answered answered, std::size_t first) {
              tally.note(answered);
              answered.first = first;
              put(seams_ ? settle_at_seams(answered, points, options) : answered);
            };
            if (sorts)
              visit_sorted(batches, part, sorted.subspan(grain_begin, grain_end - grain_begin),
                           [&](const Answered& answered) { give(answered, from); });
            else
              visit_in_order(batches, part.subspan(grain_begin), grain_end - grain_begin,
                             [&](std::size_t first, const Answered& answered) {
                               give(answered, from + grain_begin + first);
                             });
          });
        });
  }
}

/// A grain of points in their own order.
void Sampler::visit_in_order(Batches& batches, std::span<const Vec3d> points, std::size_t count,
                             Batches::Put put) const {
  thread_local std::vector<Vec3d> images;
  if (chart_) {
    images.resize(count);
    std::transform(points.begin(), points.begin() + std::ptrdiff_t(count), images.begin(), *chart_);
    points = images;
  }
  batches.run_grain(points, count, put);
}

/// A grain of points in spatial order.
void Sampler::visit_sorted(Batches& batches, std::span<const Vec3d> points,
                           std::span<const accel::morton::Coded> order, PutAnswers put) const {
  Vec3d batch[batch_size];
  for (std::size_t first = 0; first < order.size(); first += batch_size) {
    const std::size_t n = std::min<std::size_t>(batch_size, order.size() - first);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3d& p = points[order[first + i].id];
      batch[i] = chart_ ? (*chart_)(p) : p;
    }
    Answered answered = batches.run({batch, n});
    answered.order = &order[first];
    put(answered);
  }
}

} // namespace insitu::query
