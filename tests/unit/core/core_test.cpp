#include <atomic>
#include <cfenv>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/float_environment.h"
#include "core/log.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "core/random.h"
#include "core/status.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

using namespace insitu::core;

TEST(Memory, CountsByPurposeAndKeepsThePeak) {
  Memory memory;
  {
    Buffer<double> a(memory, INSITU_MEMORY_TREE);
    a.resize_discard(1000);
    EXPECT_EQ(memory.current(INSITU_MEMORY_TREE), 8000);
    a.resize_discard(10); // kept for reuse
    EXPECT_EQ(memory.current(), 8000);
    a.shrink();
    EXPECT_EQ(memory.current(), 80);
    Buffer<char> b(memory, INSITU_MEMORY_FRAME);
    b.resize_discard(100);
    EXPECT_EQ(memory.current(), 180);
    EXPECT_EQ(memory.current(INSITU_MEMORY_FRAME), 100);
  }
  EXPECT_EQ(memory.current(), 0);
  EXPECT_GE(memory.peak(), 8000);
}

TEST(Memory, BufferKeepsItsItemsWhenItGrows) {
  Memory memory;
  Buffer<int> b(memory, INSITU_MEMORY_QUERY);
  for (int i = 0; i < 1000; ++i)
    b.push_back(i);
  ASSERT_EQ(b.size(), 1000u);
  for (int i = 0; i < 1000; ++i)
    ASSERT_EQ(b[std::size_t(i)], i);
  const int* before = b.data();
  Buffer<int> moved(std::move(b));
  EXPECT_EQ(moved.data(), before);
  EXPECT_EQ(b.size(), 0u); // NOLINT: the moved-from state is part of the contract
}

TEST(Memory, RefusesWhatCannotBeHad) {
  try {
    allocate_bytes(std::numeric_limits<std::size_t>::max() - 4096);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_MEMORY);
    EXPECT_NE(std::string(e.what()).find("bytes"), std::string::npos);
  }
}

TEST(Parallel, CoversEveryItemOnceInRangesThatDoNotDependOnThreads) {
  for (const int count : {1, 2, 4}) {
    const Threads threads(count);
    EXPECT_LE(threads.count(), count);
    std::vector<std::atomic<int>> seen(10007);
    std::atomic<bool> aligned{true};
    threads.parallel_for(10007, 100, [&](std::int64_t begin, std::int64_t end) {
      aligned = aligned && begin % 100 == 0 && (end == 10007 || end - begin == 100);
      for (std::int64_t i = begin; i < end; ++i)
        ++seen[std::size_t(i)];
    });
    EXPECT_TRUE(aligned);
    for (const auto& s : seen)
      ASSERT_EQ(s.load(), 1);
  }
}

TEST(Parallel, PassesExceptionsOn) {
  const Threads threads(2);
  EXPECT_THROW(threads.parallel_for(1000, 1,
                                    [](std::int64_t begin, std::int64_t) {
                                      if (begin == 500)
                                        throw Error(INSITU_ERROR_MESH, "cell 500");
                                    }),
               Error);
}

TEST(FloatEnvironment, IsSavedSetAndRestored) {
#if defined(__x86_64__)
  const unsigned host = _mm_getcsr();
  _mm_setcsr((host | 0x8040u) & ~0x80u); // flush to zero, denormals are zero, trap on invalid
  const unsigned strange = _mm_getcsr();
  {
    const FloatEnvironment environment;
    volatile double zero = 0.0, tiny = std::numeric_limits<double>::min();
    EXPECT_TRUE(std::isnan(zero / zero)); // would trap
    EXPECT_GT(tiny / 4, 0.0);             // would be flushed
    const Threads threads(2);
    std::atomic<int> bad{0};
    threads.parallel_for(64, 1, [&](std::int64_t, std::int64_t) {
      volatile double t = std::numeric_limits<double>::min();
      bad += t / 4 > 0.0 ? 0 : 1;
    });
    EXPECT_EQ(bad, 0);
  }
  EXPECT_EQ(_mm_getcsr(), strange);
  _mm_setcsr(host);
#endif
  std::fesetround(FE_UPWARD);
  {
    const FloatEnvironment environment;
    EXPECT_EQ(std::fegetround(), FE_TONEAREST);
  }
  EXPECT_EQ(std::fegetround(), FE_UPWARD);
  std::fesetround(FE_TONEAREST);
}

TEST(Random, IsTheWorkloadsGenerator) {
  // SplitMix64 from state 0: the reference sequence's first value.
  EXPECT_EQ(splitmix64(0), 0xe220a8397b1dcdafull);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const double r = random_unit(1, i, 2);
    ASSERT_GE(r, 0.0);
    ASSERT_LT(r, 1.0);
  }
  EXPECT_NE(random_bits(1, 0, 0), random_bits(2, 0, 0));
}

TEST(Log, GoesToTheCallersFunctionUpToItsLevel) {
  std::vector<std::string> seen;
  const Log log(
      INSITU_LOG_WARNING,
      [](insitu_log_level, const char* m, void* user) {
        static_cast<std::vector<std::string>*>(user)->push_back(m);
      },
      &seen);
  log.error("a");
  log.warning("b");
  log.info("c");
  EXPECT_EQ(seen, (std::vector<std::string>{"a", "b"}));
}
