/// Of a build without HDF5.
#include "core/status.h"
#include "output/hdf/hdf_writer.h"

namespace insitu::output {

struct HdfWriter::File {};

void HdfWriter::require_hdf5(const std::string& what) {
  throw core::Error(INSITU_ERROR_UNSUPPORTED, what + ": this build has no HDF5 (INSITU_WITH_HDF5)");
}
HdfWriter::HdfWriter(const std::string& path) {
  require_hdf5("cannot write '" + path + "'");
}
HdfWriter::~HdfWriter() = default;
void HdfWriter::make_dataset(const std::string&, insitu_type, std::span<const std::int64_t>) {}
void HdfWriter::write(const std::string&, std::int64_t, std::span<const std::byte>) {}
void HdfWriter::make_group(const std::string&) {}
void HdfWriter::set_attribute(const std::string&, const char*, std::span<const std::int64_t>) {}
void HdfWriter::set_attribute(const std::string&, const char*, std::span<const double>) {}
void HdfWriter::set_attribute(const std::string&, const char*, std::string_view) {}
void HdfWriter::link(const std::string&, const std::string&) {}
void HdfWriter::commit() {}

} // namespace insitu::output
