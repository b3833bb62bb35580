#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "query/directory.h"
#include "render/camera/camera.h"
#include "render/clip.h"

namespace insitu::render {

/// Where each process has cells, by a few boxes, for rays and places within a mesh.
class CellBoxes {
public:
  /// diagonal: of the mesh. A box is met by what passes it by no more than 1e-9 of it.
  CellBoxes(const query::Directory& where, double diagonal) {
    const math::Vec3d more = 1e-9 * diagonal * math::Vec3d{1, 1, 1};
    for (int process = 0; process < where.size(); ++process) {
      Of& of = of_.emplace_back();
      for (mesh::Box box : where.boxes(process)) {
        box.low = box.low - more;
        box.high = box.high + more;
        of.boxes.push_back(box);
        of.all = of.boxes.size() == 1 ? box : of.all;
        of.all.extend(box);
      }
    }
  }

  /// Whether a process's cells may be met by the ray up to t_max.
  bool may_meet(int process, const Ray& ray, double t_max) const {
    return any_of(process, [&](const mesh::Box& box) {
      const std::optional<Stretch> in = stretch_in_box(ray, box.low, box.high);
      return in && in->to >= 0 && in->from <= t_max;
    });
  }
  /// Whether they may hold the place.
  bool may_hold(int process, const math::Vec3d& at) const {
    return any_of(process, [&](const mesh::Box& box) { return box.holds(at); });
  }

private:
  struct Of {
    std::vector<mesh::Box> boxes;
    mesh::Box all; ///< around these
  };
  template <class Holds>
  bool any_of(int process, Holds&& holds) const {
    const Of& of = of_[std::size_t(process)];
    return !of.boxes.empty() && holds(of.all) &&
           std::any_of(of.boxes.begin(), of.boxes.end(), holds);
  }

  std::vector<Of> of_; ///< by process
};

} // namespace insitu::render
