#include "runs/netcdf/classic_size.h"

#include <cstdint>
#include <fstream>
#include <vector>

#include "file_error.h"

namespace insitu_replay {

namespace {

/// Reads the header of a classic file: numbers of 4 or 8 bytes, the highest first.
class Header {
public:
  explicit Header(std::ifstream& in, int version) : in_(in), version_(version) {}

  std::uint64_t number(int bytes) {
    std::uint64_t out = 0;
    for (int i = 0; i < bytes; ++i)
      out = out << 8 | static_cast<unsigned char>(in_.get());
    return out;
  }
  /// A count or a length.
  std::uint64_t count() { return number(version_ == 5 ? 8 : 4); }
  std::uint64_t offset() { return number(version_ == 1 ? 4 : 8); }
  std::string text() {
    const std::uint64_t length = count();
    std::string out;
    for (std::uint64_t i = 0; i < length && in_; ++i)
      out += char(in_.get());
    skip((4 - length % 4) % 4);
    return out;
  }
  void skip(std::uint64_t bytes) { in_.seekg(std::streamoff(bytes), std::ios::cur); }
  /// Begins a list: how many items it has.
  std::uint64_t list() {
    number(4);
    return count();
  }
  void skip_attributes() {
    for (std::uint64_t left = list(); left > 0 && in_; --left) {
      text();
      const auto type = number(4);
      const std::uint64_t bytes = count() * size_of(type);
      skip(bytes + (4 - bytes % 4) % 4);
    }
  }
  /// Of a type by its number; 8 for one that is not known.
  static std::uint64_t size_of(std::uint64_t type) {
    constexpr std::uint64_t sizes[] = {0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
    return type < std::size(sizes) ? sizes[type] : 8;
  }
  explicit operator bool() const { return bool(in_); }

private:
  std::ifstream& in_;
  int version_;
};

struct Extent {
  std::string name;
  std::uint64_t begin = 0, bytes = 0;
  bool of_records = false;
};

} // namespace

void require_whole_netcdf(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  char magic[4] = {};
  in.read(magic, 4);
  const int version = magic[3];
  if (!in || std::string(magic, 3) != "CDF" || (version != 1 && version != 2 && version != 5))
    return;
  Header header(in, version);
  const std::uint64_t records = header.count(),
                      streaming = version == 5 ? ~std::uint64_t(0) : 0xffffffffu;
  std::vector<std::uint64_t> lengths;
  for (std::uint64_t left = header.list(); left > 0 && header; --left) {
    header.text();
    lengths.push_back(header.count());
  }
  header.skip_attributes();
  std::vector<Extent> variables;
  std::uint64_t record = 0, padded_record = 0, of_records = 0;
  for (std::uint64_t left = header.list(); left > 0 && header; --left) {
    Extent& v = variables.emplace_back();
    v.name = header.text();
    v.bytes = 1;
    for (std::uint64_t dims = header.count(), d = 0; d < dims && header; ++d) {
      const std::uint64_t dim = header.count();
      const std::uint64_t length = dim < lengths.size() ? lengths[dim] : 0;
      v.of_records = v.of_records || (d == 0 && length == 0);
      v.bytes *= length == 0 ? 1 : length;
    }
    header.skip_attributes();
    v.bytes *= Header::size_of(header.number(4));
    header.count(); // the size with padding, which does not hold all sizes
    v.begin = header.offset();
    if (v.of_records) {
      ++of_records;
      record += v.bytes;
      padded_record += v.bytes + (4 - v.bytes % 4) % 4;
    }
  }
  if (!header)
    throw FileError(path, "ends within its header");
  const std::uint64_t each = of_records == 1 ? record : padded_record;
  in.seekg(0, std::ios::end);
  const auto size = std::uint64_t(in.tellg());
  for (const Extent& v : variables) {
    if (v.of_records && (records == 0 || records == streaming))
      continue;
    const std::uint64_t end = v.begin + v.bytes + (v.of_records ? (records - 1) * each : 0);
    if (end > size)
      throw FileError(path, "variable '" + v.name + "': its values end at byte " +
                                std::to_string(end) + ", but the file is cut and has " +
                                std::to_string(size));
  }
}

} // namespace insitu_replay
