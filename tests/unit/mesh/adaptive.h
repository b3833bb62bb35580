#pragma once

#include <cstddef>
#include <functional>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "core/memory.h"
#include "core/parallel.h"
#include "core/status.h"
#include "mesh/registered/mesh.h"

/// What the tests of adaptive meshes share.
namespace adaptive {

using namespace insitu;

struct Quadrant { // as p4est lays it out
  std::int32_t x, y, z;
  std::int8_t level, pad8;
  std::int16_t pad16;
  void* data;
};

struct Record {
  float other;
  double density, velocity[3];
};

inline void expect_refused(insitu_status status, std::initializer_list<const char*> words,
                           const std::function<void()>& call) {
  try {
    call();
  } catch (const core::Error& e) {
    EXPECT_EQ(e.status(), status) << e.what();
    for (const char* word : words)
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos)
          << word << " not in: " << e.what();
    return;
  }
  FAIL() << "not refused";
}

struct Adaptive : testing::Test {
  core::Memory memory;
  core::Threads threads{2};
  mesh::Mesh mesh{"amr", memory};
  insitu_amr amr = insitu_amr_default();
  insitu_patch patch = insitu_patch_default();

  void levels(int count, std::vector<std::int32_t> ratios = {}) {
    amr.level_count = count;
    amr.ratios = ratios.empty() ? nullptr : ratios.data();
    mesh.set_amr(&amr);
  }
  void give_patch(std::int32_t piece, int level, std::int64_t lower, std::int64_t cells) {
    patch.level = level;
    for (int a = 0; a < 3; ++a) {
      patch.lower[a] = lower;
      patch.cells[a] = cells;
    }
    mesh.set_patch(piece, &patch);
  }
  void expect_levels_refused(std::initializer_list<const char*> words) {
    expect_refused(INSITU_ERROR_ARGUMENT, words, [&] { mesh.set_amr(&amr); });
    EXPECT_FALSE(mesh.is_adaptive());
  }
};

/// Quadrants of one tree, each with a record.
struct Forest {
  explicit Forest(std::size_t n) : quadrants(n), records(n) {
    for (std::size_t i = 0; i < n; ++i) {
      records[i] = {-1, double(i), {10.0 + double(i), 20.0 + double(i), 30.0 + double(i)}};
      quadrants[i] = {std::int32_t(i % 8) << 27, 0, std::int32_t(1) << 29, 3, 0, 0, &records[i]};
    }
  }
  insitu_leaves leaves() const {
    const auto n = std::int64_t(quadrants.size());
    insitu_leaves l = insitu_leaves_default();
    l.levels = insitu_array_of(&quadrants[0].level, INSITU_UINT8, n, 1);
    l.corners = insitu_array_of(&quadrants[0].x, INSITU_INT32, n, 3);
    l.levels.stride[0] = l.corners.stride[0] = sizeof(Quadrant);
    l.corner_bits = 30;
    return l;
  }
  insitu_array values(std::size_t offset, int components = 1) const {
    insitu_array a = insitu_array_of(&quadrants[0].data, INSITU_FLOAT64,
                                     std::int64_t(quadrants.size()), components);
    a.stride[0] = sizeof(Quadrant);
    a.indirect = 1;
    a.offset = std::int64_t(offset);
    return a;
  }
  std::vector<Quadrant> quadrants;
  std::vector<Record> records;
};

} // namespace adaptive
