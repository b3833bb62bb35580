#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "advect/field/mesh_velocity.h"
#include "advect/integrate/integrate.h"
#include "advect/lanes/lane_kernels.h"
#include "query/elsewhere.h"

/// Many particles at a time on one thread: each goes on until it needs a velocity, then all
/// velocities are found together. The answers are those of particles one by one, to the bit.
namespace insitu::advect {

/// The velocity of one of them, which waits for its answers: see WaitingField.
class LaneVelocity : public MeshVelocity {
public:
  using MeshVelocity::MeshVelocity;

  void ask(const math::Vec3d& x, double t) {
    x_ = x;
    t_ = t;
    crosses_ = false;
  }
  void ask_crossing(const math::Vec3d& x, const math::Vec3d& towards, double t) {
    x_ = x;
    t_ = t;
    beyond_ = beyond(x, towards, t);
    crosses_ = true;
  }
  /// Throw query::Elsewhere where the question took a point that another process may hold.
  Crossed answer_crossing() {
    check_here();
    return crossed(x_, beyond_at_);
  }
  Sampled answer(math::Vec3d& v) {
    check_here();
    v = v_;
    return sampled_;
  }

private:
  friend class LaneBatch;
  void check_here() {
    if (elsewhere_) [[unlikely]] {
      const query::Elsewhere at = *elsewhere_;
      elsewhere_.reset();
      throw at;
    }
  }
  /// Does this lane's part of an answer; what is thrown of a point elsewhere waits for the lane.
  template <class Work>
  void note_elsewhere(Work&& work) {
    try {
      work();
    } catch (const query::Elsewhere& at) {
      elsewhere_ = at;
    }
  }

  std::optional<query::Elsewhere> elsewhere_;
  math::Vec3d x_, v_;
  double t_ = 0.0;
  bool crosses_ = false; ///< a cell is asked for, not a velocity
  math::Vec3d beyond_;   ///< the place whose cell it is
  query::Location beyond_at_;
  KeptCell* tried_ = nullptr; ///< that which was tried last
  int walked_ = 0;
  Sampled sampled_ = Sampled::outside;
};

/// Answers what lanes wait for: cells that they keep are tried many at a time; what is left goes
/// through the sampler as a batch. One object serves one thread.
class LaneBatch {
public:
  static constexpr int lane_count = 64;

  explicit LaneBatch(const query::Sampler& sampler) : sampler_(&sampler) {}

  /// All of the same sampler, fields and times.
  void answer(std::span<LaneVelocity* const> lanes);

private:
  struct Asked {
    LaneVelocity* lane;
    KeptCell* cell;
  };
  struct Guessed {
    LaneVelocity* lane;
    std::int64_t cell;
  };
  void ask(LaneVelocity& lane, KeptCell& cell);
  void find_sound();
  void ask_guessed();
  void try_cells();
  void try_next();
  query::Location found_elsewhere(const math::Vec3d& x, double alpha) const;
  void locate();

  const query::Sampler* sampler_;
  std::vector<Asked> asked_[5];                     ///< by shape
  std::vector<query::SoundCells::Asked> unsure_[5]; ///< cells of these, likewise
  std::vector<LaneVelocity*> missed_, lost_, crossing_;
  std::vector<Guessed> guessed_;
  std::vector<LaneQuery> queries_;
  std::vector<LaneAnswer> answers_;
  std::vector<math::Vec3d> points_;
  std::vector<query::Location> locations_;
};

/// Runs the integrations of items [begin, end), some at a time: start(item, slot, velocity) gives
/// one of them (its State, and what else it needs by reference, are the caller's, by slot, of which
/// there are lane_count), and finished(item, slot, velocity, stepping) is called at its end. make()
/// adds a LaneVelocity to a deque.
template <class Make, class Start, class Finished>
void run_lanes(const query::Sampler& sampler, std::int64_t begin, std::int64_t end, Make&& make,
               Start&& start, Finished&& finished) {
  struct Lane {
    std::int64_t item = 0;
    Stepping stepping;
  };
  const auto count = std::size_t(std::min<std::int64_t>(LaneBatch::lane_count, end - begin));
  std::deque<LaneVelocity> velocities;
  for (std::size_t l = 0; l < count; ++l)
    make(velocities);
  std::vector<Lane> lanes(count);
  std::vector<LaneVelocity*> waiting;
  LaneBatch batch(sampler);
  std::int64_t next = begin;
  do {
    waiting.clear();
    for (std::size_t l = 0; l < count; ++l) {
      Lane& lane = lanes[l];
      for (;;) {
        if (!lane.stepping) {
          if (next == end)
            break;
          lane.item = next++;
          lane.stepping = start(lane.item, l, velocities[l]);
          if (!lane.stepping)
            continue; // nothing to do
        }
        lane.stepping.resume();
        if (!lane.stepping.done()) {
          waiting.push_back(&velocities[l]);
          break;
        }
        finished(lane.item, l, velocities[l], lane.stepping);
        lane.stepping = {};
      }
    }
    batch.answer(waiting);
  } while (!waiting.empty());
}

} // namespace insitu::advect
