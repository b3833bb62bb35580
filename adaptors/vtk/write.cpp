#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <unistd.h>
#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCommand.h>
#include <vtkDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkErrorCode.h>
#include <vtkExecutive.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkTypeInt32Array.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>
#include <vtkXMLDataObjectWriter.h>
#include <vtkXMLWriter.h>

#include "insitu/vtk.hpp"

namespace insitu::vtk {

namespace {

[[noreturn]] void file_error(const std::string& path, const std::string& what) {
  throw Error(INSITU_ERROR_FILE, path + ": " + what);
}

/// A name in the same folder for the unfinished file.
std::string part_name(const std::string& path) {
  return path + "." + std::to_string(::getpid()) + ".insitu-part";
}

void rename_part(const std::string& part, const std::string& path) {
  std::error_code error;
  std::filesystem::rename(part, path, error);
  if (!error)
    return;
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  file_error(path, error.message());
}

void expect_items(const std::string& what, std::size_t given, std::size_t expected) {
  if (given != expected)
    throw Error(INSITU_ERROR_ARGUMENT, what + ": " + std::to_string(given) + " values, " +
                                           std::to_string(expected) + " expected");
}

std::size_t point_count(View<const double> points) {
  if (points.size() % 3 != 0)
    throw Error(INSITU_ERROR_ARGUMENT, "points: " + std::to_string(points.size()) +
                                           " values are not whole points of 3 coordinates");
  return points.size() / 3;
}

/// A copy of the values as a named VTK array.
template <class VtkArray, class T>
void add(vtkPolyData* data, const std::string& name, const std::vector<T>& values, int components,
         std::size_t items) {
  expect_items(name, values.size(), items * static_cast<std::size_t>(components));
  vtkNew<VtkArray> array;
  array->SetName(name.c_str());
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(static_cast<vtkIdType>(items));
  std::copy(values.begin(), values.end(), array->GetPointer(0));
  data->GetPointData()->AddArray(array);
}

vtkSmartPointer<vtkPolyData> poly_data(View<const double> points) {
  const std::size_t n = point_count(points);
  vtkNew<vtkDoubleArray> coordinates;
  coordinates->SetNumberOfComponents(3);
  coordinates->SetNumberOfTuples(static_cast<vtkIdType>(n));
  std::copy(points.begin(), points.end(), coordinates->GetPointer(0));
  vtkNew<vtkPoints> vtk_points;
  vtk_points->SetData(coordinates);
  auto out = vtkSmartPointer<vtkPolyData>::New();
  out->SetPoints(vtk_points);
  return out;
}

/// Cells [begins[c], ends[c]) over consecutive points.
struct Ranges {
  std::vector<std::int64_t> begins, ends;

  void add(std::int64_t begin, std::int64_t end) {
    begins.push_back(begin);
    ends.push_back(end);
  }
  vtkSmartPointer<vtkCellArray> cells() const {
    vtkNew<vtkTypeInt64Array> offsets, ids;
    offsets->InsertNextValue(0);
    for (std::size_t c = 0; c < ends.size(); ++c) {
      for (std::int64_t i = begins[c]; i < ends[c]; ++i)
        ids->InsertNextValue(i);
      offsets->InsertNextValue(ids->GetNumberOfValues());
    }
    auto out = vtkSmartPointer<vtkCellArray>::New();
    out->SetData(offsets, ids);
    return out;
  }
};

vtkSmartPointer<vtkPolyData> located(View<const double> points, const Locations& at) {
  const std::size_t n = point_count(points);
  auto out = poly_data(points);
  Ranges vertices;
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(n); ++i)
    vertices.add(i, i + 1);
  out->SetVerts(vertices.cells());
  add<vtkUnsignedCharArray>(out, "found", at.found, 1, n);
  add<vtkTypeInt64Array>(out, "cell", at.cells, 1, n);
  add<vtkTypeInt32Array>(out, "piece", at.pieces, 1, n);
  return out;
}

/// Errors of a VTK object are no longer printed; its error code tells.
void silence(vtkObject* object) {
  vtkNew<vtkCallbackCommand> nothing;
  object->AddObserver(vtkCommand::ErrorEvent, nothing);
}

std::string number(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value + 0.0).ptr; // no -0
  return {text, end};
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    switch (c) {
    case '&':
      out += "&amp;";
      break;
    case '<':
      out += "&lt;";
      break;
    case '>':
      out += "&gt;";
      break;
    case '"':
      out += "&quot;";
      break;
    default:
      out += c;
    }
  return out;
}

} // namespace

vtkSmartPointer<vtkPolyData> sampled_points(View<const double> points,
                                            const FieldSamples& samples) {
  auto out = located(points, samples);
  for (const FieldValues& f : samples.values)
    add<vtkDoubleArray>(out, f.name, f.values, f.components, samples.size());
  return out;
}

vtkSmartPointer<vtkPolyData> sampled_points(View<const double> points, const std::string& field,
                                            const Samples& samples) {
  auto out = located(points, samples);
  add<vtkDoubleArray>(out, field, samples.values, samples.components, samples.size());
  return out;
}

vtkSmartPointer<vtkPolyData> tracks(View<const double> points, View<const std::int64_t> ends,
                                    const std::vector<FieldValues>& values) {
  const std::size_t n = point_count(points);
  std::int64_t last = 0;
  Ranges lines, vertices;
  for (std::size_t l = 0; l < ends.size(); ++l) {
    if (ends[l] < last || ends[l] > static_cast<std::int64_t>(n))
      throw Error(INSITU_ERROR_ARGUMENT, "ends: line " + std::to_string(l) + " ends at " +
                                             std::to_string(ends[l]) + ", " + std::to_string(last) +
                                             " to " + std::to_string(n) + " expected");
    if (ends[l] - last > 1)
      lines.add(last, ends[l]);
    else if (ends[l] - last == 1)
      vertices.add(last, ends[l]);
    last = ends[l];
  }
  expect_items("ends, points of all lines", static_cast<std::size_t>(last), n);
  auto out = poly_data(points);
  out->SetLines(lines.cells());
  out->SetVerts(vertices.cells());
  for (const FieldValues& f : values)
    add<vtkDoubleArray>(out, f.name, f.values, f.components, n);
  return out;
}

void write(const std::string& path, vtkDataSet* data) {
  if (!data)
    throw Error(INSITU_ERROR_ARGUMENT, "data: null");
  auto writer = vtkSmartPointer<vtkXMLWriter>::Take(
      vtkXMLDataObjectWriter::NewWriter(data->GetDataObjectType()));
  if (!writer)
    throw Error(INSITU_ERROR_UNSUPPORTED, path + ": no file format for a " + data->GetClassName());
  const std::string expected = std::string(".") + writer->GetDefaultFileExtension();
  if (std::filesystem::path(path).extension() != expected)
    throw Error(INSITU_ERROR_ARGUMENT,
                path + ": a " + data->GetClassName() + " is written to a " + expected + " file");
  const std::string part = part_name(path);
  silence(writer);
  silence(writer->GetExecutive());
  writer->SetInputData(data);
  writer->SetFileName(part.c_str());
  const bool written = writer->Write() != 0 && writer->GetErrorCode() == vtkErrorCode::NoError;
  if (!written) {
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    file_error(path, std::string("cannot be written: ") +
                         vtkErrorCode::GetStringFromErrorCode(writer->GetErrorCode()));
  }
  rename_part(part, path);
}

void Series::add(double time, const std::string& file, int part) {
  entries_.push_back({time, part, file});
  const std::string unfinished = part_name(path_);
  std::ofstream out(unfinished, std::ios::binary);
  out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n  <Collection>\n";
  for (const Entry& e : entries_)
    out << "    <DataSet timestep=\"" << number(e.time) << "\" part=\"" << e.part << "\" file=\""
        << escaped(e.file) << "\"/>\n";
  out << "  </Collection>\n</VTKFile>\n";
  out.close();
  if (!out) {
    std::error_code ignored;
    std::filesystem::remove(unfinished, ignored);
    entries_.pop_back();
    file_error(path_, "cannot be written");
  }
  rename_part(unfinished, path_);
}

} // namespace insitu::vtk
