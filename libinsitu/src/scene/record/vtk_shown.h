#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "commit/committed_mesh.h"
#include "parallel/world.h"
#include "scene/record/piece_arrays.h"
#include "scene/record/record_file.h"

namespace insitu::scene {

/// What readers of VTKHDF show of a mesh: cells with shapes as an UnstructuredGrid, of which each
/// piece is a part, or the one uniform block of one process as ImageData. Arrays that a record has
/// as readers want them get a second path; what readers want besides is made, such as the types of
/// cells. Cells whose ids are none, which ghosts may be, are shown as empty ones.
class VtkShown {
public:
  /// folder: the mesh's group in the file. Collective; throws parallel::AgreedError.
  VtkShown(const commit::CommittedMesh& mesh, std::string folder, parallel::World& world);
  ~VtkShown();

  /// Whether there is anything to show; the same on all processes.
  bool any() const { return form_ != Form::none; }
  /// What is made, for RecordFile::write().
  std::vector<RecordStream> streams() const;
  /// Those of the mesh's datasets that ImageData has in three dimensions.
  std::map<std::string, std::vector<std::int64_t>>
  extents(const std::vector<RecordStream>& of_mesh) const;
  /// Attributes and second paths, at the root, once all datasets are written.
  void finish(RecordFile& file, std::int64_t cycle, double time) const;

  struct Piece;

private:
  enum class Form { none, grid, image };
  struct Facts;
  void look_at(const mesh::GivenPiece& piece, Facts& facts);
  std::string dataset(const char* name, insitu_type type, int components) const;
  void link_fields(RecordFile& file, const std::string& prefix, const std::string& group,
                   std::int64_t items) const;

  std::string folder_;
  Form form_ = Form::none;
  bool links_points_ = false, links_ids_ = false, has_ghosts_ = false;
  insitu_type id_type_ = INSITU_INT64, point_type_ = INSITU_FLOAT64;
  std::vector<std::shared_ptr<const Piece>> pieces_; ///< of this process
};

} // namespace insitu::scene
