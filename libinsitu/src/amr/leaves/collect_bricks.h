#pragma once

#include "amr/leaves/brick_store.h"

namespace insitu::amr {

/// The bricks that hold cells of a mesh or finer ones.
BrickKeys collect_bricks(const mesh::AmrView& mesh, const core::Threads& threads);

/// Adds to every depth the bricks above the ones of the next.
void add_bricks_above(BrickKeys& keys);

} // namespace insitu::amr
