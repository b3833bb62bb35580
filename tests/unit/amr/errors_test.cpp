// Cells that cannot be leaves of one mesh are named.
#include <gtest/gtest.h>

#include "amr/dual/dual_mesh.h"
#include "amr_mesh.h"
#include "core/status.h"

using namespace insitu;

namespace {

std::string error_of(test::AmrMesh& mesh) {
  core::Memory memory;
  amr::DualMesh dual(memory);
  for (const int threads : {1, 2})
    try {
      dual.build(mesh.view(), core::Threads(threads));
    } catch (const core::Error& e) {
      EXPECT_EQ(e.status(), INSITU_ERROR_MESH);
      EXPECT_EQ(dual.counts().leaves, 0);
      EXPECT_EQ(dual.view().cell_count(), 0);
      if (threads == 2)
        return e.what();
    }
  return "";
}

} // namespace

TEST(AmrErrors, BoxesOverlap) {
  test::AmrMesh mesh;
  mesh.add_patch(0, {0, 0, 0}, {4, 4, 4});
  mesh.add_patch(0, {3, 3, 2}, {4, 4, 4});
  EXPECT_EQ(
      error_of(mesh),
      "cells overlap: cell 47 of piece 0 and cell 0 of piece 1 are both (3, 3, 2) of level 0; "
      "2 cells lie on another in all");
}

TEST(AmrErrors, LeavesTwice) {
  test::AmrMesh mesh;
  mesh.depth_of = {0, 2};
  mesh.add_leaf(1, {-5, 1, 2});
  mesh.add_leaf(1, {-5, 1, 3});
  mesh.add_leaf(1, {-5, 1, 2});
  EXPECT_EQ(error_of(mesh), "cells overlap: cell 0 of piece 0 and cell 2 of piece 0 are both "
                            "(-5, 1, 2) of level 1; 1 cell lies on another in all");
}

TEST(AmrErrors, CoveredInPart) {
  test::AmrMesh mesh;
  mesh.depth_of = {0, 1};
  mesh.add_patch(0, {0, 0, 0}, {4, 4, 4});
  mesh.add_patch(1, {2, 2, 2}, {3, 2, 2});
  EXPECT_EQ(
      error_of(mesh),
      "cell 22 of piece 0, (2, 1, 1) of level 0, is covered by finer cells in part only: boxes "
      "have to begin and end at faces of the level above");
}

TEST(AmrErrors, CoveredInPartFarBelow) {
  test::AmrMesh mesh;
  mesh.depth_of = {0, 3};
  mesh.add_patch(0, {-1, 0, 0}, {2, 1, 1});
  mesh.add_patch(1, {0, 0, 0}, {8, 8, 7});
  EXPECT_NE(error_of(mesh).find("cell 1 of piece 0, (0, 0, 0) of level 0"), std::string::npos);
}

TEST(AmrErrors, NothingLeftOfAFailedBuild) {
  core::Memory memory;
  amr::DualMesh dual(memory);
  test::AmrMesh good, bad;
  good.add_patch(0, {0, 0, 0}, {3, 3, 3});
  bad.add_patch(0, {0, 0, 0}, {3, 3, 3});
  bad.add_patch(0, {1, 1, 1}, {1, 1, 1});
  const core::Threads threads(1);
  dual.build(good.view(), threads);
  EXPECT_EQ(dual.counts().cubes, 8);
  EXPECT_THROW(dual.build(bad.view(), threads), core::Error);
  EXPECT_EQ(dual.view().cell_count(), 0);
  EXPECT_FALSE(dual.leaves().find({1.0, 0.0, 3.0}));
  dual.build(good.view(), threads);
  EXPECT_EQ(dual.counts().cubes, 8);
}
