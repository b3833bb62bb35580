#pragma once

// OpenFOAM makes a macro of Log, so its headers come last.
// clang-format off
#include <insitu/insitu.hpp>
#include <optional>
#include <set>
#include <string>
#include <fvMesh.H>
#include <labelIOList.H>
#include <wordRes.H>
// clang-format on

namespace insitu::foam {

/// Gives an OpenFOAM mesh and its fields to a session's mesh, all in place: points, the lists of
/// faces, owners, neighbours and values of fields are read where OpenFOAM has them.
class BorrowedMesh {
public:
  BorrowedMesh(const Foam::fvMesh& from, insitu_mesh to) : from_(from), to_(to) {}

  bool is_of(const Foam::polyMesh& mesh) const { return &mesh == &from_; }

  /// What OpenFOAM says of the mesh since the last give().
  void points_moved() { points_moved_ = true; }
  void cells_changed() { cells_changed_ = true; }

  /// Gives what changed, and the fields that `names` selects: all if it is empty. Collective over
  /// the processes of a parallel run. Throws nothing: the session's mesh is refused with what went
  /// wrong, and the next execute() tells it on all processes.
  void give(const Foam::wordRes& names);

private:
  /// The arrays of a mesh, by which a change shows that OpenFOAM did not tell of.
  struct Places {
    const void *points = nullptr, *faces = nullptr, *owner = nullptr, *neighbour = nullptr;
    Foam::label point_count = 0, face_count = 0, cell_count = 0;
    bool has_cells_of(const Places& other) const;
  };
  Places places() const;
  void give_what_changed(const Foam::wordRes& names);
  void give_cells();
  void give_points();
  void read_global_ids();
  void give_global_ids();
  void read_addressing(const char* name, Foam::label count,
                       std::optional<Foam::labelIOList>& into) const;
  void give_fields(const Foam::wordRes& names);
  template <class Field>
  void give_fields(const Foam::wordRes& names, insitu_association on, Foam::label count,
                   std::set<std::string>& given);

  const Foam::fvMesh& from_;
  insitu_mesh to_;
  bool is_given_ = false, is_refused_ = false, points_moved_ = false, cells_changed_ = false;
  bool lacks_global_ids_said_ = false;
  Places places_;
  std::optional<Foam::labelIOList> global_cells_, global_points_;
  std::set<std::string> fields_; ///< those that the mesh has
};

} // namespace insitu::foam
