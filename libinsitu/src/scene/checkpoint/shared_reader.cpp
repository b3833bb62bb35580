#include "scene/checkpoint/shared_reader.h"

#include <cstring>
#include <span>
#include <vector>

namespace insitu::scene {

void SharedReader::bytes(const char* name, std::size_t item_bytes, std::size_t,
                         core::FunctionRef<void*(std::size_t)> place) {
  std::vector<std::byte> read;
  std::int64_t count = 0;
  world_.agree_after([&] {
    if (at_root_)
      at_root_->read(name, item_bytes, [&](std::size_t found) {
        count = std::int64_t(found);
        read.resize(found * item_bytes);
        return static_cast<void*>(read.data());
      });
  });
  world_.broadcast(std::as_writable_bytes(std::span(&count, 1)));
  std::span<std::byte> to;
  world_.agree_after([&] {
    to = {static_cast<std::byte*>(place(std::size_t(count))), std::size_t(count) * item_bytes};
    if (!read.empty())
      std::memcpy(to.data(), read.data(), read.size());
  });
  world_.broadcast(to);
}

} // namespace insitu::scene
