#include "runs/netcdf/ugrid_fields.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vtkCellData.h>
#include <vtkDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPointData.h>

namespace insitu_replay {

namespace {

using Variable = NetcdfFile::Variable;

/// Values of layers at the interfaces: linear between the layers' heights, and those of the first
/// and the last layer beyond.
std::vector<double> at_interfaces(const UgridColumn& column, const std::vector<double>& values) {
  const std::size_t n = column.nodes, layers = column.vertical->layers;
  const std::vector<double>&z = column.interfaces, &at = column.middles;
  std::vector<double> out((layers + 1) * n);
  for (std::size_t i = 0; i < n; ++i) {
    out[i] = values[i];
    out[layers * n + i] = values[(layers - 1) * n + i];
    for (std::size_t k = 1; k < layers; ++k) {
      const std::size_t a = (k - 1) * n + i, b = k * n + i;
      const double span = at[b] - at[a], w = span == 0 ? 0.5 : (z[b] - at[a]) / span;
      out[b] = (1 - w) * values[a] + w * values[b];
    }
  }
  return out;
}

/// Values of cells on interfaces as values of layers.
std::vector<double> at_layers(const std::vector<double>& values, std::size_t layers) {
  const std::size_t n = values.size() / (layers + 1);
  std::vector<double> out(layers * n);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = (values[i] + values[i + n]) / 2;
  return out;
}

/// Takes values of faces to the cells that they were cut into.
std::vector<double> of_cut(const CutFaces& faces, const std::vector<double>& values,
                           std::size_t count) {
  std::vector<double> out;
  out.reserve(values.size() / count * faces.cells());
  for (std::size_t k = 0; k < values.size() / count; ++k)
    for (const std::int64_t f : faces.face)
      out.push_back(values[k * count + std::size_t(f)]);
  return out;
}

/// Adds the values of made vertices to those of each level.
std::vector<double> of_made(const UgridDims& dims, const CutFaces& faces,
                            const std::vector<double>& values) {
  if (faces.cut.empty())
    return values;
  const std::size_t nodes = dims.topology.nodes();
  std::vector<double> out, level;
  for (std::size_t k = 0; k < values.size() / nodes; ++k) {
    level.assign(values.begin() + std::ptrdiff_t(k * nodes),
                 values.begin() + std::ptrdiff_t((k + 1) * nodes));
    append_means(dims.topology, faces, false, level);
    out.insert(out.end(), level.begin(), level.end());
  }
  return out;
}

/// The values of a field, or of a component, at all points or cells of the mesh.
std::vector<double> values_of(const UgridDims& dims, const CutFaces& faces,
                              const UgridColumn& column, const UgridField& field, std::size_t step,
                              std::size_t component) {
  std::vector<double> values = dims.values(
      *field.v, {.step = step,
                 .level = field.level,
                 .item = field.of_cells ? dims.topology.cell_dim : dims.topology.node_dim,
                 .part = field.part,
                 .component = component});
  if (dims.topology.dimension == 2)
    values = field.of_cells ? of_cut(faces, values, dims.topology.cells())
                            : of_made(dims, faces, values);
  if (!column.vertical)
    return values;
  const UgridVertical& vertical = *column.vertical;
  if (field.level >= 0 && field.level == vertical.layer_dim)
    return field.of_cells ? values : at_interfaces(column, values);
  if (field.level >= 0)
    return field.of_cells ? at_layers(values, vertical.layers) : values;
  const std::size_t items = values.size(), levels = vertical.layers + (field.of_cells ? 0 : 1);
  values.reserve(items * levels);
  for (std::size_t i = items; i < items * levels; ++i)
    values.push_back(values[i - items]);
  return values;
}

vtkDataSetAttributes* attributes_of(vtkDataSet* set, bool of_cells) {
  if (of_cells)
    return set->GetCellData();
  return set->GetPointData();
}

void add_blank(const std::string& name, vtkDataSet* out) {
  const vtkNew<vtkDoubleArray> blank;
  blank->SetName((name + "._FillValue").c_str());
  blank->InsertNextValue(std::numeric_limits<double>::quiet_NaN());
  out->GetFieldData()->AddArray(blank);
}

/// Which component of which vector a variable is by its names.
struct Component {
  std::string vector;
  int axis = -1;
};

Component component_of(const NetcdfFile& file, const Variable& v) {
  const std::string name = file.text(v, "standard_name");
  for (const auto& [prefix, axis] : {std::pair{"eastward_", 0}, {"northward_", 1}, {"upward_", 2}})
    if (name.starts_with(prefix))
      return {name.substr(std::string(prefix).size()), axis};
  for (const auto& [infix, axis] : {std::pair{"_x_", 0}, {"_y_", 1}, {"_upward_", 2}})
    if (const std::size_t at = name.find(infix); at != std::string::npos)
      return {name.substr(0, at + 1) + name.substr(at + std::string(infix).size()), axis};
  if (name.empty() && (v.name == "u" || v.name == "v" || v.name == "w"))
    return {"velocity", v.name[0] - 'u'};
  return {};
}

} // namespace

std::vector<UgridField> fields_of(const UgridDims& dims, std::vector<std::string>& notes) {
  const NetcdfFile& file = dims.file;
  const UgridTopology& t = dims.topology;
  const auto mesh_of = [&](const Variable& v) { return file.text(v, "mesh"); };
  const bool said = std::any_of(file.variables().begin(), file.variables().end(),
                                [&](const Variable& v) { return mesh_of(v) == t.mesh->name; });
  std::vector<UgridField> out;
  for (const Variable& v : file.variables()) {
    const std::string mesh = mesh_of(v), location = file.text(v, "location");
    const bool of_nodes = dims.has(v, t.node_dim), of_cells = dims.has(v, t.cell_dim);
    if (!mesh.empty() && !file.find(mesh))
      file.fail(v, "mesh names the variable '" + mesh + "', which is not in the file");
    if (mesh.empty() ? said || of_nodes == of_cells : mesh != t.mesh->name)
      continue;
    if (std::find(t.parts.begin(), t.parts.end(), &v) != t.parts.end())
      continue;
    const std::string cells = t.dimension == 3 ? "volume" : "face";
    if ((location == "node" && !of_nodes) || (location == cells && !of_cells))
      file.fail(v, "location is " + location + ", but it does not have the dimension '" +
                       file.name_of_dim(location == "node" ? t.node_dim : t.cell_dim) + "'");
    if (of_nodes == of_cells)
      notes.push_back("variable '" + v.name + "' is left out: values of nodes and of " + cells +
                      "s are read, those of its location '" + location + "' are not");
    else if (!NetcdfFile::has_numbers(v))
      notes.push_back("variable '" + v.name + "' is left out: it holds no numbers");
    else
      out.push_back({&v, of_cells, dims.others(v)});
  }
  return out;
}

void resolve_levels(const UgridDims& dims, const UgridVertical* vertical,
                    std::vector<UgridField>& fields, std::vector<std::string>& notes) {
  const NetcdfFile& file = dims.file;
  std::erase_if(fields, [&](UgridField& field) {
    for (const int dim : field.others) {
      if (vertical && (dim == vertical->layer_dim || dim == vertical->interface_dim))
        field.level = dim;
      else if (field.part < 0 && (file.length(dim) == 2 || file.length(dim) == 3))
        field.part = dim;
      else if (file.length(dim) != 1) {
        notes.push_back("variable '" + field.v->name + "' is left out: its dimension '" +
                        file.name_of_dim(dim) +
                        "' is that of no vertical coordinate that gives the mesh's layers");
        return true;
      }
    }
    return false;
  });
}

void set_fields(const UgridDims& dims, const CutFaces& faces, const UgridColumn& column,
                const std::vector<UgridField>& fields, std::size_t step, vtkDataSet* out) {
  for (const UgridField& field : fields) {
    const std::size_t parts = field.part < 0 ? 1 : dims.file.length(field.part);
    const bool volume = column.vertical || dims.topology.dimension == 3;
    const vtkNew<vtkDoubleArray> array;
    array->SetName(field.v->name.c_str());
    array->SetNumberOfComponents(parts == 1 ? 1 : volume ? 3 : int(parts));
    bool blank = false;
    for (std::size_t part = 0; part < parts; ++part) {
      const std::vector<double> values = values_of(dims, faces, column, field, step, part);
      if (part == 0)
        array->SetNumberOfTuples(vtkIdType(values.size()));
      for (std::size_t i = 0; i < values.size(); ++i) {
        array->SetTypedComponent(vtkIdType(i), int(part), values[i]);
        blank = blank || std::isnan(values[i]);
      }
    }
    if (parts == 2 && volume) // across alone
      for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i)
        array->SetTypedComponent(i, 2, 0.0);
    attributes_of(out, field.of_cells)->AddArray(array);
    if (blank)
      add_blank(field.v->name, out);
  }
}

void add_vectors(const NetcdfFile& file, const std::vector<UgridField>& fields, bool flat,
                 vtkDataSet* out) {
  const auto find = [&](const UgridField& like, const Component& wanted) -> const UgridField* {
    for (const UgridField& field : fields)
      if (const Component c = component_of(file, *field.v);
          field.part < 0 && field.of_cells == like.of_cells && c.vector == wanted.vector &&
          c.axis == wanted.axis && (field.level >= 0) == (like.level >= 0))
        return &field;
    return nullptr;
  };
  for (const UgridField& x : fields) {
    const Component c = component_of(file, *x.v);
    const UgridField* const y = c.axis == 0 && x.part < 0 ? find(x, {c.vector, 1}) : nullptr;
    if (!y || find(x, c) != &x)
      continue;
    const UgridField* const z = flat ? nullptr : find(x, {c.vector, 2});
    vtkDataSetAttributes* const arrays = attributes_of(out, x.of_cells);
    const bool taken = file.find(c.vector) || out->GetPointData()->HasArray(c.vector.c_str()) ||
                       out->GetCellData()->HasArray(c.vector.c_str());
    const std::string name = taken ? x.v->name + "_" + y->v->name : c.vector;
    const vtkNew<vtkDoubleArray> vector;
    vector->SetName(name.c_str());
    vector->SetNumberOfComponents(flat ? 2 : 3);
    vtkDataArray* const parts[3] = {arrays->GetArray(x.v->name.c_str()),
                                    arrays->GetArray(y->v->name.c_str()),
                                    z ? arrays->GetArray(z->v->name.c_str()) : nullptr};
    vector->SetNumberOfTuples(parts[0]->GetNumberOfTuples());
    bool blank = false;
    for (int a = 0; a < (flat ? 2 : 3); ++a)
      for (vtkIdType i = 0; i < vector->GetNumberOfTuples(); ++i) {
        const double value = parts[a] ? parts[a]->GetComponent(i, 0) : 0.0;
        vector->SetTypedComponent(i, a, value);
        blank = blank || std::isnan(value);
      }
    arrays->AddArray(vector);
    if (blank)
      add_blank(name, out);
  }
}

} // namespace insitu_replay
