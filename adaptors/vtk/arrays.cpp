#include "arrays.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <vtkAOSDataArrayTemplate.h>
#include <vtkDataSetAttributes.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkSOADataArrayTemplate.h>

namespace insitu::vtk {

namespace {

template <class T>
bool in_place(vtkDataArray* array, std::vector<Array>& out) {
  const std::int64_t items = array->GetNumberOfTuples();
  const int components = array->GetNumberOfComponents();
  if (auto* aos = vtkAOSDataArrayTemplate<T>::FastDownCast(array)) {
    out = {Array(static_cast<const T*>(aos->GetPointer(0)), items).components(components)};
    return true;
  }
  if (auto* soa = vtkSOADataArrayTemplate<T>::FastDownCast(array)) {
    out.clear();
    for (int c = 0; c < components; ++c)
      out.emplace_back(static_cast<const T*>(soa->GetComponentArrayPointer(c)), items);
    return true;
  }
  return false;
}

/// The bytes of an array that lies in one piece of memory; null if it does not.
const void* contiguous(vtkDataArray* array) {
  return array->HasStandardMemoryLayout() ? array->GetVoidPointer(0) : nullptr;
}

} // namespace

const char* reason_to_convert(vtkDataArray* array) {
  switch (array->GetDataType()) {
  case VTK_FLOAT:
  case VTK_DOUBLE: {
    std::vector<Array> unused;
    const bool known = in_place<double>(array, unused) || in_place<float>(array, unused);
    return known ? nullptr : "values are computed, not stored (implicit array)";
  }
  case VTK_BIT:
    return "bits";
  default:
    return "integer values";
  }
}

Adopted adopt(vtkDataArray* array, const char* other_reason) {
  Adopted out;
  out.owner = array;
  out.reason = reason_to_convert(array);
  if (!out.reason)
    out.reason = other_reason;
  if (out.reason) {
    auto copy = vtkSmartPointer<vtkDoubleArray>::New();
    copy->DeepCopy(array);
    out.owner = copy;
  }
  if (!in_place<double>(out.owner, out.arrays))
    in_place<float>(out.owner, out.arrays);
  for (Array& a : out.arrays)
    a.converted(out.reason);
  return out;
}

vtkSmartPointer<vtkUnsignedCharArray> ghost_bytes(vtkDataSetAttributes* attributes,
                                                  const char** reason, const char* of) {
  vtkDataArray* const array = attributes->GetArray(vtkDataSetAttributes::GhostArrayName());
  if (!array)
    return nullptr;
  if (auto* bytes = vtkUnsignedCharArray::SafeDownCast(array))
    return bytes;
  const auto refuse = [&](const std::string& what) {
    throw Error(INSITU_ERROR_MESH, std::string(of) + " array 'vtkGhostType': " + what);
  };
  if (array->GetNumberOfComponents() != 1)
    refuse(std::to_string(array->GetNumberOfComponents()) + " components, 1 expected");
  *reason = "ghost values of another type than unsigned char";
  auto bytes = vtkSmartPointer<vtkUnsignedCharArray>::New();
  bytes->SetName(array->GetName());
  bytes->SetNumberOfValues(array->GetNumberOfTuples());
  for (vtkIdType c = 0; c < array->GetNumberOfTuples(); ++c) {
    const double value = array->GetComponent(c, 0);
    if (!(value >= -128 && value <= 255) || value != std::floor(value))
      refuse("value " + std::to_string(value) + " of " + of + " " + std::to_string(c) +
             "; bits, 0 to 255, are expected");
    bytes->SetValue(c, static_cast<unsigned char>(static_cast<int>(value) & 0xff));
  }
  return bytes;
}

namespace {

/// The double of the float's shortest decimal: 1e20 for 1e20f, as arrays of double have it.
double as_written(float value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  double written = value;
  std::from_chars(text, end, written);
  return written;
}

} // namespace

std::vector<double> blank_values(vtkFieldData* field_data, const std::string& name) {
  std::vector<double> values;
  for (const char* const key : {"_FillValue", "missing_value"})
    for (const std::string& prefix : {std::string(), name + "."})
      if (vtkDataArray* const array =
              field_data ? field_data->GetArray((prefix + key).c_str()) : nullptr)
        for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i)
          for (int c = 0; c < array->GetNumberOfComponents(); ++c) {
            values.push_back(array->GetComponent(i, c));
            if (array->GetDataType() == VTK_FLOAT)
              values.push_back(as_written(float(values.back())));
          }
  return values;
}

bool same_values(vtkDataArray* a, vtkDataArray* b) {
  if (a == b)
    return true;
  if (!a || !b || a->GetDataType() != b->GetDataType() ||
      a->GetNumberOfTuples() != b->GetNumberOfTuples() ||
      a->GetNumberOfComponents() != b->GetNumberOfComponents())
    return false;
  const auto bytes =
      static_cast<std::size_t>(a->GetNumberOfValues()) * std::size_t(a->GetDataTypeSize());
  if (contiguous(a) && contiguous(b))
    return bytes == 0 || std::memcmp(contiguous(a), contiguous(b), bytes) == 0;
  for (vtkIdType i = 0; i < a->GetNumberOfTuples(); ++i)
    for (int c = 0; c < a->GetNumberOfComponents(); ++c) {
      const double x = a->GetComponent(i, c), y = b->GetComponent(i, c);
      if (std::memcmp(&x, &y, sizeof x) != 0)
        return false;
    }
  return true;
}

} // namespace insitu::vtk
