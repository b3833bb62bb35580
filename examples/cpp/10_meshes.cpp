// 10: several meshes in one frame. A fluid flows through a pipe of steel: the fluid is drawn as a
// volume, the half of the pipe that lies behind it by its boundary, each coloured by its own
// temperature.
#include <cmath>
#include <filesystem>
#include <insitu/insitu.hpp>
#include <iostream>

namespace {

constexpr const char* scene = R"(insitu: 1
page: false
frames:
  - name: pipe
    size: [320, 200]
    camera: {azimuth: -70, elevation: 35, fit: box}
    effects: [lighting, shadows]
    step: 0.1 # fine, else samples show as rings on the curved outside of the water
    meshes:
      - mesh: water
        volume: {field: temperature, range: [10, 60], opacity: [[10, 0.005], [60, 0.06]]}
      - mesh: steel
        boundary: {color: {field: temperature, colors: inferno, range: [10, 90]}}
)";

/// A grid of n[0] x n[1] x n[2] vertices, along the x axis, outwards and around it, with a number
/// at each.
struct Grid {
  int n[3];
  std::vector<double> x, y, z, temperature;
};

/// Around the x axis, from radius to radius and angle to angle.
Grid tube(double inner, double outer, double from, double to, int around) {
  Grid grid{{41, 6, around}, {}, {}, {}, {}};
  for (int k = 0; k < grid.n[2]; ++k)
    for (int j = 0; j < grid.n[1]; ++j)
      for (int i = 0; i < grid.n[0]; ++i) {
        const double along = 4.0 * i / (grid.n[0] - 1);
        const double radius = inner + (outer - inner) * j / (grid.n[1] - 1);
        const double angle = from + (to - from) * k / (grid.n[2] - 1);
        grid.x.push_back(along);
        grid.y.push_back(radius * std::cos(angle));
        grid.z.push_back(radius * std::sin(angle));
        // It is heated in the middle of its way, from outside.
        grid.temperature.push_back(10 + 80 * std::exp(-2 * std::pow(along - 2, 2)) * radius);
      }
  return grid;
}

insitu::Mesh give(insitu::Session& session, const char* name, const Grid& grid) {
  insitu::Mesh mesh = session.mesh(name);
  mesh.points(grid.x.data(), grid.y.data(), grid.z.data(), grid.x.size());
  mesh.block(grid.n[0], grid.n[1], grid.n[2]);
  mesh.vertex_field("temperature", grid.temperature.data());
  return mesh;
}

} // namespace

int main() try {
  constexpr double pi = 3.14159265358979323846;
  const Grid water = tube(0.02, 0.8, 0, 2 * pi, 33),
             steel = tube(0.8, 1, -0.75 * pi, 0.25 * pi, 17);
  insitu::Session session({.scene_text = scene, .output = "meshes"});
  give(session, "water", water);
  give(session, "steel", steel);
  session.execute(0, 0.0);
  std::cout << "meshes/pipe_000000.png\n";
  return std::filesystem::exists("meshes/pipe_000000.png") ? 0 : 1;
} catch (const insitu::Error& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
