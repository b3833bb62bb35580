#include "runs/netcdf/ugrid.h"

#include <algorithm>
#include <cmath>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include "file_error.h"
#include "runs/netcdf/netcdf_time.h"
#include "runs/netcdf/ugrid_fields.h"
#include "runs/netcdf/ugrid_heights.h"
#include "runs/netcdf/ugrid_topology.h"
#include "runs/netcdf/ugrid_vertical.h"

namespace insitu_replay {

namespace {

class UgridRun : public Run {
public:
  explicit UgridRun(const std::string& path)
      : file_(path), topology_(read_ugrid_topology(file_)),
        time_(netcdf_time_of(file_)), dims_{file_, topology_, time_.dim} {
    for (const std::string& other : topology_.others)
      notes_.push_back("mesh '" + other + "' is left out: one mesh of faces or volumes is read");
    for (std::size_t i = 0; time_.coordinate && i < time_.values.size(); ++i)
      if (!std::isfinite(time_.values[i]) || (i > 0 && time_.values[i] <= time_.values[i - 1]))
        file_.fail(*time_.coordinate,
                   "the time of step " + std::to_string(i) + " does not follow the one before");
    if (!time_.note.empty())
      notes_.push_back(time_.note);
    fields_ = fields_of(dims_, notes_);
    if (topology_.dimension == 2) {
      faces_ = cut_faces(file_, topology_);
      vertical_ = UgridVertical::find(
          dims_, [&](int level) { return values_along(level); }, notes_);
      drop_coordinates();
    }
    resolve_levels(dims_, vertical_.get(), fields_, notes_);
    if (!faces_.cut.empty())
      notes_.push_back(std::to_string(faces_.cut.size()) +
                       " faces of more than four vertices are cut into triangles about their "
                       "centres: cells are these triangles, and the field 'ugrid_face' has the "
                       "numbers of the faces in the file");
    make_cells();
  }

  std::vector<double> times() const override { return time_.values; }
  std::optional<insitu::Frame> frame() const override {
    return topology_.geodetic ? std::optional(insitu::Frame::geodetic()) : std::nullopt;
  }
  std::vector<std::string> notes() const override {
    std::vector<std::string> out;
    for (const std::string& note : notes_)
      out.push_back(file_.path() + ": " + note);
    return out;
  }

  vtkSmartPointer<vtkDataObject> read(std::optional<double> time) override {
    const auto at =
        time ? std::find(time_.values.begin(), time_.values.end(), *time) : time_.values.begin();
    const auto step = std::size_t(at - time_.values.begin());
    if (time && at == time_.values.end())
      throw FileError(file_.path(), "has no time " + std::to_string(*time));
    const UgridColumn column = column_at(step);
    auto out = vtkSmartPointer<vtkUnstructuredGrid>::New();
    if (!points_ || (vertical_ && vertical_->moves))
      points_ = points_of(column);
    out->SetPoints(points_);
    out->SetCells(types_, cells_);
    set_fields(dims_, faces_, column, fields_, step, out);
    add_vectors(file_, fields_, !vertical_ && topology_.dimension == 2, out);
    if (!faces_.cut.empty())
      out->GetCellData()->AddArray(face_numbers());
    return out;
  }

private:
  /// Coordinates along the levels are no fields: the heights are those of the points.
  void drop_coordinates() {
    std::erase_if(fields_, [&](const UgridField& field) {
      return vertical_ && vertical_->is_coordinate(*field.v);
    });
  }

  UgridVertical::Along values_along(int level) const {
    UgridVertical::Along out;
    for (const UgridField& field : fields_)
      if (dims_.has(*field.v, level) && !gives_heights(file_, *field.v))
        (field.of_cells ? out.cells : out.nodes) = true;
    return out;
  }

  /// Nodes with the made vertices behind.
  std::vector<double> with_made(std::vector<double> values, bool longitudes) const {
    if (topology_.dimension == 2)
      append_means(topology_, faces_, longitudes, values);
    return values;
  }

  std::vector<double> levels_with_made(const std::vector<double>& levels) const {
    const std::size_t nodes = topology_.nodes();
    std::vector<double> out;
    for (std::size_t k = 0; k < levels.size() / nodes; ++k) {
      const auto first = levels.begin() + std::ptrdiff_t(k * nodes);
      const std::vector<double> level = with_made({first, first + std::ptrdiff_t(nodes)}, false);
      out.insert(out.end(), level.begin(), level.end());
    }
    return out;
  }

  UgridColumn column_at(std::size_t step) const {
    UgridColumn out;
    out.vertical = vertical_.get();
    out.nodes = topology_.nodes() + faces_.cut.size();
    if (!vertical_)
      return out;
    out.interfaces = levels_with_made(vertical_->interfaces(dims_, step));
    if (vertical_->layer_dim >= 0)
      out.middles = levels_with_made(vertical_->middles(dims_, step));
    return out;
  }

  vtkSmartPointer<vtkPoints> points_of(const UgridColumn& column) const {
    const std::vector<double> x = with_made(topology_.x, topology_.geodetic),
                              y = with_made(topology_.y, false);
    const std::size_t levels = vertical_ ? vertical_->layers + 1 : 1;
    auto points = vtkSmartPointer<vtkPoints>::New();
    points->SetDataTypeToDouble();
    points->SetNumberOfPoints(vtkIdType(levels * column.nodes));
    for (std::size_t k = 0; k < levels; ++k)
      for (std::size_t n = 0; n < column.nodes; ++n) {
        const std::size_t i = k * column.nodes + n;
        points->SetPoint(vtkIdType(i), x[n], y[n],
                         vertical_                  ? column.interfaces[i]
                         : topology_.dimension == 3 ? topology_.z[n]
                                                    : 0.0);
      }
    return points;
  }

  void add_cell(unsigned char type, const std::vector<vtkIdType>& ids) {
    types_->InsertNextValue(type);
    cells_->InsertNextCell(vtkIdType(ids.size()), ids.data());
  }

  void make_cells() {
    if (topology_.dimension == 3) {
      for (std::size_t c = 0; c < topology_.cells(); ++c) {
        const std::vector<vtkIdType> ids(topology_.ids.begin() + topology_.offsets[c],
                                         topology_.ids.begin() + topology_.offsets[c + 1]);
        add_cell(ids.size() == 4   ? VTK_TETRA
                 : ids.size() == 5 ? VTK_PYRAMID
                 : ids.size() == 6 ? VTK_WEDGE
                                   : VTK_HEXAHEDRON,
                 ids);
      }
      return;
    }
    const auto ring_of = [&](std::size_t c) {
      return std::vector<vtkIdType>(faces_.ids.begin() + faces_.offsets[c],
                                    faces_.ids.begin() + faces_.offsets[c + 1]);
    };
    if (!vertical_) {
      for (std::size_t c = 0; c < faces_.cells(); ++c) {
        const std::vector<vtkIdType> ring = ring_of(c);
        add_cell(ring.size() == 3 ? VTK_TRIANGLE : VTK_QUAD, ring);
      }
      return;
    }
    const std::vector<double> z = vertical_->interfaces(dims_, 0);
    double thickness = 0; // of all columns, as some may be dry
    for (std::size_t n = 0; n < topology_.nodes(); ++n)
      thickness += z[z.size() - topology_.nodes() + n] - z[n];
    const bool up = thickness > 0;
    const auto nodes = vtkIdType(topology_.nodes() + faces_.cut.size());
    for (std::size_t layer = 0; layer < vertical_->layers; ++layer)
      for (std::size_t c = 0; c < faces_.cells(); ++c) {
        std::vector<vtkIdType> lower = ring_of(c), upper;
        if (lower.size() == 3) // a wedge's first triangle is seen from outside
          std::swap(lower[1], lower[2]);
        upper = lower;
        for (vtkIdType& id : up ? upper : lower)
          id += nodes;
        for (auto* ring : {&lower, &upper})
          for (vtkIdType& id : *ring)
            id += nodes * vtkIdType(layer);
        lower.insert(lower.end(), upper.begin(), upper.end());
        add_cell(lower.size() == 6 ? VTK_WEDGE : VTK_HEXAHEDRON, lower);
      }
  }

  vtkSmartPointer<vtkDataArray> face_numbers() const {
    auto array = vtkSmartPointer<vtkDoubleArray>::New();
    array->SetName("ugrid_face");
    for (std::size_t layer = 0; layer < (vertical_ ? vertical_->layers : 1); ++layer)
      for (const std::int64_t face : faces_.face)
        array->InsertNextValue(double(face));
    return array;
  }

  NetcdfFile file_;
  UgridTopology topology_;
  NetcdfTime time_;
  UgridDims dims_;
  std::vector<std::string> notes_;
  std::vector<UgridField> fields_;
  CutFaces faces_;
  std::unique_ptr<UgridVertical> vertical_;
  vtkNew<vtkUnsignedCharArray> types_;
  vtkNew<vtkCellArray> cells_;
  vtkSmartPointer<vtkPoints> points_;
};

} // namespace

std::unique_ptr<Run> open_ugrid(const std::string& path) {
  if (!is_ugrid(NetcdfFile(path)))
    return nullptr;
  return std::make_unique<UgridRun>(path);
}

} // namespace insitu_replay
