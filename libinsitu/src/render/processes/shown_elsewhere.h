#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "mesh/box.h"
#include "parallel/world.h"
#include "render/volume/macrocells.h"

namespace insitu::render {

/// Where something shows of a volume in other processes' cells, in parts of the whole mesh's box:
/// an integral between two samples needs both, and one that does not show may be beside one of
/// another process that does; and a sample on the face between two cells takes its value of the
/// lowest, which may show nothing while the other one does.
class ShownElsewhere {
public:
  static constexpr int side = 32; ///< parts along each axis
  /// processes: in the World that it is for.
  ShownElsewhere(const mesh::Box& whole, int processes);

  /// Notes what shows in this process's cells, and a sample's distance about it. tree: where these
  /// are. majorants: null: something may show everywhere.
  void note(const accel::Tree& tree, const Majorants* majorants, double step);
  /// Tells the others. Collective.
  void exchange(parallel::World& world);
  /// These majorants, but above 0 where something shows elsewhere as well.
  std::unique_ptr<Majorants> with(const Majorants& majorants, core::Memory& memory) const;

private:
  struct Range {
    std::array<int, 3> first, last;
  };
  Range parts_of(const math::Vec3d& low, const math::Vec3d& high) const;
  bool is_shown(const math::Vec3d& low, const math::Vec3d& high) const;
  /// The word of a part, and the number of its lowest bit there.
  std::size_t word_of(int i, int j, int k) const;
  int shift_of(int i) const;

  mesh::Box whole_;
  math::Vec3d size_;                ///< of a part
  int parts_a_word_;                ///< so that each counts all processes
  std::vector<std::int64_t> shown_; ///< so many parts each: of how many processes
  std::vector<std::int64_t> mine_;
};

} // namespace insitu::render
