#pragma once

#include <cstdint>
#include <span>

#include "query/locate_counts.h"
#include "query/location.h"

namespace insitu::query {

struct DualPlaces;
struct PointQuery;

/// Answers the batches of one thread by a locator.
class Batches {
public:
  virtual ~Batches() = default;
  /// The answers of at most batch_size points; valid until the next call.
  virtual Answered run(std::span<const math::Vec3d> points) = 0;
  /// The answers of points that follow each other, the first `count`, at most
  /// GuessedBatches::grain; the points behind them are next, and may be asked for early.
  /// put(first, answered): of the points from `first` on, valid until the next call of it.
  using Put = core::FunctionRef<void(std::size_t first, const Answered& answered)>;
  virtual void run_grain(std::span<const math::Vec3d> points, std::size_t count, Put put);
};

/// How the points of a committed mesh find their cells: by the tree, by rays, by their places on a
/// lattice, on a device. The commit chooses it, and a Sampler asks it. All locators give the same
/// answers but in `fast` by rays. All calls are const and thread-safe; what they refer to must stay
/// as it is until the next commit.
class PointLocator {
public:
  virtual ~PointLocator() = default;

  /// Answers one point without the tree, if the point's place tells its cell, or that it has none.
  /// False: the tree has to be asked, and guess may be a likely cell. hint: a cell to look at
  /// first, or -1. at comes in as outside.
  virtual bool find(const math::Vec3d& /*p*/, std::int64_t hint, Location& /*at*/,
                    Reason& /*reason*/, std::int64_t& guess) const {
    guess = hint;
    return false;
  }

  /// Gives `ask` what answers batches on the calling thread, as long as it runs.
  using Ask = core::FunctionRef<void(Batches& batches)>;
  virtual void with_batches(const PointQuery& query, Ask ask) const = 0;

  /// Answers a whole call in another way than by batches, as a device does, and counts it. False:
  /// not this call.
  virtual bool visit(const core::Threads& /*threads*/, std::span<const math::Vec3d> /*points*/,
                     const LocateOptions& /*options*/, LocateCounts* /*counts*/,
                     PutAnswers /*put*/) const {
    return false;
  }

  /// Whether a cell that is proven to hold a point is this locator's answer, so that a bundle of
  /// rays may find it in its own way.
  virtual bool answers_by_proof(const LocateOptions&) const { return true; }

  /// Where the cells of an adaptive mesh's dual lie; null for all other meshes.
  virtual const DualPlaces* dual() const { return nullptr; }
};

} // namespace insitu::query
