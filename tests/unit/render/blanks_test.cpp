// Frames of fields with blank values: isosurfaces and volumes are those of the mesh without the
// blank cells.
#include <cmath>

#include "unit/render/same_frames.h"

namespace insitu::test {
namespace {

constexpr double fill = 1e20;

/// A box of which a ball has no values, told by blank values, by hidden points, or by hidden cells.
struct Ball {
  enum class Told { blank, hidden_points, hidden_cells };

  Ball(Shape shape, Told told) : whole(box_cells(8, shape, 0.2)), arrays(whole) {
    const auto in_ball = [](const Vec3d& p) {
      const Vec3d d = p - Vec3d{0.7, 0.45, 0.5};
      return dot(d, d) < 0.25 * 0.25;
    };
    for (const Vec3d& v : whole.vertices) {
      hidden.push_back(in_ball(v) ? 2 : 0);
      values.push_back(in_ball(v) && told == Told::blank ? fill : blob(v));
    }
    for (const MeshCell& cell : whole.cells) {
      Vec3d middle;
      bool blank = false;
      const int count = mesh::vertex_count(cell.shape);
      for (int v = 0; v < count; ++v) {
        const auto id = std::size_t(cell.vertices[std::size_t(v)]);
        middle += whole.vertices[id] / double(count);
        blank |= hidden[id] != 0;
      }
      const bool in = in_ball(middle);
      cell_values.push_back(in && told != Told::hidden_cells ? fill : blob(middle));
      // By the field: that of vertices takes cells with one of them, that of cells those alone.
      ghosts_f.push_back(blank ? 32 : 0);
      ghosts_c.push_back(in ? 32 : 0);
    }
    mesh::Mesh& mesh = committed.mesh.mesh();
    const insitu_array x = arrays.point_array();
    const insitu_cells c = arrays.cells();
    const auto array = [](auto& from, insitu_type type) {
      return insitu_array_of(from.data(), type, std::int64_t(from.size()), 1);
    };
    mesh.set_points(0, &x, 1);
    mesh.set_cells(0, &c);
    const insitu_array f = array(values, INSITU_FLOAT64),
                       of_cells = array(cell_values, INSITU_FLOAT64);
    mesh.set_field(0, "f", INSITU_VERTEX, &f, 1);
    mesh.set_field(0, "c", INSITU_CELL, &of_cells, 1);
    if (told != Told::hidden_cells)
      mesh.add_blank("c", fill);
    if (told == Told::blank)
      mesh.add_blank("f", fill);
    const insitu_array h = array(hidden, INSITU_UINT8);
    if (told == Told::hidden_points)
      mesh.set_hidden_points(0, &h);
    committed.commit();
  }
  /// By hidden cells: those that the field calls for.
  ScalarField field(const char* name, bool hide) {
    mesh::Mesh& mesh = committed.mesh.mesh();
    if (hide) {
      std::vector<std::uint8_t>& ghosts = name[0] == 'f' ? ghosts_f : ghosts_c;
      const insitu_array g =
          insitu_array_of(ghosts.data(), INSITU_UINT8, std::int64_t(ghosts.size()), 1);
      mesh.set_ghosts(0, &g, INSITU_GHOSTS_VTK);
      committed.commit();
    }
    return {mesh.field(name), -1};
  }

  TestMesh whole;
  fixtures::SolverArrays arrays;
  std::vector<double> values, cell_values;
  std::vector<std::uint8_t> hidden, ghosts_f, ghosts_c;
  fixtures::Committed committed;
};

FrameImages image(Ball& ball, const char* name, bool volume, render::Normals normals,
                  bool hide = false) {
  const ScalarField field = ball.field(name, hide);
  FrameSettings s = box_frame(48);
  if (volume) {
    s.volume = render::VolumeSettings{field, colors()};
  } else {
    s.isosurfaces.push_back({field, {0.3, 0.6}, 0.5, render::Color{1, 1, 1}});
    s.isosurfaces[0].normals = normals;
  }
  s.lighting.lights = {{render::Light::Kind::directional, {1, 1, 2}, {1, 1, 1}}};
  return draw(ball.committed, s, ball.committed.memory, 2);
}

std::size_t covered(const FrameImages& a) {
  std::size_t n = 0;
  for (std::size_t i = 3; i < a.color.rgba.size(); i += 4)
    n += a.color.rgba[i] > 0.02f;
  return n;
}

TEST(Blanks, FramesAreThoseWithoutTheBlankCells) {
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron, Shape::wedge, Shape::pyramid})
    for (const char* name : {"f", "c"})
      for (const bool volume : {false, true}) {
        SCOPED_TRACE(testing::Message() << "shape " << int(shape) << " " << name << volume);
        Ball without(shape, Ball::Told::hidden_cells), plain(shape, Ball::Told::hidden_cells);
        const FrameImages want = image(without, name, volume, render::Normals::cell, true);
        EXPECT_GT(covered(want), 100u);
        EXPECT_NE(want.color.rgba, image(plain, name, volume, render::Normals::cell).color.rgba);
        for (const auto told : {Ball::Told::blank, Ball::Told::hidden_points}) {
          Ball blank(shape, told);
          const FrameImages got = image(blank, name, volume, render::Normals::cell);
          std::size_t other = 0;
          for (std::size_t i = 0; i < want.color.rgba.size(); i += 4) {
            float most = 0;
            for (std::size_t c = 0; c < 4; ++c)
              most = std::max(most, std::abs(got.color.rgba[i + c] - want.color.rgba[i + c]));
            // A volume's samples lie elsewhere behind hidden cells, by less than a step.
            other += most > (volume ? 0.1f : 1e-5f);
          }
          EXPECT_LE(other, volume ? 12u : 0u);
        }
      }
}

TEST(Blanks, SmoothNormalsAreFinite) {
  for (const char* name : {"f", "c"})
    for (const render::Normals normals : {render::Normals::smooth, render::Normals::central}) {
      Ball ball(Shape::hexahedron, Ball::Told::blank);
      for (const float v : image(ball, name, false, normals).color.rgba)
        EXPECT_TRUE(std::isfinite(v)) << name << int(normals);
    }
}

} // namespace
} // namespace insitu::test
