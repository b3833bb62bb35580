#include "query/sampler.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "accel/tree/tree.h"
#include "query/batch/batch.h"
#include "query/batch/direct_batch.h"
#include "query/batch/guessed_batches.h"
#include "query/batch/order.h"
#include "query/batch/ray_batch.h"
#include "query/chart_image.h"
#include "query/lattice/adaptive.h"
#include "query/lattice/culled_cells.h"
#include "query/lattice/dual_query.h"
#include "query/lattice/leaf_query.h"
#include "query/locators.h"
#include "query/point_query.h"
#include "query/proof.h"

namespace insitu::query {

using math::Vec3d;

namespace {

BatchScratch& batch_scratch() {
  thread_local std::unique_ptr<BatchScratch> scratch = std::make_unique<BatchScratch>();
  return *scratch;
}

BatchAnswers& batch_answers() {
  thread_local std::unique_ptr<BatchAnswers> answers = std::make_unique<BatchAnswers>();
  return *answers;
}

/// Runs batches over points in their own or another order, and counts.
class Batches {
public:
  /// counts, locators, adaptive: or null. shown: see DualFinder.
  Batches(const PointQuery& query, LocateCounts* counts, const Locators* locators,
          const Adaptive* adaptive, const std::uint64_t* shown)
      : locator_(query, batch_scratch()), counts_(counts),
        ray_counts_(locators ? &locators->ray_counts() : nullptr) {
    if (locators && locators->rays())
      by_rays_ = std::make_unique<RayBatch>(query, *locators->rays(), batch_scratch(), locator_,
                                            batch_answers());
    else if (adaptive && adaptive->gridlets())
      by_places_.emplace(DualFinder(*adaptive, -1, shown), query, batch_scratch(), locator_,
                         batch_answers());
    else if (adaptive)
      by_leaves_.emplace(LeafFinder(adaptive->leaves()), query, batch_scratch(), locator_,
                         batch_answers());
    else if (GuessedBatches::may_pay(query))
      by_guesses_.emplace(query, batch_scratch(), locator_, batch_answers());
  }
  ~Batches() {
    if (counts_)
      counts_->add(by_reason_);
    if (by_rays_) {
      ray_counts_->kept += by_rays_->kept;
      ray_counts_->by_neighbour += by_rays_->by_neighbour;
      ray_counts_->by_tree += by_rays_->by_tree;
    }
  }
  Batches(const Batches&) = delete;
  Batches& operator=(const Batches&) = delete;

  /// The answers of at most batch_size points; valid until the next run.
  Answered run(std::span<const Vec3d> points) {
    const Answered answered = by_rays_     ? by_rays_->run(points)
                              : by_places_ ? by_places_->run(points)
                              : by_leaves_ ? by_leaves_->run(points)
                                           : by_tree(points);
    note(answered);
    return answered;
  }

  /// A grain of points that follow each other, the first `count`; see GuessedBatches::run.
  template <class Put>
  void run_grain(std::span<const Vec3d> points, std::size_t count, Put&& put) {
    if (by_guesses_)
      return by_guesses_->run(points, count, [&](std::size_t first, const Answered& answered) {
        note(answered);
        put(first, answered);
      });
    for (std::size_t first = 0; first < count; first += batch_size) {
      const std::size_t n = std::min<std::size_t>(batch_size, count - first);
      ask_for_batch(points, first + n);
      put(first, run(points.subspan(first, n)));
    }
  }

private:
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
  Answered by_tree(std::span<const Vec3d> points) {
    locator_.run(points);
    return {locator_.locations(), locator_.reasons()};
  }

  BatchLocator locator_;
  LocateCounts* counts_;
  RayCounts* ray_counts_;
  std::unique_ptr<RayBatch> by_rays_;
  std::optional<DirectBatch<DualFinder>> by_places_;
  std::optional<DirectBatch<LeafFinder>> by_leaves_;
  std::optional<GuessedBatches> by_guesses_;
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

LocateCounts::Copy& LocateCounts::mine() {
  static std::atomic<unsigned> threads{0};
  thread_local const unsigned thread = threads.fetch_add(1, std::memory_order_relaxed);
  return copies_[thread % copy_count];
}

void LocateCounts::add(const std::int64_t (&by_reason)[reason_count]) {
  Copy& copy = mine();
  for (int i = 0; i < reason_count; ++i)
    if (by_reason[i])
      copy.by_reason[i].fetch_add(by_reason[i], std::memory_order_relaxed);
}

void LocateCounts::add(Reason reason) {
  mine().by_reason[int(reason)].fetch_add(1, std::memory_order_relaxed);
}

std::array<std::int64_t, reason_count> LocateCounts::totals() const {
  std::array<std::int64_t, reason_count> sum{};
  for (const Copy& copy : copies_)
    for (std::size_t i = 0; i < sum.size(); ++i)
      sum[i] += copy.by_reason[i].load(std::memory_order_relaxed);
  return sum;
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
  const bool dual = adaptive_ && adaptive_->gridlets();
  bool found = false;
  std::int64_t guess = hint; // or, without one, what the point's place suggests
  if (dual)
    found = DualFinder(*adaptive_, hint, shown_).find(p, at, why, guess);
  else if (adaptive_)
    found = LeafFinder(adaptive_->leaves()).find(p, at, why);
  if (!found && guess >= 0 && guess < mesh_->cell_count() &&
      ProofRule(*mesh_, *tree_, options).counts_for(p) && owns(guess)) {
    mesh::CellVertices cell;
    mesh::gather(*mesh_, guess, cell, options.alpha);
    if ((at = try_cell(cell, guess, p)))
      why = Reason::certified;
  }
  if (!found && !at && (dual || !adaptive_))
    at = PointQuery{*mesh_, *tree_, options}.locate(p, why);
  if (counts_)
    counts_->add(why);
  if (reason)
    *reason = why;
  return at;
}

Sampler Sampler::among(const CulledCells& cells) const {
  Sampler some = *this;
  some.tree_ = &cells.tree();
  some.locators_ = nullptr; // these know all cells
  some.shown_ = cells.shown();
  return some;
}

void Sampler::count_certified(std::int64_t points) const {
  std::int64_t by_reason[reason_count] = {};
  by_reason[int(Reason::certified)] = points;
  if (counts_ && points > 0)
    counts_->add(by_reason);
}

void Sampler::locate_serial(std::span<const Vec3d> points, std::span<Location> locations,
                            const LocateOptions& options, std::span<std::uint8_t> reasons) const {
  const PointQuery query{*mesh_, *tree_, options};
  Batches batches(query, counts_, locators_, adaptive_, shown_);
  std::vector<Vec3d> images(chart_ ? std::min<std::size_t>(batch_size, points.size()) : 0);
  for (std::size_t first = 0; first < points.size(); first += batch_size) {
    const std::size_t n = std::min<std::size_t>(batch_size, points.size() - first);
    if (chart_)
      std::transform(points.begin() + std::ptrdiff_t(first),
                     points.begin() + std::ptrdiff_t(first + n), images.begin(), *chart_);
    Answered answered =
        batches.run(chart_ ? std::span<const Vec3d>(images).first(n) : points.subspan(first, n));
    answered.first = first;
    store(answered, locations, reasons);
  }
}

void Sampler::locate(const core::Threads& threads, std::span<const Vec3d> points,
                     std::span<Location> locations, const LocateOptions& options,
                     std::span<std::uint8_t> reasons) const {
  visit(threads, points, options,
        [&](const Answered& answered) { store(answered, locations, reasons); });
}

void Sampler::visit(const core::Threads& threads, std::span<const Vec3d> points,
                    const LocateOptions& options, Put put) const {
  if (locators_ && locators_->device() && options.alpha == 1.0)
    return visit_on_device(threads, points, options, put);
  constexpr auto grain = std::int64_t(GuessedBatches::grain);
  static_assert(grain % batch_size == 0);
  const PointQuery query{*mesh_, *tree_, options};
  const bool sorts = order_ && is_incoherent(points, *tree_);
  const auto image = [&](const Vec3d& p) { return chart_ ? (*chart_)(p) : p; };
  // So many at a time that numbers of points fit 32 bits and the memory stays bounded.
  constexpr std::size_t slice = std::size_t(1) << 22;
  for (std::size_t from = 0; from < points.size(); from += slice) {
    const std::span<const Vec3d> part = points.subspan(from, std::min(slice, points.size() - from));
    const auto sorted =
        sorts ? order_->sort(threads, part, *tree_) : std::span<const accel::morton::Coded>();
    threads.parallel_for(
        std::int64_t(part.size()), grain, [&](std::int64_t begin, std::int64_t end) {
          Batches batches(query, counts_, locators_, adaptive_, shown_);
          if (!sorts) {
            const auto count = std::size_t(end - begin);
            auto own = part.subspan(std::size_t(begin));
            thread_local std::vector<Vec3d> images;
            if (chart_) {
              images.resize(count);
              std::transform(own.begin(), own.begin() + std::ptrdiff_t(count), images.begin(),
                             image);
              own = images;
            }
            return batches.run_grain(own, count, [&](std::size_t first, Answered answered) {
              answered.first = from + std::size_t(begin) + first;
              put(answered);
            });
          }
          Vec3d batch[batch_size];
          for (auto first = std::size_t(begin); first < std::size_t(end); first += batch_size) {
            const std::size_t n = std::min<std::size_t>(batch_size, std::size_t(end) - first);
            for (std::size_t i = 0; i < n; ++i)
              batch[i] = image(part[sorted[first + i].id]);
            Answered answered = batches.run({batch, n});
            answered.first = from;
            answered.order = &sorted[first];
            put(answered);
          }
        });
  }
}

/// The device answers slices, which are given on in parallel.
void Sampler::visit_on_device(const core::Threads& threads, std::span<const Vec3d> points,
                              const LocateOptions& options, Put put) const {
  constexpr std::size_t slice = std::size_t(1) << 20;
  const std::size_t most = std::min(slice, points.size());
  std::vector<std::int64_t> cells(most);
  std::vector<Vec3d> parametric(most);
  std::vector<std::uint8_t> reasons(most);
  for (std::size_t from = 0; from < points.size(); from += slice) {
    const std::size_t n = std::min(slice, points.size() - from);
    accel::DeviceQuery query;
    query.points = &points[from].x;
    query.count = std::int64_t(n);
    query.accuracy = options.accuracy;
    query.cells = cells.data();
    query.parametric = &parametric.data()->x;
    query.reasons = reasons.data();
    locators_->note(locators_->device()->locate(query));
    threads.parallel_for(std::int64_t(n), std::int64_t(batch_size),
                         [&](std::int64_t begin, std::int64_t end) {
                           Location locations[batch_size];
                           Reason why[batch_size];
                           std::int64_t by_reason[reason_count] = {};
                           const auto first = std::size_t(begin), count = std::size_t(end - begin);
                           for (std::size_t k = 0; k < count; ++k) {
                             locations[k] = {cells[first + k], parametric[first + k]};
                             why[k] = Reason(reasons[first + k]);
                             ++by_reason[reasons[first + k]];
                           }
                           if (counts_)
                             counts_->add(by_reason);
                           put({{locations, count}, {why, count}, from + first, nullptr});
                         });
  }
}

} // namespace insitu::query
