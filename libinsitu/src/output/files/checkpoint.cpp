#include "output/files/checkpoint.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "core/status.h"
#include "output/files/file_system.h"

namespace insitu::output {

namespace {

constexpr std::string_view magic = "INSITUCP";
constexpr std::uint32_t version = 9, byte_order = 0x01020304;
constexpr std::size_t longest_name = 255;
constexpr std::size_t most_read = std::size_t(1) << 20; ///< bytes that are looked at together

struct Head {
  char magic[8];
  std::uint32_t version, byte_order;
  std::uint64_t bytes, checksum, items;
};
static_assert(sizeof(Head) == 40);

} // namespace

void ItemWriter::begin_item(std::string_view name, std::size_t item_bytes, std::size_t count) {
  const auto size = std::uint64_t(item_bytes), many = std::uint64_t(count);
  const auto length = static_cast<unsigned char>(std::min(name.size(), longest_name));
  put(&length, 1);
  put(name.data(), length);
  put(&size, sizeof size);
  put(&many, sizeof many);
  ++items_;
}

void ItemWriter::bytes(const char* name, std::size_t item_bytes, std::size_t count,
                       core::FunctionRef<void*(std::size_t)> place) {
  begin_item(name, item_bytes, count);
  if (count > 0)
    put(place(count), item_bytes * count);
}

CheckpointWriter::CheckpointWriter(const std::string& path) : file_(path) {
  const Head none{};
  file_.write(&none, sizeof none);
}

void CheckpointWriter::put(const void* data, std::size_t bytes) {
  checksum_.add({static_cast<const char*>(data), bytes});
  file_.write(data, bytes);
  size_ += bytes;
}

void CheckpointWriter::commit() {
  Head head{};
  std::memcpy(head.magic, magic.data(), magic.size());
  head.version = version;
  head.byte_order = byte_order;
  head.bytes = size_;
  head.checksum = checksum_.sum();
  head.items = items_;
  file_.write_begin(&head, sizeof head);
  file_.commit();
}

CheckpointReader::CheckpointReader(std::string path) : ItemReader(std::move(path)) {
  errno = 0;
  file_.open(path_, std::ios::binary);
  if (!file_)
    throw_file_error("read checkpoint", path_, errno ? errno : EIO);
  Head head{};
  file_.read(reinterpret_cast<char*>(&head), sizeof head);
  if (std::size_t(file_.gcount()) != sizeof head ||
      std::string_view(head.magic, sizeof head.magic) != magic)
    refuse("it is no checkpoint of this library");
  if (head.byte_order != byte_order)
    refuse("it was written on a host of another byte order");
  if (head.version != version)
    refuse("it is of version " + std::to_string(head.version) + ", version " +
           std::to_string(version) + " expected");
  file_.seekg(0, std::ios::end);
  size_ = std::uint64_t(file_.tellg()) - sizeof head;
  if (size_ != head.bytes)
    refuse("it has " + std::to_string(size_) + " bytes after its head, " +
           std::to_string(head.bytes) + " expected");
  file_.seekg(sizeof head);
  Checksum checksum;
  std::vector<char> some(std::size_t(std::min<std::uint64_t>(size_, most_read)));
  for (std::uint64_t at = 0; at < size_;) {
    const auto now = std::size_t(std::min<std::uint64_t>(size_ - at, some.size()));
    if (!file_.read(some.data(), std::streamsize(now)))
      throw_file_error("read checkpoint", path_, EIO);
    checksum.add({some.data(), now});
    at += now;
  }
  if (checksum.sum() != head.checksum)
    refuse("it is damaged: its checksum is not the one that its head says");
  file_.seekg(sizeof head);
}

void CheckpointReader::take(void* to, std::size_t bytes) {
  if (!file_.read(static_cast<char*>(to), std::streamsize(bytes)))
    throw_file_error("read checkpoint", path_, EIO);
}

void PartWriter::put(const void* data, std::size_t bytes) {
  text_.append(static_cast<const char*>(data), bytes);
}

PartReader::PartReader(std::string path, std::span<const std::byte> bytes)
    : ItemReader(std::move(path)), bytes_(bytes) {
  size_ = bytes.size();
}

void PartReader::take(void* to, std::size_t bytes) {
  std::memcpy(to, bytes_.data() + at_, bytes);
}

void ItemReader::refuse(const std::string& message) const {
  throw core::Error(INSITU_ERROR_FILE, "cannot restart from '" + path_ + "': " + message);
}

void ItemReader::bytes(const char* name, std::size_t item_bytes, std::size_t,
                       core::FunctionRef<void*(std::size_t)> place) {
  const std::uint64_t begin = at_;
  const auto next = [&](void* to, std::size_t count) {
    if (size_ - at_ < count)
      refuse("'" + std::string(name) + "' expected at byte " + std::to_string(begin) +
             ", where it ends");
    if (count > 0)
      take(to, count);
    at_ += count;
  };
  unsigned char length = 0;
  next(&length, 1);
  std::string found(length, '\0');
  next(found.data(), length);
  std::uint64_t size = 0, count = 0;
  next(&size, sizeof size);
  next(&count, sizeof count);
  if (found != name || size != item_bytes)
    refuse("'" + std::string(name) + "' of " + std::to_string(item_bytes) +
           " bytes each expected at byte " + std::to_string(begin) + ", '" + found + "' of " +
           std::to_string(size) + " found");
  if (count > (size_ - at_) / std::max<std::size_t>(item_bytes, 1))
    refuse("'" + found + "' has " + std::to_string(count) + " items, more than there are bytes");
  if (void* to = place(std::size_t(count)); count > 0)
    next(to, std::size_t(count) * item_bytes);
}

void ItemReader::require_end() const {
  if (at_ != size_)
    refuse(std::to_string(size_ - at_) + " bytes are left over");
}

} // namespace insitu::output
