#pragma once

#include <cstdint>
#include <vector>

#include "query/nearest/nearest_cells.h"

namespace insitu::query {

/// A vertex near a place. Vertices of one global id are one; without ids a piece's own are.
struct NearVertex {
  double squared; ///< of the distance
  std::int64_t global = -1;
  std::int32_t rank = -1, piece = -1;
  std::int64_t vertex = -1; ///< in the piece
  math::Vec3d x;            ///< in the mesh's frame

  bool is_before(const NearVertex& b) const;
  bool is_same(const NearVertex& b) const {
    return global >= 0 || b.global >= 0 ? global == b.global
                                        : rank == b.rank && piece == b.piece && vertex == b.vertex;
  }
};

/// The nearest of several vertices, each once, in order.
class NearVertices {
public:
  /// farthest: those beyond are left out.
  NearVertices(std::size_t most, double farthest) : most_(most), farthest_(farthest * farthest) {}

  /// The squared distance that still counts.
  double reach() const { return found_.size() < most_ ? farthest_ : found_.back().squared; }
  void take(const NearVertex& vertex);
  const std::vector<NearVertex>& found() const { return found_; }

private:
  std::size_t most_;
  double farthest_;
  std::vector<NearVertex> found_; ///< ascending
};

/// The vertices of a process's own cells that are nearest to a place.
class NearestVertices {
public:
  /// sampler: own_sampler() of a committed mesh whose vertices are the solver's; own: the mesh as
  /// the solver has it; own_cell: the flat id in it of a cell of the sampler's; global_id: of a
  /// flat vertex of it, -1: none. All must outlive the object. Fits the tree, if that waits.
  NearestVertices(const Sampler& sampler, const mesh::MeshView& own,
                  core::FunctionRef<std::int64_t(std::int64_t)> own_cell,
                  core::FunctionRef<std::int64_t(std::int64_t)> global_id, int rank)
      : sampler_(sampler), tree_(sampler.tree()), own_(own), own_cell_(own_cell),
        global_id_(global_id), rank_(rank) {}

  void find(const math::Vec3d& p, NearVertices& found) const;

private:
  const Sampler sampler_;
  const accel::Tree& tree_;
  const mesh::MeshView& own_;
  core::FunctionRef<std::int64_t(std::int64_t)> own_cell_, global_id_;
  int rank_;
};

} // namespace insitu::query
