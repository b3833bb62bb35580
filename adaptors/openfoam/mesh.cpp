#include "mesh.h"

#include <cstring>
#include <pointFields.H>
#include <volFields.H>

namespace insitu::foam {

namespace {

using Foam::label;
using Foam::scalar;

constexpr insitu_type label_type = sizeof(label) == 4 ? INSITU_INT32 : INSITU_INT64;
constexpr insitu_type scalar_type = sizeof(scalar) == 4 ? INSITU_FLOAT32 : INSITU_FLOAT64;

void check(insitu_status status) {
  if (status != INSITU_OK)
    throw Error(status, insitu_last_message());
}

insitu_array labels(const label* data, label count) {
  return insitu_array_of(data, label_type, count, 1);
}

// A face is a list of labels: their number, then the pointer to them.
static_assert(sizeof(Foam::face) == 2 * sizeof(void*), "OpenFOAM's lists are laid out otherwise");
constexpr std::size_t pointer_in_face = sizeof(void*);

void require_known_layout(const Foam::face& face) {
  const char* const record = reinterpret_cast<const char*>(&face);
  label count;
  const label* first;
  std::memcpy(&count, record, sizeof count);
  std::memcpy(&first, record + pointer_in_face, sizeof first);
  if (count != face.size() || first != face.cdata())
    throw Error(INSITU_ERROR_UNSUPPORTED, "OpenFOAM's lists are laid out otherwise here");
}

/// The rings of faces where OpenFOAM has them.
void set_rings(const Foam::faceList& faces, label count, insitu_faces& to) {
  if (count > 0)
    require_known_layout(faces[0]);
  const char* const records = reinterpret_cast<const char*>(faces.cdata());
  to.face_count = count;
  to.vertices = insitu_array_of(records + pointer_in_face, label_type, count, 1);
  to.vertices.indirect = 1;
  to.offsets = labels(faces.empty() ? nullptr : reinterpret_cast<const label*>(records), count);
  to.vertices.stride[0] = to.offsets.stride[0] = sizeof(Foam::face);
}

} // namespace

bool BorrowedMesh::Places::has_cells_of(const Places& other) const {
  return faces == other.faces && owner == other.owner && neighbour == other.neighbour &&
         point_count == other.point_count && face_count == other.face_count &&
         cell_count == other.cell_count;
}

BorrowedMesh::Places BorrowedMesh::places() const {
  return {from_.points().cdata(),
          from_.faces().cdata(),
          from_.faceOwner().cdata(),
          from_.faceNeighbour().cdata(),
          from_.nPoints(),
          from_.nFaces(),
          from_.nCells()};
}

void BorrowedMesh::give(const Foam::wordRes& names) {
  try {
    give_what_changed(names);
    if (is_refused_)
      check(insitu_mesh_refuse(to_, nullptr));
    is_refused_ = false;
  } catch (const std::exception& e) {
    is_refused_ = true;
    (void)insitu_mesh_refuse(to_, e.what());
  }
}

void BorrowedMesh::give_what_changed(const Foam::wordRes& names) {
  const Places now = places();
  bool anew = cells_changed_ || !is_given_ || !now.has_cells_of(places_);
  Foam::reduce(anew, Foam::orOp<bool>()); // all processes read what they read for that
  if (anew) {
    is_given_ = false; // until all is
    read_global_ids();
    give_cells();
    give_global_ids();
  } else if (now.points != places_.points) {
    give_points();
  } else if (points_moved_) {
    check(insitu_mesh_changed(to_, INSITU_CHANGED_GEOMETRY));
  }
  give_fields(names);
  check(insitu_mesh_changed(to_, INSITU_CHANGED_FIELDS));
  places_ = now;
  is_given_ = true;
  points_moved_ = cells_changed_ = false;
}

void BorrowedMesh::give_points() {
  const insitu_array points =
      insitu_array_of(from_.points().cdata(), scalar_type, from_.nPoints(), 3);
  check(insitu_mesh_points(to_, 0, &points, 1));
}

void BorrowedMesh::give_cells() {
  give_points();
  insitu_faces faces = insitu_faces_default();
  faces.cell_count = from_.nCells();
  set_rings(from_.faces(), from_.nFaces(), faces);
  faces.owner = labels(from_.faceOwner().cdata(), from_.nFaces());
  faces.neighbour = labels(from_.faceNeighbour().cdata(), from_.nInternalFaces());
  check(insitu_mesh_faces(to_, 0, &faces));
  check(insitu_mesh_changed(to_, INSITU_CHANGED_TOPOLOGY));
}

void BorrowedMesh::read_addressing(const char* name, label count,
                                   std::optional<Foam::labelIOList>& into) const {
  into.reset();
  Foam::IOobject file(name, from_.facesInstance(), Foam::polyMesh::meshSubDir, from_,
                      Foam::IOobject::MUST_READ, Foam::IOobject::NO_WRITE, false);
  if (!file.typeHeaderOk<Foam::labelIOList>(true))
    return;
  into.emplace(file);
  if (into->size() != count)
    into.reset();
}

void BorrowedMesh::read_global_ids() {
  if (!Foam::Pstream::parRun())
    return;
  read_addressing("cellProcAddressing", from_.nCells(), global_cells_);
  read_addressing("pointProcAddressing", from_.nPoints(), global_points_);
  const bool has_all = Foam::returnReduce(global_cells_ && global_points_, Foam::andOp<bool>());
  if (has_all)
    return;
  global_cells_.reset();
  global_points_.reset();
  if (!lacks_global_ids_said_)
    Foam::Info << "insitu: there are no cellProcAddressing and pointProcAddressing of the mesh "
               << from_.name() << " of time " << from_.facesInstance()
               << ": cells are named by process and number" << Foam::nl;
  lacks_global_ids_said_ = true;
}

void BorrowedMesh::give_global_ids() {
  const auto give = [&](const std::optional<Foam::labelIOList>& ids, insitu_association on) {
    const insitu_array array = ids ? labels(ids->cdata(), ids->size()) : insitu_array_default();
    check(insitu_mesh_global_ids(to_, 0, on, ids ? &array : nullptr));
  };
  give(global_cells_, INSITU_CELL);
  give(global_points_, INSITU_VERTEX);
}

template <class Field>
void BorrowedMesh::give_fields(const Foam::wordRes& names, insitu_association on, label count,
                               std::set<std::string>& given) {
  using Value = typename Field::value_type;
  for (const Foam::word& name : from_.sortedNames<Field>()) {
    const auto& values = from_.lookupObject<Field>(name).primitiveField();
    if ((!names.empty() && !names.match(name)) || values.size() != count)
      continue;
    const insitu_array array =
        insitu_array_of(values.cdata(), scalar_type, count, Foam::pTraits<Value>::nComponents);
    check(insitu_mesh_field(to_, 0, name.c_str(), on, &array, 1));
    given.insert(name);
  }
}

void BorrowedMesh::give_fields(const Foam::wordRes& names) {
  using namespace Foam;
  std::set<std::string> given;
  give_fields<volScalarField>(names, INSITU_CELL, from_.nCells(), given);
  give_fields<volVectorField>(names, INSITU_CELL, from_.nCells(), given);
  give_fields<volSymmTensorField>(names, INSITU_CELL, from_.nCells(), given);
  give_fields<volTensorField>(names, INSITU_CELL, from_.nCells(), given);
  give_fields<pointScalarField>(names, INSITU_VERTEX, from_.nPoints(), given);
  give_fields<pointVectorField>(names, INSITU_VERTEX, from_.nPoints(), given);
  for (const std::string& name : fields_)
    if (given.count(name) == 0)
      check(insitu_mesh_remove_field(to_, name.c_str()));
  fields_ = std::move(given);
}

} // namespace insitu::foam
