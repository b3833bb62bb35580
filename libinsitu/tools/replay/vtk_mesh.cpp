#include "vtk_mesh.h"

#include <algorithm>
#include <vtkDataSet.h>
#include <vtkNew.h>
#include <vtkUnstructuredGrid.h>

#include "read.h"

namespace insitu_replay {

void VtkMesh::give(insitu::Mesh mesh, const std::vector<Part>& parts, const std::string& first,
                   std::size_t most_parts) {
  mesh_ = mesh;
  const auto is_set = [](const Part& p) { return vtkDataSet::SafeDownCast(p.data) != nullptr; };
  for (const Part& part : parts)
    if (is_set(part) ? adaptive_.has_value() : !pieces_.empty() || parts.size() > 1)
      throw FileError(part.name,
                      std::string(is_set(part) ? "is no adaptive mesh" : "is an adaptive mesh") +
                          "; all steps are adaptive meshes, a file each, or none");
  if (!parts.empty() && !is_set(parts[0])) {
    give_adaptive(parts[0]);
    give_blanks(first, field_names_of(parts));
    return;
  }
  if (adaptive_)
    throw FileError(first, "no parts after an adaptive mesh");
  keep_common_arrays(parts, [&](const std::string& what) { say_once_(first + ": " + what, what); });
  // Pieces that a step lacks are there without cells, so that the mesh has as many in all steps,
  // as far as an index tells, and tables name pieces from the first step on.
  const std::size_t count = std::max({parts.size(), pieces_.size(), most_parts});
  const vtkNew<vtkUnstructuredGrid> nothing;
  for (std::size_t p = 0; p < count; ++p)
    give_piece(p, p < parts.size() ? vtkDataSet::SafeDownCast(parts[p].data) : nothing.Get(),
               p < parts.size() ? parts[p].name : first);
  if (!parts.empty())
    give_blanks(first, field_names_of(parts));
}

void VtkMesh::give_blanks(const std::string& file, const std::vector<std::string>& fields) {
  try {
    for (const ReplayOptions::Blank& blank : options_.blanks)
      for (const std::string& name : blank.field.empty() ? fields : std::vector{blank.field})
        mesh_.field_blank(name, blank.value);
  } catch (const insitu::Error& e) {
    throw FileError(file, e.what());
  }
}

void VtkMesh::give_adaptive(const Part& part) {
  try {
    if (adaptive_)
      adaptive_->update(part.data);
    else
      adaptive_ = insitu::vtk::attach_adaptive(mesh_, part.data);
  } catch (const insitu::Error& e) {
    throw FileError(part.name, e.what());
  }
  say_notes(part.name, adaptive_->skipped(), adaptive_->converted());
}

void VtkMesh::give_piece(std::size_t p, vtkDataSet* data, const std::string& name) {
  try {
    if (p < pieces_.size()) {
      pieces_[p].update(data);
    } else {
      insitu::vtk::AttachOptions o;
      o.piece = int(p);
      pieces_.push_back(insitu::vtk::attach(mesh_, data, o));
    }
  } catch (const insitu::Error& e) {
    throw FileError(name, e.what());
  }
  say_notes(name, pieces_[p].skipped(), pieces_[p].converted());
}

/// Each thing once, of the first file that has it. Of what is converted ghosts of another type
/// alone: fields of integers mean the same as they are.
void VtkMesh::say_notes(const std::string& file, const std::vector<insitu::vtk::Note>& skipped,
                        const std::vector<insitu::vtk::Note>& converted) {
  for (const insitu::vtk::Note& n : skipped)
    say_once_(file + ": " + n.array + " is left out: " + n.reason, n.array + n.reason);
  for (const insitu::vtk::Note& n : converted)
    if (n.array.find("vtkGhostType") != std::string::npos &&
        n.reason.find("another type") != std::string::npos)
      say_once_(file + ": " + n.array + " is converted: " + n.reason, n.array + n.reason);
}

} // namespace insitu_replay
