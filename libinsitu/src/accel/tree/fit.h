#pragma once

#include "accel/tree/node.h"

/// Fitting nodes to boxes, compiled per SIMD target and dispatched at run time.
namespace insitu::accel {

/// The same node, byte for byte, as encode_boxes(node, children); returns the sum of the children's
/// half areas.
float encode_node(Node& node, const Box* children);

/// Encodes the nodes [begin, end) of a level from the boxes of the nodes below them (node_boxes, by
/// node) and of their leaf children's cells, and stores their own boxes in node_boxes. The cells'
/// boxes lie at cell_boxes in the order of the nodes' leaf children or, if `places` is given, at
/// cell_boxes + places[k] for the k-th of these. Returns the sum of the children's half areas.
double fit_nodes(Node* nodes, std::uint32_t begin, std::uint32_t end, const Box* cell_boxes,
                 const std::uint32_t* places, Box* node_boxes);

} // namespace insitu::accel
