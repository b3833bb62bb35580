#include "runs/netcdf/cf.h"

#ifdef REPLAY_NETCDF

#include <algorithm>
#include <vtkNetCDFCFReader.h>

#include "runs/netcdf/netcdf_time.h"
#include "runs/netcdf/units.h"
#include "runs/vtk_run.h"

namespace insitu_replay {

namespace {

/// Geodetic where the axes are longitudes and latitudes, and the vertical one, if there is one, has
/// a unit of length.
std::optional<insitu::Frame> frame_of(const NetcdfFile& file) {
  bool longitude = false, latitude = false;
  double unit = 1;
  for (const NetcdfFile::Variable& v : file.variables()) {
    if (v.dims.size() != 1 || v.name != file.name_of_dim(v.dims[0]))
      continue; // no axis
    longitude = longitude || is_longitude(file, v);
    latitude = latitude || is_latitude(file, v);
    if (!file.text(v, "positive").empty() || file.text(v, "axis") == "Z")
      unit = metres_of(file.text(v, "units")).value_or(0);
  }
  if (!longitude || !latitude || (unit != 1 && unit != 1000))
    return std::nullopt;
  return insitu::Frame::geodetic(insitu::Vertical::up, insitu::Angle::degrees,
                                 unit == 1 ? insitu::Length::metres : insitu::Length::kilometres);
}

class CfRun : public Run {
public:
  CfRun(const std::string& path, vtkSmartPointer<vtkAlgorithm> reader)
      : path_(path), run_(path, std::move(reader)) {
    const NetcdfFile file(path);
    const NetcdfTime time = netcdf_time_of(file);
    unit_ = time.unit;
    note_ = time.note;
    frame_ = frame_of(file);
  }

  std::vector<double> times() const override {
    std::vector<double> out = run_.times();
    for (double& time : out)
      time *= unit_;
    return out;
  }
  vtkSmartPointer<vtkDataObject> read(std::optional<double> time) override {
    if (time) { // as the reader has it
      const std::vector<double> all = times(), own = run_.times();
      time = own[std::size_t(std::find(all.begin(), all.end(), *time) - all.begin())];
    }
    return run_.read(time);
  }
  std::optional<insitu::Frame> frame() const override { return frame_; }
  std::vector<std::string> notes() const override {
    return note_.empty() ? std::vector<std::string>() : std::vector{path_ + ": " + note_};
  }

private:
  std::string path_;
  VtkRun run_;
  double unit_ = 1;
  std::string note_;
  std::optional<insitu::Frame> frame_;
};

} // namespace

std::unique_ptr<Run> open_cf(const std::string& path) {
  const auto reader = vtkSmartPointer<vtkNetCDFCFReader>::New();
  reader->SetFileName(path.c_str());
  reader->SphericalCoordinatesOff();
  reader->ReplaceFillValueWithNanOn();
  reader->UpdateInformation();
  return std::make_unique<CfRun>(path, reader);
}

} // namespace insitu_replay

#endif
