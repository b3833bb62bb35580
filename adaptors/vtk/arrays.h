#pragma once

#include <string>
#include <vector>
#include <vtkDataArray.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include "insitu/insitu.hpp"

class vtkDataSetAttributes;
class vtkFieldData;

namespace insitu::vtk {

/// A VTK array as the library reads it: in place, or from a copy.
struct Adopted {
  vtkSmartPointer<vtkDataArray> owner; ///< the array itself, or the copy
  const char* reason = nullptr;        ///< why it is a copy; null: in place
  std::vector<Array> arrays;           ///< one, or one a component
};

/// The array in place if it holds float or double, interleaved or one array a component, and
/// nothing else speaks against it; else a copy as float64, with the reason.
Adopted adopt(vtkDataArray* array, const char* other_reason = nullptr);

/// Why an array cannot be read in place; null if it can.
const char* reason_to_convert(vtkDataArray* array);

/// The array vtkGhostType of cells or points, as bytes; null if there is none. Numbers of another
/// type are converted, and *reason says so; throws Error for a value that is no set of bits. of:
/// "cell" or "point".
vtkSmartPointer<vtkUnsignedCharArray> ghost_bytes(vtkDataSetAttributes* attributes,
                                                  const char** reason, const char* of = "cell");

/// Values that mean that there is none, of an array of this name: what the field data say by
/// _FillValue and missing_value for all arrays, or for this one with its name and a dot before.
std::vector<double> blank_values(vtkFieldData* field_data, const std::string& name);

/// Whether both hold the same values in the same type and shape.
bool same_values(vtkDataArray* a, vtkDataArray* b);

} // namespace insitu::vtk
