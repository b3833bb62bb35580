#include "parallel/world.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <exception>
#include <limits>
#include <new>
#include <optional>
#include <time.h>
#include <unistd.h>

namespace insitu::parallel {

namespace {

constexpr std::size_t longest_message = 4096;

/// Integers that ascend as the numbers do, and back.
std::int64_t ordered(double value) {
  const auto bits = std::bit_cast<std::int64_t>(
      value != value ? std::numeric_limits<double>::quiet_NaN() : value);
  return bits < 0 ? bits ^ std::numeric_limits<std::int64_t>::max() : bits;
}
double number_of(std::int64_t key) {
  return std::bit_cast<double>(key < 0 ? key ^ std::numeric_limits<std::int64_t>::max() : key);
}

/// FNV-1a.
std::uint64_t hash_of(const std::string& text, std::uint64_t hash) {
  for (const char c : text)
    hash = (hash ^ std::uint8_t(c)) * 0x100000001b3u;
  return (hash ^ 0xff) * 0x100000001b3u; // an end, which no byte of text is
}
std::uint64_t hash_of(const std::vector<Named>& all) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const Named& one : all)
    hash = hash_of(one.value, hash_of(one.name, hash));
  return hash;
}

std::string numbered(int rank, int size) {
  return "process " + std::to_string(rank) + " of " + std::to_string(size);
}

std::span<std::byte> bytes_of(std::string& text) {
  return std::as_writable_bytes(std::span(text.data(), text.size()));
}

/// Does the work; if it throws, failed(status, message) before the exception ends.
template <class Failed>
void attempt(core::FunctionRef<void()> work, Failed&& failed) {
  try {
    work();
  } catch (const core::Error& e) {
    failed(e.status(), e.what());
  } catch (const std::bad_alloc&) {
    failed(INSITU_ERROR_MEMORY, "out of memory");
  } catch (const std::exception& e) {
    failed(INSITU_ERROR_INTERNAL, e.what());
  }
}

/// How work ended on this process. It takes no memory, which may be what is lacking.
struct Outcome {
  explicit Outcome(core::FunctionRef<void()> work) {
    attempt(work, [this](insitu_status with, const char* what) { failed(with, what); });
  }
  void failed(insitu_status with, const char* what) {
    status = with;
    std::strncpy(said, what, sizeof said - 1);
  }

  insitu_status status = INSITU_OK;
  char said[longest_message] = {};
};

/// status: of this process, with what it says; INSITU_OK: it has not failed.
void agree_on(World& world, insitu_status status, const char* what) {
  const int size = world.size();
  if (size == 1) {
    if (status != INSITU_OK)
      throw AgreedError(status, what, true);
    return;
  }
  std::int64_t first = status != INSITU_OK ? world.rank() : size;
  world.reduce(std::span(&first, 1), Reduction::least);
  if (first == size)
    return;
  // What it said is cut, so that every process has the room for it.
  char said[longest_message] = {};
  std::int64_t agreed = status;
  if (world.rank() == first)
    std::strncpy(said, what, sizeof said - 1);
  world.broadcast(std::as_writable_bytes(std::span(&agreed, 1)), int(first));
  world.broadcast(std::as_writable_bytes(std::span(said)), int(first));
  throw AgreedError(insitu_status(agreed), numbered(int(first), size) + ": " + said,
                    world.is_root());
}

double seconds_by(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

} // namespace

/// The time of one call of a World of several processes.
class World::Call {
public:
  explicit Call(Traffic& traffic) : traffic_(traffic) {}
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
  ~Call() {
    traffic_.seconds += seconds_by(CLOCK_MONOTONIC) - seconds_;
    traffic_.processor_seconds += seconds_by(CLOCK_THREAD_CPUTIME_ID) - processor_seconds_;
  }

private:
  Traffic& traffic_;
  double seconds_ = seconds_by(CLOCK_MONOTONIC);
  double processor_seconds_ = seconds_by(CLOCK_THREAD_CPUTIME_ID);
};

int World::cores_here() const {
  return int(sysconf(_SC_NPROCESSORS_ONLN));
}

void World::reduce(std::span<std::int64_t> values, Reduction reduction) {
  if (size() == 1)
    return;
  const Call call(traffic_);
  ++traffic_.reductions;
  traffic_.collective_bytes += std::int64_t(values.size_bytes());
  do_reduce(values, reduction);
}

void World::broadcast(std::span<std::byte> bytes, int root) {
  if (size() == 1 || bytes.empty())
    return;
  const Call call(traffic_);
  ++traffic_.broadcasts;
  if (rank() == root)
    traffic_.collective_bytes += std::int64_t(bytes.size());
  do_broadcast(bytes, root);
}

void World::swap(std::span<const std::int64_t> to, std::span<std::int64_t> from) {
  if (size() == 1)
    return swap_numbers(to, from);
  const Call call(traffic_);
  ++traffic_.exchanges;
  traffic_.collective_bytes += std::int64_t(to.size_bytes() - sizeof to[0]);
  swap_numbers(to, from);
}

void World::send(std::span<const Outgoing> out, std::span<const Incoming> in) {
  if (size() == 1)
    return;
  const Call call(traffic_);
  traffic_.messages += std::int64_t(out.size());
  for (const Outgoing& o : out)
    traffic_.bytes += std::int64_t(o.bytes.size());
  transfer(out, in);
}

void World::reduce(std::span<double> values, Reduction reduction) {
  if (reduction == Reduction::sum)
    throw core::Error(INSITU_ERROR_INTERNAL, "a sum of doubles over processes has no order");
  if (size() == 1)
    return;
  std::int64_t few[64]; // as most calls have: no memory to agree on
  std::vector<std::int64_t> many;
  std::span<std::int64_t> keys(few, std::min(values.size(), std::size(few)));
  if (values.size() > std::size(few)) {
    agree_after([&] { many.resize(values.size()); });
    keys = many;
  }
  std::transform(values.begin(), values.end(), keys.begin(), ordered);
  reduce(keys, reduction);
  std::transform(keys.begin(), keys.end(), values.begin(), number_of);
}

std::string World::broadcast(const std::string& text, int root) {
  std::int64_t length = rank() == root ? std::int64_t(text.size()) : 0;
  broadcast(std::as_writable_bytes(std::span(&length, 1)), root);
  std::string all;
  const auto take = [&] { all = rank() == root ? text : std::string(std::size_t(length), '\0'); };
  if (std::size_t(length) > all.capacity())
    agree_after(take);
  else
    take();
  broadcast(bytes_of(all), root);
  return all;
}

void World::agree(const core::Error* failure) {
  agree_on(*this, failure ? failure->status() : INSITU_OK, failure ? failure->what() : "");
}

void World::agree_after(core::FunctionRef<void()> work) {
  if (size() == 1) // whose message is not cut
    return attempt(work, [](insitu_status status, const char* what) {
      throw AgreedError(status, what, true);
    });
  const Outcome outcome(work);
  agree_on(*this, outcome.status, outcome.said);
}

void World::require_same(core::FunctionRef<std::vector<Named>()> make) {
  if (size() == 1)
    return;
  std::vector<Named> mine;
  const Outcome outcome([&] { mine = make(); });
  const auto hash = std::bit_cast<std::int64_t>(hash_of(mine));
  const bool has_failed = outcome.status != INSITU_OK;
  std::int64_t least[] = {hash, ~hash, has_failed ? 0 : 1};
  reduce(std::span(least), Reduction::least);
  if (least[2] == 0)
    agree_on(*this, outcome.status, outcome.said);
  if (least[0] == ~least[1])
    return;
  // The root's values, one after the other, until one differs somewhere.
  std::int64_t count = std::int64_t(mine.size());
  broadcast(std::as_writable_bytes(std::span(&count, 1)));
  for (std::int64_t i = 0;; ++i) {
    const bool here = i < std::int64_t(mine.size());
    const Named own = here ? mine[std::size_t(i)] : Named{"nothing further", ""};
    Named root = i < count ? own : Named{"nothing further", ""};
    root.name = broadcast(root.name);
    root.value = broadcast(root.value);
    std::int64_t first = own.name == root.name && own.value == root.value ? size() : rank();
    reduce(std::span(&first, 1), Reduction::least);
    if (first < size()) {
      const std::string name = broadcast(own.name, int(first));
      const std::string value = broadcast(own.value, int(first));
      const auto told = [](const std::string& n, const std::string& v) {
        return v.empty() ? n : n + " " + v;
      };
      throw AgreedError(INSITU_ERROR_ARGUMENT,
                        "processes differ: " + told(root.name, root.value) + " on process 0, " +
                            told(name, value) + " on " + numbered(int(first), size()),
                        is_root());
    }
    if (i >= count)
      return; // two lists of one hash, which differ nowhere
  }
}

std::vector<Parcel> World::exchange(std::span<const Parcel> parcels) {
  const auto processes = std::size_t(size());
  std::vector<std::int64_t> to, from;
  std::vector<std::vector<std::int64_t>> lengths_out, lengths_in;
  std::vector<Parcel> received;
  std::vector<Outgoing> out;
  std::vector<Incoming> in;
  // How many parcels, how long they are, then the parcels: each step's memory before its data.
  agree_after([&] {
    to.resize(processes);
    from.resize(processes);
    lengths_out.resize(processes);
    lengths_in.resize(processes);
    for (const Parcel& p : parcels)
      if (p.rank >= 0 && p.rank < size())
        ++to[std::size_t(p.rank)];
      else
        throw core::Error(INSITU_ERROR_INTERNAL, "a parcel for process " + std::to_string(p.rank));
  });
  swap(to, from);
  agree_after([&] {
    for (const Parcel& p : parcels)
      lengths_out[std::size_t(p.rank)].push_back(std::int64_t(p.bytes.size()));
    for (std::size_t r = 0; r < processes; ++r) {
      lengths_in[r].resize(std::size_t(from[r]));
      if (int(r) == rank())
        lengths_in[r] = lengths_out[r];
      else if (from[r] > 0)
        in.push_back({int(r), std::as_writable_bytes(std::span(lengths_in[r]))});
      if (int(r) != rank() && to[r] > 0)
        out.push_back({int(r), std::as_bytes(std::span(lengths_out[r]))});
    }
    prepare(out, in);
  });
  send(out, in);
  agree_after([&] {
    out.clear();
    in.clear();
    for (std::size_t r = 0; r < processes; ++r)
      for (const std::int64_t length : lengths_in[r])
        received.push_back({int(r), std::vector<std::byte>(std::size_t(length))});
    for (Parcel& p : received)
      if (p.rank != rank() && !p.bytes.empty())
        in.push_back({p.rank, p.bytes});
    std::size_t own = 0; // where the parcels to this process itself begin
    while (own < received.size() && received[own].rank < rank())
      ++own;
    for (const Parcel& p : parcels)
      if (p.rank == rank())
        received[own++].bytes = p.bytes;
      else if (!p.bytes.empty())
        out.push_back({p.rank, p.bytes});
    prepare(out, in);
  });
  send(out, in);
  return received;
}

void World::gather(std::span<const std::byte> mine, std::size_t most,
                   core::FunctionRef<void(int, std::span<const std::byte>)> take) {
  std::int64_t rounds = std::int64_t((mine.size() + most - 1) / most);
  reduce(std::span(&rounds, 1), Reduction::greatest);
  for (; rounds > 0; --rounds) {
    const std::size_t now = std::min(most, mine.size());
    std::vector<Parcel> parcels;
    agree_after([&] {
      if (now > 0)
        parcels.push_back({0, {mine.begin(), mine.begin() + std::ptrdiff_t(now)}});
    });
    mine = mine.subspan(now);
    const std::vector<Parcel> received = exchange(parcels);
    agree_after([&] {
      for (const Parcel& p : received)
        take(p.rank, p.bytes);
    });
  }
}

} // namespace insitu::parallel
