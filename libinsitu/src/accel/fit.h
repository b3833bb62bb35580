#pragma once

#include "accel/node.h"

/// Fitting nodes to boxes, compiled per SIMD target and dispatched at run time.
namespace insitu::accel {

/// The same node, byte for byte, as encode_boxes(node, children); returns the sum of the children's
/// half areas.
float encode_node(Node& node, const Box* children);

/// Encodes the nodes [begin, end) from the boxes of the nodes below them (node_boxes, by node) and
/// of their leaf children's cells (cell_boxes, from cell slot first_slot on), and stores their own
/// boxes in node_boxes. Returns the sum of the children's half areas.
double fit_nodes(Node* nodes, std::uint32_t begin, std::uint32_t end, const Box* cell_boxes,
                 std::uint32_t first_slot, Box* node_boxes);

} // namespace insitu::accel
