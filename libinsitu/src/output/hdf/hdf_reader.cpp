#include "output/hdf/hdf_reader.h"

#include <filesystem>
#include <limits>

#include "core/status.h"
#include "output/hdf/hdf_library.h"

namespace insitu::output {

using hdf::Call;
using hdf::Handle;

namespace {

constexpr std::size_t most_extents = 8;

/// Whether a type of a file is one of the API's, and which.
bool is_known(hid_t type, insitu_type& out) {
  const std::size_t size = H5Tget_size(type);
  const H5T_class_t kind = H5Tget_class(type);
  if (kind == H5T_FLOAT && (size == 4 || size == 8))
    out = size == 4 ? INSITU_FLOAT32 : INSITU_FLOAT64;
  else if (kind == H5T_INTEGER && H5Tget_sign(type) == H5T_SGN_2 && (size == 4 || size == 8))
    out = size == 4 ? INSITU_INT32 : INSITU_INT64;
  else if (kind == H5T_INTEGER && H5Tget_sign(type) == H5T_SGN_NONE && size == 1)
    out = INSITU_UINT8;
  else
    return false;
  return true;
}

} // namespace

std::int64_t HdfDataset::numbers() const {
  std::int64_t product = 1;
  for (const std::int64_t extent : extents)
    product *= extent;
  return product;
}

struct HdfReader::File {
  std::string path;
  Handle file;
  std::int64_t bytes = 0; ///< of the whole file
};

HdfReader::HdfReader(const std::string& path) : file_(std::make_unique<File>()) {
  const Call call;
  file_->path = path;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
  H5Pset_file_locking(access.get(), false, true); // folders may be read-only
  file_->file = Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose);
  if (!file_->file.open())
    refuse("/", hdf::reason());
  std::error_code error;
  file_->bytes = std::int64_t(std::filesystem::file_size(path, error));
}

HdfReader::~HdfReader() {
  const Call call;
  file_.reset();
}

void HdfReader::refuse(const std::string& where, const std::string& message) const {
  throw core::Error(INSITU_ERROR_FILE,
                    "cannot read '" + file_->path + "': " + where + ": " + message);
}

bool HdfReader::has(const std::string& where) const {
  const Call call;
  for (std::size_t at = where.find('/', 1);; at = where.find('/', at + 1)) {
    const std::string path = where.substr(0, at);
    const htri_t exists = H5Lexists(file_->file.get(), path.c_str(), H5P_DEFAULT);
    if (exists < 0) // the tables of the group are damaged
      refuse(path, hdf::reason());
    if (exists == 0 || at == std::string::npos)
      return exists > 0;
  }
}

HdfDataset HdfReader::dataset(const std::string& where) const {
  const Call call;
  if (!has(where))
    refuse(where, "is missing");
  const Handle dataset(H5Dopen2(file_->file.get(), where.c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset.open())
    refuse(where, hdf::reason());
  const Handle type(H5Dget_type(dataset.get()), H5Tclose);
  const Handle space(H5Dget_space(dataset.get()), H5Sclose);
  HdfDataset out;
  if (!type.open() || !space.open() || !is_known(type.get(), out.type))
    refuse(where, "is no dataset of float32, float64, int32, int64 or uint8");
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0 || std::size_t(rank) > most_extents)
    refuse(where, "has " + std::to_string(rank) + " dimensions");
  hsize_t extents[most_extents];
  H5Sget_simple_extent_dims(space.get(), extents, nullptr);
  std::int64_t numbers = 1;
  for (int a = 0; a < rank; ++a) {
    // What is contiguous cannot be more than the file; extents of nothing may be anything.
    if (extents[a] > hsize_t(file_->bytes) ||
        (numbers > 0 && extents[a] > 0 && std::int64_t(extents[a]) > file_->bytes / numbers))
      refuse(where, "has more values than the file holds");
    numbers *= std::int64_t(extents[a]);
    out.extents.push_back(std::int64_t(extents[a]));
  }
  return out;
}

void HdfReader::read(const std::string& where, const HdfDataset& shape, std::int64_t first,
                     std::int64_t count, std::byte* to) const {
  if (count == 0)
    return;
  const Call call;
  const Handle dataset(H5Dopen2(file_->file.get(), where.c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset.open())
    refuse(where, hdf::reason());
  const Handle space(H5Dget_space(dataset.get()), H5Sclose);
  hid_t memory = H5S_ALL, file = H5S_ALL;
  Handle some;
  if (first != 0 || count != shape.numbers()) {
    // Whole rows of the slowest extent: what pieces have of a dataset.
    std::int64_t row = 1;
    for (std::size_t a = 1; a < shape.extents.size(); ++a)
      row *= shape.extents[a];
    if (row == 0 || first % row != 0 || count % row != 0 || first < 0 || count < 0 ||
        first > shape.numbers() - count)
      refuse(where,
             "has no values " + std::to_string(first) + " to " + std::to_string(first + count));
    std::vector<hsize_t> start(shape.extents.size(), 0),
        size(shape.extents.begin(), shape.extents.end());
    start[0] = hsize_t(first / row);
    size[0] = hsize_t(count / row);
    H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr);
    const auto numbers = hsize_t(count);
    some = Handle(H5Screate_simple(1, &numbers, nullptr), H5Sclose);
    memory = some.get();
    file = space.get();
  }
  if (H5Dread(dataset.get(), hdf::type_of(shape.type), memory, file, H5P_DEFAULT, to) < 0)
    refuse(where, hdf::reason());
}

std::vector<std::int64_t> HdfReader::attribute(const std::string& where, const char* name) const {
  const Call call;
  const std::string shown = where + ", attribute '" + name + "'";
  const Handle attribute(
      H5Aopen_by_name(file_->file.get(), where.c_str(), name, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!attribute.open())
    refuse(shown, hdf::reason());
  const Handle space(H5Aget_space(attribute.get()), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space.get());
  if (count < 0 || count > file_->bytes)
    refuse(shown, "cannot be read");
  std::vector<std::int64_t> numbers(static_cast<std::size_t>(count));
  if (count > 0 && H5Aread(attribute.get(), H5T_NATIVE_INT64, numbers.data()) < 0)
    refuse(shown, hdf::reason());
  return numbers;
}

} // namespace insitu::output
