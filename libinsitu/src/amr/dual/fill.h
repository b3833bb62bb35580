#pragma once

#include "amr/leaves/brick_store.h"

namespace insitu::amr {

/// Enters every cell. Throws INSITU_ERROR_MESH if two of a depth lie at one place.
void fill(BrickStore& store, const mesh::AmrView& mesh, const core::Threads& threads);

/// Makes every entry that has finer cells on it `refined`, or `refined_in_part` where no cell was
/// and not all of it is covered; returns how many were cells. Throws INSITU_ERROR_MESH if finer
/// cells cover one in part.
std::int64_t mark_refined(BrickStore& store, const mesh::AmrView& mesh,
                          const core::Threads& threads);

} // namespace insitu::amr
