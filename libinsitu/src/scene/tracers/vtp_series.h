#pragma once

#include <memory>

#include "output/vtk/file_series.h"
#include "output/vtk/xml_vtk.h"
#include "scene/run/environment.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// Values [row][column] turned into one named array a column, for VTK files.
class VtkColumns {
public:
  VtkColumns(std::vector<std::string> names, std::span<const double> values);
  void add_to(std::vector<output::VtkArray>& arrays) const;

private:
  std::vector<std::string> names_;
  std::vector<std::vector<double>> columns_;
};

/// Points as a VTK array over the same memory.
output::VtkArray vtk_points(std::span<const math::Vec3d> points);

/// One .vtp file a cycle and the .pvd index over them.
class VtpSeries {
public:
  /// backward: of a tracer whose time goes back.
  explicit VtpSeries(bool backward = false) : backward_(backward) {}

  /// Writes <output>/<name>_<cycle>.vtp and adds it to <output>/<name>.pvd.
  void write(const Environment& environment, const std::string& name, const Step& step,
             output::VtkPolyData& data);
  /// The same of a file `path`, within <output>, for some time.
  void write(const Environment& environment, const std::string& name, const std::string& path,
             double time, output::VtkPolyData& data);

private:
  std::unique_ptr<output::FileSeries> index_;
  bool backward_;
};

} // namespace insitu::scene
