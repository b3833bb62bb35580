#include "scene/frames/frame_files.h"

#include "output/image/depth_image.h"
#include "output/image/exr.h"
#include "output/image/png.h"

namespace insitu::scene {

namespace {

class FrameFiles {
public:
  FrameFiles(const Frame& frame, const render::FrameImages& images, const CinemaRow& row)
      : images_(images), width_(images.color.width), height_(images.color.height),
        keep_alpha_(frame.keeps_alpha()), attributes_{{"cycle", row.cycle}, {"time", row.time}} {}

  void write_png(const std::string& path, ImageKind kind,
                 const std::optional<output::DepthScale>& scale) const {
    switch (kind) {
    case ImageKind::color:
      output::write_png(path, images_.color, keep_alpha_);
      break;
    case ImageKind::depth:
      output::write_depth_png(path, width_, height_, images_.depth, *scale, counted());
      break;
    case ImageKind::cell:
      output::write_cell_png(path, width_, height_, images_.cell, counted());
      break;
    }
  }

  void write_exr(const std::string& path, ImageKind kind) const {
    switch (kind) {
    case ImageKind::color:
      output::write_exr(path, images_.color, keep_alpha_, attributes_);
      break;
    case ImageKind::depth:
      output::write_depth_exr(path, width_, height_, images_.depth, attributes_, counted());
      break;
    case ImageKind::cell:
      output::write_cell_exr(path, width_, height_, images_.cell, attributes_, counted());
      break;
    }
  }

private:
  core::CountedAllocator<char> counted() const { return images_.color.rgba.get_allocator(); }

  const render::FrameImages& images_;
  int width_, height_;
  bool keep_alpha_;
  std::vector<output::ExrAttribute> attributes_;
};

} // namespace

void write_frame_files(const Frame& frame, const Environment& environment,
                       const render::FrameImages& images, CinemaRow row) {
  const FrameFiles files(frame, images, row);
  const std::string stem = row.camera.empty() ? frame.name : frame.name + "_" + row.camera;
  std::vector<CinemaRow> rows;
  for (const ImageKind kind : frame.images) {
    std::optional<output::DepthScale> scale;
    if (kind == ImageKind::depth)
      scale = output::depth_scale(images.depth);
    for (const ImageFormat format : frame.formats) {
      const std::string path = cycle_path(environment, image_stem(stem, kind), row.cycle,
                                          format == ImageFormat::exr ? ".exr" : ".png");
      if (format == ImageFormat::exr)
        files.write_exr(path, kind);
      else
        files.write_png(path, kind, scale);
      ++environment.statistics.files;
      // Browsers show PNG; of cells they would show numbers as colours.
      if (environment.page && format == ImageFormat::png && kind != ImageKind::cell)
        environment.page->add_frame(image_stem(stem, kind),
                                    kind == ImageKind::depth ? "depth" : "color", path);
      row.image = kind;
      row.format = format;
      row.depth = scale ? std::optional(ValueRange{scale->low, scale->high}) : std::nullopt;
      row.file = path.substr(environment.output.size() + 1);
      rows.push_back(row);
    }
  }
  // The images first: they are what was asked for.
  if (!rows.empty())
    environment.statistics.files += environment.table.put(rows, environment.context.log);
}

} // namespace insitu::scene
