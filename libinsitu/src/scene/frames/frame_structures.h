#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "commit/committed_mesh.h"
#include "render/structures/structures.h"
#include "scene/earth/geocentric_mesh.h"

namespace insitu::scene {

/// The structures that the frames of a session share, by mesh.
class FrameStructures {
public:
  explicit FrameStructures(core::Context& context) : context_(&context) {}

  /// The mesh in geocentric coordinates with heights exaggerated, as it is now; made when a frame
  /// first asks for that factor, and kept while the mesh is there. Valid until the next commit of
  /// `mesh`, or until end_cycle() finds it gone.
  commit::CommittedMesh& geocentric(const commit::CommittedMesh& mesh, double exaggeration);

  /// The mesh in longitude and latitude, as it is now, on a chart that begins at `west`; made when
  /// a frame first asks for that, and kept while the mesh is there and frames of it ask. Valid as
  /// geocentric() is.
  commit::CommittedMesh& on_chart(const commit::CommittedMesh& mesh, double west);

  /// Those of a mesh as it is now; valid until end_cycle().
  render::Structures& of(const commit::CommittedMesh& mesh);
  /// Meshes that are there though cycles may do without them, by their ids: those of steps that are
  /// held, and the live ones.
  void keep_also(std::vector<std::uint64_t> ids) { kept_ = std::move(ids); }
  /// Gives back what the cycle's frames of a mesh did without, and all of meshes that are gone. In
  /// a cycle without a frame of a mesh, what is there stays.
  void end_cycle(std::span<commit::CommittedMesh* const> meshes);

  /// Of all meshes, so far.
  render::Structures::Counts counts() const;
  render::Structures::Seconds seconds() const;
  /// How often vertices were made geocentric, so far.
  std::int64_t geocentric_conversions() const;

private:
  struct Entry {
    std::unique_ptr<render::Structures> structures;
    bool begun = false;
    std::uint64_t tree = 0, fields = 0; ///< the mesh's versions when it was begun
  };
  struct Geocentric {
    std::unique_ptr<GeocentricMesh> mesh;
    std::uint64_t id = 0; ///< of what it draws
  };
  struct OnChart {
    std::unique_ptr<SharedMesh> mesh;
    std::uint64_t id = 0; ///< of what it draws
    bool is_asked_for = false;
  };
  bool is_there(std::uint64_t id, std::span<commit::CommittedMesh* const> meshes) const;

  core::Context* context_;
  std::vector<std::uint64_t> kept_;
  std::map<std::uint64_t, Entry> by_mesh_; ///< by CommittedMesh::id()
  /// By the solver's mesh and the exaggeration.
  std::map<std::pair<std::uint64_t, double>, Geocentric> geocentric_;
  /// By the solver's mesh and where the chart begins.
  std::map<std::pair<std::uint64_t, double>, OnChart> on_chart_;
  std::int64_t gone_conversions_ = 0;
  render::Structures::Counts gone_;          ///< of meshes that are gone
  render::Structures::Seconds gone_seconds_; ///< of these
};

} // namespace insitu::scene
