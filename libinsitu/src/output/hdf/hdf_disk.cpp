#include "output/hdf/hdf_disk.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <new>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace insitu::output::hdf {

namespace {

/// What the property list tells the driver.
struct Told {
  int* error;
};

/// An open file; HDF5's own part comes first.
struct OpenFile {
  H5FD_t base{};
  int descriptor = -1;
  haddr_t end_of_address = 0, end_of_file = 0;
  int* error = nullptr;
  struct stat place {};

  void note(int failure) {
    if (error && *error == 0)
      *error = failure ? failure : EIO;
  }
};

OpenFile& of(H5FD_t* file) {
  return *reinterpret_cast<OpenFile*>(file);
}
const OpenFile& of(const H5FD_t* file) {
  return *reinterpret_cast<const OpenFile*>(file);
}

H5FD_t* open_file(const char* name, unsigned flags, hid_t access, haddr_t) {
  int how = flags & H5F_ACC_RDWR ? O_RDWR : O_RDONLY;
  how |= (flags & H5F_ACC_TRUNC ? O_TRUNC : 0) | (flags & H5F_ACC_CREAT ? O_CREAT : 0);
  const int descriptor = ::open(name, how | O_CLOEXEC, 0666);
  if (descriptor < 0)
    return nullptr;
  auto* const file = new (std::nothrow) OpenFile;
  if (!file || fstat(descriptor, &file->place) != 0) {
    delete file;
    ::close(descriptor);
    return nullptr;
  }
  file->descriptor = descriptor;
  file->end_of_file = haddr_t(file->place.st_size);
  if (const auto* const told = static_cast<const Told*>(H5Pget_driver_info(access)))
    file->error = told->error;
  return &file->base;
}

herr_t close_file(H5FD_t* file) {
  if (::close(of(file).descriptor) != 0)
    of(file).note(errno);
  delete &of(file);
  return 0;
}

int compare(const H5FD_t* a, const H5FD_t* b) {
  const auto key = [](const H5FD_t* f) {
    return std::pair(of(f).place.st_dev, of(f).place.st_ino);
  };
  return key(a) < key(b) ? -1 : key(b) < key(a);
}

herr_t tell_features(const H5FD_t*, unsigned long* flags) {
  if (flags) // those of HDF5's own driver for a file
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t end_of_address(const H5FD_t* file, H5FD_mem_t) {
  return of(file).end_of_address;
}
herr_t set_end_of_address(H5FD_t* file, H5FD_mem_t, haddr_t address) {
  of(file).end_of_address = address;
  return 0;
}
haddr_t end_of_file(const H5FD_t* file, H5FD_mem_t) {
  return of(file).end_of_file;
}

/// What is not there, since it could not be written, is zeros.
herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, void* to) {
  auto* bytes = static_cast<char*>(to);
  while (size > 0) {
    const ssize_t n = pread(of(file).descriptor, bytes, size, off_t(address));
    if (n < 0 && errno == EINTR)
      continue;
    if (n <= 0) {
      if (n < 0)
        of(file).note(errno);
      std::memset(bytes, 0, size);
      return 0;
    }
    bytes += n;
    address += haddr_t(n);
    size -= std::size_t(n);
  }
  return 0;
}

herr_t write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, const void* from) {
  OpenFile& to = of(file);
  const haddr_t end = address + size;
  const auto* bytes = static_cast<const char*>(from);
  while (size > 0) {
    const ssize_t n = pwrite(to.descriptor, bytes, size, off_t(address));
    if (n < 0 && errno == EINTR)
      continue;
    if (n <= 0) {
      to.note(n < 0 ? errno : ENOSPC);
      break;
    }
    bytes += n;
    address += haddr_t(n);
    size -= std::size_t(n);
  }
  to.end_of_file = std::max(to.end_of_file, end);
  return 0;
}

herr_t truncate(H5FD_t* file, hid_t, hbool_t) {
  OpenFile& to = of(file);
  if (to.end_of_file == to.end_of_address)
    return 0;
  if (ftruncate(to.descriptor, off_t(to.end_of_address)) != 0)
    to.note(errno);
  to.end_of_file = to.end_of_address;
  return 0;
}

/// By its members' names, since later versions of HDF5 have more of them.
H5FD_class_t driver_class() {
  H5FD_class_t c{};
#ifdef H5FD_CLASS_VERSION
  c.version = H5FD_CLASS_VERSION;
  c.value = H5FD_class_value_t(H5_VFD_MAX - 1); // of those that anybody may take
#endif
  c.name = "insitu";
  c.maxaddr = HADDR_MAX;
  c.fc_degree = H5F_CLOSE_STRONG;
  c.fapl_size = sizeof(Told);
  c.open = open_file;
  c.close = close_file;
  c.cmp = compare;
  c.query = tell_features;
  c.get_eoa = end_of_address;
  c.set_eoa = set_end_of_address;
  c.get_eof = end_of_file;
  c.read = read;
  c.write = write;
  c.truncate = truncate;
  const H5FD_mem_t map[] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(map), std::end(map), c.fl_map);
  return c;
}

} // namespace

Disk::Disk() : error_(std::make_unique<int>(0)) {
  static const H5FD_class_t driver = driver_class();
  driver_ = Handle(H5FDregister(&driver), H5FDunregister);
}

bool Disk::serve(hid_t access) const {
  const Told told{error_.get()};
  return H5Pset_driver(access, driver_.get(), &told) >= 0;
}

} // namespace insitu::output::hdf
