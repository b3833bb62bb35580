#include "hyper_trees.h"

#include <string>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkHyperTreeGrid.h>
#include <vtkObjectFactory.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

namespace insitu_replay {

vtkStandardNewMacro(HyperTreeReader);

void HyperTreeReader::ReadXMLData() {
  Superclass::ReadXMLData();
  if (DataError || GetFileMajorVersion() < 2)
    return;
  vtkXMLDataElement* const grid = XMLParser->GetRootElement()->GetNestedElement(0);
  vtkXMLDataElement* const cells = grid ? grid->FindNestedElementWithName("CellData") : nullptr;
  for (int i = 0; cells && i < cells->GetNumberOfNestedElements(); ++i)
    read_vector(cells->GetNestedElement(i));
}

/// Reads an array of several components again, whole: values lie in the file in the order of the
/// nodes, as they do in memory.
void HyperTreeReader::read_vector(vtkXMLDataElement* element) {
  int components = 1;
  const char* const name = element->GetAttribute("Name");
  if (!name || element->GetScalarAttribute("NumberOfComponents", components) != 1 || components < 2)
    return;
  vtkDataArray* const array =
      vtkHyperTreeGrid::SafeDownCast(GetCurrentOutput())->GetCellData()->GetArray(name);
  vtkIdType nodes = -1;
  element->GetScalarAttribute("NumberOfTuples", nodes);
  if (!array || array->GetNumberOfTuples() != nodes ||
      !ReadArrayValues(element, 0, array, 0, array->GetNumberOfValues())) {
    vtkErrorMacro("cell array '" << name << "': its values cannot be read");
    DataError = 1;
  }
}

} // namespace insitu_replay
