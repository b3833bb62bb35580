// 07: a VTK data set as the mesh, its arrays read in place; answers as a VTK file.
#include <cmath>
#include <insitu/vtk.hpp>
#include <iostream>
#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

int main() try {
  vtkNew<vtkImageData> image;
  image->SetDimensions(11, 11, 11);
  image->SetSpacing(0.1, 0.1, 0.1);
  vtkNew<vtkDoubleArray> pressure;
  pressure->SetName("pressure");
  for (vtkIdType i = 0; i < image->GetNumberOfPoints(); ++i)
    pressure->InsertNextValue(image->GetPoint(i)[0] + 2.0 * image->GetPoint(i)[1]);
  image->GetPointData()->AddArray(pressure);

  insitu::Session session;
  insitu::Mesh mesh = session.mesh("image");
  // Keeps the arrays alive, and tells the next time steps from the last: attachment.update(next).
  insitu::vtk::Attachment attachment = insitu::vtk::attach(mesh, image);
  for (const insitu::vtk::Note& note : attachment.converted())
    std::cout << note.array << " had to be copied: " << note.reason << '\n';
  mesh.commit();

  std::vector<double> points;
  for (int i = 0; i < 50; ++i)
    points.insert(points.end(),
                  {0.5 + 0.4 * std::cos(0.3 * i), 0.5 + 0.4 * std::sin(0.3 * i), 0.02 * i});
  const insitu::Samples samples = mesh.sample("pressure", points);
  insitu::vtk::write("helix.vtp", insitu::vtk::sampled_points(points, "pressure", samples));
  std::cout << "50 points in helix.vtp\n";

  double worst = 0;
  for (std::size_t i = 0; i < samples.size(); ++i)
    worst = std::fmax(worst, std::abs(samples(i) - points[3 * i] - 2.0 * points[3 * i + 1]));
  return worst < 1e-12 && mesh.audit().front().data == pressure->GetPointer(0) ? 0 : 1;
} catch (const insitu::Error& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
