#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vtkAutoInit.h>
#include <vtkCamera.h>
#include <vtkColorTransferFunction.h>
#include <vtkDataSetTriangleFilter.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGridVolumeRayCastMapper.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include "measure.h"
#include "commands/render.h"
#include "peers/vtk_mesh.h"

VTK_MODULE_INIT(vtkRenderingOpenGL2)
VTK_MODULE_INIT(vtkRenderingVolumeOpenGL2)

namespace insitu::bench {

namespace {

/// Colours go through VTK's own table in linear light, so that both pictures can be compared.
void set_functions(const render::VolumeSettings& settings, vtkVolumeProperty* property) {
  vtkNew<vtkColorTransferFunction> colors;
  vtkNew<vtkPiecewiseFunction> opacity; // which VTK takes for an attenuation
  const render::TransferFunction& function = settings.function;
  constexpr int steps = 256;
  for (int i = 0; i <= steps; ++i) {
    const double value = function.low() + (function.high() - function.low()) * i / steps;
    const render::Color c = function.color(value);
    colors->AddRGBPoint(value, double(c.r), double(c.g), double(c.b));
    opacity->AddPoint(value, -std::log1p(-std::min(function.opacity(value), 0.99)));
  }
  property->SetColor(colors);
  property->SetScalarOpacity(opacity);
  property->SetScalarOpacityUnitDistance(settings.unit_distance);
  property->SetInterpolationTypeToLinear();
  property->ShadeOff();
}

} // namespace

std::optional<PeerFrame> draw_by_vtk(const workload::Mesh& mesh, const std::vector<double>& field,
                                     const render::FrameSettings& settings, int repetitions,
                                     std::string& why) {
  if (!std::getenv("DISPLAY")) {
    why = "its window needs a display (DISPLAY is not set; xvfb-run gives one)";
    return std::nullopt;
  }
  PeerFrame out;
  out.name = "vtkUnstructuredGridVolumeRayCastMapper";
  vtkNew<vtkDataSetTriangleFilter> tetrahedra;
  Series convert;
  convert.time([&] {
    tetrahedra->SetInputData(make_grid(mesh, field));
    tetrahedra->TetrahedraOnlyOn();
    tetrahedra->Update();
  });
  out.convert_seconds = convert.for_ratio(1);
  out.cells = tetrahedra->GetOutput()->GetNumberOfCells();
  vtkNew<vtkUnstructuredGridVolumeRayCastMapper> mapper;
  mapper->SetInputData(tetrahedra->GetOutput());
  mapper->SelectScalarArray("f");
  mapper->SetScalarModeToUsePointFieldData();
  mapper->AutoAdjustSampleDistancesOff();
  mapper->SetImageSampleDistance(1.0f);
  mapper->IntermixIntersectingGeometryOff();
  mapper->SetNumberOfThreads(1);
  vtkNew<vtkVolume> volume;
  volume->SetMapper(mapper);
  set_functions(*settings.volume, volume->GetProperty());
  vtkNew<vtkRenderer> renderer;
  renderer->AddVolume(volume);
  renderer->SetBackground(0, 0, 0);
  const render::Camera& from = settings.camera;
  vtkCamera* camera = renderer->GetActiveCamera();
  camera->SetPosition(from.position.x, from.position.y, from.position.z);
  camera->SetFocalPoint(from.look_at.x, from.look_at.y, from.look_at.z);
  camera->SetViewUp(from.up.x, from.up.y, from.up.z);
  camera->SetViewAngle(from.fov);
  renderer->ResetCameraClippingRange();
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(0);
  window->SetSize(settings.width, settings.height);
  window->AddRenderer(renderer);
  Series first;
  first.time([&] { window->Render(); });
  for (int i = 0; i < repetitions; ++i)
    out.time.time([&] { window->Render(); });
  out.first_seconds = first.for_ratio(1);
  vtkNew<vtkUnsignedCharArray> pixels;
  window->GetPixelData(0, 0, settings.width - 1, settings.height - 1, 1, pixels);
  out.color = core::Image(settings.width, settings.height);
  for (int y = 0; y < settings.height; ++y)
    for (int x = 0; x < settings.width; ++x) {
      float* to = out.color.pixel(x, settings.height - 1 - y);
      for (int c = 0; c < 3; ++c)
        to[c] = float(pixels->GetComponent(vtkIdType(y) * settings.width + x, c) / 255.0);
      to[3] = 1.0f;
    }
  return out;
}

} // namespace insitu::bench
