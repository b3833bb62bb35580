// Adaptive meshes as they are registered: what the view says, what is refused, nothing copied.
#include <cstddef>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

#include "core/memory.h"
#include "core/parallel.h"
#include "core/status.h"
#include "mesh/mesh.h"

using namespace insitu;

namespace {

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

void expect_refused(insitu_status status, std::initializer_list<const char*> words,
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

} // namespace

TEST_F(Adaptive, PatchesByLevelAndRatio) {
  amr.origin[0] = -1.5;
  amr.spacing[2] = 0.25;
  levels(4, {2, 4, 2});
  give_patch(0, 0, -3, 4);
  give_patch(1, 2, 5, 2);
  mesh.update(&threads);
  EXPECT_TRUE(mesh.is_adaptive());
  const mesh::AmrView& view = mesh.adaptive();
  EXPECT_EQ(view.piece_count, 2);
  EXPECT_EQ(view.cell_count(), 64 + 8);
  EXPECT_EQ(view.first_cell[1], 64);
  EXPECT_EQ(view.finest_depth(), 4);
  EXPECT_EQ(view.depth_of[2], 3);
  EXPECT_EQ(view.lattice.origin[0], -1.5);
  EXPECT_EQ(view.lattice.spacing[2], 0.25);
  EXPECT_EQ(view.pieces[1].depth, 3);
  const mesh::AmrCell c = view.cell(view.pieces[1], 1 + 2 * (0 + 2 * 1));
  EXPECT_EQ(c.depth, 3);
  EXPECT_EQ(c.index[0], 6);
  EXPECT_EQ(c.index[1], 5);
  EXPECT_EQ(c.index[2], 6);
  EXPECT_EQ(view.cell(view.pieces[0], 0).index[0], -3);
}

TEST_F(Adaptive, LevelsCountedFromTheFinest) {
  amr.finest_first = 1;
  levels(3, {4, 2}); // the ratios go on from the coarsest
  give_patch(0, 0, 0, 1);
  give_patch(1, 2, 0, 1);
  const std::vector<std::int32_t> raw{0, 1, 2}, corners{1, 2, 3, 4, 5, 6, 7, 8, 9};
  insitu_leaves l = insitu_leaves_default();
  l.levels = insitu_array_of(raw.data(), INSITU_INT32, 3, 1);
  l.corners = insitu_array_of(corners.data(), INSITU_INT32, 3, 3);
  mesh.set_leaves(2, &l);
  mesh.update();
  const mesh::AmrView& view = mesh.adaptive();
  EXPECT_EQ(view.pieces[0].depth, 3);
  EXPECT_EQ(view.pieces[1].depth, 0);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(view.cell(view.pieces[2], i).depth, i == 0 ? 3 : i == 1 ? 2 : 0);
    EXPECT_EQ(view.cell(view.pieces[2], i).index[1], 2 + 3 * i);
  }
}

TEST_F(Adaptive, LevelsThatCannotBeAreRefusedByNumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_refused(INSITU_ERROR_ARGUMENT, {"insitu_amr_default"}, [&] { mesh.set_amr(nullptr); });
  for (const int count : {0, -1, 32}) {
    amr.level_count = count;
    expect_levels_refused({"'amr'", std::to_string(count).c_str(), "1 to 31"});
  }
  amr.level_count = 3;
  const std::int32_t three[] = {2, 3};
  amr.ratios = three;
  expect_levels_refused({"ratio 3", "between levels 1 and 2", "2 or 4"});
  const std::vector<std::int32_t> fours(16, 4);
  amr.level_count = 17;
  amr.ratios = fours.data();
  expect_levels_refused({"17 levels", "2^30"});
  amr.ratios = nullptr;
  amr.level_count = 2;
  amr.origin[1] = nan;
  expect_levels_refused({"origin along axis 1", "nan"});
  amr.origin[1] = 1e17;
  expect_levels_refused({"origin along axis 1", "1e+17", "cells of 0.5"});
  amr.origin[1] = 0;
  for (const double h : {nan, 0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    amr.spacing[2] = h;
    expect_levels_refused({"spacing along axis 2", "positive"});
  }
  amr.spacing[2] = 1;
  amr.finest_first = 2;
  expect_levels_refused({"finest_first 2"});
  amr.finest_first = 0;
  amr.reconstruction = insitu_reconstruction(7);
  expect_levels_refused({"reconstruction 7"});
}

TEST_F(Adaptive, PatchesThatCannotBeAreRefusedByNumber) {
  const auto refused = [&](std::initializer_list<const char*> words, int level, std::int64_t lower,
                           std::int64_t cells) {
    expect_refused(INSITU_ERROR_ARGUMENT, words, [&] { give_patch(0, level, lower, cells); });
  };
  expect_refused(INSITU_ERROR_ORDER, {"piece 0 patch", "insitu_mesh_amr"},
                 [&] { give_patch(0, 0, 0, 1); });
  levels(2);
  refused({"piece 0", "level 2", "0 to 1"}, 2, 0, 1);
  refused({"level -1"}, -1, 0, 1);
  refused({"0 cells along axis 0"}, 0, 0, 0);
  refused({"-4 cells"}, 0, 0, -4);
  refused({"cells from index 1073741823", "1073741823"}, 0, (1 << 30) - 1, 2);
  refused({"-1073741825"}, 0, -(std::int64_t(1) << 30) - 1, 2);
  refused({"64 bits"}, 0, -(1 << 30), std::int64_t(1) << 31);
  expect_refused(INSITU_ERROR_ARGUMENT, {"piece 3", "the next is 0"},
                 [&] { give_patch(3, 0, 0, 1); });
  EXPECT_EQ(mesh.pending() & INSITU_CHANGED_TOPOLOGY, INSITU_CHANGED_TOPOLOGY);
  give_patch(0, 1, 0, 2000);
  expect_refused(INSITU_ERROR_UNSUPPORTED, {"piece 0", "8000000000 cells", "4294967295"},
                 [&] { mesh.update(); });
  give_patch(0, 1, 0, 2);
  levels(1); // the patch's level is gone
  expect_refused(INSITU_ERROR_ARGUMENT, {"piece 0", "level 1", "0 to 0"}, [&] { mesh.update(); });
}

TEST_F(Adaptive, KindsOfPiecesAreNotMixed) {
  const std::vector<double> xyz(24);
  const std::vector<std::int32_t> ids(8);
  const std::vector<std::uint8_t> bits(8);
  const insitu_array points = insitu_array_of(xyz.data(), INSITU_FLOAT64, 8, 3);
  const insitu_array ghosts = insitu_array_of(bits.data(), INSITU_UINT8, 8, 1);
  insitu_cells cells = insitu_cells_default();
  cells.count = 1;
  cells.connectivity = insitu_array_of(ids.data(), INSITU_INT32, 1, 8);
  insitu_block block = insitu_block_default();
  block.vertices[0] = block.vertices[1] = block.vertices[2] = 2;
  const char* const words[] = {"adaptive", "insitu_mesh_patch"};
  const auto refused = [&](const std::function<void()>& call) {
    expect_refused(INSITU_ERROR_ORDER, {words[0], words[1]}, call);
  };
  levels(1);
  refused([&] { mesh.set_points(0, &points, 1); });
  refused([&] { mesh.set_cells(0, &cells); });
  refused([&] { mesh.set_block(0, &block); });
  refused([&] { mesh.set_ghosts(0, &ghosts, INSITU_GHOSTS_VTK); });

  mesh::Mesh other("box", memory);
  other.set_block(0, &block);
  expect_refused(INSITU_ERROR_ORDER, {"'box'", "piece 0 has a block"},
                 [&] { other.set_amr(&amr); });
  EXPECT_FALSE(other.is_adaptive());
  const Forest forest(1);
  const insitu_leaves l = forest.leaves();
  expect_refused(INSITU_ERROR_ORDER, {"'box'", "piece 1 leaves", "insitu_mesh_amr"},
                 [&] { other.set_leaves(1, &l); });
}

TEST_F(Adaptive, QuadrantsAreReadInPlace) {
  const Forest forest(64);
  levels(4);
  insitu_leaves l = forest.leaves();
  l.offset[0] = std::int64_t(5) << 30;
  mesh.set_leaves(0, &l);
  const insitu_array density = forest.values(offsetof(Record, density));
  const insitu_array velocity = forest.values(offsetof(Record, velocity), 3);
  mesh.set_field(0, "density", INSITU_CELL, &density, 1);
  mesh.set_field(0, "velocity", INSITU_CELL, &velocity, 1);
  mesh.update(&threads);
  const mesh::AmrView& view = mesh.adaptive();
  EXPECT_EQ(reinterpret_cast<const void*>(view.pieces[0].levels), &forest.quadrants[0].level);
  EXPECT_EQ(reinterpret_cast<const void*>(view.pieces[0].corner[1]), &forest.quadrants[0].y);
  for (int i = 0; i < 64; ++i) {
    const mesh::AmrCell c = view.cell(view.pieces[0], i);
    EXPECT_EQ(c.depth, 3);
    EXPECT_EQ(c.index[0], 40 + i % 8);
    EXPECT_EQ(c.index[2], 4);
    EXPECT_EQ(mesh.own_field("density").pieces[0].load(i, 0), i);
    for (int a = 0; a < 3; ++a)
      EXPECT_EQ(mesh.own_field("velocity").pieces[0].load(i, a), 10 * (a + 1) + i);
  }
  const std::vector<insitu_audit_entry> audit = mesh.audit();
  ASSERT_EQ(audit.size(), 4u);
  const void* const expected[] = {&forest.quadrants[0].level, &forest.quadrants[0].x,
                                  &forest.quadrants[0].data, &forest.quadrants[0].data};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(audit[i].data, expected[i]) << audit[i].name;
    EXPECT_TRUE(audit[i].borrowed);
  }
  EXPECT_STREQ(audit[0].name, "piece 0 levels");
  EXPECT_EQ(mesh.bytes_borrowed(), 64 * (1 + 12 + 8 + 24));
  expect_refused(INSITU_ERROR_FIELD, {"no field 'mass'"}, [&] { (void)mesh.own_field("mass"); });
}

TEST_F(Adaptive, LeavesInRecordsBehindPointersAndInColumns) {
  const Forest forest(16);
  std::vector<const Quadrant*> pointers;
  std::vector<std::int64_t> level(16, 3), columns(3 * 16);
  for (std::size_t i = 0; i < 16; ++i) {
    pointers.push_back(&forest.quadrants[15 - i]);
    for (std::size_t a = 0; a < 3; ++a)
      columns[a * 16 + i] = std::int64_t(100 * a + i);
  }
  levels(4);
  insitu_leaves l = insitu_leaves_default();
  l.levels = insitu_array_of(pointers.data(), INSITU_UINT8, 16, 1);
  l.corners = insitu_array_of(pointers.data(), INSITU_INT32, 16, 3);
  l.levels.indirect = l.corners.indirect = 1;
  l.levels.offset = offsetof(Quadrant, level);
  l.corner_bits = 30;
  mesh.set_leaves(0, &l);
  l = insitu_leaves_default();
  l.levels = insitu_array_of(level.data(), INSITU_INT64, 16, 1);
  l.corners = insitu_array_of(columns.data(), INSITU_INT64, 16, 3);
  l.corners.component_stride = 16 * 8;
  mesh.set_leaves(1, &l);
  mesh.update(&threads);
  const mesh::AmrView& view = mesh.adaptive();
  for (int i = 0; i < 16; ++i) {
    EXPECT_EQ(view.cell(view.pieces[0], i).index[0], (15 - i) % 8);
    EXPECT_EQ(view.cell(view.pieces[0], i).index[2], 4);
    for (int a = 0; a < 3; ++a)
      EXPECT_EQ(view.cell(view.pieces[1], i).index[a], 100 * a + i);
  }
}

TEST_F(Adaptive, LeavesThatCannotBeAreRefusedByPieceAndLeaf) {
  Forest forest(40000);
  levels(4);
  const insitu_leaves l = forest.leaves();
  mesh.set_leaves(0, &l);
  const auto refused = [&](std::initializer_list<const char*> words) {
    mesh.set_changed(INSITU_CHANGED_TOPOLOGY);
    expect_refused(INSITU_ERROR_MESH, words, [&] { mesh.update(&threads); });
    expect_refused(INSITU_ERROR_MESH, words, [&] { mesh.update(); });
  };
  forest.quadrants[39999].level = 4;
  refused({"'amr', piece 0, leaf 39999", "level 4, 0 to 3 expected"});
  forest.quadrants[30000].level = -1;
  refused({"leaf 30000", "level 255"});
  forest.quadrants[20000].x = (1 << 27) + 1;
  refused({"leaf 20000", "level 3", "corner (134217729, 0, 536870912)", "1/2^30",
           "multiples of 134217728"});
  mesh.clear_pending(); // fields alone: leaves are not looked at again
  mesh.update(&threads);
  forest = Forest(8);
  insitu_leaves far = forest.leaves();
  far.offset[1] = std::int64_t(1) << 60;
  mesh.set_leaves(0, &far);
  refused({"leaf 0", "offset (0, 1152921504606846976, 0)", "indices from -1073741824"});
  far = forest.leaves();
  far.corner_bits = 2;
  mesh.set_leaves(0, &far);
  refused({"leaf 0", "1/2^2", "coarser than its level's 1/2^3"});
}

TEST_F(Adaptive, ArraysOfLeavesThatCannotBeAreRefused) {
  const Forest forest(8);
  const insitu_leaves good = forest.leaves();
  levels(4);
  const auto refused = [&](std::initializer_list<const char*> words, auto change) {
    insitu_leaves l = good;
    change(l);
    expect_refused(INSITU_ERROR_ARGUMENT, words, [&] { mesh.set_leaves(0, &l); });
  };
  refused({"float64", "uint8, int32 or int64"}, [](auto& l) { l.levels.type = INSITU_FLOAT64; });
  refused({"corners", "uint8", "int32 or int64"}, [](auto& l) { l.corners.type = INSITU_UINT8; });
  refused({"2 of corners", "1 and 3"}, [](auto& l) { l.corners.components = 2; });
  refused({"7 levels, but 8 corners"}, [](auto& l) { l.levels.count = 7; });
  refused({"corner_bits 31"}, [](auto& l) { l.corner_bits = 31; });
  refused({"corner_bits -2"}, [](auto& l) { l.corner_bits = -2; });
  refused({"offset", "2^61"}, [](auto& l) { l.offset[2] = std::int64_t(1) << 62; });
  refused({"levels", "data is null"}, [](auto& l) { l.levels.data = nullptr; });
  refused({"evenly spaced"}, [](auto& l) {
    l.levels.count = 8;
    l.levels.extent[0] = l.levels.extent[1] = l.levels.extent[2] = 2;
    l.levels.stride[1] = 100;
  });
  refused({"levels", "indirect 3"}, [](auto& l) { l.levels.indirect = 3; });
  refused({"corners", "offset 8"}, [](auto& l) { l.corners.offset = 8; });
  refused({"insitu_leaves_default"}, [](auto& l) { l.size = 1; });
}

TEST_F(Adaptive, NoLeafOnThisRank) {
  levels(5);
  const insitu_leaves none = insitu_leaves_default();
  insitu_leaves l = none;
  l.levels.type = INSITU_INT32;
  l.corners = insitu_array_of(nullptr, INSITU_INT32, 0, 3);
  mesh.set_leaves(0, &l);
  const insitu_array nothing = insitu_array_of(nullptr, INSITU_FLOAT64, 0, 1);
  mesh.set_field(0, "density", INSITU_CELL, &nothing, 1);
  mesh.update(&threads);
  EXPECT_EQ(mesh.adaptive().cell_count(), 0);
  EXPECT_EQ(mesh.view().cell_count(), 0);
}

TEST_F(Adaptive, FieldsAreOfCellsAndOfTheirNumber) {
  levels(1);
  give_patch(0, 0, 0, 2);
  const std::vector<double> values(8);
  const auto give = [&](std::int64_t n, insitu_association association) {
    const insitu_array a = insitu_array_of(values.data(), INSITU_FLOAT64, n, 1);
    mesh.set_field(0, "rho", association, &a, 1);
  };
  give(7, INSITU_CELL);
  expect_refused(INSITU_ERROR_FIELD, {"'rho'", "piece 0", "7 values for 8 cells"},
                 [&] { mesh.update(); });
  give(8, INSITU_VERTEX);
  expect_refused(INSITU_ERROR_FIELD, {"'rho'", "on vertices", "INSITU_CELL"},
                 [&] { mesh.update(); });
  give(8, INSITU_CELL);
  mesh.update();
  give_patch(1, 0, 2, 1);
  expect_refused(INSITU_ERROR_FIELD, {"'rho'", "piece 1 has no values"}, [&] { mesh.update(); });
  // A regrid that leaves fewer patches.
  mesh.drop_pieces(1);
  mesh.update();
  EXPECT_EQ(mesh.adaptive().piece_count, 1);
  expect_refused(INSITU_ERROR_ARGUMENT, {"from 2 on", "0 to 1"}, [&] { mesh.drop_pieces(2); });
  expect_refused(INSITU_ERROR_ARGUMENT, {"from -1"}, [&] { mesh.drop_pieces(-1); });
}

TEST_F(Adaptive, PointersAreCheckedAtTopologyCommitsAndWhenNew) {
  Forest forest(20000);
  levels(4);
  const insitu_leaves l = forest.leaves();
  mesh.set_leaves(0, &l);
  forest.quadrants[17000].data = nullptr;
  const insitu_array density = forest.values(offsetof(Record, density));
  mesh.set_field(0, "density", INSITU_CELL, &density, 1);
  const auto refused = [&] {
    expect_refused(INSITU_ERROR_FIELD, {"'density', piece 0", "pointer of item 17000 is null"},
                   [&] { mesh.update(&threads); });
  };
  refused();
  mesh.clear_pending();
  refused(); // still new
  forest.quadrants[17000].data = &forest.records[0];
  mesh.update(&threads);
  EXPECT_EQ(mesh.own_field("density").pieces[0].load(17000, 0), 0.0);
  forest.quadrants[17000].data = nullptr;
  mesh.update(&threads); // fields alone
  mesh.set_changed(INSITU_CHANGED_TOPOLOGY);
  refused();
}

TEST_F(Adaptive, PointersWhereTheyAreNotFollowed) {
  const Forest forest(8);
  insitu_array a = forest.values(0, 3);
  expect_refused(INSITU_ERROR_ARGUMENT, {"points", "indirect", "only fields and leaves"},
                 [&] { mesh.set_points(0, &a, 1); });
  insitu_cells cells = insitu_cells_default();
  cells.count = 8;
  cells.connectivity = a;
  cells.connectivity.type = INSITU_INT32;
  cells.connectivity.components = 8;
  expect_refused(INSITU_ERROR_ARGUMENT, {"connectivity", "indirect"},
                 [&] { mesh.set_cells(0, &cells); });
  a.type = INSITU_UINT8;
  a.components = 1;
  expect_refused(INSITU_ERROR_ARGUMENT, {"ghosts", "indirect"},
                 [&] { mesh.set_ghosts(0, &a, INSITU_GHOSTS_VTK); });
  // One component an array: all behind pointers, or none.
  const std::vector<double> direct(8);
  insitu_array mixed[] = {forest.values(offsetof(Record, density)),
                          insitu_array_of(direct.data(), INSITU_FLOAT64, 8, 1)};
  expect_refused(INSITU_ERROR_ARGUMENT, {"array 1", "indirect", "all or none"},
                 [&] { mesh.set_field(0, "v", INSITU_CELL, mixed, 2); });
  mixed[1] = forest.values(offsetof(Record, velocity));
  mesh.set_field(0, "v", INSITU_CELL, mixed, 2);
  insitu_block block = insitu_block_default(); // other meshes have such fields too
  block.kind = INSITU_BLOCK_UNIFORM;
  block.vertices[0] = block.vertices[1] = block.vertices[2] = 3;
  mesh.set_block(0, &block);
  mesh.update();
  EXPECT_EQ(mesh.field("v").pieces[0].load(7, 0), 7.0);
  EXPECT_EQ(mesh.field("v").pieces[0].load(7, 1), 17.0);
}

TEST_F(Adaptive, WhatChangedIsSaid) {
  levels(2);
  give_patch(0, 0, 0, 2);
  mesh.update();
  mesh.clear_pending();
  amr.reconstruction = INSITU_NEAREST;
  levels(2);
  EXPECT_EQ(mesh.pending(), std::uint32_t(INSITU_CHANGED_FIELDS));
  EXPECT_EQ(mesh.reconstruction(), INSITU_NEAREST);
  amr.spacing[0] = 2;
  levels(2);
  EXPECT_EQ(mesh.pending(), std::uint32_t(INSITU_CHANGED_ALL));
}
