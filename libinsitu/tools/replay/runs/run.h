#pragma once

#include <optional>
#include <string>
#include <vector>
#include <vtkSmartPointer.h>

#include "insitu/insitu.hpp"

class vtkDataObject;

namespace insitu_replay {

/// All steps of a run, as another program keeps them in a file or a folder. Members throw
/// FileError.
class Run {
public:
  Run() = default;
  virtual ~Run() = default;
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  /// Ascending; none of a file that knows no time.
  virtual std::vector<double> times() const = 0;
  /// The data of one of these times, all arrays and blocks; empty: of a run that knows none.
  virtual vtkSmartPointer<vtkDataObject> read(std::optional<double> time) = 0;
  /// In which frame of reference the file says that its points are.
  virtual std::optional<insitu::Frame> frame() const { return std::nullopt; }
  /// What is left out of the data read so far, or is not as it stands in the file.
  virtual std::vector<std::string> notes() const { return {}; }
};

} // namespace insitu_replay
