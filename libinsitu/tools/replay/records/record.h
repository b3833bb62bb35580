#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "insitu/insitu.hpp"

#include "file_error.h"
#include "output/hdf/hdf_reader.h"

namespace insitu_replay {

/// Where the datasets of a record come from.
class RecordSource {
public:
  virtual ~RecordSource() = default;
  virtual insitu::output::HdfDataset dataset(const std::string& where) const = 0;
  virtual void read(const std::string& where, const insitu::output::HdfDataset& dataset,
                    std::int64_t first, std::int64_t count, std::byte* to) const = 0;
  /// Of a dataset: of the numbers of each process.
  virtual std::vector<std::int64_t> checksums(const std::string& where) const = 0;
  virtual std::string path() const = 0; ///< of the file
  /// Throws FileError with the file's name and the path before the message.
  [[noreturn]] void refuse(const std::string& where, const std::string& message) const {
    throw FileError(path(), where + ": " + message);
  }
};

/// Whether a file is a record: a `.hdf` of HDF5 with the group that insitu_session_record() writes.
/// Throws FileError for a `.hdf` that does not tell, since it is damaged.
bool is_record(const std::string& path);
/// Throws FileError for what is no record.
std::unique_ptr<RecordSource> open_record(const std::string& path);

/// An array of a record, which process `process` gave: `count` items, whose numbers follow each
/// other from the `first` number of the dataset on.
struct RecordedArray {
  std::string dataset; ///< path in the file; empty: not given
  int process = 0;
  int components = 1;
  std::int64_t first = 0, count = 0;

  bool given() const { return !dataset.empty(); }
};

struct RecordedField {
  std::string name;
  insitu_association association = INSITU_VERTEX;
  RecordedArray array;
};

/// A piece, with the API's structs, whose arrays are not set yet.
struct RecordedPiece {
  enum class Kind { none, cells, faces, block, patch, leaves };
  Kind kind = Kind::none;
  insitu_cells cells = insitu_cells_default();
  insitu_faces faces = insitu_faces_default();
  insitu_block block = insitu_block_default();
  insitu_patch patch = insitu_patch_default();
  insitu_leaves leaves = insitu_leaves_default();
  insitu_ghost_convention convention = INSITU_GHOSTS_VTK;
  std::map<std::string, RecordedArray> arrays; ///< by name
  std::vector<RecordedField> fields;
};

struct RecordedMesh {
  std::string name;
  insitu_frame frame = insitu_frame_default();
  bool separate_pieces = false, is_adaptive = false;
  insitu_amr levels = insitu_amr_default(); ///< without its ratios
  std::vector<std::int32_t> ratios;
  std::int64_t topology = 0, geometry = 0; ///< versions: equal ones are the same
  struct Field {
    std::string name;
    std::vector<double> blanks;
  };
  std::vector<Field> fields;         ///< in the order in which they were given
  std::vector<RecordedPiece> pieces; ///< those of the lower processes first
  int processes = 1;
};

/// What a record holds of a step.
struct Record {
  std::int64_t cycle = 0;
  double time = 0.0;
  std::string scene_file, scene_text; ///< empty: none
  std::vector<RecordedMesh> meshes;
};

/// Reads all but the arrays. Throws FileError for what cannot be, such as arrays that reach beyond
/// their datasets.
Record read_record(const RecordSource& source);

} // namespace insitu_replay
