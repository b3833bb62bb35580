// What a solver gives to a mesh, and tells of it, before a commit.
#include "insitu/insitu.h"

#include "api/entry.h"
#include "core/caller_struct.h"
#include "core/unsigned_zero.h"
#include "scene/earth/reference_frames.h"

using namespace insitu;
using api::require;
using api::with_mesh;
using api::with_session_mesh;

extern "C" {

insitu_status insitu_mesh_points(insitu_mesh mesh, int32_t piece, const insitu_array* arrays,
                                 int32_t array_count) {
  return with_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) {
    m.mesh().set_points(piece, arrays, array_count);
  });
}

insitu_status insitu_mesh_cells(insitu_mesh mesh, int32_t piece, const insitu_cells* cells) {
  return with_mesh(
      mesh, [&](api::Session&, commit::CommittedMesh& m) { m.mesh().set_cells(piece, cells); });
}

insitu_status insitu_mesh_faces(insitu_mesh mesh, int32_t piece, const insitu_faces* faces) {
  return with_mesh(
      mesh, [&](api::Session&, commit::CommittedMesh& m) { m.mesh().set_faces(piece, faces); });
}

insitu_status insitu_mesh_block(insitu_mesh mesh, int32_t piece, const insitu_block* block) {
  return with_mesh(
      mesh, [&](api::Session&, commit::CommittedMesh& m) { m.mesh().set_block(piece, block); });
}

insitu_status insitu_mesh_field(insitu_mesh mesh, int32_t piece, const char* name,
                                insitu_association association, const insitu_array* arrays,
                                int32_t array_count) {
  return with_session_mesh(mesh, [&](api::Session& s, api::SessionMesh& m) {
    require(name, "name");
    m.mesh.mesh().set_field(piece, name, association, arrays, array_count);
    s.note_field(m, piece, name);
  });
}

insitu_status insitu_mesh_remove_field(insitu_mesh mesh, const char* name) {
  return with_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) {
    require(name, "name");
    m.mesh().remove_field(name);
  });
}

insitu_status insitu_mesh_drop_pieces(insitu_mesh mesh, int32_t first) {
  return with_mesh(mesh,
                   [&](api::Session&, commit::CommittedMesh& m) { m.mesh().drop_pieces(first); });
}

insitu_status insitu_mesh_separate_pieces(insitu_mesh mesh, int separate) {
  return with_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) {
    m.mesh().set_separate_pieces(separate != 0);
  });
}

insitu_status insitu_mesh_field_blank(insitu_mesh mesh, const char* name, double value) {
  return with_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) {
    require(name, "name");
    m.mesh().add_blank(name, value);
  });
}

insitu_status insitu_mesh_hidden_points(insitu_mesh mesh, int32_t piece,
                                        const insitu_array* array) {
  return with_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) {
    m.mesh().set_hidden_points(piece, array);
  });
}

insitu_status insitu_mesh_ghosts(insitu_mesh mesh, int32_t piece, const insitu_array* array,
                                 insitu_ghost_convention convention) {
  return with_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) {
    m.mesh().set_ghosts(piece, array, convention);
  });
}

insitu_status insitu_mesh_global_ids(insitu_mesh mesh, int32_t piece,
                                     insitu_association association, const insitu_array* array) {
  return with_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) {
    m.mesh().set_global_ids(piece, association, array);
  });
}

insitu_status insitu_mesh_frame(insitu_mesh mesh, const insitu_frame* frame) {
  return with_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) {
    require(frame, "frame");
    const insitu_frame now = scene::read_frame(*frame);
    const bool was = m.reference_frame.kind == INSITU_FRAME_GEODETIC,
               is = now.kind == INSITU_FRAME_GEODETIC;
    if (was != is || (is && !(scene::to_geo(m.reference_frame) == scene::to_geo(now))))
      m.mesh().set_changed(INSITU_CHANGED_TOPOLOGY); // located otherwise
    m.reference_frame = now;
  });
}

insitu_status insitu_mesh_changed(insitu_mesh mesh, uint32_t what) {
  return with_session_mesh(mesh, [&](api::Session& s, api::SessionMesh& m) {
    if (what & ~std::uint32_t(INSITU_CHANGED_ALL))
      throw core::Error(INSITU_ERROR_ARGUMENT,
                        "what: " + std::to_string(what) + ", a sum of INSITU_CHANGED_* expected");
    s.note_changed(m, what);
  });
}

insitu_status insitu_mesh_refuse(insitu_mesh mesh, const char* message) {
  return with_mesh(
      mesh, [&](api::Session&, commit::CommittedMesh& m) { m.refuse(message ? message : ""); });
}

} // extern "C"
