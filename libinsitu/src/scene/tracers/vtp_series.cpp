#include "scene/tracers/vtp_series.h"

#include "core/status.h"

namespace insitu::scene {

VtkColumns::VtkColumns(std::vector<std::string> names, std::span<const double> values)
    : names_(std::move(names)) {
  const std::size_t width = names_.size(), rows = width ? values.size() / width : 0;
  columns_.assign(width, std::vector<double>(rows));
  for (std::size_t c = 0; c < width; ++c)
    for (std::size_t i = 0; i < rows; ++i)
      columns_[c][i] = values[i * width + c];
}

void VtkColumns::add_to(std::vector<output::VtkArray>& arrays) const {
  for (std::size_t c = 0; c < names_.size(); ++c)
    arrays.push_back(output::vtk_array(names_[c], std::span<const double>(columns_[c])));
}

output::VtkArray vtk_points(std::span<const math::Vec3d> points) {
  static_assert(sizeof(math::Vec3d) == 3 * sizeof(double));
  return output::vtk_array(
      "points", std::span<const double>(points.empty() ? nullptr : &points[0].x, 3 * points.size()),
      3);
}

void VtpSeries::write(const Environment& environment, const std::string& name, const Step& step,
                      output::VtkPolyData& data) {
  write(environment, name, cycle_path(environment, name, step.cycle, ".vtp"), step.time, data);
}

void VtpSeries::write(const Environment& environment, const std::string& name,
                      const std::string& path, double time, output::VtkPolyData& data) {
  data.has_time = true;
  data.time = time;
  output::write_vtp(path, data);
  ++environment.statistics.files;
  if (!index_) { // entries before this time stay, as rows of tables do
    const std::string index = environment.output + "/" + name + ".pvd";
    try {
      index_ = std::make_unique<output::FileSeries>(index, true, backward_);
    } catch (const core::Error&) { // not one of ours: replaced
      index_ = std::make_unique<output::FileSeries>(index);
    }
  }
  index_->add(time, path.substr(environment.output.size() + 1));
}

} // namespace insitu::scene
