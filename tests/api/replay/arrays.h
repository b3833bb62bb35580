// Arrays of runs that are recorded, and their files.
#pragma once

#include <cstdint>
#include <deque>
#include <type_traits>

#include "insitu/insitu.hpp"

#include "replay.h"

namespace records {

using Files = std::map<std::string, std::string>;

inline void check(insitu_status status) {
  ASSERT_EQ(status, INSITU_OK) << insitu_last_message();
}

/// Files of a folder, without the page, whose seconds differ.
inline Files files_of(const fs::path& folder) {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (const std::string name = fs::relative(entry.path(), folder).string();
        entry.is_regular_file() && name != "run.js" && name != "index.html" &&
        name.find("lock") == std::string::npos)
      files[name] = contents(entry.path());
  return files;
}

/// Arrays that a solver keeps for as long as a run goes on.
class Arrays {
public:
  template <class T>
  insitu_array keep(std::vector<T> values, int components = 1) {
    constexpr insitu_type type = std::is_same_v<T, float>          ? INSITU_FLOAT32
                                 : std::is_same_v<T, double>       ? INSITU_FLOAT64
                                 : std::is_same_v<T, std::int32_t> ? INSITU_INT32
                                 : std::is_same_v<T, std::int64_t> ? INSITU_INT64
                                                                   : INSITU_UINT8;
    const auto count = std::int64_t(values.size()) / components;
    const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
    kept_.emplace_back(bytes, bytes + values.size() * sizeof(T));
    return insitu_array_of(kept_.back().data(), type, count, components);
  }

private:
  std::deque<std::vector<unsigned char>> kept_;
};

} // namespace records
