#include "scene/frames/frame_plan_images.h"

#include <algorithm>

#include "core/image.h"

namespace insitu::scene {

namespace {

using Held = Plan::Held;

/// Codes, and the file's bytes as if nothing could be compressed.
std::int64_t most_file_bytes(const Frame& frame, std::int64_t pixels) {
  constexpr std::int64_t headers = 8192;
  const bool alpha = frame.keeps_alpha();
  std::int64_t most = 0;
  for (const ImageFormat format : frame.formats)
    for (const ImageKind kind : frame.images) {
      const bool exr = format == ImageFormat::exr;
      std::int64_t codes = 0, written = 0; // a pixel
      switch (kind) {
      case ImageKind::color:
        codes = exr ? (alpha ? 16 : 0) : 3 + alpha;
        written = exr ? 12 + 4 * alpha : codes;
        break;
      case ImageKind::depth:
        codes = exr ? 0 : 4;
        written = exr ? 4 : 2;
        break;
      case ImageKind::cell:
        codes = exr ? 4 : 12;
        written = exr ? 4 : 6;
        break;
      }
      most = std::max(most, pixels * (codes + written) + pixels * written / 1000 +
                                16 * std::int64_t(frame.size[1]) + headers);
    }
  return most;
}

void overlays(const Frame& frame, const FrameDecisions& decisions, Plan& plan) {
  plan.tell("scalar bar", decisions.scalar_bar);
  const auto overlay = [&](const char* item, bool asked) {
    plan.tell(item, {asked, asked ? "drawn over the image" : "not asked for"});
  };
  overlay("time label", frame.time_label.has_value());
  overlay("axes", frame.axes);
}

} // namespace

void plan_images(const Frame& frame, const FrameDecisions& decisions, Plan& plan) {
  const std::int64_t pixels = std::int64_t(frame.size[0]) * frame.size[1];
  plan.need("image of " + std::to_string(frame.size[0]) + " x " + std::to_string(frame.size[1]),
            pixels * std::int64_t(core::Image::bytes_a_pixel), "while it is drawn",
            Held::while_executed);
  plan.tell("image of a sample", decisions.samples,
            pixels * std::int64_t(core::Image::bytes_a_pixel), Held::while_executed);
  plan.tell("image of depth", decisions.depth, pixels * std::int64_t(sizeof(float)),
            Held::while_executed);
  plan.tell("image of cells", decisions.cell, pixels * std::int64_t(sizeof(std::int64_t)),
            Held::while_executed);
  if (decisions.cell && frame.layers.size() > 1)
    plan.need("image of the meshes of cells",
              pixels * std::int64_t(sizeof(std::int32_t) + sizeof(std::int64_t)),
              "whose cells are seen, while it is drawn; and the cells of one, while written",
              Held::while_executed);
  plan.need_at_most("files of images", most_file_bytes(frame, pixels),
                    "one at a time, while written", Held::while_executed);
  overlays(frame, decisions, plan);
}

} // namespace insitu::scene
