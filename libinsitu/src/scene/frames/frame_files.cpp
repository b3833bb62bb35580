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

  /// cells: of the image of these.
  void write_png(const std::string& path, ImageKind kind,
                 const std::optional<output::DepthScale>& scale,
                 std::span<const std::int64_t> cells) const {
    switch (kind) {
    case ImageKind::color:
      output::write_png(path, images_.color, keep_alpha_);
      break;
    case ImageKind::depth:
      output::write_depth_png(path, width_, height_, images_.depth, *scale, counted());
      break;
    case ImageKind::cell:
      output::write_cell_png(path, width_, height_, cells, counted());
      break;
    }
  }

  void write_exr(const std::string& path, ImageKind kind,
                 std::span<const std::int64_t> cells) const {
    switch (kind) {
    case ImageKind::color:
      output::write_exr(path, images_.color, keep_alpha_, attributes_);
      break;
    case ImageKind::depth:
      output::write_depth_exr(path, width_, height_, images_.depth, attributes_, counted());
      break;
    case ImageKind::cell:
      output::write_cell_exr(path, width_, height_, cells, attributes_, counted());
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

/// The image of the cells of one of several meshes: those of others are none.
core::CountedVector<std::int64_t> cells_of(const Frame& frame, const render::FrameImages& images,
                                           const std::string& mesh) {
  core::CountedVector<std::int64_t> cells(images.cell);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (frame.layers[std::size_t(images.layer[i])].mesh.text != mesh)
      cells[i] = -1;
  return cells;
}

} // namespace

void write_frame_files(const Frame& frame, const Environment& environment,
                       const render::FrameImages& images, CinemaRow row) {
  const FrameFiles files(frame, images, row);
  const std::string name = row.camera.empty() ? frame.name : frame.name + "_" + row.camera;
  std::vector<CinemaRow> rows;
  const auto write = [&](ImageKind kind, const std::string& mesh) {
    const std::string stem = image_stem(name, kind, mesh);
    std::optional<output::DepthScale> scale;
    if (kind == ImageKind::depth)
      scale = output::depth_scale(images.depth);
    std::optional<core::CountedVector<std::int64_t>> of_mesh;
    if (!mesh.empty())
      of_mesh.emplace(cells_of(frame, images, mesh));
    const std::span<const std::int64_t> cells = of_mesh ? *of_mesh : images.cell;
    for (const ImageFormat format : frame.formats) {
      const std::string path =
          cycle_path(environment, stem, row.cycle, format == ImageFormat::exr ? ".exr" : ".png");
      if (format == ImageFormat::exr)
        files.write_exr(path, kind, cells);
      else
        files.write_png(path, kind, scale, cells);
      ++environment.statistics.files;
      // Browsers show PNG; of cells they would show numbers as colours.
      if (environment.page && format == ImageFormat::png && kind != ImageKind::cell)
        environment.page->add_frame(stem, kind == ImageKind::depth ? "depth" : "color", path);
      row.image = kind;
      row.mesh = mesh;
      row.format = format;
      row.depth = scale ? std::optional(ValueRange{scale->low, scale->high}) : std::nullopt;
      row.file = path.substr(environment.output.size() + 1);
      rows.push_back(row);
    }
  };
  for (const ImageKind kind : frame.images)
    for (const std::string& mesh : image_meshes(frame, kind))
      write(kind, mesh);
  // The images first: they are what was asked for.
  if (!rows.empty())
    environment.statistics.files += environment.table.put(rows, environment.context.log);
}

} // namespace insitu::scene
