#pragma once

#include <cmath>
#include <gtest/gtest.h>

#include "core/random.h"
#include "parallel/world.h"

/// What every World promises, whatever carries its messages.
namespace insitu::test {

inline std::string message_of(const core::Error& e) {
  return e.what();
}

/// Each process's own values, by which a receiver knows the sender and the number.
inline std::vector<std::byte> bytes_for(int from, int to, int number) {
  const auto length = std::size_t(
      1e4 * core::random_unit(5, std::uint64_t(from * 100 + to), std::uint64_t(number)));
  std::vector<std::byte> bytes(number % 3 == 1 ? 0 : length);
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = std::byte(std::size_t(from) * 7 + std::size_t(to) * 13 + std::size_t(number) + i);
  return bytes;
}

inline void check_reductions(parallel::World& w) {
  std::int64_t sums[] = {w.rank(), 1, std::int64_t(1) << 40};
  w.reduce(std::span(sums), parallel::Reduction::sum);
  const std::int64_t n = w.size();
  EXPECT_EQ(sums[0], n * (n - 1) / 2);
  EXPECT_EQ(sums[1], n);
  EXPECT_EQ(sums[2], n << 40);
  std::int64_t extremes[] = {-w.rank(), INT64_MIN + w.rank()};
  w.reduce(std::span(extremes), parallel::Reduction::least);
  EXPECT_EQ(extremes[0], 1 - n);
  EXPECT_EQ(extremes[1], INT64_MIN);
  double lows[] = {w.rank() == 0 ? 0.0 : -0.0, 1e-300 * (w.rank() + 1), -1.0 * w.rank(),
                   w.rank() == 1 ? HUGE_VAL : 3.0};
  w.reduce(std::span(lows), parallel::Reduction::least);
  EXPECT_EQ(std::signbit(lows[0]), n > 1);
  EXPECT_EQ(lows[1], 1e-300);
  EXPECT_EQ(lows[2], double(1 - n));
  EXPECT_EQ(lows[3], 3.0);
  double highs[] = {w.rank() == n - 1 ? std::nan("") : 5.0, -1e300 / (w.rank() + 1), -HUGE_VAL};
  w.reduce(std::span(highs), parallel::Reduction::greatest);
  EXPECT_TRUE(std::isnan(highs[0]));
  EXPECT_EQ(highs[1], -1e300 / double(n));
  EXPECT_EQ(highs[2], -HUGE_VAL);
}

inline void check_broadcasts(parallel::World& w) {
  for (int root = 0; root < w.size(); ++root) {
    const std::string mine = w.rank() == root ? "said by " + std::to_string(root) : "unheard";
    EXPECT_EQ(w.broadcast(mine, root), "said by " + std::to_string(root));
  }
  EXPECT_EQ(w.broadcast(std::string()), "");
}

/// Each process fails in turn, and then several do.
inline void check_agreement(parallel::World& w) {
  w.agree(nullptr);
  const auto expect = [&](insitu_status status, int first, const std::string& said,
                          const core::Error* mine) {
    try {
      w.agree(mine);
      ADD_FAILURE() << "process " << w.rank() << " heard nothing of process " << first;
    } catch (const parallel::AgreedError& e) {
      EXPECT_EQ(e.status(), status);
      EXPECT_EQ(e.at_root(), w.rank() == 0);
      const std::string who =
          "process " + std::to_string(first) + " of " + std::to_string(w.size()) + ": ";
      EXPECT_EQ(message_of(e), w.size() > 1 ? who + said : said);
    }
  };
  for (int failing = 0; failing < w.size(); ++failing) {
    const core::Error error(INSITU_ERROR_FIELD, "no field 'q' on " + std::to_string(failing));
    expect(INSITU_ERROR_FIELD, failing, "no field 'q' on " + std::to_string(failing),
           w.rank() == failing ? &error : nullptr);
  }
  const core::Error low(INSITU_ERROR_MESH, "low"), high(INSITU_ERROR_FILE, "high");
  expect(INSITU_ERROR_MESH, 0, "low", w.rank() == 0 ? &low : &high);
  const core::Error endless(INSITU_ERROR_MESH, std::string(100000, 'x'));
  if (w.size() > 1)
    expect(INSITU_ERROR_MESH, w.size() - 1, std::string(4095, 'x'),
           w.rank() == w.size() - 1 ? &endless : nullptr);
  EXPECT_THROW(w.agree_after([&] {
    if (w.rank() == w.size() - 1)
      throw std::bad_alloc();
  }),
               parallel::AgreedError);
  w.agree_after([] {});
}

inline void check_sameness(parallel::World& w) {
  using parallel::Named;
  const std::vector<Named> all = {{"cycle", "12"}, {"mesh", "'box'"}, {"", ""}};
  w.require_same([&] { return all; });
  w.require_same([] { return std::vector<Named>(); });
  if (w.size() == 1)
    return;
  const auto expect = [&](const std::vector<Named>& mine, const std::string& message) {
    try {
      w.require_same([&] { return mine; });
      ADD_FAILURE() << "process " << w.rank() << " saw no difference";
    } catch (const parallel::AgreedError& e) {
      EXPECT_EQ(e.status(), INSITU_ERROR_ARGUMENT);
      EXPECT_EQ(message_of(e), message);
    }
  };
  const int last = w.size() - 1;
  const std::string who = "process " + std::to_string(last) + " of " + std::to_string(w.size());
  std::vector<Named> mine = all;
  if (w.rank() == last)
    mine[0].value = "13";
  expect(mine, "processes differ: cycle 12 on process 0, cycle 13 on " + who);
  mine = all;
  if (w.rank() == last)
    mine.resize(1);
  expect(mine, "processes differ: mesh 'box' on process 0, nothing further on " + who);
  mine = all;
  if (w.rank() == 0)
    mine.resize(1);
  const std::string first = "process 1 of " + std::to_string(w.size());
  expect(mine, "processes differ: nothing further on process 0, mesh 'box' on " + first);
}

/// Parcels of many lengths, also none, between all processes and to oneself; then one process is
/// sent all there is, then nothing goes anywhere.
inline void check_exchange(parallel::World& w) {
  const int n = w.size();
  const auto count = [&](int from, int to) { return (from * 3 + to * 5) % 4; };
  for (int round = 0; round < 3; ++round) {
    std::vector<parallel::Parcel> parcels;
    for (int to = n - 1; to >= 0; --to)
      for (int i = 0; i < count(w.rank(), to); ++i)
        parcels.push_back({to, bytes_for(w.rank(), to, i)});
    const std::vector<parallel::Parcel> got = w.exchange(parcels);
    std::size_t next = 0;
    for (int from = 0; from < n; ++from)
      for (int i = 0; i < count(from, w.rank()); ++i, ++next) {
        ASSERT_LT(next, got.size());
        EXPECT_EQ(got[next].rank, from);
        EXPECT_EQ(got[next].bytes, bytes_for(from, w.rank(), i)) << from << " " << i;
      }
    EXPECT_EQ(next, got.size());
  }
  std::vector<parallel::Parcel> to_last;
  for (int i = 0; i < 50; ++i)
    to_last.push_back({n - 1, bytes_for(w.rank(), n - 1, 3 * i)});
  EXPECT_EQ(w.exchange(to_last).size(), w.rank() == n - 1 ? std::size_t(50 * n) : 0u);
  EXPECT_TRUE(w.exchange({}).empty());
}

/// In pieces that end anywhere; some processes have nothing.
inline void check_gather(parallel::World& w) {
  const auto bytes_of = [&](int rank) {
    return rank % 2 ? bytes_for(rank, 0, 3) : std::vector<std::byte>();
  };
  for (const std::size_t most : {std::size_t(1000), std::size_t(1) << 20}) {
    std::vector<std::vector<std::byte>> got(std::size_t(w.size()));
    w.gather(bytes_of(w.rank()), most, [&](int rank, std::span<const std::byte> piece) {
      EXPECT_TRUE(w.is_root());
      EXPECT_LE(piece.size(), most);
      got[std::size_t(rank)].insert(got[std::size_t(rank)].end(), piece.begin(), piece.end());
    });
    for (int r = 0; r < w.size() && w.is_root(); ++r)
      EXPECT_EQ(got[std::size_t(r)], bytes_of(r)) << r;
  }
}

/// What a process sent is counted where it sends it, and nothing is in a World of one process.
inline void check_traffic(parallel::World& w) {
  const parallel::Traffic before = w.traffic();
  const int n = w.size();
  std::vector<parallel::Parcel> parcels;
  for (int to = 0; to < n; ++to) {
    parcels.push_back({to, std::vector<std::byte>(100)});
    parcels.push_back({to, {}});
  }
  w.exchange(parcels);
  std::int64_t three[3] = {};
  w.reduce(std::span(three), parallel::Reduction::sum);
  const std::string word = w.broadcast(std::string("word"), n - 1);
  const parallel::Traffic& now = w.traffic();
  const std::int64_t others = n - 1, several = n > 1;
  EXPECT_EQ(now.exchanges - before.exchanges, several);
  EXPECT_EQ(now.reductions - before.reductions, 4 * several); // an exchange agrees three times
  EXPECT_EQ(now.broadcasts - before.broadcasts, 2 * several); // the length, and the word
  // To each of the others two lengths in one message, and the parcel that is not empty.
  EXPECT_EQ(now.messages - before.messages, 2 * others);
  EXPECT_EQ(now.bytes - before.bytes, (2 * 8 + 100) * others);
  EXPECT_EQ(now.collective_bytes - before.collective_bytes,
            several * (3 * 8 + 3 * 8 + 8 * others + (w.rank() == n - 1 ? 8 + 4 : 0)));
  EXPECT_GE(now.seconds, before.seconds);
  EXPECT_EQ(now.processor_seconds > 0, n > 1);
}

inline void check_all(parallel::World& w) {
  check_reductions(w);
  check_broadcasts(w);
  check_agreement(w);
  check_sameness(w);
  check_exchange(w);
  check_gather(w);
  check_traffic(w);
}

} // namespace insitu::test
