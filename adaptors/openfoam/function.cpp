#include "function.h"

#include <Time.H>
#include <addToRunTimeSelectionTable.H>

#include "communicator.h"

namespace insitu::foam {

using Foam::functionObject;

defineTypeNameAndDebug(InsituFunction, 0);
addToRunTimeSelectionTable(functionObject, InsituFunction, dictionary);

namespace {

/// A path of the user's, which is of the case's folder also where processes have folders of their
/// own.
std::string path_in_case(const Foam::Time& time, Foam::fileName path) {
  path.expand();
  return path.isAbsolute() ? path : time.globalPath() / path;
}

} // namespace

InsituFunction::InsituFunction(const Foam::word& name, const Foam::Time& time,
                               const Foam::dictionary& entries)
    : fvMeshFunctionObject(name, time, entries) {
  read(entries);
  open(entries);
}

bool InsituFunction::read(const Foam::dictionary& entries) {
  fvMeshFunctionObject::read(entries);
  fields_.clear();
  entries.readIfPresent("fields", fields_);
  return true;
}

void InsituFunction::open(const Foam::dictionary& entries) {
  const Foam::Time& time = mesh_.time();
  Options options;
  if (entries.found("scene"))
    options.scene = path_in_case(time, entries.get<Foam::fileName>("scene"));
  options.default_scene = options.scene.empty();
  options.output = path_in_case(time, entries.getOrDefault<Foam::fileName>(
                                          "output", Foam::fileName("postProcessing") / name()));
  options.threads = entries.getOrDefault<int>("threads", 0);
  options.strict = entries.getOrDefault<bool>("strict", false);
  options.log = [this](LogLevel, const char* message) { warn(message); };
  const auto mesh = entries.getOrDefault<Foam::word>("mesh", mesh_.name());
  try {
    options.communicator = world_communicator();
    session_.emplace(options);
    lent_.emplace(mesh_, session_->mesh(mesh).handle());
  } catch (const std::exception& e) { // on all processes alike
    warn(e.what());
    session_.reset();
  }
}

bool InsituFunction::execute() {
  if (!session_)
    return true;
  lent_->give(fields_);
  try {
    session_->execute(mesh_.time().timeIndex(), mesh_.time().value());
  } catch (const std::exception& e) {
    warn(e.what());
  }
  return true;
}

bool InsituFunction::end() {
  if (session_)
    try {
      session_->close();
    } catch (const std::exception& e) {
      warn(e.what());
    }
  lent_.reset();
  session_.reset();
  return true;
}

void InsituFunction::updateMesh(const Foam::mapPolyMesh&) {
  if (lent_)
    lent_->cells_changed();
}

void InsituFunction::movePoints(const Foam::polyMesh&) {
  if (lent_)
    lent_->points_moved();
}

void InsituFunction::warn(const std::string& text) {
  if (!warned_.insert(text).second)
    return;
  if (Foam::Pstream::master())
    Foam::Warning << "function object " << name() << ": " << text.c_str() << Foam::nl << Foam::endl;
  else
    Foam::Perr << "insitu: warning: " << text.c_str() << Foam::endl;
}

} // namespace insitu::foam
