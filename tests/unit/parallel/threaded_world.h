#pragma once

#include <barrier>
#include <exception>
#include <thread>
#include <vector>

#include "parallel/world.h"

/// Processes as threads, on the code paths of processes.
namespace insitu::test {

/// Whether this thread is between processes: what is taken there is the test's own.
inline thread_local bool is_exchanging = false;

class ThreadedWorld final : public parallel::World {
public:
  /// What the threads of one World share.
  struct Shared {
    explicit Shared(int processes)
        : size(processes), met(processes), values(std::size_t(processes)),
          bytes(std::size_t(processes)), out(std::size_t(processes)) {}
    int size;
    std::barrier<> met;
    std::vector<std::span<const std::int64_t>> values;
    std::vector<std::span<const std::byte>> bytes;
    std::vector<std::span<const Outgoing>> out;
  };
  ThreadedWorld(Shared& shared, int rank) : shared_(shared), rank_(rank) {}

  int rank() const override { return rank_; }
  int size() const override { return shared_.size; }
  int on_this_node() const override { return shared_.size; }

private:
  void meet() { shared_.met.arrive_and_wait(); }
  void do_reduce(std::span<std::int64_t> values, parallel::Reduction reduction) override {
    is_exchanging = true;
    shared_.values[std::size_t(rank_)] = values;
    meet();
    std::vector<std::int64_t> all(shared_.values[0].begin(), shared_.values[0].end());
    for (std::size_t r = 1; r < shared_.values.size(); ++r)
      for (std::size_t i = 0; i < all.size(); ++i) {
        const std::int64_t v = shared_.values[r][i];
        all[i] = reduction == parallel::Reduction::sum
                     ? std::int64_t(std::uint64_t(all[i]) + std::uint64_t(v))
                 : reduction == parallel::Reduction::least ? std::min(all[i], v)
                                                           : std::max(all[i], v);
      }
    meet();
    std::copy(all.begin(), all.end(), values.begin());
    is_exchanging = false;
  }
  void do_broadcast(std::span<std::byte> bytes, int root) override {
    shared_.bytes[std::size_t(rank_)] = bytes;
    meet();
    if (rank_ != root)
      std::copy(shared_.bytes[std::size_t(root)].begin(), shared_.bytes[std::size_t(root)].end(),
                bytes.begin());
    meet();
  }
  void swap_numbers(std::span<const std::int64_t> to, std::span<std::int64_t> from) override {
    shared_.values[std::size_t(rank_)] = to;
    meet();
    for (std::size_t r = 0; r < from.size(); ++r)
      from[r] = shared_.values[r][std::size_t(rank_)];
    meet();
  }
  void transfer(std::span<const Outgoing> out, std::span<const Incoming> in) override {
    is_exchanging = true;
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
    is_exchanging = false;
  }

  Shared& shared_;
  int rank_;
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
