#include "runs/vtk_run.h"

#include <algorithm>
#include <vtkDataObjectTree.h>
#include <vtkInformation.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include "read.h"

namespace insitu_replay {

std::vector<double> times_of(vtkAlgorithm& reader) {
  vtkInformation* const about = reader.GetOutputInformation(0);
  std::vector<double> times;
  if (about->Has(vtkStreamingDemandDrivenPipeline::TIME_STEPS())) {
    const double* const first = about->Get(vtkStreamingDemandDrivenPipeline::TIME_STEPS());
    times.assign(first, first + about->Length(vtkStreamingDemandDrivenPipeline::TIME_STEPS()));
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

vtkSmartPointer<vtkDataObject> kept(vtkDataObject* read) {
  // The reader's own object becomes the next step's.
  auto out = vtkSmartPointer<vtkDataObject>::Take(read->NewInstance());
  if (auto* const tree = vtkDataObjectTree::SafeDownCast(out))
    tree->RecursiveShallowCopy(read);
  else
    out->ShallowCopy(read);
  return out;
}

VtkRun::VtkRun(std::string path, vtkSmartPointer<vtkAlgorithm> reader)
    : path_(std::move(path)), reader_(std::move(reader)), times_(times_of(*reader_)) {}

vtkSmartPointer<vtkDataObject> VtkRun::read(std::optional<double> time) {
  forget_messages();
  if (time)
    reader_->UpdateTimeStep(*time);
  else
    reader_->Update();
  vtkDataObject* const read = reader_->GetOutputDataObject(0);
  if (const std::string message = first_message(); !message.empty() || !read)
    throw FileError(path_, "cannot be read" + (message.empty() ? message : ": " + message));
  return kept(read);
}

} // namespace insitu_replay
