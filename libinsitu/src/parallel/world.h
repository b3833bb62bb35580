#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"

/// The processes of a session (design/parallel.md). Everything here but rank() and size() is
/// collective: all processes call the same functions in the same order, each from the thread that
/// called the library.
namespace insitu::parallel {

/// An error that all processes of a World throw alike, after one of them has failed.
class AgreedError : public core::Error {
public:
  AgreedError(insitu_status status, const std::string& message, bool at_root)
      : core::Error(status, message), at_root_(at_root) {}
  /// Whether this process is the one that logs.
  bool at_root() const { return at_root_; }

private:
  bool at_root_;
};

enum class Reduction { sum, least, greatest };

/// Bytes for another process, or from another process.
struct Parcel {
  int rank; ///< the receiver; of what was received the sender
  std::vector<std::byte> bytes;
};

/// What all processes must have alike, such as {"cycle", "12"}.
struct Named {
  std::string name, value;
};

/// What a process gave to a World since it was made, and how long its calls took. All is 0 in a
/// World of one process.
struct Traffic {
  std::int64_t reductions = 0, broadcasts = 0, exchanges = 0; ///< calls of all processes
  std::int64_t messages = 0, bytes = 0; ///< to other processes, with the lengths of parcels
  std::int64_t collective_bytes = 0;    ///< in reductions, broadcasts and swapped numbers
  double seconds = 0.0;                 ///< in calls, where processes wait for each other
  double processor_seconds = 0.0;       ///< of the thread that called, meanwhile
};

class World {
public:
  World() = default;
  World(const World&) = delete;
  World& operator=(const World&) = delete;
  virtual ~World() = default;

  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// How many of the processes run on this one's node, itself among them.
  virtual int on_this_node() const = 0;
  /// How many of this node's cores any of these may use; all of them, where a World knows no
  /// better.
  virtual int cores_here() const;
  bool is_root() const { return rank() == 0; }
  /// Throws core::Error (INSITU_ERROR_ORDER) if messages cannot be sent any more, or not from this
  /// thread. Not collective.
  virtual void check_usable() const {}

  /// Waits until all processes have called this, at most for so long, and returns -1; or the lowest
  /// rank of those that have not, after which the World is of no use. The root waits for `seconds`,
  /// the others for the root's word, twice as long.
  int wait_for_all(double seconds) { return size() > 1 ? do_wait_for_all(seconds) : -1; }

  /// Replaces each value by its reduction over all processes, which are given equally many. A sum
  /// wraps round.
  void reduce(std::span<std::int64_t> values, Reduction reduction);
  /// The least or the greatest of numbers, in IEEE 754's total order: -0 is less than 0, and NaN
  /// greater than all numbers. There is no sum: it would depend on an order.
  void reduce(std::span<double> values, Reduction reduction);

  /// Gives the root's bytes to all processes; all know how many there are.
  void broadcast(std::span<std::byte> bytes, int root = 0);
  /// Of text of any length.
  std::string broadcast(const std::string& text, int root = 0);

  /// Throws the same AgreedError on all processes if any of them has failed: the status of the
  /// first one that did, and its message with its rank before it. failure: of this process; null:
  /// it has none.
  void agree(const core::Error* failure);
  /// Runs the work, which is not collective and may fail, and agrees.
  void agree_after(core::FunctionRef<void()> work);

  /// Throws an AgreedError (INSITU_ERROR_ARGUMENT) on all processes unless all have the same values
  /// by the same names: the message tells the first difference, and who has which value. The call
  /// of mine() may fail, as in agree_after().
  void require_same(core::FunctionRef<std::vector<Named>()> mine);

  /// Sends each parcel to its receiver, and returns the parcels for this process in the order of
  /// their senders, those of one sender in its order. Memory is taken and agreed on before anything
  /// is sent, so a process that lacks it (AgreedError, INSITU_ERROR_MEMORY) makes nobody wait.
  std::vector<Parcel> exchange(std::span<const Parcel> parcels);

  /// Gives the bytes of all processes to the root, at most `most` of each at a time: take(rank,
  /// bytes) is called at the root alone, pieces of a process in its order.
  void gather(std::span<const std::byte> mine, std::size_t most,
              core::FunctionRef<void(int, std::span<const std::byte>)> take);

  /// Not collective; wait_for_all() is not in it.
  const Traffic& traffic() const { return traffic_; }

protected:
  struct Outgoing {
    int rank;
    std::span<const std::byte> bytes;
  };
  struct Incoming {
    int rank;
    std::span<std::byte> bytes;
  };
  virtual int do_wait_for_all(double) { return -1; }
  virtual void do_reduce(std::span<std::int64_t> values, Reduction reduction) = 0;
  virtual void do_broadcast(std::span<std::byte> bytes, int root) = 0;
  /// to[r] goes to process r; from[r] is what process r has for this one.
  virtual void swap_numbers(std::span<const std::int64_t> to, std::span<std::int64_t> from) = 0;
  /// Takes the memory of the transfer that follows. Not collective.
  virtual void prepare(std::span<const Outgoing>, std::span<const Incoming>) {}
  /// Both sides know all lengths; none is empty, and none is from a process to itself.
  virtual void transfer(std::span<const Outgoing> out, std::span<const Incoming> in) = 0;

private:
  class Call;
  void swap(std::span<const std::int64_t> to, std::span<std::int64_t> from);
  void send(std::span<const Outgoing> out, std::span<const Incoming> in);

  Traffic traffic_;
};

/// One process alone.
class SerialWorld final : public World {
public:
  int rank() const override { return 0; }
  int size() const override { return 1; }
  int on_this_node() const override { return 1; }

private:
  void do_reduce(std::span<std::int64_t>, Reduction) override {}
  void do_broadcast(std::span<std::byte>, int) override {}
  void swap_numbers(std::span<const std::int64_t> to, std::span<std::int64_t> from) override {
    from[0] = to[0];
  }
  void transfer(std::span<const Outgoing>, std::span<const Incoming>) override {}
};

} // namespace insitu::parallel
