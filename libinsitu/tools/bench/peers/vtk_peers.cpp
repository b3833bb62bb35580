#include <cstdlib>
#include <vtkAbstractCellLocator.h>
#include <vtkCellLocator.h>
#include <vtkCellTreeLocator.h>
#include <vtkDataArray.h>
#include <vtkGenericCell.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkProbeFilter.h>
#include <vtkStaticCellLocator.h>

#include "peers/vtk_mesh.h"
#include "peers/vtk_parts.h"

namespace insitu::bench {

namespace {

using math::Vec3d;

template <class Locator>
class LocatorPeer : public Peer {
public:
  LocatorPeer(const char* name, vtkSmartPointer<vtkUnstructuredGrid> grid, const double* field)
      : name_(name), grid_(std::move(grid)), field_(field) {}

  const char* name() const override { return name_; }
  void build() override {
    locator_ = vtkSmartPointer<Locator>::New();
    locator_->SetDataSet(grid_);
    locator_->BuildLocator();
  }
  void locate(std::span<const Vec3d> points, std::span<std::int64_t> cells,
              std::span<Vec3d> parametric) override {
    run(points, cells, parametric, nullptr);
  }
  void sample(std::span<const Vec3d> points, std::span<std::int64_t> cells,
              std::span<double> values) override {
    run(points, cells, {}, values.data());
  }

private:
  void run(std::span<const Vec3d> points, std::span<std::int64_t> cells,
           std::span<Vec3d> parametric, double* values) {
    vtkNew<vtkGenericCell> cell;
    std::vector<double> weights(std::size_t(grid_->GetMaxCellSize()));
    for (std::size_t i = 0; i < points.size(); ++i) {
      double x[3] = {points[i].x, points[i].y, points[i].z}, r[3];
      cells[i] = locator_->FindCell(x, 0.0, cell, r, weights.data());
      if (!parametric.empty())
        parametric[i] = {r[0], r[1], r[2]};
      if (!values)
        continue;
      values[i] = 0.0;
      if (cells[i] >= 0)
        for (vtkIdType v = 0; v < cell->GetNumberOfPoints(); ++v)
          values[i] += weights[std::size_t(v)] * field_[cell->GetPointId(int(v))];
    }
  }

  const char* name_;
  vtkSmartPointer<vtkUnstructuredGrid> grid_;
  const double* field_;
  vtkSmartPointer<Locator> locator_;
};

/// The filter a user would take, with its default strategy.
class ProbePeer : public Peer {
public:
  explicit ProbePeer(vtkSmartPointer<vtkUnstructuredGrid> grid) : grid_(std::move(grid)) {}

  const char* name() const override { return "vtkProbeFilter"; }
  bool tells_cells() const override { return false; }
  void build() override {
    probe_ = vtkSmartPointer<vtkProbeFilter>::New();
    probe_->SetSourceData(grid_);
    grid_->BuildLocator(); // what its default strategy walks from
  }
  void locate(std::span<const Vec3d> points, std::span<std::int64_t> cells,
              std::span<Vec3d>) override {
    std::vector<double> values(points.size());
    sample(points, cells, values);
  }
  void sample(std::span<const Vec3d> points, std::span<std::int64_t> cells,
              std::span<double> values) override {
    vtkNew<vtkPoints> at;
    at->SetDataTypeToDouble();
    at->SetNumberOfPoints(vtkIdType(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i)
      at->SetPoint(vtkIdType(i), points[i].x, points[i].y, points[i].z);
    vtkNew<vtkPolyData> input;
    input->SetPoints(at);
    probe_->SetInputData(input);
    probe_->Update();
    vtkPointData* out = probe_->GetOutput()->GetPointData();
    vtkDataArray* valid = out->GetArray(probe_->GetValidPointMaskArrayName());
    vtkDataArray* f = out->GetArray("f");
    for (std::size_t i = 0; i < points.size(); ++i) {
      cells[i] = valid && valid->GetTuple1(vtkIdType(i)) != 0.0 ? 0 : -1;
      values[i] = f ? f->GetTuple1(vtkIdType(i)) : 0.0;
    }
  }

private:
  vtkSmartPointer<vtkUnstructuredGrid> grid_;
  vtkSmartPointer<vtkProbeFilter> probe_;
};

} // namespace

Peers make_vtk_peers(const workload::Mesh& mesh, const std::vector<double>& field) {
  // (vtkSMPTools.h of VTK 9.1 is not C++20, so its threads are limited from outside.)
  setenv("VTK_SMP_MAX_THREADS", "1", 1);
  const auto grid = make_grid(mesh, field);
  Peers all;
  all.push_back(std::make_unique<LocatorPeer<vtkStaticCellLocator>>("vtkStaticCellLocator", grid,
                                                                    field.data()));
  all.push_back(
      std::make_unique<LocatorPeer<vtkCellTreeLocator>>("vtkCellTreeLocator", grid, field.data()));
  all.push_back(
      std::make_unique<LocatorPeer<vtkCellLocator>>("vtkCellLocator", grid, field.data()));
  all.push_back(std::make_unique<ProbePeer>(grid));
  return all;
}

} // namespace insitu::bench
