/// Adaptive meshes through insitu.hpp. Compiled as C++17 and as C++20.

#include <cstddef>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>

namespace {

struct Record {
  int id;
  double rho;
};

struct Leaf {
  std::int32_t corner[3];
  std::uint8_t level;
  Record* record;
};

const void* address_of(const insitu::Mesh& mesh, const std::string& name) {
  for (const insitu::AuditEntry& e : mesh.audit())
    if (e.name == name && e.borrowed)
      return e.data;
  return nullptr;
}

} // namespace

TEST(AmrWrapper, Patches) {
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("patches");
  insitu::AmrLevels levels;
  levels.ratios = {2, 4};
  levels.reconstruction = insitu::Reconstruction::nearest;
  mesh.adaptive(levels);
  mesh.patch(0, {0, 0, 0}, {2, 2, 2});
  mesh.piece(1).patch(1, {0, 0, 0}, {2, 2, 2});
  const std::vector<double> coarse(8, 1.0);
  const std::vector<float> fine(8, 2.0f);
  mesh.cell_field("rho", coarse.data()); // as many as the patch has cells
  mesh.piece(1).cell_field("rho", fine);
  mesh.commit();
  EXPECT_EQ(address_of(mesh, "piece 0 field 'rho'"), coarse.data());
  EXPECT_EQ(address_of(mesh, "piece 1 field 'rho'"), fine.data());
  const std::vector<double> places = {1.5, 1.5, 1.5, 0.3, 0.3, 0.9, -1, 0, 0};
  const insitu::Locations at = mesh.locate(insitu::Points(places));
  EXPECT_EQ(mesh.cell_levels(at), (std::vector<std::int32_t>{0, 1, -1}));
  EXPECT_THROW(mesh.patch(3, {0, 0, 0}, {2, 2, 2}), insitu::Error);
  EXPECT_THROW(mesh.uniform_block({2, 2, 2}, {0, 0, 0}, {1, 1, 1}), insitu::Error);
  mesh.drop_pieces(1);
  mesh.commit();
  EXPECT_EQ(address_of(mesh, "piece 1 field 'rho'"), nullptr);
}

TEST(AmrWrapper, GhostsOfAPatch) {
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("ghosts");
  mesh.adaptive({});
  mesh.patch(0, {0, 0, 0}, {2, 1, 1}, {{{1, 0, 0}}, {{2, 0, 0}}});
  const std::vector<double> row = {1.0, 3.0, 5.0, 11.0, -1.0};
  mesh.cell_field("rho", insitu::Array(&row[1]).block({2, 1, 1}, {8, 16, 16}));
  mesh.commit();
  double value;
  EXPECT_TRUE(mesh.sample_point("rho", {0.0, 0.5, 0.5}, {&value, 1}));
  EXPECT_EQ(value, 2.0);
  EXPECT_TRUE(mesh.sample_point("rho", {2.0, 0.5, 0.5}, {&value, 1}));
  EXPECT_EQ(value, 8.0);
}

TEST(AmrWrapper, LeavesWithARecordEach) {
  std::vector<Leaf> leaves(8);
  std::vector<Record> records(8);
  for (int i = 0; i < 8; ++i)
    leaves[static_cast<std::size_t>(i)] = {
        {i & 1, i >> 1 & 1, i >> 2}, 1, &records[static_cast<std::size_t>(i)]};
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("leaves");
  insitu::AmrLevels levels;
  levels.count = 2;
  mesh.adaptive(levels);
  const auto bytes = static_cast<std::int64_t>(sizeof(Leaf));
  mesh.leaves(insitu::Array(&leaves[0].level, 8).stride(bytes),
              insitu::Array(leaves[0].corner, 8).stride(bytes));
  mesh.cell_field(
      "rho", insitu::Array::behind<double>(&leaves[0].record, offsetof(Record, rho)).stride(bytes));
  mesh.commit();
  EXPECT_EQ(address_of(mesh, "piece 0 corners"), leaves[0].corner);
  EXPECT_EQ(address_of(mesh, "piece 0 field 'rho'"), &leaves[0].record);
  insitu::LeafLattice lattice;
  lattice.corner_bits = 99;
  EXPECT_THROW(mesh.leaves(insitu::Array(&leaves[0].level, 8).stride(bytes),
                           insitu::Array(leaves[0].corner, 8).stride(bytes), lattice),
               insitu::Error);
}
