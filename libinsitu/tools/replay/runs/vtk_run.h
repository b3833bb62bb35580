#pragma once

#include <memory>
#include <vtkAlgorithm.h>

#include "runs/run.h"

namespace insitu_replay {

/// The times of a reader, as it tells them, ascending.
std::vector<double> times_of(vtkAlgorithm& reader);

/// A data object that stays as it is when its reader goes on.
vtkSmartPointer<vtkDataObject> kept(vtkDataObject* read);

/// A run by a reader of VTK, which is kept, since readers read what does not change once.
class VtkRun : public Run {
public:
  VtkRun(std::string path, vtkSmartPointer<vtkAlgorithm> reader);
  std::vector<double> times() const override { return times_; }
  vtkSmartPointer<vtkDataObject> read(std::optional<double> time) override;
  std::vector<std::string> notes() const override { return notes_; }
  void add_note(std::string note) { notes_.push_back(std::move(note)); }

private:
  std::string path_;
  vtkSmartPointer<vtkAlgorithm> reader_;
  std::vector<double> times_;
  std::vector<std::string> notes_;
};

} // namespace insitu_replay
