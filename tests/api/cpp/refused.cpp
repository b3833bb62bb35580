// What must not compile, by CASE; case 0 must.

#include <insitu/insitu.hpp>

void refused(insitu::Mesh mesh) {
  std::vector<double> values(8);
  std::vector<int> ids(8);
  std::vector<unsigned> unsigned_ids(8);
#if CASE == 0
  mesh.cell_field("a", values);
  mesh.hexahedra(ids.data(), 1);
  mesh.points(values.data(), values.data(), values.data(), 8);
#elif CASE == 1 // a temporary would be gone at the commit
  mesh.cell_field("a", std::vector<double>(8));
#elif CASE == 2
  mesh.hexahedra(std::vector<int>(8));
#elif CASE == 3
  mesh.cell_field("a", nullptr);
#elif CASE == 4 // ids are signed
  mesh.hexahedra(unsigned_ids.data(), 1);
#elif CASE == 5 // points are real
  mesh.points(ids.data(), ids.data(), ids.data(), 8);
#elif CASE == 6
  mesh.cell_field("a", {1.0, 2.0});
#endif
}
