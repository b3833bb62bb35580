#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStreamTracer.h>

#include "commands/advect.h"
#include "peers/vtk_mesh.h"

namespace insitu::bench {

std::vector<PeerLines> trace_by_vtk(const workload::Mesh& mesh, const std::vector<double>& velocity,
                                    const std::vector<math::Vec3d>& seeds, double length,
                                    double step, double error, int repetitions) {
  const std::vector<double> none(std::size_t(mesh.vertex_count()));
  vtkSmartPointer<vtkUnstructuredGrid> grid = make_grid(mesh, none);
  vtkNew<vtkDoubleArray> vectors;
  vectors->SetName("velocity");
  vectors->SetNumberOfComponents(3);
  vectors->SetArray(const_cast<double*>(velocity.data()), vtkIdType(velocity.size()), 1);
  grid->GetPointData()->SetVectors(vectors);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const math::Vec3d& s : seeds)
    points->InsertNextPoint(s.x, s.y, s.z);
  vtkNew<vtkPolyData> source;
  source->SetPoints(points);

  std::vector<PeerLines> out;
  for (const bool adaptive : {false, true}) {
    PeerLines lines;
    lines.name = adaptive ? "vtkStreamTracer RK45" : "vtkStreamTracer RK4";
    vtkSmartPointer<vtkPolyData> result;
    // The first run builds the locator, which is not counted.
    vtkNew<vtkStreamTracer> tracer;
    tracer->SetInputData(grid);
    tracer->SetSourceData(source);
    tracer->SetIntegrationDirectionToForward();
    tracer->SetComputeVorticity(false);
    tracer->SetMaximumPropagation(length);
    tracer->SetMaximumNumberOfSteps(1000000);
    tracer->SetIntegrationStepUnit(vtkStreamTracer::CELL_LENGTH_UNIT);
    tracer->SetInitialIntegrationStep(step);
    if (adaptive) {
      tracer->SetIntegratorTypeToRungeKutta45();
      tracer->SetMaximumError(error);
      tracer->SetMinimumIntegrationStep(1e-3);
      tracer->SetMaximumIntegrationStep(1.0);
    } else {
      tracer->SetIntegratorTypeToRungeKutta4();
    }
    tracer->Update();
    for (int i = 0; i < repetitions; ++i) {
      tracer->Modified();
      lines.time.time([&] { tracer->Update(); });
    }
    result = tracer->GetOutput();
    lines.ends = seeds;
    lines.times.assign(seeds.size(), 0.0);
    lines.whole.assign(seeds.size(), false);
    vtkDataArray* const times = result->GetPointData()->GetArray("IntegrationTime");
    vtkDataArray* const ids = result->GetCellData()->GetArray("SeedIds");
    vtkDataArray* const reasons = result->GetCellData()->GetArray("ReasonForTermination");
    for (vtkIdType l = 0; times && ids && reasons && l < result->GetNumberOfLines(); ++l) {
      vtkNew<vtkIdList> line;
      result->GetLines()->GetCellAtId(l, line);
      const vtkIdType last = line->GetId(line->GetNumberOfIds() - 1);
      const auto seed = std::size_t(ids->GetTuple1(l));
      double x[3];
      result->GetPoint(last, x);
      lines.ends[seed] = {x[0], x[1], x[2]};
      lines.times[seed] = times->GetTuple1(last);
      lines.whole[seed] = int(reasons->GetTuple1(l)) == vtkStreamTracer::OUT_OF_LENGTH;
      lines.steps += line->GetNumberOfIds() - 1;
    }
    out.push_back(std::move(lines));
  }
  return out;
}

} // namespace insitu::bench
