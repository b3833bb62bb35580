#pragma once

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "nodes.h"

/// The box by its faces, two of its cells glued to one that is no standard shape.
struct Glued {
  Glued() {
    std::map<std::set<std::int64_t>, int> known;
    constexpr int ring[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    for (std::size_t c = 0; c < std::size_t(box.own_cells()); ++c) {
      const std::int64_t* v = &box.hexahedra[8 * c];
      for (const auto& f : ring) {
        const auto [face, fresh] =
            known.try_emplace({v[f[0]], v[f[1]], v[f[2]], v[f[3]]}, int(known.size()));
        if (fresh) {
          for (const int i : f)
            vertices.push_back(std::int32_t(v[i]));
          sizes.push_back(4);
        }
        cell_faces.push_back(face->second);
      }
      cell_sizes.push_back(6);
    }
    // Cells 22 and 23, the last two, become one, without the face between them.
    const auto last = cell_faces.end() - 12;
    const std::set<int> of_first(last, last + 6);
    int between = -1;
    for (auto f = last + 6; f != cell_faces.end(); ++f)
      between = of_first.count(*f) > 0 ? *f : between;
    cell_faces.erase(std::remove(last, cell_faces.end(), between), cell_faces.end());
    cell_sizes.pop_back();
    cell_sizes.back() = 10;
    number = box.number;
    number.pop_back();
  }
  /// Where the items start, and, with_end, where the last one ends.
  static std::vector<std::int64_t> offsets_of(const std::vector<std::int32_t>& sizes,
                                              bool with_end) {
    std::vector<std::int64_t> out{0};
    for (const std::int32_t size : sizes)
      out.push_back(out.back() + size);
    if (!with_end)
      out.pop_back();
    return out;
  }
  static constexpr const char *e = "topologies/topo/elements/", *s = "topologies/topo/subelements/";
  /// node, domain: a mesh, or a domain of it by its path, such as "a/".
  void add_to(TestNode& node, const std::string& domain = "") {
    const std::string elements = domain + e, faces = domain + s;
    node.set(elements + "shape", "polyhedral").set(elements + "connectivity", cell_faces);
    node.set(elements + "sizes", cell_sizes).set(faces + "shape", "polygonal");
    node.set(faces + "connectivity", vertices).set(faces + "sizes", sizes);
    node.set(domain + "fields/number/values", number);
  }

  Box box;
  std::vector<std::int32_t> vertices, sizes, cell_faces, cell_sizes;
  std::vector<double> number;
};
