/// Cells by their faces through insitu.hpp.

#include <gtest/gtest.h>
#include <insitu/insitu.hpp>

// A cube with a pyramid on it, as two cells by their faces, and as one cell of nine faces.
TEST(Faces, AreCellsInBothForms) {
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  const std::vector<double> xyz{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0,
                                1, 1, 0, 1, 1, 1, 1, 0, 1, 1, 1, 1, 3};
  const std::vector<int> vertices{4, 5, 6, 7, 0, 1, 2, 3, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3,
                                  7, 6, 3, 0, 4, 7, 4, 5, 8, 5, 6, 8, 6, 7, 8, 7, 4, 8};
  const std::vector<long> offsets{0, 4, 8, 12, 16, 20, 24, 27, 30, 33, 36};
  const std::vector<int> owner{0, 0, 0, 0, 0, 0, 1, 1, 1, 1}, neighbour{1};
  const std::vector<double> numbers{10, 20};
  mesh.points(xyz.data(), 9);
  mesh.faces(vertices, offsets, owner, neighbour, 2);
  mesh.cell_field("number", numbers.data());
  EXPECT_EQ(mesh.commit().cells, 2);
  const std::vector<double> in{0.5, 0.5, 0.5, 0.6, 0.6, 1.2};
  const auto at = mesh.sample("number", insitu::Points(in));
  EXPECT_EQ(at.values, numbers);
  EXPECT_EQ(at.cells, (std::vector<std::int64_t>{0, 1}));
  const std::vector<int> lists{1, 2, 3, 4, 5, 6, 7, 8, 9}, starts{0, 9};
  mesh.remove_field("number");
  mesh.faces_of_cells(vertices, offsets, lists, starts);
  EXPECT_EQ(mesh.commit().cells, 1);
  EXPECT_EQ(mesh.locate(insitu::Points(in)).cells, (std::vector<std::int64_t>{0, 0}));
  // The last face and the last cell end where the ids do.
  insitu_faces faces = insitu_faces_default();
  faces.form = INSITU_FACES_CELLS;
  faces.cell_count = 1;
  faces.face_count = 10;
  faces.vertices = insitu_array_of(vertices.data(), INSITU_INT32, 36, 1);
  faces.offsets = insitu_array_of(offsets.data(), INSITU_INT64, 10, 1);
  faces.cell_faces = insitu_array_of(lists.data(), INSITU_INT32, 9, 1);
  faces.cell_offsets = insitu_array_of(starts.data(), INSITU_INT32, 1, 1);
  ASSERT_EQ(insitu_mesh_faces(mesh.handle(), 0, &faces), INSITU_OK);
  EXPECT_EQ(mesh.commit().cells, 1);
  EXPECT_EQ(mesh.locate(insitu::Points(in)).cells, (std::vector<std::int64_t>{0, 0}));
  faces.form = INSITU_FACES_OWNERS;
  faces.cell_count = 2;
  faces.owner = insitu_array_of(owner.data(), INSITU_INT32, 10, 1);
  faces.neighbour = insitu_array_of(neighbour.data(), INSITU_INT32, 1, 1);
  ASSERT_EQ(insitu_mesh_faces(mesh.handle(), 0, &faces), INSITU_OK);
  EXPECT_EQ(mesh.commit().cells, 2);
  EXPECT_EQ(mesh.locate(insitu::Points(in)).cells, (std::vector<std::int64_t>{0, 1}));
  session.hold(1);
  session.execute(0, 0.0);
  session.show(0);
  EXPECT_EQ(mesh.locate(insitu::Points(in)).cells, (std::vector<std::int64_t>{0, 1}));
  session.show_live();
  faces.offsets.count = 9; // a face too few
  EXPECT_EQ(insitu_mesh_faces(mesh.handle(), 0, &faces), INSITU_ERROR_ARGUMENT);
}
