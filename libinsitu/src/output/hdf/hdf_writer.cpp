#include "output/hdf/hdf_writer.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <vector>

#include "core/status.h"
#include "output/files/atomic_file.h"
#include "output/hdf/hdf_disk.h"
#include "output/hdf/hdf_library.h"

namespace insitu::output {

using hdf::Call;
using hdf::Handle;

struct HdfWriter::File {
  explicit File(const std::string& target) : place(target) {}

  AtomicFile place; ///< first, so that the unfinished file is closed before it goes
  hdf::Disk disk;
  Handle file;
  // The dataset that was written to last.
  std::string path;
  Handle dataset;
  insitu_type type = INSITU_FLOAT64;
  std::vector<hsize_t> extents;

  [[noreturn]] void fail(const std::string& where) const {
    throw core::Error(INSITU_ERROR_FILE,
                      "cannot write '" + place.target() + "': " + where + ": " + hdf::reason());
  }
  /// Of what has come to the disk so far.
  void check_disk(const std::string& where) const {
    if (disk.error() != 0)
      throw core::Error(INSITU_ERROR_FILE, "cannot write '" + place.target() + "': " + where +
                                               ": " + std::strerror(disk.error()));
  }
  hid_t check(hid_t id, const std::string& where) const {
    if (id < 0)
      fail(where);
    return id;
  }

  void make_groups(const std::string& where);
  void write_range(std::size_t axis, std::vector<hsize_t>& start, hsize_t first, hsize_t count,
                   const std::byte*& from);
  void write_attribute(const std::string& where, const char* name, hid_t in_file, hid_t in_memory,
                       const Handle& space, const void* data);
};

void HdfWriter::require_hdf5(const std::string&) {}

HdfWriter::HdfWriter(const std::string& path) {
  const Call call;
  file_ = std::make_unique<File>(path);
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // Headers of this version have checksums.
  if (access.get() < 0 || !file_->disk.open() || !file_->disk.serve(access.get()) ||
      H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_V110) < 0 ||
      H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG) < 0)
    file_->fail("/");
  const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation.get(), false);
  file_->file = Handle(
      file_->check(
          H5Fcreate(file_->place.part().c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), "/"),
      H5Fclose);
}

HdfWriter::~HdfWriter() {
  const Call call;
  file_.reset();
}

/// Makes the groups of a path up to its last slash. Nothing in the file tells when it was made, so
/// that equal contents are equal files.
void HdfWriter::File::make_groups(const std::string& where) {
  const Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation.get(), false);
  for (std::size_t at = where.find('/', 1); at != std::string::npos; at = where.find('/', at + 1)) {
    const std::string group = where.substr(0, at);
    if (H5Lexists(file.get(), group.c_str(), H5P_DEFAULT) > 0)
      continue;
    const Handle made(
        check(H5Gcreate2(file.get(), group.c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
              group),
        H5Gclose);
  }
}

void HdfWriter::make_group(const std::string& where) {
  const Call call;
  file_->make_groups(where + "/");
}

void HdfWriter::make_dataset(const std::string& where, insitu_type type,
                             std::span<const std::int64_t> extents) {
  const Call call;
  file_->dataset.reset();
  file_->path = where;
  file_->type = type;
  file_->extents.assign(extents.begin(), extents.end());
  const Handle space(
      file_->check(H5Screate_simple(int(extents.size()), file_->extents.data(), nullptr), where),
      H5Sclose);
  file_->make_groups(where);
  const Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(layout.get(), false);
  H5Pset_fill_time(layout.get(), H5D_FILL_TIME_NEVER);
  file_->dataset =
      Handle(file_->check(H5Dcreate2(file_->file.get(), where.c_str(), hdf::type_of(type),
                                     space.get(), H5P_DEFAULT, layout.get(), H5P_DEFAULT),
                          where),
             H5Dclose);
}

/// Writes `count` numbers of the block at `start` along the axes before this one, from its `first`
/// number on: whole rows along this axis at once, and parts of rows one axis down.
void HdfWriter::File::write_range(std::size_t axis, std::vector<hsize_t>& start, hsize_t first,
                                  hsize_t count, const std::byte*& from) {
  hsize_t row = 1; // numbers of one step along this axis
  for (std::size_t a = axis + 1; a < extents.size(); ++a)
    row *= extents[a];
  const auto write_part = [&](hsize_t index, hsize_t begin, hsize_t numbers) {
    start[axis] = index;
    write_range(axis + 1, start, begin, numbers, from);
  };
  if (const hsize_t into = first % row; into > 0) {
    const hsize_t now = std::min(count, row - into);
    write_part(first / row, into, now);
    first += now;
    count -= now;
  }
  if (const hsize_t rows = count / row; rows > 0) {
    std::vector<hsize_t> size(extents);
    std::fill(size.begin(), size.begin() + std::ptrdiff_t(axis), 1);
    size[axis] = rows;
    start[axis] = first / row;
    std::fill(start.begin() + std::ptrdiff_t(axis) + 1, start.end(), 0);
    const Handle space(check(H5Dget_space(dataset.get()), path), H5Sclose);
    const hsize_t numbers = rows * row;
    const Handle memory(check(H5Screate_simple(1, &numbers, nullptr), path), H5Sclose);
    check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, size.data(),
                              nullptr),
          path);
    check(H5Dwrite(dataset.get(), hdf::type_of(type), memory.get(), space.get(), H5P_DEFAULT, from),
          path);
    from += numbers * H5Tget_size(hdf::type_of(type));
    first += numbers;
    count -= numbers;
  }
  if (count > 0)
    write_part(first / row, 0, count);
}

void HdfWriter::write(const std::string& where, std::int64_t first,
                      std::span<const std::byte> numbers) {
  if (numbers.empty())
    return;
  const Call call;
  if (file_->path != where || !file_->dataset.open())
    throw core::Error(INSITU_ERROR_INTERNAL,
                      "'" + where + "' is not the dataset that was made last");
  std::vector<hsize_t> start(file_->extents.size(), 0);
  const std::byte* from = numbers.data();
  file_->write_range(0, start, hsize_t(first),
                     numbers.size() / H5Tget_size(hdf::type_of(file_->type)), from);
  file_->check_disk(where);
}

void HdfWriter::File::write_attribute(const std::string& where, const char* name, hid_t in_file,
                                      hid_t in_memory, const Handle& space, const void* data) {
  const Handle object(check(H5Oopen(file.get(), where.c_str(), H5P_DEFAULT), where), H5Oclose);
  const Handle attribute(
      check(H5Acreate2(object.get(), name, in_file, space.get(), H5P_DEFAULT, H5P_DEFAULT), where),
      H5Aclose);
  check(H5Awrite(attribute.get(), in_memory, data), where);
}

void HdfWriter::set_attribute(const std::string& where, const char* name,
                              std::span<const std::int64_t> numbers) {
  const Call call;
  const hsize_t size = numbers.size();
  const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
  file_->write_attribute(where, name, H5T_NATIVE_INT64, H5T_NATIVE_INT64, space, numbers.data());
}

void HdfWriter::set_attribute(const std::string& where, const char* name,
                              std::span<const double> numbers) {
  const Call call;
  const hsize_t size = numbers.size();
  const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
  file_->write_attribute(where, name, H5T_NATIVE_DOUBLE, H5T_NATIVE_DOUBLE, space, numbers.data());
}

void HdfWriter::set_attribute(const std::string& where, const char* name, std::string_view text) {
  const Call call;
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), std::max<std::size_t>(text.size(), 1));
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  file_->write_attribute(where, name, type.get(), type.get(), space,
                         std::string(text).append(1, '\0').data());
}

void HdfWriter::link(const std::string& where, const std::string& dataset) {
  const Call call;
  file_->make_groups(where);
  file_->check(H5Lcreate_hard(file_->file.get(), dataset.c_str(), file_->file.get(), where.c_str(),
                              H5P_DEFAULT, H5P_DEFAULT),
               where);
}

void HdfWriter::commit() {
  {
    const Call call;
    if (!file_->dataset.reset() || !file_->file.reset())
      file_->fail("/");
    file_->check_disk("/");
  }
  file_->place.commit();
}

} // namespace insitu::output
