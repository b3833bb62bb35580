#include "insitu/insitu.h"

#include "insitu/c/amr.h"

#include "api/entry.h"
#include "core/caller_struct.h"
#include "core/unsigned_zero.h"
#include "scene/earth/reference_frames.h"

using namespace insitu;
using api::guarded;
using api::require;
using api::with_asked_mesh;
using api::with_mesh;
using api::with_session;
using api::with_session_mesh;

namespace insitu::api {

// Never destroyed: a solver may close its sessions from a static destructor.
Handles<Session>& sessions() {
  static auto* handles = new Handles<Session>(0);
  return *handles;
}

Handles<MeshRef>& mesh_refs() {
  static auto* handles = new Handles<MeshRef>(8);
  return *handles;
}

std::string& last_message() {
  thread_local std::string message;
  return message;
}

/// Returns the handle. Collective; throws core::Error.
static std::uintptr_t open_session(const insitu_session_options& options) {
  const std::shared_ptr<parallel::World> world =
      world_of(options, {options.log_level, options.log, options.log_user});
  std::uintptr_t handle = 0;
  try {
    std::shared_ptr<Session> session;
    world->agree_after([&] {
      session = std::make_shared<Session>(options, world);
      handle = sessions().add(session);
    });
    session->open(options);
  } catch (...) {
    sessions().remove(handle);
    throw;
  }
  return handle;
}

insitu_status fail(insitu_status status, const char* message) noexcept {
  try {
    last_message() = message;
  } catch (...) { // no memory for the message; the status says it
  }
  return status;
}

} // namespace insitu::api

extern "C" {

const char* insitu_status_name(insitu_status status) {
  switch (status) {
  case INSITU_OK:
    return "INSITU_OK";
  case INSITU_ERROR_ARGUMENT:
    return "INSITU_ERROR_ARGUMENT";
  case INSITU_ERROR_HANDLE:
    return "INSITU_ERROR_HANDLE";
  case INSITU_ERROR_BUSY:
    return "INSITU_ERROR_BUSY";
  case INSITU_ERROR_ORDER:
    return "INSITU_ERROR_ORDER";
  case INSITU_ERROR_MESH:
    return "INSITU_ERROR_MESH";
  case INSITU_ERROR_FIELD:
    return "INSITU_ERROR_FIELD";
  case INSITU_ERROR_SCENE:
    return "INSITU_ERROR_SCENE";
  case INSITU_ERROR_FILE:
    return "INSITU_ERROR_FILE";
  case INSITU_ERROR_MEMORY:
    return "INSITU_ERROR_MEMORY";
  case INSITU_ERROR_UNSUPPORTED:
    return "INSITU_ERROR_UNSUPPORTED";
  case INSITU_ERROR_CONVERSION:
    return "INSITU_ERROR_CONVERSION";
  case INSITU_ERROR_ACTION:
    return "INSITU_ERROR_ACTION";
  case INSITU_ERROR_INTERNAL:
    return "INSITU_ERROR_INTERNAL";
  }
  return "unknown status";
}

insitu_status insitu_version(int* major, int* minor, int* patch) {
  if (major)
    *major = INSITU_VERSION_MAJOR;
  if (minor)
    *minor = INSITU_VERSION_MINOR;
  if (patch)
    *patch = INSITU_VERSION_PATCH;
  return INSITU_OK;
}

const char* insitu_last_message(void) {
  return api::last_message().c_str();
}

insitu_status insitu_session_open(const insitu_session_options* options, insitu_session* session) {
  return guarded([&] {
    require(session, "session");
    *session = nullptr;
    insitu_session_options known = insitu_session_options_default();
    try {
      if (options)
        known = core::from_caller(options, "options");
      *session = reinterpret_cast<insitu_session>(api::open_session(known));
    } catch (const parallel::AgreedError& e) { // one process tells it for all
      if (e.at_root())
        core::Log(known.log_level, known.log, known.log_user)
            .error(std::string("insitu_session_open: ") + e.what());
      throw;
    } catch (const std::exception& e) { // a host that asks no status learns of it
      core::Log(known.log_level, known.log, known.log_user)
          .error(std::string("insitu_session_open: ") + e.what());
      throw;
    }
  });
}

insitu_status insitu_session_close(insitu_session* session) {
  return guarded([&] {
    require(session, "session");
    if (!*session)
      return;
    const auto handle = reinterpret_cast<std::uintptr_t>(*session);
    const auto found = api::sessions().find(handle);
    if (!found)
      throw core::Error(INSITU_ERROR_HANDLE, "session: not open, or closed already");
    const api::Occupied occupied(*found);
    *session = nullptr;
    found->closed = true;
    api::sessions().remove(handle);
    for (const auto& m : found->meshes())
      api::mesh_refs().remove(reinterpret_cast<std::uintptr_t>(m->handle));
    const std::string failures = found->finish();
    if (!failures.empty())
      throw core::Error(INSITU_ERROR_FILE, failures);
  });
}

insitu_status insitu_session_mesh(insitu_session session, const char* name, insitu_mesh* mesh) {
  if (mesh)
    *mesh = nullptr;
  return with_session(session, [&](api::Session& s) {
    require(name, "name");
    require(mesh, "mesh");
    api::SessionMesh& m = s.mesh(name);
    if (!m.handle)
      m.handle = reinterpret_cast<insitu_mesh>(api::mesh_refs().add(std::make_shared<api::MeshRef>(
          api::MeshRef{api::sessions().find(reinterpret_cast<std::uintptr_t>(session)), &m})));
    *mesh = m.handle;
  });
}

insitu_status insitu_session_execute(insitu_session session, int64_t cycle, double time) {
  return with_session(session, [&](api::Session& s) {
    const std::string failures = s.execute(cycle, core::unsigned_zero(time));
    if (!failures.empty())
      throw core::Error(INSITU_ERROR_ACTION, failures);
  });
}

insitu_status insitu_mesh_locator(insitu_mesh mesh, const insitu_locator* locator) {
  return with_session_mesh(
      mesh, [&](api::Session& s, api::SessionMesh& m) { s.choose_locator(m, locator); });
}

insitu_status insitu_mesh_locator_info(insitu_mesh mesh, insitu_locator_info* info) {
  return with_asked_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) {
    require(info, "info");
    core::to_caller(m.locator_info(), info, "info");
  });
}

insitu_status insitu_mesh_advance(insitu_mesh mesh, const insitu_advance_args* args) {
  return with_session_mesh(mesh, [&](api::Session& s, api::SessionMesh& m) {
    require(args, "args");
    s.advance(m, *args);
  });
}

insitu_status insitu_mesh_commit(insitu_mesh mesh, insitu_commit_report* report) {
  return with_session_mesh(mesh, [&](api::Session& s, api::SessionMesh& m) {
    if (report)
      core::check_size(report, "report"); // before anything is done
    const insitu_commit_report done = s.commit(m);
    if (report)
      core::to_caller(done, report, "report");
  });
}

insitu_status insitu_mesh_complete(insitu_mesh mesh, insitu_commit_report* report) {
  return with_asked_mesh(mesh, [&](api::Session& s, commit::CommittedMesh& m) {
    if (report)
      core::check_size(report, "report"); // before anything is done
    const insitu_commit_report done = m.complete(s.context().memory);
    if (report)
      core::to_caller(done, report, "report");
  });
}

insitu_status insitu_mesh_validate(insitu_mesh mesh, insitu_validation* validation) {
  return with_mesh(mesh, [&](api::Session& s, commit::CommittedMesh& m) {
    const cells::Validation found = m.validate(s.context().threads);
    if (validation)
      core::to_caller(found.counts, validation, "validation");
    if (!found.findings.empty())
      throw core::Error(INSITU_ERROR_MESH, found.findings);
  });
}

insitu_status insitu_mesh_amr_info(insitu_mesh mesh, insitu_amr_info* info) {
  return with_asked_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) {
    require(info, "info");
    core::to_caller(m.amr_info(), info, "info");
  });
}

insitu_status insitu_mesh_audit(insitu_mesh mesh, insitu_audit_entry* entries, int32_t* count) {
  return with_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) {
    require(count, "count");
    const std::vector<insitu_audit_entry> all = m.audit();
    for (std::size_t i = 0; entries && i < all.size() && std::int64_t(i) < *count; ++i)
      entries[i] = all[i];
    *count = std::int32_t(all.size());
  });
}

insitu_status insitu_mesh_locate(insitu_mesh mesh, const insitu_locate_args* args) {
  return with_session_mesh(mesh, [&](api::Session& s, api::SessionMesh& m) {
    require(args, "args");
    s.locate(m, *args);
  });
}

insitu_status insitu_mesh_sample(insitu_mesh mesh, const insitu_sample_args* args) {
  return with_session_mesh(mesh, [&](api::Session& s, api::SessionMesh& m) {
    require(args, "args");
    s.sample(m, *args);
  });
}

insitu_status insitu_mesh_nearest_vertices(insitu_mesh mesh, const insitu_vertices_args* args) {
  return with_session_mesh(mesh, [&](api::Session& s, api::SessionMesh& m) {
    require(args, "args");
    s.nearest_vertices(m, *args);
  });
}

insitu_status insitu_mesh_sample_point(insitu_mesh mesh, const char* field, const double point[3],
                                       double* values, int32_t* found) {
  return with_session_mesh(mesh, [&](api::Session& s, api::SessionMesh& m) {
    require(field, "field");
    require(point, "point");
    require(values, "values");
    const bool inside = s.sample_point(m, field, point, values);
    if (found)
      *found = inside;
  });
}

insitu_status insitu_mesh_field_info(insitu_mesh mesh, const char* name, int32_t* components,
                                     insitu_association* association) {
  return with_asked_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) {
    require(name, "name");
    const mesh::FieldView field = m.mesh().own_field(name);
    if (components)
      *components = field.components;
    if (association)
      *association = field.association;
  });
}

insitu_status insitu_session_report(insitu_session session, insitu_report* report) {
  return with_session(session, [&](api::Session& s) {
    require(report, "report");
    core::to_caller(s.report(), report, "report");
  });
}

insitu_status insitu_session_plan(insitu_session session, const char** text) {
  return with_session(session, [&](api::Session& s) {
    require(text, "text");
    *text = s.plan().c_str();
  });
}

insitu_status insitu_session_checkpoint(insitu_session session, const char* path) {
  return with_session(session, [&](api::Session& s) {
    require(path, "path");
    s.checkpoint(path);
  });
}

insitu_status insitu_session_restart(insitu_session session, const char* path) {
  return with_session(session, [&](api::Session& s) {
    require(path, "path");
    s.restart(path);
  });
}

insitu_status insitu_session_record(insitu_session session, const char* path) {
  return with_session(session, [&](api::Session& s) {
    require(path, "path");
    s.record(path);
  });
}

insitu_status insitu_session_hold(insitu_session session, int32_t steps) {
  return with_session(session, [&](api::Session& s) { s.hold(steps); });
}

insitu_status insitu_session_held(insitu_session session, int64_t* cycles, int32_t* count) {
  return with_session(session, [&](api::Session& s) {
    require(count, "count");
    const std::vector<std::int64_t> held = s.held();
    for (std::size_t i = 0; cycles && i < held.size() && std::int64_t(i) < *count; ++i)
      cycles[i] = held[i];
    *count = std::int32_t(held.size());
  });
}

insitu_status insitu_session_show(insitu_session session, int64_t cycle) {
  return with_session(session, [&](api::Session& s) { s.show(cycle); });
}

insitu_status insitu_session_write_summary(insitu_session session, const char* path,
                                           double solver_s) {
  return with_session(session, [&](api::Session& s) {
    require(path, "path");
    s.write_summary(path, solver_s);
  });
}

} // extern "C"
