#include "paper/zellmann_meshes.h"

#include <cmath>

namespace insitu::bench::paper {

namespace {

using math::Vec3d;

constexpr double box = 256.0;

double field(const Vec3d& p) {
  const Vec3d d = p - Vec3d{box / 2, box / 2, box / 2};
  return 0.5 + 0.5 * std::tanh((90.0 - std::sqrt(dot(d, d))) / 16.0);
}

} // namespace

AdaptiveCase AdaptiveCase::of_blocks(std::int64_t cells) {
  AdaptiveCase out;
  out.blocks_ = workload::make_amr(cells);
  out.set_values();
  return out;
}

AdaptiveCase AdaptiveCase::of_front(std::int64_t cells) {
  AdaptiveCase out;
  out.is_octree_ = out.is_front_ = true;
  out.octree_ = workload::make_front_octree(cells);
  out.set_values();
  return out;
}

AdaptiveCase AdaptiveCase::of_octree(std::int64_t cells) {
  AdaptiveCase out;
  out.is_octree_ = true;
  out.octree_ = workload::make_octree(cells);
  out.set_values();
  return out;
}

AdaptiveCase AdaptiveCase::of_balanced_octree(std::int64_t cells) {
  AdaptiveCase out;
  out.is_octree_ = out.is_balanced_ = true;
  out.octree_ = workload::balanced(workload::make_octree(cells));
  out.set_values();
  return out;
}

AdaptiveCase AdaptiveCase::cut(int level_count) const {
  AdaptiveCase out;
  out.is_octree_ = is_octree_;
  out.is_balanced_ = is_balanced_;
  out.is_front_ = is_front_;
  if (is_front_) {
    out.octree_ = workload::make_front_octree(int(std::lround(box / octree_.spacing)), level_count);
  } else if (is_octree_) {
    out.octree_ = workload::make_octree(octree_.reach, level_count);
    if (is_balanced_)
      out.octree_ = workload::balanced(out.octree_);
  } else {
    out.blocks_ = blocks_;
    std::erase_if(out.blocks_.blocks, [&](const auto& b) { return b.level >= level_count; });
    out.blocks_.level_count = level_count;
    out.blocks_.values.resize(std::size_t(out.blocks_.cell_count()));
  }
  out.set_values();
  return out;
}

void AdaptiveCase::set_values() {
  std::size_t at = 0;
  for (const auto& block : blocks_.blocks)
    for (std::int64_t c = 0; c < blocks_.cells_a_block(); ++c)
      blocks_.values[at++] = field(blocks_.centre(block, c));
  for (std::size_t i = 0; i < octree_.leaves.levels.size(); ++i) {
    const double width = octree_.spacing / double(1 << octree_.leaves.levels[i]);
    Vec3d p;
    for (int a = 0; a < 3; ++a)
      p[a] = (octree_.leaves.corners[3 * i + std::size_t(a)] + 0.5) * width;
    octree_.leaves.values[i] = field(p);
  }
}

std::unique_ptr<commit::CommittedMesh> AdaptiveCase::make(core::Memory& memory) const {
  return is_octree_ ? register_leaves(octree_.leaves, octree_.spacing, octree_.level_count,
                                      INSITU_DUAL, memory)
                    : register_patches(blocks_, INSITU_DUAL, memory);
}

Held hold(const AdaptiveCase& mesh, int threads) {
  Held out;
  out.context = std::make_unique<core::Context>(threads, core::Log());
  core::Memory& memory = out.context->memory;
  out.mesh = mesh.make(memory);
  out.mesh->commit(out.context->threads, out.context->log, memory, true);
  (void)out.mesh->mesh().field("f"); // gathered when asked for
  out.data = double(out.mesh->amr_info().bytes + memory.current(INSITU_MEMORY_GATHERED));
  out.total = double(memory.current());
  out.peak = double(memory.peak());
  return out;
}

Held hold_reference(const Held& ours, int threads) {
  Held out;
  out.plain = welded(plain_dual(*ours.mesh));
  out.context = std::make_unique<core::Context>(threads, core::Log());
  core::Memory& memory = out.context->memory;
  out.mesh = register_plain(out.plain, memory);
  out.mesh->commit(out.context->threads, out.context->log, memory, true);
  out.data = double(out.plain.bytes() + out.plain.bytes_values());
  out.total = out.data + double(memory.current());
  out.peak = out.data + double(memory.peak());
  return out;
}

render::FrameSettings march_frame(const commit::CommittedMesh& mesh, int size) {
  render::FrameSettings s;
  s.width = s.height = size;
  s.camera = render::Camera::around({0, 0, 0}, {box, box, box}, 30, 20);
  s.background = {0, 0, 0};
  s.volume = render::VolumeSettings{
      {mesh.mesh().field("f"), 0},
      {render::ColorMap::built_in("viridis"), 0.0, 1.0, {{0.0, 0.0}, {1.0, 0.005}}}};
  s.volume->unit_distance = 4.0;
  s.volume->step = box / 128;
  s.volume->skip_empty = false;
  return s;
}

render::FrameSettings path_frame(const commit::CommittedMesh& mesh, int size) {
  render::FrameSettings s = march_frame(mesh, size);
  s.volume->function = {render::ColorMap::built_in("viridis"), 0.0, 1.0, {{0.3, 0.0}, {1.0, 0.2}}};
  s.path_tracing = render::PathTracingSettings{};
  s.path_tracing->samples = 1;
  s.lighting.lights = {{render::Light::Kind::dome, {}, {1, 1, 1}}};
  return s;
}

render::Camera orbit(int i, int count) {
  const double elevation = std::asin(2 * (i + 0.5) / count - 1) * 180 / M_PI;
  return render::Camera::around({0, 0, 0}, {box, box, box}, std::fmod(137.50776405 * i, 360.0),
                                elevation, 0.5 + 0.5 * (i % 5));
}

} // namespace insitu::bench::paper
