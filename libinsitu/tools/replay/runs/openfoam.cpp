#include "runs/openfoam.h"

#ifdef REPLAY_OPENFOAM

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <vtkCompositeDataSet.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkDoubleArray.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkOpenFOAMReader.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>

#include "read.h"
#include "runs/decomposition.h"
#include "runs/foam_labels.h"
#include "runs/vtk_run.h"

namespace insitu_replay {

namespace fs = std::filesystem;

namespace {

/// A reader of a case or, with a parent, of a processor folder.
vtkSmartPointer<vtkOpenFOAMReader> reader_of(const std::string& folder) {
  auto reader = vtkSmartPointer<vtkOpenFOAMReader>::New();
  reader->SetFileName((fs::path(folder) / "system" / "controlDict").string().c_str());
  reader->SetCreateCellToPoint(0);
  reader->SetDecomposePolyhedra(0);
  reader->SetSkipZeroTime(false);
  return reader;
}

void select_inner_mesh(vtkOpenFOAMReader& reader) {
  reader.EnableAllCellArrays();
  reader.DisableAllPatchArrays();
  reader.SetPatchArrayStatus("internalMesh", 1);
}

/// The numbers of the folders whose names are a stem and a number.
std::set<int> numbered_folders(const std::string& folder, const std::string& stem) {
  std::set<int> out;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    int number = 0;
    if (!entry.is_directory() || !name.starts_with(stem))
      continue;
    const auto [end, error] =
        std::from_chars(name.data() + stem.size(), name.data() + name.size(), number);
    if (error == std::errc() && end == name.data() + name.size() && number >= 0)
      out.insert(number);
  }
  return out;
}

/// The highest number of a processor that the seams of one name.
int highest_neighbour(const fs::path& boundary) {
  std::ifstream in(boundary);
  int highest = -1;
  for (std::string word; in >> word;)
    if (int number = 0; word == "neighbProcNo" && in >> number)
      highest = std::max(highest, number);
  return highest;
}

/// The processor folders of a case.
struct Processors {
  std::vector<std::string> names;
  std::string missing; ///< the first, up to the last that there is or that a seam names
  int last = -1;
};

Processors processors_of(const std::string& folder) {
  Processors out;
  const std::set<int> found = numbered_folders(folder, "processor");
  for (const int p : found) {
    out.names.push_back("processor" + std::to_string(p));
    out.last = std::max(
        {out.last, p,
         highest_neighbour(fs::path(folder) / out.names.back() / "constant/polyMesh/boundary")});
  }
  for (int p = 0; p <= out.last && out.missing.empty(); ++p)
    if (found.count(p) == 0)
      out.missing = "processor" + std::to_string(p);
  return out;
}

/// The blocks of inner meshes of one processor.
std::vector<vtkSmartPointer<vtkUnstructuredGrid>> inner_meshes(vtkDataObject* read) {
  std::vector<vtkSmartPointer<vtkUnstructuredGrid>> out;
  auto* const tree = vtkDataObjectTree::SafeDownCast(read);
  if (!tree)
    return out;
  const auto leaves = vtkSmartPointer<vtkDataObjectTreeIterator>::New();
  leaves->SetDataSet(tree);
  leaves->VisitOnlyLeavesOn();
  leaves->TraverseSubTreeOn();
  leaves->SkipEmptyNodesOn();
  for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem())
    if (auto* const grid = vtkUnstructuredGrid::SafeDownCast(leaves->GetCurrentDataObject())) {
      auto own = vtkSmartPointer<vtkUnstructuredGrid>::New();
      own->ShallowCopy(grid);
      out.push_back(own);
    }
  return out;
}

/// A case whose meshes and fields are in processor folders.
class DecomposedRun : public Run {
public:
  DecomposedRun(const std::string& folder, const std::vector<std::string>& processors)
      : folder_(folder), processors_(processors), parent_(reader_of(folder)) {
    for (const std::string& name : processors) {
      forget_messages();
      auto reader = vtkSmartPointer<vtkOpenFOAMReader>::New();
      reader->SetFileName(parent_->GetFileName());
      reader->SetParent(parent_);
      reader->SetSkipZeroTime(false);
      const bool read = reader->MakeInformationVector(nullptr, name) != 0 &&
                        reader->MakeMetaDataAtTimeStep(true) != 0;
      if (const std::string message = first_message(); !read || !message.empty())
        throw FileError(path_of(name), "cannot be read" + (message.empty() ? "" : ": " + message));
      const std::vector<std::string> names = time_names(*reader);
      if (readers_.empty())
        times_.assign(reader->GetTimeValues()->GetPointer(0),
                      reader->GetTimeValues()->GetPointer(0) + names.size());
      else if (const auto before = time_names(*readers_[0]); names != before)
        throw FileError(path_of(name), "has " + words_of(names) + ", but " + processors[0] +
                                           " has " + words_of(before));
      readers_.push_back(reader);
    }
    select_inner_mesh(*parent_);
  }

  std::vector<double> times() const override { return times_; }
  std::vector<std::string> notes() const override { return {notes_.begin(), notes_.end()}; }

  vtkSmartPointer<vtkDataObject> read(std::optional<double> time) override {
    std::vector<vtkSmartPointer<vtkUnstructuredGrid>> pieces;
    std::vector<std::string> names;
    for (std::size_t p = 0; p < readers_.size(); ++p)
      for (const auto& grid : read_processor(p, time)) {
        pieces.push_back(grid);
        names.push_back(processors_[p]);
      }
    if (pieces.size() == readers_.size())
      if (const std::optional<Numbers> numbers = numbers_of(pieces, time)) {
        std::set<std::string> left_out;
        auto out = put_together(pieces, *numbers, left_out);
        for (const std::string& name : left_out)
          notes_.insert(folder_ + ": field '" + name +
                        "' is left out: not all processors have it, or not alike");
        return out;
      }
    const auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      blocks->SetBlock(unsigned(p), pieces[p]);
      blocks->GetMetaData(unsigned(p))->Set(vtkCompositeDataSet::NAME(), names[p].c_str());
    }
    return blocks;
  }

private:
  std::string path_of(const std::string& processor) const {
    return (fs::path(folder_) / processor).string();
  }

  std::vector<vtkSmartPointer<vtkUnstructuredGrid>> read_processor(std::size_t p,
                                                                   std::optional<double> time) {
    vtkOpenFOAMReader& reader = *readers_[p];
    forget_messages();
    if (time)
      reader.SetTimeValue(*time);
    reader.Modified();
    if (reader.MakeMetaDataAtTimeStep(false))
      reader.Update();
    const std::string message = first_message();
    if (!message.empty() && has_no_cells(p, time)) // which VTK takes for a fault
      return {vtkSmartPointer<vtkUnstructuredGrid>::New()};
    vtkDataObject* const read = reader.GetOutputDataObject(0);
    if (!message.empty() || !read)
      throw FileError(path_of(processors_[p]),
                      "cannot be read" + (message.empty() ? "" : ": " + message));
    return inner_meshes(read);
  }

  static std::vector<std::string> time_names(vtkOpenFOAMReader& reader) {
    std::vector<std::string> out;
    for (vtkIdType i = 0; i < reader.GetTimeNames()->GetNumberOfValues(); ++i)
      out.push_back(reader.GetTimeNames()->GetValue(i));
    return out;
  }
  /// Times in words, of which the last tells most.
  static std::string words_of(const std::vector<std::string>& times) {
    return times.empty() ? "no time"
                         : std::to_string(times.size()) + " times, the last '" + times.back() + "'";
  }

  /// The folder of the mesh at a time: that of the last time with faces of its own.
  fs::path mesh_folder(std::size_t p, std::optional<double> time) const {
    const fs::path root = path_of(processors_[p]);
    fs::path out = root / "constant" / "polyMesh";
    vtkStringArray* const names = readers_[p]->GetTimeNames();
    for (vtkIdType i = 0; time && i < names->GetNumberOfValues(); ++i)
      if (const fs::path own = root / std::string(names->GetValue(i)) / "polyMesh";
          times_[std::size_t(i)] <= *time &&
          (fs::exists(own / "faces") || fs::exists(own / "faces.gz")))
        out = own;
    return out;
  }

  bool has_no_cells(std::size_t p, std::optional<double> time) const {
    const fs::path owner = mesh_folder(p, time) / "owner";
    return fs::exists(owner) && read_foam_labels(owner.string()).empty();
  }

  /// The numbers that cells and points have in the whole case; empty where processors do not tell
  /// them, or tell those of another mesh.
  std::optional<Numbers> numbers_of(const std::vector<vtkSmartPointer<vtkUnstructuredGrid>>& pieces,
                                    std::optional<double> time) {
    Numbers out;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      const fs::path folder = mesh_folder(p, time);
      for (const bool of_cells : {true, false}) {
        const fs::path file = folder / (of_cells ? "cellProcAddressing" : "pointProcAddressing");
        const auto expected =
            of_cells ? pieces[p]->GetNumberOfCells() : pieces[p]->GetNumberOfPoints();
        std::vector<std::int64_t> labels;
        if (fs::exists(file))
          labels = read_foam_labels(file.string());
        if (!fs::exists(file) || std::int64_t(labels.size()) != expected) {
          notes_.insert(file.string() +
                        (fs::exists(file) ? " has " + std::to_string(labels.size()) +
                                                " labels for " + std::to_string(expected)
                                          : std::string(" is not there")) +
                        ": the processors' meshes are pieces, and cells have the numbers that "
                        "they have there");
          return std::nullopt;
        }
        (of_cells ? out.cells : out.points).push_back({file.string(), std::move(labels)});
      }
    }
    return out;
  }

  std::string folder_;
  std::vector<std::string> processors_;
  vtkSmartPointer<vtkOpenFOAMReader> parent_; ///< whose settings the readers go by
  std::vector<vtkSmartPointer<vtkOpenFOAMReader>> readers_;
  std::vector<double> times_;
  std::set<std::string> notes_;
};

/// The whole case.
std::unique_ptr<VtkRun> open_whole(const std::string& folder) {
  const vtkSmartPointer<vtkOpenFOAMReader> reader = reader_of(folder);
  forget_messages();
  reader->UpdateInformation();
  select_inner_mesh(*reader);
  if (const std::string message = first_message(); !message.empty())
    throw FileError(folder, "cannot be read: " + message);
  return std::make_unique<VtkRun>(folder, reader);
}

bool has_mesh(const fs::path& folder) {
  const fs::path faces = folder / "constant" / "polyMesh" / "faces";
  return fs::exists(faces) || fs::exists(faces.string() + ".gz");
}

} // namespace

std::unique_ptr<Run> open_openfoam(const std::string& folder) {
  const Processors processors = processors_of(folder);
  if (processors.names.empty()) {
    const std::set<int> collated = numbered_folders(folder, "processors");
    if (collated.empty())
      return open_whole(folder);
    const std::string found = "processors" + std::to_string(*collated.begin()) +
                              " has the files of several processors in one, which are not read";
    if (!has_mesh(folder))
      throw FileError(folder,
                      found + "; reconstructParMesh and reconstructPar make the case whole");
    std::unique_ptr<VtkRun> whole = open_whole(folder);
    whole->add_note(folder + ": " + found + ": the case is read as it is without them");
    return whole;
  }
  std::unique_ptr<Run> whole = has_mesh(folder) ? open_whole(folder) : nullptr;
  auto parts = std::make_unique<DecomposedRun>(folder, processors.names);
  if (whole && whole->times().size() >= parts->times().size())
    return whole;
  if (!processors.missing.empty())
    throw FileError(folder, "the folder " + processors.missing +
                                " is missing, of processor0 to processor" +
                                std::to_string(processors.last));
  return parts;
}

} // namespace insitu_replay

#endif
