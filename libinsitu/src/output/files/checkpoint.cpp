#include "output/files/checkpoint.h"

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string_view>

#include "core/status.h"
#include "output/files/atomic_file.h"
#include "output/files/file_system.h"

namespace insitu::output {

namespace {

constexpr std::string_view magic = "INSITUCP";
constexpr std::uint32_t version = 6, byte_order = 0x01020304;
constexpr std::size_t longest_name = 255;

struct Head {
  char magic[8];
  std::uint32_t version, byte_order;
  std::uint64_t bytes, checksum, items;
};
static_assert(sizeof(Head) == 40);

/// Four interleaved FNV-1a hashes over 64-bit words. Each step is a bijection of its state and of
/// the word, so a change of a single word always changes the sum.
std::uint64_t checksum(std::string_view bytes) {
  constexpr std::uint64_t prime = 0x100000001b3u, basis = 0xcbf29ce484222325u;
  std::uint64_t lanes[4] = {basis, basis + 1, basis + 2, basis + 3};
  std::size_t at = 0;
  const auto mix = [&](std::uint64_t& lane, std::size_t count) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, count);
    lane = (lane ^ word) * prime;
    lane ^= lane >> 32;
    at += count;
  };
  while (bytes.size() - at >= 32)
    for (std::uint64_t& lane : lanes)
      mix(lane, 8);
  while (at < bytes.size())
    mix(lanes[0], std::min<std::size_t>(8, bytes.size() - at));
  std::uint64_t sum = bytes.size();
  for (const std::uint64_t lane : lanes)
    sum = (sum ^ lane) * prime;
  return sum;
}

} // namespace

void CheckpointWriter::bytes(const char* name, std::size_t item_bytes, std::size_t count,
                             core::FunctionRef<void*(std::size_t)> place) {
  const std::string_view text(name);
  const auto size = std::uint64_t(item_bytes), many = std::uint64_t(count);
  body_.push_back(static_cast<char>(std::min(text.size(), longest_name)));
  body_.append(text.substr(0, longest_name));
  body_.append(reinterpret_cast<const char*>(&size), sizeof size);
  body_.append(reinterpret_cast<const char*>(&many), sizeof many);
  if (count > 0)
    body_.append(static_cast<const char*>(place(count)), item_bytes * count);
  ++items_;
}

void CheckpointWriter::commit(const std::string& path) const {
  Head head{};
  std::memcpy(head.magic, magic.data(), magic.size());
  head.version = version;
  head.byte_order = byte_order;
  head.bytes = body_.size();
  head.checksum = checksum(body_);
  head.items = items_;
  AtomicFile file(path);
  file.write(&head, sizeof head);
  file.write(body_);
  file.commit();
}

CheckpointReader::CheckpointReader(std::string path) : path_(std::move(path)) {
  errno = 0;
  std::ifstream file(path_, std::ios::binary);
  if (!file)
    throw_file_error("read checkpoint", path_, errno ? errno : EIO);
  Head head{};
  file.read(reinterpret_cast<char*>(&head), sizeof head);
  if (std::size_t(file.gcount()) != sizeof head ||
      std::string_view(head.magic, sizeof head.magic) != magic)
    refuse("it is no checkpoint of this library");
  if (head.byte_order != byte_order)
    refuse("it was written on a host of another byte order");
  if (head.version != version)
    refuse("it is of version " + std::to_string(head.version) + ", version " +
           std::to_string(version) + " expected");
  file.seekg(0, std::ios::end);
  const auto found = std::uint64_t(file.tellg()) - sizeof head;
  if (found != head.bytes)
    refuse("it has " + std::to_string(found) + " bytes after its head, " +
           std::to_string(head.bytes) + " expected");
  file.seekg(sizeof head);
  body_.resize(std::size_t(head.bytes));
  file.read(body_.data(), std::streamsize(body_.size()));
  if (!file)
    throw_file_error("read checkpoint", path_, EIO);
  if (checksum(body_) != head.checksum)
    refuse("it is damaged: its checksum is not the one that its head says");
}

void CheckpointReader::refuse(const std::string& message) const {
  throw core::Error(INSITU_ERROR_FILE, "cannot restart from '" + path_ + "': " + message);
}

void CheckpointReader::bytes(const char* name, std::size_t item_bytes, std::size_t,
                             core::FunctionRef<void*(std::size_t)> place) {
  const std::size_t begin = at_;
  const auto take = [&](void* to, std::size_t count) {
    if (body_.size() - at_ < count)
      refuse("'" + std::string(name) + "' expected at byte " + std::to_string(begin) +
             ", where it ends");
    std::memcpy(to, body_.data() + at_, count);
    at_ += count;
  };
  unsigned char length = 0;
  take(&length, 1);
  std::string found(length, '\0');
  take(found.data(), length);
  std::uint64_t size = 0, count = 0;
  take(&size, sizeof size);
  take(&count, sizeof count);
  if (found != name || size != item_bytes)
    refuse("'" + std::string(name) + "' of " + std::to_string(item_bytes) +
           " bytes each expected at byte " + std::to_string(begin) + ", '" + found + "' of " +
           std::to_string(size) + " found");
  if (count > (body_.size() - at_) / std::max<std::size_t>(item_bytes, 1))
    refuse("'" + found + "' has " + std::to_string(count) + " items, more than there are bytes");
  if (void* to = place(std::size_t(count)); count > 0)
    take(to, std::size_t(count) * item_bytes);
}

void CheckpointReader::require_end() const {
  if (at_ != body_.size())
    refuse(std::to_string(body_.size() - at_) + " bytes are left over");
}

} // namespace insitu::output
