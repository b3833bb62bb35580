// 08: an adaptive mesh of octree leaves. Levels, corners and a record a cell are read in place; a
// regrid is announced by giving the leaves again.
#include <cmath>
#include <cstddef>
#include <insitu/insitu.hpp>
#include <iostream>
#include <memory>

struct Zone {
  int material;
  double rho;
};

// A cell of the solver's octree: corner in cells of its own level, and its record elsewhere.
struct Leaf {
  std::int32_t corner[3];
  std::uint8_t level;
  Zone* zone;
};

// The leaf's eight children take its place; the field is x at the centre.
static void refine(std::vector<Leaf>& leaves, std::vector<std::unique_ptr<Zone>>& zones,
                   std::size_t which) {
  const Leaf parent = leaves[which];
  leaves.erase(leaves.begin() + static_cast<std::ptrdiff_t>(which));
  for (int c = 0; c < 8; ++c) {
    Leaf child{{2 * parent.corner[0] + (c & 1), 2 * parent.corner[1] + (c >> 1 & 1),
                2 * parent.corner[2] + (c >> 2)},
               static_cast<std::uint8_t>(parent.level + 1),
               nullptr};
    zones.push_back(std::make_unique<Zone>(Zone{7, (child.corner[0] + 0.5) / (1 << child.level)}));
    child.zone = zones.back().get();
    leaves.push_back(child);
  }
}

int main() try {
  Zone root{7, 0.5};
  std::vector<Leaf> leaves{{{0, 0, 0}, 0, &root}};
  std::vector<std::unique_ptr<Zone>> zones;

  insitu::Session session;
  insitu::Mesh mesh = session.mesh("octree");
  insitu::AmrLevels levels; // a unit cube
  levels.count = 4;
  mesh.adaptive(levels);
  for (std::size_t regrid = 0; regrid < 3; ++regrid) {
    refine(leaves, zones, leaves.size() / 2);
    const auto bytes = static_cast<std::int64_t>(sizeof(Leaf));
    mesh.leaves(insitu::Array(&leaves[0].level, leaves.size()).stride(bytes),
                insitu::Array(leaves[0].corner, leaves.size()).stride(bytes));
    mesh.cell_field(
        "rho", insitu::Array::behind<double>(&leaves[0].zone, offsetof(Zone, rho)).stride(bytes));
    mesh.commit();
  }
  double value = 0.0;
  const bool found = mesh.sample_point("rho", {0.5, 0.45, 0.55}, {&value, 1});
  std::cout << leaves.size() << " leaves, rho(0.5, 0.45, 0.55): " << value << '\n';
  return found && std::fabs(value - 0.5) < 1e-13 ? 0 : 1;
} catch (const insitu::Error& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
