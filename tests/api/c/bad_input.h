#pragma once

#include <cstdint>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "insitu/insitu.h"

/// What the tests of bad input share: a good mesh, and what a refusal looks like.
namespace bad_input {

/// 4 x 3 x 2 hexahedra over unit steps, slightly sheared so that nothing is axis-parallel.
struct Box {
  static constexpr int nx = 4, ny = 3, nz = 2;
  std::vector<double> xyz, pressure, velocity, density;
  std::vector<std::int32_t> connectivity;
  insitu_session session = nullptr;
  insitu_mesh mesh = nullptr;

  Box() {
    const auto id = [](int i, int j, int k) { return i + (nx + 1) * (j + (ny + 1) * k); };
    for (int k = 0; k <= nz; ++k)
      for (int j = 0; j <= ny; ++j)
        for (int i = 0; i <= nx; ++i) {
          xyz.insert(xyz.end(), {i + 0.125 * j, j + 0.0625 * k, double(k)});
          pressure.push_back(i + 10.0 * j + 100.0 * k);
          velocity.insert(velocity.end(), {1.0 * i, 1.0 * j, 1.0 * k});
        }
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i) {
          for (const int dk : {0, 1})
            connectivity.insert(connectivity.end(),
                                {id(i, j, k + dk), id(i + 1, j, k + dk), id(i + 1, j + 1, k + dk),
                                 id(i, j + 1, k + dk)});
          density.push_back(double(density.size()));
        }
    open();
  }
  ~Box() { EXPECT_EQ(insitu_session_close(&session), INSITU_OK); }
  Box(const Box&) = delete;
  Box& operator=(const Box&) = delete;

  void open() {
    insitu_session_options options = insitu_session_options_default();
    options.threads = 2;
    options.log_level = INSITU_LOG_ERROR;
    EXPECT_EQ(insitu_session_open(&options, &session), INSITU_OK);
    EXPECT_EQ(insitu_session_mesh(session, "box", &mesh), INSITU_OK);
    const auto vertices = std::int64_t(pressure.size()), count = std::int64_t(density.size());
    insitu_array a = insitu_array_of(xyz.data(), INSITU_FLOAT64, vertices, 3);
    EXPECT_EQ(insitu_mesh_points(mesh, 0, &a, 1), INSITU_OK);
    insitu_cells cells = insitu_cells_default();
    cells.count = count;
    cells.connectivity = insitu_array_of(connectivity.data(), INSITU_INT32, count, 8);
    EXPECT_EQ(insitu_mesh_cells(mesh, 0, &cells), INSITU_OK);
    a = insitu_array_of(pressure.data(), INSITU_FLOAT64, vertices, 1);
    EXPECT_EQ(insitu_mesh_field(mesh, 0, "pressure", INSITU_VERTEX, &a, 1), INSITU_OK);
    a = insitu_array_of(velocity.data(), INSITU_FLOAT64, vertices, 3);
    EXPECT_EQ(insitu_mesh_field(mesh, 0, "velocity", INSITU_VERTEX, &a, 1), INSITU_OK);
    a = insitu_array_of(density.data(), INSITU_FLOAT64, count, 1);
    EXPECT_EQ(insitu_mesh_field(mesh, 0, "density", INSITU_CELL, &a, 1), INSITU_OK);
    EXPECT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_OK);
  }
};

inline std::string message() {
  return insitu_last_message();
}

#define EXPECT_REFUSED(call, expected, ...)                                                        \
  do {                                                                                             \
    EXPECT_EQ((call), expected) << message();                                                      \
    for (const char* word : {__VA_ARGS__})                                                         \
      EXPECT_NE(message().find(word), std::string::npos) << word << " not in: " << message();      \
  } while (false)

} // namespace bad_input
