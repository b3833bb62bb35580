#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/context.h"
#include "output/hdf/hdf_writer.h"
#include "parallel/world.h"
#include "scene/record/piece_arrays.h"

namespace insitu::scene {

/// The file of a record on its way: the root writes it, and all processes give what they have in
/// parcels of bounded size. All calls but at_root() are collective and throw parallel::AgreedError.
class RecordFile {
public:
  RecordFile(const std::string& path, core::Context& context, parallel::World& world);

  /// Writes datasets to which processes add items, those of the lower ranks first.
  /// extents: of datasets that have others than (items, components), the slowest first; as the root
  /// says.
  void write(const std::vector<RecordStream>& streams,
             const std::map<std::string, std::vector<std::int64_t>>& extents = {});
  /// The texts of all processes, by rank; at the root alone.
  std::vector<std::string> gather(const std::string& mine);

  /// The items of a dataset that was written; -1 if there is none. At the root, as is the next.
  std::int64_t items(const std::string& where) const;
  void for_each_dataset(core::FunctionRef<void(const std::string&, std::int64_t)> visit) const;

  /// Null on other processes.
  output::HdfWriter* at_root() { return file_ ? &*file_ : nullptr; }

private:
  struct Dataset;
  std::vector<Dataset> agree_on_datasets(const std::vector<RecordStream>& streams);
  std::uint64_t write(const Dataset& dataset, const RecordStream* mine);
  void write_checksums(const std::vector<Dataset>& datasets, const std::vector<std::int64_t>& mine);

  parallel::World& world_;
  std::optional<output::HdfWriter> file_;
  core::Buffer<std::byte> slab_;
  std::map<std::string, std::int64_t> items_; ///< by dataset; at the root
};

} // namespace insitu::scene
