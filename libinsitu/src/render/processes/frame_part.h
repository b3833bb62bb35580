#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "parallel/world.h"
#include "render/frame.h"
#include "render/processes/compositing.h"

/// Frames of meshes that are spread over processes (design/parallel.md): tiles of the image go
/// round the processes; each finds hits and claims samples in its own cells, and sends them to the
/// tile's owner, which runs the code of frames of one process on what it gets.
namespace insitu::render {

/// What a process has to do with a mesh of a frame of several.
struct FramePart {
  parallel::World& world;
  /// Flat cells below this are of this process, the others came from other processes.
  std::int64_t own_cells;
  /// The number of a flat cell of this process among the cells of all: of cells that hold a point
  /// the lowest owns it.
  std::function<std::int64_t(std::int64_t flat)> key;
  /// Of one of this process's own cells; -1 of any other, and of none.
  std::int64_t own_key(const mesh::MeshView& mesh, std::int64_t flat) const {
    return flat >= 0 && flat < own_cells && mesh.is_own(flat) ? key(flat) : -1;
  }
  /// About so many bytes of samples are on their way to one process, or from one, at a time; and
  /// traced paths take about so many where their tiles are.
  std::size_t most_bytes = std::size_t(32) << 20;
  /// Where other cells are drawn in the place of the solver's: the key of the lowest of this
  /// process's own cells of the solver's that hold a place; -1: none does. Images of cells then
  /// show the lowest of all processes. Empty, alike on all processes: they show what is drawn.
  std::function<std::int64_t(const math::Vec3d& place)> solvers_cell = {};
  Compositing compositing = Compositing::exact;
};

/// Why a frame's volume is drawn as by Compositing::exact in any case; null: there is no reason.
const char* why_exact(const FrameSettings& settings);
/// The same of the volumes of several meshes.
const char* why_exact(std::span<const FrameSettings* const> layers);

/// Draws a frame, to the bit as render_frame() draws that of the whole mesh on one process unless
/// FramePart::compositing says otherwise. Images are complete at the root and empty elsewhere;
/// their cells are numbered by FramePart::key, and sums of traced paths have pixels at the root
/// alone. PathCounts in the statistics are of all processes. Collective; the settings are the same
/// on all processes but for fields and structures. The sampler's facts() are those of the whole
/// mesh; its cells may be none. Where the settings ask for a boundary, or for averages or smooth
/// normals at vertices, the mesh has the cells of other processes around this one's (FramePart's
/// own_cells), and averages that smooth normals are of are those of the processes that own the
/// vertices' cells. Throws AgreedError.
FrameImages render_shared_frame(const FramePart& part, const query::Sampler& sampler,
                                const FrameSettings& settings, Structures& structures,
                                const core::Threads& threads,
                                FrameStatistics* statistics = nullptr);
/// Draws a frame of several meshes, each of which has a cell somewhere. parts: of the layers; they
/// differ by cells alone.
FrameImages render_shared_frame(std::span<const FramePart> parts,
                                std::span<const FrameLayer> layers, const core::Threads& threads,
                                FrameStatistics* statistics = nullptr);

} // namespace insitu::render
