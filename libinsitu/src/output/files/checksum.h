#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace insitu::output {

/// Of all bytes that were added, whatever the pieces they came in.
class Checksum {
public:
  void add(std::string_view bytes);
  std::uint64_t sum() const;

private:
  std::uint64_t lanes_[4] = {basis, basis + 1, basis + 2, basis + 3};
  std::string rest_; ///< fewer bytes than the lanes take at once
  std::uint64_t size_ = 0;
  static constexpr std::uint64_t basis = 0xcbf29ce484222325u;
};

} // namespace insitu::output
