#pragma once

// OpenFOAM makes a macro of Log, so its headers come last.
// clang-format off
#include "mesh.h"
#include <list>
#include <optional>
#include <set>
#include <timeFunctionObject.H>
// clang-format on

namespace insitu::foam {

/// The function object `insitu` of libinsituFoam.so, which runs a scene inside a solver: a session
/// from its construction to the end of the run, with a mesh for each region that the entries name.
/// Whatever goes wrong is a warning, and the solver goes on. Parallel runs construct, execute and
/// end it on all processes.
class InsituFunction : public Foam::functionObjects::timeFunctionObject {
public:
  using word = Foam::word; // which the macro names
  TypeName("insitu");

  InsituFunction(const Foam::word& name, const Foam::Time& time, const Foam::dictionary& entries);

  bool read(const Foam::dictionary& entries) override;
  bool execute() override;
  bool write() override { return true; } ///< the scene says when something is written
  bool end() override;
  void updateMesh(const Foam::mapPolyMesh& changes) override;
  void movePoints(const Foam::polyMesh& mesh) override;

private:
  void open(const Foam::dictionary& entries);
  void lend(const Foam::dictionary& entries);
  BorrowedMesh* lent_of(const Foam::polyMesh& mesh);
  void warn(const std::string& text);

  Foam::wordRes fields_;           ///< empty: all
  std::set<std::string> warned_;   ///< each text once
  std::optional<Session> session_; ///< none if it could not be opened, or is closed
  std::list<BorrowedMesh> lent_;   ///< the session's meshes, one a region
};

} // namespace insitu::foam
