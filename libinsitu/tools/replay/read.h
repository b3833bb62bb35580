#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vtkSmartPointer.h>

#include "file_error.h"

class vtkDataObject;

namespace insitu_replay {

/// What a file's name ends in, in small letters: ".vtu" of "a.VTU".
std::string ending_of(const std::string& path);

/// Whether read() knows the file's kind; the kinds in words, for messages.
bool is_readable_kind(const std::string& path);
extern const char* const readable_kinds;

/// Throws FileError for what is no file that can be opened.
void require_readable(const std::string& path);

/// Reads one data object: VTKHDF (.hdf), data sets (.vtu, .vts, .vtr, .vti, their parallel forms
/// .pvtu and so on, legacy .vtk), multi-block data sets (.vtm), a vtkOverlappingAMR with all of its
/// grids (.vthb, .vth), a vtkHyperTreeGrid (.htg). Throws FileError.
vtkSmartPointer<vtkDataObject> read(const std::string& path);

/// What the field data says.
std::optional<std::int64_t> cycle_of(vtkDataObject* data);
std::optional<double> time_of(vtkDataObject* data);

/// From here on VTK prints nothing; read() puts its first error into the FileError.
void silence_vtk();
/// Forgets the first error; what it was since then, without VTK's decoration, empty if there was
/// none.
void forget_messages();
std::string first_message();

} // namespace insitu_replay
