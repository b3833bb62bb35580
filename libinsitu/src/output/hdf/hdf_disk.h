#pragma once

#include <hdf5.h>
#include <memory>

#include "output/hdf/hdf_library.h"

namespace insitu::output::hdf {

/// How HdfWriter's files come to the disk. Where HDF5 1.10 cannot close a file or a dataset, as on
/// a full disk, it keeps what it has freed, and the program crashes at its exit. So this driver of
/// files tells HDF5 of every write that it went well, and remembers the first that did not.
class Disk {
public:
  Disk();

  /// Whether HDF5 has taken the driver.
  bool open() const { return driver_.open(); }
  /// Lets files of this property list (H5P_FILE_ACCESS) be written so; the object must outlive
  /// them. Returns whether all went well.
  bool serve(hid_t access) const;
  /// errno of the first write that failed; 0: none.
  int error() const { return *error_; }

private:
  std::unique_ptr<int> error_;
  Handle driver_;
};

} // namespace insitu::output::hdf
