#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "parallel/world.h"

/// Processes as threads, on the code paths of processes.
namespace insitu::test {

/// Where threads wait for each other, asleep: std::barrier yields before it sleeps, which takes
/// minutes where many threads share few cores.
class Meeting {
public:
  explicit Meeting(int threads) : threads_(threads) {}
  void arrive_and_wait() {
    std::unique_lock lock(mutex_);
    ++waiting_;
    const std::uint64_t mine = round_;
    if (!end_if_complete())
      met_.wait(lock, [&] { return round_ != mine; });
  }
  void arrive_and_drop() {
    const std::lock_guard lock(mutex_);
    --threads_;
    end_if_complete();
  }

private:
  bool end_if_complete() {
    if (waiting_ < threads_)
      return false;
    waiting_ = 0;
    ++round_;
    met_.notify_all();
    return true;
  }

  std::mutex mutex_;
  std::condition_variable met_;
  int threads_, waiting_ = 0;
  std::uint64_t round_ = 0;
};

/// Whether this thread is between processes: what is taken there is the test's own.
inline thread_local bool is_exchanging = false;
struct Exchanging {
  Exchanging() { is_exchanging = true; }
  ~Exchanging() { is_exchanging = false; }
};

class ThreadedWorld final : public parallel::World {
public:
  /// What the threads of one World share. Who has met the others twice since it wrote what is here
  /// knows that they have read it, so that calls take turns with two places.
  struct Shared {
    struct Place {
      std::vector<std::int64_t> values;
      std::vector<std::byte> bytes;
    };
    explicit Shared(int processes)
        : size(processes), met(processes), places{std::vector<Place>(std::size_t(processes)),
                                                  std::vector<Place>(std::size_t(processes))},
          out(std::size_t(processes)) {}
    int size;
    Meeting met;
    std::vector<Place> places[2]; ///< [turn][process]
    std::vector<std::span<const Outgoing>> out;
  };
  ThreadedWorld(Shared& shared, int rank) : shared_(shared), rank_(rank) {}

  int rank() const override { return rank_; }
  int size() const override { return shared_.size; }
  int on_this_node() const override { return shared_.size; }

private:
  void meet() { shared_.met.arrive_and_wait(); }
  /// Where all write for this call.
  std::vector<Shared::Place>& next() { return shared_.places[turn_ ^= 1]; }
  void do_reduce(std::span<std::int64_t> values, parallel::Reduction reduction) override {
    const Exchanging now;
    std::vector<Shared::Place>& all = next();
    all[std::size_t(rank_)].values.assign(values.begin(), values.end());
    meet();
    std::copy(all[0].values.begin(), all[0].values.end(), values.begin());
    for (std::size_t r = 1; r < all.size(); ++r)
      for (std::size_t i = 0; i < values.size(); ++i) {
        const std::int64_t v = all[r].values[i];
        values[i] = reduction == parallel::Reduction::sum
                        ? std::int64_t(std::uint64_t(values[i]) + std::uint64_t(v))
                    : reduction == parallel::Reduction::least ? std::min(values[i], v)
                                                              : std::max(values[i], v);
      }
  }
  void do_broadcast(std::span<std::byte> bytes, int root) override {
    const Exchanging now;
    Shared::Place& place = next()[std::size_t(root)];
    if (rank_ == root)
      place.bytes.assign(bytes.begin(), bytes.end());
    meet();
    if (rank_ != root)
      std::copy(place.bytes.begin(), place.bytes.end(), bytes.begin());
  }
  void swap_numbers(std::span<const std::int64_t> to, std::span<std::int64_t> from) override {
    const Exchanging now;
    std::vector<Shared::Place>& all = next();
    all[std::size_t(rank_)].values.assign(to.begin(), to.end());
    meet();
    for (std::size_t r = 0; r < from.size(); ++r)
      from[r] = all[r].values[std::size_t(rank_)];
  }
  void transfer(std::span<const Outgoing> out, std::span<const Incoming> in) override {
    const Exchanging now;
    shared_.out[std::size_t(rank_)] = out;
    meet();
    std::vector<std::size_t> next(std::size_t(shared_.size));
    for (const Incoming& i : in) {
      const auto& sent = shared_.out[std::size_t(i.rank)];
      std::size_t& at = next[std::size_t(i.rank)];
      while (sent[at].rank != rank_)
        ++at;
      std::copy(sent[at].bytes.begin(), sent[at].bytes.end(), i.bytes.begin());
      ++at;
    }
    meet();
  }

  Shared& shared_;
  int rank_;
  unsigned turn_ = 0;
};

/// Runs body(world) as so many processes. They end before this returns; what one of them throws is
/// thrown again, that of the lowest rank.
template <class Body>
void run_processes(int size, const Body& body) {
  ThreadedWorld::Shared shared(size);
  std::vector<std::exception_ptr> thrown(std::size_t(size), nullptr);
  {
    std::vector<std::jthread> threads;
    for (int r = 0; r < size; ++r)
      threads.emplace_back([&, r] {
        try {
          ThreadedWorld world(shared, r);
          body(world);
        } catch (...) {
          thrown[std::size_t(r)] = std::current_exception();
          shared.met.arrive_and_drop(); // the others need not wait for it
        }
      });
  }
  for (const std::exception_ptr& e : thrown)
    if (e)
      std::rethrow_exception(e);
}

} // namespace insitu::test
