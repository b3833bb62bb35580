#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <map>
#include <string>

/// The contents of a folder's files, by their names.
inline std::map<std::string, std::string> files_of(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream in(entry.path(), std::ios::binary);
    files[entry.path().filename().string()] = {std::istreambuf_iterator<char>(in), {}};
  }
  return files;
}

/// least: so many files there are.
inline void expect_same_files(const std::string& folder, const std::string& other,
                              std::size_t least) {
  const auto expected = files_of(folder), found = files_of(other);
  EXPECT_GE(expected.size(), least);
  EXPECT_EQ(found.size(), expected.size());
  for (const auto& [name, text] : expected)
    EXPECT_TRUE(found.contains(name) && found.at(name) == text) << name;
}
