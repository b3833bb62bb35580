// Adaptive meshes as they are registered: levels, patches, fields; what is refused.
#include <limits>

#include "adaptive.h"

using namespace adaptive;

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

TEST_F(Adaptive, GhostsHaveRoomBetweenTheRows) {
  levels(1);
  patch.ghosts_after[1] = -1;
  expect_refused(INSITU_ERROR_ARGUMENT, {"piece 0", "-1 layers of ghosts along axis 1"},
                 [&] { give_patch(0, 0, 0, 2); });
  patch.ghosts_after[1] = 1 << 21;
  expect_refused(INSITU_ERROR_ARGUMENT, {"2097152 layers"}, [&] { give_patch(0, 0, 0, 2); });
  for (int a = 0; a < 3; ++a)
    patch.ghosts_before[a] = patch.ghosts_after[a] = 1;
  give_patch(0, 0, 0, 2);
  std::vector<double> values(64);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = double(i);
  insitu_array a = insitu_array_of(&values[21], INSITU_FLOAT64, 8, 1);
  const auto refused = [&](std::initializer_list<const char*> words) {
    mesh.set_field(0, "rho", INSITU_CELL, &a, 1);
    expect_refused(INSITU_ERROR_FIELD, words, [&] { mesh.update(); });
  };
  refused({"'rho'", "piece 0", "extents 8, 1", "2, 2"});
  std::fill_n(a.extent, 3, 2);
  refused({"stride 16 along axis 1", "no room", "4 cells", "stride 8 along axis 0"});
  a.stride[1] = 8 * 4;
  a.stride[2] = 8 * 15;
  refused({"stride 120 along axis 2", "4 cells", "stride 32 along axis 1"});
  const std::byte* pointers[8];
  std::fill_n(pointers, 8, reinterpret_cast<const std::byte*>(values.data()));
  a = insitu_array_of(pointers, INSITU_FLOAT64, 8, 1);
  a.indirect = 1;
  refused({"indirect"});
  for (const bool c_order : {false, true}) {
    a = insitu_array_of(&values[21], INSITU_FLOAT64, 8, 1);
    std::fill_n(a.extent, 3, 2);
    a.stride[c_order ? 2 : 0] = 8;
    a.stride[1] = 8 * 4;
    a.stride[c_order ? 0 : 2] = 8 * 16;
    mesh.set_field(0, "rho", INSITU_CELL, &a, 1);
    mesh.update();
    EXPECT_EQ(mesh.adaptive().pieces[0].ghost_faces, 63);
    const mesh::FieldPieceView& rho = mesh.own_field("rho").pieces[0];
    EXPECT_EQ(rho.load_ghost(0, 0, 0), c_order ? 5 : 20);  // before the first cell along i
    EXPECT_EQ(rho.load_ghost(7, 0, 5), c_order ? 43 : 58); // after the last one along k
  }
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
