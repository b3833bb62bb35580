#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <gtest/gtest.h>
#include <string>
#include <utility>
#include <vector>

#include "unit/render/render_mesh.h"

/// Several meshes in one frame, and what rays see of homogeneous boxes.
namespace insitu::test {
using render::Color;
using render::FrameImages;
using render::FrameSettings;
using render::RayGenerator;
using render::Stretch;
using render::VolumeSettings;

/// A box of n^3 cells.
struct Box {
  Vec3d low, high;
};

inline TestMesh cells_of(const Box& box, int n = 4, double jitter = 0.2,
                         Shape shape = Shape::hexahedron) {
  TestMesh mesh = box_cells(n, shape, jitter);
  for (Vec3d& p : mesh.vertices)
    for (int a = 0; a < 3; ++a)
      p[a] = box.low[a] + p[a] * (box.high[a] - box.low[a]);
  return mesh;
}

/// The cells of both.
inline TestMesh together(TestMesh a, const TestMesh& b) {
  const auto shift = std::int32_t(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (MeshCell cell : b.cells) {
    for (auto& v : cell.vertices)
      v += shift;
    a.cells.push_back(cell);
  }
  return a;
}

/// Cut where x is a half, between hexahedra.
inline std::pair<TestMesh, TestMesh> halves_of(const TestMesh& cells) {
  TestMesh left = cells, right = cells;
  const auto keep = [&](TestMesh& half, bool low) {
    std::erase_if(half.cells, [&](const MeshCell& cell) {
      Vec3d p;
      for (const auto v : cell.vertices)
        p += 0.125 * cells.vertices[std::size_t(v)];
      return (p.x < 0.5) != low;
    });
  };
  keep(left, true);
  keep(right, false);
  return {left, right};
}

struct Layer {
  RenderMesh* mesh;
  FrameSettings settings;
};

inline core::Image draw(const std::vector<Layer>& layers, int threads = 2,
                        render::FrameStatistics* statistics = nullptr,
                        std::vector<float>* depth = nullptr,
                        const std::function<void(const FrameImages&)>& check = {}) {
  const core::Threads pool(threads);
  std::deque<query::Sampler> samplers;
  std::deque<render::Structures> structures;
  std::vector<render::FrameLayer> drawn;
  for (const Layer& layer : layers) {
    samplers.push_back(layer.mesh->sampler());
    structures.emplace_back(layer.mesh->committed.memory).begin(samplers.back(), 0, 0, pool);
    drawn.push_back({samplers.back(), layer.settings, structures.back()});
  }
  const FrameImages images = render::render_frame(drawn, pool, statistics);
  if (check)
    check(images);
  if (depth)
    depth->assign(images.depth.begin(), images.depth.end());
  return images.color;
}

/// By the greatest difference of a number of a pixel.
inline double difference(const core::Image& a, const core::Image& b) {
  double most = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      for (int c = 0; c < 4; ++c)
        most = std::max(most, std::fabs(double(a.pixel(x, y)[c]) - b.pixel(x, y)[c]));
  return most;
}

inline Stretch stretch_of(const render::Ray& ray, const Box& box) {
  Stretch in{0, HUGE_VAL};
  for (int a = 0; a < 3; ++a) {
    const double t0 = (box.low[a] - ray.origin[a]) / ray.direction[a];
    const double t1 = (box.high[a] - ray.origin[a]) / ray.direction[a];
    in.from = std::max(in.from, std::min(t0, t1));
    in.to = std::min(in.to, std::max(t0, t1));
  }
  return {in.from, std::max(in.from, in.to)};
}

/// A homogeneous medium in a box.
struct Medium {
  Box box;
  double opacity; ///< over a length of 1
  double grey;
};

/// What a ray sees of media: alpha, and the colour without the background.
inline std::pair<double, double> seen(const render::Ray& ray, const std::vector<Medium>& media) {
  std::vector<double> ends;
  for (const Medium& m : media) {
    const Stretch in = stretch_of(ray, m.box);
    ends.insert(ends.end(), {in.from, in.to});
  }
  std::sort(ends.begin(), ends.end());
  double through = 1, color = 0;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const double middle = 0.5 * (ends[i - 1] + ends[i]), length = ends[i] - ends[i - 1];
    double tau = 0, emitted = 0;
    for (const Medium& m : media) {
      const Stretch in = stretch_of(ray, m.box);
      if (!(in.from < middle && middle < in.to))
        continue;
      const double own = -std::log1p(-m.opacity) * length;
      tau += own;
      emitted += own * m.grey;
    }
    if (tau > 0)
      color += through * -std::expm1(-tau) * emitted / tau;
    through *= std::exp(-tau);
  }
  return {1 - through, through < 1 ? color / (1 - through) : 0};
}

class SeveralMeshes : public testing::Test {
protected:
  SeveralMeshes() {
    frame = box_frame(32);
    frame.background_alpha = 0;
    frame.lighting.enabled = false;
  }

  RenderMesh& mesh(const TestMesh& cells) { return meshes.emplace_back(cells); }
  Layer layer(const Medium& m, int n = 4) {
    RenderMesh& of = mesh(cells_of(m.box, n));
    const auto one = of.field("one", INSITU_VERTEX, [](const Vec3d&) { return 1.0; });
    FrameSettings s = frame;
    s.volume = VolumeSettings{one, constant_function(m.opacity, m.grey)};
    s.volume->unit_distance = 1;
    return {&of, s};
  }
  /// Both orders of the list, and all forms of a volume.
  void expect_closed_form(const std::vector<Medium>& media) {
    const RayGenerator rays(frame.camera, frame.width, frame.height);
    std::vector<Layer> layers;
    int n = 3;
    for (const Medium& m : media)
      layers.push_back(layer(m, n++)); // steps differ
    for (const char* form : {"samples", "integrals", "tolerance"})
      for (const bool reversed : {false, true}) {
        SCOPED_TRACE(std::string(form) + (reversed ? ", reversed" : ""));
        for (Layer& l : layers) {
          l.settings.volume->preintegrated = form == std::string("integrals");
          if (form == std::string("tolerance"))
            l.settings.volume->tolerance = 0.01;
        }
        std::vector<Layer> listed = layers;
        if (reversed)
          std::reverse(listed.begin(), listed.end());
        const core::Image image = draw(listed);
        int both = 0;
        for (int y = 0; y < frame.height; ++y)
          for (int x = 0; x < frame.width; ++x) {
            const auto [alpha, grey] = seen(rays(x, y), media);
            const float* p = image.pixel(x, y);
            // Floats' rounding for each of some hundred samples, and the bounds' own.
            EXPECT_NEAR(p[3], alpha, 1e-5) << x << ", " << y;
            if (alpha > 0.01) {
              EXPECT_NEAR(p[0], grey, 1e-4) << x << ", " << y;
            }
            both += std::all_of(media.begin(), media.end(), [&](const Medium& m) {
              const Stretch in = stretch_of(rays(x, y), m.box);
              return in.to > in.from;
            });
          }
        EXPECT_GT(both, 50);
      }
  }

  std::deque<RenderMesh> meshes;
  FrameSettings frame;
};

} // namespace insitu::test
