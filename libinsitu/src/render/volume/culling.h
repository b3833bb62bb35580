#pragma once

namespace insitu::render {

/// Whether the frame's locator leaves out the gridlets and stitching cells of an adaptive mesh's
/// dual that the transfer function makes invisible (Zellmann 2023, section 5.1). The scene decides,
/// because no look at some cells tells well enough when culling pays: on meshes of blocks,
/// a frame that skips samples by macrocells takes less time than a culled one; on meshes of many
/// stitching cells, the culled frame takes less.
enum class Culling { never, always };

} // namespace insitu::render
