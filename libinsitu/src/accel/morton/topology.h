#pragma once

#include <cstdint>
#include <vector>

#include "accel/morton/order.h"
#include "core/memory.h"

namespace insitu::accel::morton {

/// Makes the nodes over cells in Morton order, breadth first, all but their boxes. A node takes a
/// range of the order and opens it where codes first differ, the fullest part first, until it has
/// eight children; parts of up to eight cells become a node of cells, or children of the node above
/// while it has room. Where more than eight cells share a code, they are ordered anew on a grid of
/// their own, which writes to `cells` and `scratch`. Ranges of cells with one centre are halved.
/// Depth stays below 64. levels: the first node of each, and the end. slots: the cells in the
/// order of the nodes' leaf children. The result does not depend on the thread count.
void make_nodes(Coded* cells, Coded* scratch, std::uint32_t count, const Box* boxes,
                const core::Threads& threads, core::Buffer<Node>& nodes,
                core::Buffer<std::uint32_t>& slots, std::vector<std::uint32_t>& levels);

} // namespace insitu::accel::morton
