// Leaves of octrees, and items behind pointers: read in place, checked one by one.
#include "adaptive.h"

using namespace adaptive;

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
  expect_refused(INSITU_ERROR_ARGUMENT,
                 {"points", "indirect", "only fields, leaves and the vertices of faces"},
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
