#pragma once

#include <bit>
#include <cstdint>

#include "accel/camera_rays/packet_boxes.h"
#include "accel/tree/tree.h"

namespace insitu::accel {

/// Visits the cells whose boxes a packet's rays may meet, those of nearer children first; rays that
/// share a node pass it together (Rathke et al. 2015, section 4).
///   accept: unsigned(uint32_t node), bit c: child c may hold what is looked for; children that do
///   not exist do not count;
///   visit: void(int64_t flat_cell, unsigned rays), takes the cell for these rays, a bit each, and
///   may end rays of the packet (RayPacket::end_at).
template <class Accept, class Visit>
void for_each_cell_along_packet(const Tree& tree, RayPacket& packet, Accept&& accept,
                                Visit&& visit) {
  if (tree.empty())
    return;
  struct Entry {
    float near;
    std::uint32_t node;  ///< or the first of the leaf's cells
    std::uint32_t count; ///< 0: a node; otherwise cells
    std::uint32_t rays;
  };
  constexpr int most_depth = 64;
  Entry stack[most_depth * 8];
  int size = 0;
  stack[size++] = {0, 0, 0, packet.open};
  while (size > 0) {
    const Entry entry = stack[--size];
    const unsigned rays = entry.rays & packet.open;
    if (!rays)
      continue;
    if (entry.count) {
      for (std::uint32_t k = 0; k < entry.count; ++k)
        visit(std::int64_t(tree.cells()[entry.node + k]), rays);
      continue;
    }
    const Node& node = tree.nodes()[entry.node];
    const unsigned accepted = accept(entry.node) & node.children();
    if (!accepted)
      continue;
    std::uint32_t met[8];
    float near[8];
    unsigned wanted = children_along_packet(node, accepted, packet, rays, met, near);
    // Farthest first, so that the nearest is popped first.
    Entry* const found = stack + size;
    for (int n = 0; wanted; wanted &= wanted - 1, ++n, ++size) {
      const int c = std::countr_zero(wanted);
      int at = n;
      for (; at > 0 && found[at - 1].near < near[c]; --at)
        found[at] = found[at - 1];
      found[at] = node.is_inner(c) ? Entry{near[c], node.child_node(c), 0, met[c]}
                                   : Entry{near[c], node.child_cells(c),
                                           std::uint32_t(node.child_cell_count(c)), met[c]};
    }
  }
}

} // namespace insitu::accel
