#include "function.h"

#include <Time.H>
#include <addToRunTimeSelectionTable.H>
#include <mapPolyMesh.H>

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

const Foam::fvMesh& mesh_of_region(const Foam::Time& time, const Foam::word& region) {
  if (const auto* mesh = time.findObject<Foam::fvMesh>(region))
    return *mesh;
  std::string message = "there is no region '" + region + "'; regions are:";
  for (const Foam::word& name : time.sortedNames<Foam::fvMesh>())
    message += " " + name;
  throw Error(INSITU_ERROR_ARGUMENT, message);
}

} // namespace

InsituFunction::InsituFunction(const Foam::word& name, const Foam::Time& time,
                               const Foam::dictionary& entries)
    : timeFunctionObject(name, time) {
  read(entries);
  open(entries);
}

bool InsituFunction::read(const Foam::dictionary& entries) {
  timeFunctionObject::read(entries);
  fields_.clear();
  entries.readIfPresent("fields", fields_);
  return true;
}

void InsituFunction::open(const Foam::dictionary& entries) {
  Options options;
  if (entries.found("scene"))
    options.scene = path_in_case(time_, entries.get<Foam::fileName>("scene"));
  options.default_scene = options.scene.empty();
  options.output = path_in_case(time_, entries.getOrDefault<Foam::fileName>(
                                           "output", Foam::fileName("postProcessing") / name()));
  options.threads = entries.getOrDefault<int>("threads", 0);
  options.strict = entries.getOrDefault<bool>("strict", false);
  options.log = [this](LogLevel, const char* message) { warn(message); };
  try {
    options.communicator = world_communicator();
    session_.emplace(options);
    lend(entries);
  } catch (const std::exception& e) { // on all processes alike
    warn(e.what());
    lent_.clear();
    session_.reset();
  }
}

void InsituFunction::lend(const Foam::dictionary& entries) {
  Foam::wordList regions;
  if (!entries.readIfPresent("regions", regions)) {
    const auto region = entries.getOrDefault<Foam::word>("region", Foam::polyMesh::defaultRegion);
    const auto name = entries.getOrDefault<Foam::word>("mesh", region);
    lent_.emplace_back(mesh_of_region(time_, region), session_->mesh(name).handle());
    return;
  }
  for (const char* const other : {"region", "mesh"})
    if (entries.found(other))
      throw Error(INSITU_ERROR_ARGUMENT,
                  std::string("the entries 'regions' and '") + other +
                      "' exclude each other: meshes of regions are named as these");
  if (regions.empty())
    throw Error(INSITU_ERROR_ARGUMENT, "the entry 'regions' names no region");
  for (const Foam::word& region : regions) {
    const Foam::fvMesh& mesh = mesh_of_region(time_, region);
    if (lent_of(mesh))
      throw Error(INSITU_ERROR_ARGUMENT, "the region '" + region + "' stands twice in 'regions'");
    lent_.emplace_back(mesh, session_->mesh(region).handle());
  }
}

BorrowedMesh* InsituFunction::lent_of(const Foam::polyMesh& mesh) {
  for (BorrowedMesh& lent : lent_)
    if (lent.is_of(mesh))
      return &lent;
  return nullptr;
}

bool InsituFunction::execute() {
  if (!session_)
    return true;
  for (BorrowedMesh& lent : lent_)
    lent.give(fields_);
  try {
    session_->execute(time_.timeIndex(), time_.value());
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
  lent_.clear();
  session_.reset();
  return true;
}

void InsituFunction::updateMesh(const Foam::mapPolyMesh& changes) {
  if (BorrowedMesh* const lent = lent_of(changes.mesh()))
    lent->cells_changed();
}

void InsituFunction::movePoints(const Foam::polyMesh& mesh) {
  if (BorrowedMesh* const lent = lent_of(mesh))
    lent->points_moved();
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
