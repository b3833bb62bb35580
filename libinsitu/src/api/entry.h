#pragma once

#include <exception>
#include <new>
#include <string>

#include "api/handles.h"
#include "api/session.h"
#include "core/float_environment.h"
#include "core/status.h"

/// What every C entry point goes through: the floating-point environment, the handle check, the one
/// thread a session allows, and the end of all exceptions.
namespace insitu::api {

/// A mesh handle's object: the session is kept alive while a call uses the mesh.
struct MeshRef {
  std::shared_ptr<Session> session;
  SessionMesh* mesh;
};

Handles<Session>& sessions();
Handles<MeshRef>& mesh_refs();

/// The calling thread's last message.
std::string& last_message();

insitu_status fail(insitu_status status, const char* message) noexcept;

/// Runs body; turns exceptions into a status and a message.
template <class Body>
insitu_status guarded(Body&& body) noexcept {
  const core::FloatEnvironment environment;
  try {
    last_message().clear();
    body();
    return INSITU_OK;
  } catch (const core::Error& e) {
    return fail(e.status(), e.what());
  } catch (const std::bad_alloc&) {
    return fail(INSITU_ERROR_MEMORY, "out of memory");
  } catch (const std::exception& e) {
    return fail(INSITU_ERROR_INTERNAL, e.what());
  } catch (...) {
    return fail(INSITU_ERROR_INTERNAL, "unknown exception");
  }
}

/// Marks the session as in use for a scope; throws if another thread is inside, or closed it since
/// the handle was looked up.
class Occupied {
public:
  explicit Occupied(Session& session) : session_(session) {
    if (session_.busy.exchange(true, std::memory_order_acquire))
      throw core::Error(INSITU_ERROR_BUSY,
                        "another thread is inside this session; one thread at a time may call it");
    if (session_.closed) {
      session_.busy.store(false, std::memory_order_release);
      throw core::Error(INSITU_ERROR_HANDLE, "session: closed by another thread just now");
    }
  }
  ~Occupied() { session_.busy.store(false, std::memory_order_release); }
  Occupied(const Occupied&) = delete;
  Occupied& operator=(const Occupied&) = delete;

private:
  Session& session_;
};

template <class Body>
insitu_status with_session(insitu_session handle, Body&& body) noexcept {
  return guarded([&] {
    const auto session = sessions().find(reinterpret_cast<std::uintptr_t>(handle));
    if (!session)
      throw core::Error(INSITU_ERROR_HANDLE, handle ? "session: not open, or closed already"
                                                    : "session: the handle is null");
    const Occupied occupied(*session);
    body(*session);
  });
}

/// body(session, mesh), with the mesh as the session keeps it.
template <class Body>
insitu_status with_session_mesh(insitu_mesh handle, Body&& body) noexcept {
  return guarded([&] {
    const auto ref = mesh_refs().find(reinterpret_cast<std::uintptr_t>(handle));
    if (!ref)
      throw core::Error(INSITU_ERROR_HANDLE, handle ? "mesh: its session is closed, or it never was"
                                                    : "mesh: the handle is null");
    const Occupied occupied(*ref->session);
    body(*ref->session, *ref->mesh);
  });
}

template <class Body>
insitu_status with_mesh(insitu_mesh handle, Body&& body) noexcept {
  return with_session_mesh(handle, [&](Session& s, SessionMesh& m) { body(s, m.mesh); });
}

/// The same with the mesh that queries are of, which may be one of a step that is held.
template <class Body>
insitu_status with_asked_mesh(insitu_mesh handle, Body&& body) noexcept {
  return with_session_mesh(handle, [&](Session& s, SessionMesh& m) { body(s, s.answering(m)); });
}

/// Throws unless the pointer argument is given.
inline void require(const void* argument, const char* name) {
  if (!argument)
    throw core::Error(INSITU_ERROR_ARGUMENT, std::string(name) + ": null");
}

} // namespace insitu::api
