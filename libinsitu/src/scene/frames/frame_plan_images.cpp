#include "scene/frames/frame_plan_images.h"

#include <algorithm>

#include "core/image.h"

namespace insitu::scene {

namespace {

using Held = Plan::Held;

/// Codes, and the file's bytes as if nothing could be compressed.
std::int64_t most_file_bytes(const Frame& frame, std::int64_t pixels) {
  constexpr std::int64_t headers = 8192;
  const bool alpha = frame.background_alpha < 1;
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

bool has_colors(const Frame& frame) {
  return frame.volume ||
         std::any_of(
             frame.isosurfaces.begin(), frame.isosurfaces.end(),
             [](const Isosurface& s) { return std::holds_alternative<ColorBy>(s.color); }) ||
         (frame.boundary && std::holds_alternative<ColorBy>(frame.boundary->color));
}

void overlays(const Frame& frame, Plan& plan) {
  const char* const over = "drawn over the image";
  const char* const not_asked = "not asked for";
  if (!frame.scalar_bar)
    plan.skip("scalar bar", not_asked);
  else if (has_colors(frame))
    plan.need("scalar bar", -1, over);
  else
    plan.skip("scalar bar", "nothing is coloured by a field");
  const auto overlay = [&](const char* item, bool asked) {
    if (asked)
      plan.need(item, -1, over);
    else
      plan.skip(item, not_asked);
  };
  overlay("time label", frame.time_label);
  overlay("axes", frame.axes);
}

} // namespace

void plan_images(const Frame& frame, const commit::CommittedMesh& mesh, Plan& plan) {
  const auto asked = [&](ImageKind kind) {
    return std::find(frame.images.begin(), frame.images.end(), kind) != frame.images.end();
  };
  const std::int64_t pixels = std::int64_t(frame.size[0]) * frame.size[1];
  const char* const why = "while it is drawn";
  plan.need("image of " + std::to_string(frame.size[0]) + " x " + std::to_string(frame.size[1]),
            pixels * std::int64_t(core::Image::bytes_a_pixel), why, Held::while_executed);
  const bool cell = asked(ImageKind::cell);
  const bool of_leaves = cell && mesh.mesh().has_stand_in();
  const bool globe = frame.geocentric && (frame.geocentric->globe || frame.geocentric->graticule);
  if (asked(ImageKind::depth) || of_leaves || globe)
    plan.need("image of depth", pixels * std::int64_t(sizeof(float)),
              asked(ImageKind::depth) ? why
              : of_leaves             ? "while it is drawn: it tells leaves from dual cells"
                                      : "while it is drawn: what the globe hides",
              Held::while_executed);
  else
    plan.skip("image of depth", "not among the frame's images");
  if (cell)
    plan.need("image of cells", pixels * std::int64_t(sizeof(std::int64_t)), why,
              Held::while_executed);
  else
    plan.skip("image of cells", "not among the frame's images");
  plan.need_at_most("files of images", most_file_bytes(frame, pixels),
                    "one at a time, while written", Held::while_executed);
  overlays(frame, plan);
}

} // namespace insitu::scene
