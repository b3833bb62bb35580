#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "insitu/insitu.hpp"
#include "insitu/vtk.hpp"

#include "options.h"
#include "parts.h"

namespace insitu_replay {

/// Gives what VTK has read to a mesh, step after step. It holds the arrays that the session reads,
/// and outlives it.
class VtkMesh {
public:
  /// say_once(what, key): tells what is left out or converted, once of a key.
  using SayOnce = std::function<void(const std::string&, const std::string&)>;
  VtkMesh(const ReplayOptions& options, SayOnce say_once)
      : options_(options), say_once_(std::move(say_once)) {}

  /// Gives the parts of a step to the mesh, as its pieces. first: the step's first file, for
  /// messages; most_parts: of any step, as far as an index tells. Throws FileError.
  void give(insitu::Mesh mesh, const std::vector<Part>& parts, const std::string& first,
            std::size_t most_parts);

private:
  void give_blanks(const std::string& file, const std::vector<std::string>& fields);
  void give_adaptive(const Part& part);
  void give_piece(std::size_t p, vtkDataSet* data, const std::string& name);
  void say_notes(const std::string& file, const std::vector<insitu::vtk::Note>& skipped,
                 const std::vector<insitu::vtk::Note>& converted);

  const ReplayOptions& options_;
  SayOnce say_once_;
  insitu::Mesh mesh_;
  std::vector<insitu::vtk::Attachment> pieces_;
  std::optional<insitu::vtk::AdaptiveAttachment> adaptive_; ///< then no pieces
};

} // namespace insitu_replay
