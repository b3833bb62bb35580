#include "setup.h"

#include "core/random.h"
#include "measure.h"
#include "peers/vtk_parts.h"

namespace insitu::bench {

Setup::Setup(const Options& o) : context(o.threads, core::Log()) {
  progress("making the mesh");
  mesh = o.mesh_file.empty()
             ? workload::make_box(o.kind, workload::box_size(o.kind, o.cells[0], o.spacing),
                                  o.jitter, o.spacing)
             : read_vtu(o.mesh_file);
  if (mesh.cell_count() == 0)
    throw UsageError("--mesh " + o.mesh_file + ": the file has no cells");
  if (mesh.has_faces() && (o.pattern >= workload::Pattern::march || o.shuffled ||
                           o.spacing != workload::Spacing::even || o.fields > 1))
    throw UsageError(
        "--shape poly and hexfaces: uniform, random or sorted points, evenly spaced cells in their "
        "own order, one field");
  if (o.shuffled)
    mesh = workload::renumbered(mesh);
  field = workload::vertex_field(mesh);
}

insitu_cells cells_of(const workload::Mesh& mesh) {
  if (mesh.has_faces())
    throw UsageError("--shape poly and hexfaces are for locate and commit");
  insitu_cells cells = insitu_cells_default();
  cells.count = mesh.cell_count();
  const auto ids = std::int64_t(mesh.connectivity.size());
  if (mesh.types.empty()) {
    cells.shape = insitu_shape(mesh.uniform_shape);
    cells.connectivity = insitu_array_of(mesh.connectivity.data(), INSITU_INT32, cells.count,
                                         mesh::vertex_count(mesh.uniform_shape));
  } else {
    cells.layout = INSITU_LAYOUT_MIXED;
    cells.connectivity = insitu_array_of(mesh.connectivity.data(), INSITU_INT32, ids, 1);
    cells.types = insitu_array_of(mesh.types.data(), INSITU_UINT8, cells.count, 1);
    cells.offsets = insitu_array_of(mesh.offsets.data(), INSITU_INT64, cells.count + 1, 1);
  }
  return cells;
}

namespace {

insitu_faces faces_of(const workload::Mesh& mesh) {
  const auto array = [](const auto& a) {
    return insitu_array_of(a.data(), sizeof a[0] == 4 ? INSITU_INT32 : INSITU_INT64,
                           std::int64_t(a.size()), 1);
  };
  insitu_faces faces = insitu_faces_default();
  faces.form = INSITU_FACES_CELLS;
  faces.cell_count = mesh.cell_count();
  faces.face_count = std::int64_t(mesh.face_offsets.size()) - 1;
  faces.vertices = array(mesh.face_vertices);
  faces.offsets = array(mesh.face_offsets);
  faces.cell_faces = array(mesh.cell_faces);
  faces.cell_offsets = array(mesh.cell_offsets);
  return faces;
}

} // namespace

std::unique_ptr<commit::CommittedMesh> Setup::register_mesh() {
  auto out = std::make_unique<commit::CommittedMesh>("bench", context.memory);
  const insitu_array points =
      insitu_array_of(mesh.points.data(), INSITU_FLOAT64, mesh.vertex_count(), 3);
  out->mesh().set_points(0, &points, 1);
  if (mesh.has_faces()) {
    const insitu_faces faces = faces_of(mesh);
    out->mesh().set_faces(0, &faces);
  } else {
    const insitu_cells cells = cells_of(mesh);
    out->mesh().set_cells(0, &cells);
  }
  const insitu_array values = insitu_array_of(field.data(), INSITU_FLOAT64, mesh.vertex_count(), 1);
  out->mesh().set_field(0, "f", INSITU_VERTEX, &values, 1);
  return out;
}

insitu_commit_report Setup::commit(commit::CommittedMesh& committed) {
  return committed.commit(context.threads, context.log, context.memory, true);
}

void Setup::wobble() {
  const double step = sign_ * 0.01 * mesh.smallest_edge;
  sign_ = -sign_;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    mesh.points[i] += i & 1 ? step : -step;
}

void Setup::update_field() {
  for (std::size_t v = 0; v < field.size(); ++v)
    field[v] = workload::field(mesh.point(std::int64_t(v)));
}

} // namespace insitu::bench
