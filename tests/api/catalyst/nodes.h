#pragma once

#include <catalyst.h>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

/// A node of Conduit's, with what tests write into it.
class TestNode {
public:
  TestNode() : node_(conduit_node_create(), conduit_node_destroy) {}

  conduit_node* get() const { return node_.get(); }

  TestNode& set(const std::string& path, const std::string& text) {
    conduit_node_set_path_char8_str(get(), path.c_str(), text.c_str());
    return *this;
  }
  TestNode& set(const std::string& path, const char* text) { return set(path, std::string(text)); }
  TestNode& set(const std::string& path, std::int64_t value) {
    conduit_node_set_path_int64(get(), path.c_str(), value);
    return *this;
  }
  TestNode& set(const std::string& path, int value) { return set(path, std::int64_t(value)); }
  TestNode& set(const std::string& path, double value) {
    conduit_node_set_path_float64(get(), path.c_str(), value);
    return *this;
  }
  /// The values where they are.
  TestNode& set(const std::string& path, std::vector<double>& values) {
    conduit_node_set_path_external_float64_ptr(get(), path.c_str(), values.data(), size(values));
    return *this;
  }
  TestNode& set(const std::string& path, std::vector<float>& values) {
    conduit_node_set_path_external_float32_ptr(get(), path.c_str(), values.data(), size(values));
    return *this;
  }
  TestNode& set(const std::string& path, std::vector<std::int32_t>& values) {
    conduit_node_set_path_external_int32_ptr(get(), path.c_str(), values.data(), size(values));
    return *this;
  }
  TestNode& set(const std::string& path, std::vector<std::int64_t>& values) {
    conduit_node_set_path_external_int64_ptr(get(), path.c_str(), values.data(), size(values));
    return *this;
  }
  TestNode& set(const std::string& path, std::vector<std::int16_t>& values) {
    conduit_node_set_path_external_int16_ptr(get(), path.c_str(), values.data(), size(values));
    return *this;
  }
  TestNode& set(const std::string& path, std::vector<std::uint8_t>& values) {
    conduit_node_set_path_external_uint8_ptr(get(), path.c_str(), values.data(), size(values));
    return *this;
  }
  /// n values, the first `first` doubles from the vector's, `step` doubles apart.
  TestNode& set_strided(const std::string& path, std::vector<double>& values, std::int64_t n,
                        std::int64_t first, std::int64_t step) {
    conduit_node_set_path_external_float64_ptr_detailed(get(), path.c_str(), values.data(), n,
                                                        8 * first, 8 * step, 8, 0);
    return *this;
  }
  bool has(const std::string& path) const {
    return conduit_node_has_path(get(), path.c_str()) != 0;
  }
  /// The doubles, or bytes, at a path that is there.
  std::vector<double> doubles(const std::string& path) const { return values<double>(path); }
  std::vector<std::uint8_t> bytes(const std::string& path) const {
    return values<std::uint8_t>(path);
  }
  TestNode& remove(const std::string& path) {
    conduit_node_remove_path(get(), path.c_str());
    return *this;
  }

private:
  template <class T>
  std::vector<T> values(const std::string& path) const {
    conduit_node* leaf = conduit_node_fetch_existing(get(), path.c_str());
    const conduit_index_t n = conduit_datatype_number_of_elements(conduit_node_dtype(leaf));
    const T* first = static_cast<const T*>(conduit_node_element_ptr(leaf, 0));
    return std::vector<T>(first, first + n); // packed, as results are
  }
  template <class T>
  static std::int64_t size(const std::vector<T>& values) {
    return static_cast<std::int64_t>(values.size());
  }
  std::unique_ptr<conduit_node, void (*)(conduit_node*)> node_;
};

/// A box of n[0] x n[1] x n[2] hexahedra of size 1, 0.5 and 0.25, from (1, 2, 3) on, with
/// f = x + 2 y + 3 z at vertices and the cell's number in cells, as the arrays of a solver.
struct Box {
  explicit Box(std::array<int, 3> cells = {4, 3, 2}, int ghosts = 0) : n(cells), g(ghosts) {
    for (std::size_t a = 0; a < 3; ++a) {
      size[a] = n[a] + 2 * g;
      for (int i = 0; i <= size[a]; ++i)
        axis[a].push_back(at(a, i - g));
    }
    for (int k = 0; k <= size[2]; ++k)
      for (int j = 0; j <= size[1]; ++j)
        for (int i = 0; i <= size[0]; ++i) {
          x.push_back(axis[0][std::size_t(i)]);
          y.push_back(axis[1][std::size_t(j)]);
          z.push_back(axis[2][std::size_t(k)]);
          xyz.insert(xyz.end(), {x.back(), y.back(), z.back()});
          f.push_back(x.back() + 2 * y.back() + 3 * z.back());
        }
    for (int k = 0; k < size[2]; ++k)
      for (int j = 0; j < size[1]; ++j)
        for (int i = 0; i < size[0]; ++i) {
          for (const auto& c : {std::array{0, 0, 0},
                                {1, 0, 0},
                                {1, 1, 0},
                                {0, 1, 0},
                                {0, 0, 1},
                                {1, 0, 1},
                                {1, 1, 1},
                                {0, 1, 1}})
            hexahedra.push_back(vertex(i + c[0], j + c[1], k + c[2]));
          const bool own = is_own(0, i) && is_own(1, j) && is_own(2, k);
          number.push_back(own ? (i - g) + n[0] * ((j - g) + n[1] * (k - g)) : -1.0);
        }
  }
  bool is_own(std::size_t a, int i) const { return i >= g && i < g + n[a]; }
  static double at(std::size_t a, int i) {
    return double(a + 1) + i * (a == 0 ? 1.0 : a == 1 ? 0.5 : 0.25);
  }
  std::int64_t vertex(int i, int j, int k) const {
    return i + std::int64_t(size[0] + 1) * (j + std::int64_t(size[1] + 1) * k);
  }
  std::int64_t own_cells() const { return std::int64_t(n[0]) * n[1] * n[2]; }

  std::array<int, 3> n;
  int g;
  std::array<int, 3> size{};
  std::vector<double> axis[3], x, y, z, xyz, f, number;
  std::vector<std::int64_t> hexahedra;
};
