#pragma once

#include <vtkXMLHyperTreeGridReader.h>

namespace insitu_replay {

/// VTK's reader of .htg files, with what VTK 9.1's leaves out: of vectors in files of version 2 it
/// sets as many numbers as there are nodes, and leaves the memory of the others as it was.
class HyperTreeReader : public vtkXMLHyperTreeGridReader {
public:
  static HyperTreeReader* New();
  // clang-format off
  vtkTypeMacro(HyperTreeReader, vtkXMLHyperTreeGridReader)
      // clang-format on
      HyperTreeReader(const HyperTreeReader&) = delete;
  void operator=(const HyperTreeReader&) = delete;

protected:
  HyperTreeReader() = default;
  void ReadXMLData() override;

private:
  void read_vector(vtkXMLDataElement* element);
};

} // namespace insitu_replay
