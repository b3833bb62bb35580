#include "records/meshes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <string_view>

#include "output/files/checksum.h"
#include "file_error.h"

namespace insitu_replay {

namespace {

using insitu::output::HdfDataset;

int bytes_of(insitu_type type) {
  return type == INSITU_UINT8 ? 1 : type == INSITU_FLOAT32 || type == INSITU_INT32 ? 4 : 8;
}

/// Reads arrays of a record into memory of its own, and sees whether they are as they were written.
class ArrayReader {
public:
  explicit ArrayReader(const RecordSource& source) : source_(source) {}

  /// The array over memory that `keep` holds from now on.
  insitu_array read(const RecordedArray& array, std::vector<std::unique_ptr<std::byte[]>>& keep) {
    const HdfDataset& dataset = dataset_of(array.dataset);
    const std::int64_t numbers = array.count * array.components;
    const auto bytes = std::size_t(numbers * bytes_of(dataset.type));
    std::unique_ptr<std::byte[]>& memory =
        keep.emplace_back(new std::byte[std::max<std::size_t>(bytes, 1)]);
    source_.read(array.dataset, dataset, array.first, numbers, memory.get());
    Sum& sum = sums_[{array.dataset, array.process}];
    sum.numbers += numbers;
    sum.sum.add({reinterpret_cast<const char*>(memory.get()), bytes});
    return insitu_array_of(memory.get(), dataset.type, array.count, array.components);
  }

  /// Throws FileError for datasets that are not as they were written, of those that were read whole.
  void check_sums() const {
    for (const auto& [where, dataset] : datasets_) {
      std::int64_t read = 0;
      for (const auto& [of, sum] : sums_)
        read += of.first == where ? sum.numbers : 0;
      if (read != dataset.numbers())
        continue;
      const std::vector<std::int64_t> expected = source_.checksums(where);
      for (const auto& [of, sum] : sums_)
        if (of.first == where && (std::size_t(of.second) >= expected.size() ||
                                  expected[std::size_t(of.second)] != std::int64_t(sum.sum.sum())))
          source_.refuse(where, "is damaged: its checksum of process " +
                                    std::to_string(of.second) + " is another one");
    }
  }

private:
  struct Sum {
    std::int64_t numbers = 0;
    insitu::output::Checksum sum;
  };

  const HdfDataset& dataset_of(const std::string& where) {
    const auto [at, is_new] = datasets_.try_emplace(where);
    if (is_new)
      at->second = source_.dataset(where);
    return at->second;
  }

  const RecordSource& source_;
  std::map<std::string, HdfDataset> datasets_;
  std::map<std::pair<std::string, int>, Sum> sums_; ///< by dataset and process
};

using insitu::detail::check;
using Keep = std::vector<std::unique_ptr<std::byte[]>>;

/// The array of that name, or one without items.
insitu_array array_of(ArrayReader& reader, const RecordedPiece& piece, const char* name,
                      Keep& keep) {
  const auto found = piece.arrays.find(name);
  return found == piece.arrays.end() ? insitu_array_default() : reader.read(found->second, keep);
}

void give_cells(ArrayReader& reader, const RecordedPiece& piece, insitu_mesh mesh, int p,
                Keep& keep) {
  const auto read = [&](const char* name) { return array_of(reader, piece, name, keep); };
  switch (piece.kind) {
  case RecordedPiece::Kind::none:
    break;
  case RecordedPiece::Kind::cells: {
    insitu_cells cells = piece.cells;
    cells.connectivity = read("connectivity");
    cells.types = read("types");
    cells.offsets = read("offsets");
    check(insitu_mesh_cells(mesh, p, &cells));
    break;
  }
  case RecordedPiece::Kind::faces: {
    insitu_faces faces = piece.faces;
    faces.vertices = read("vertices");
    faces.offsets = read("face offsets");
    faces.owner = read("owner");
    faces.neighbour = read("neighbour");
    faces.boundary_vertices = read("boundary vertices");
    faces.boundary_offsets = read("boundary offsets");
    faces.boundary_owner = read("boundary owner");
    faces.cell_faces = read("cell faces");
    faces.cell_offsets = read("cell offsets");
    check(insitu_mesh_faces(mesh, p, &faces));
    break;
  }
  case RecordedPiece::Kind::block: {
    insitu_block block = piece.block;
    block.coordinates[0] = read("coordinates 0");
    block.coordinates[1] = read("coordinates 1");
    block.coordinates[2] = read("coordinates 2");
    check(insitu_mesh_block(mesh, p, &block));
    break;
  }
  case RecordedPiece::Kind::patch:
    check(insitu_mesh_patch(mesh, p, &piece.patch));
    break;
  case RecordedPiece::Kind::leaves: {
    insitu_leaves leaves = piece.leaves;
    leaves.levels = read("levels");
    leaves.corners = read("corners");
    if (piece.arrays.count("levels") == 0) { // a piece without cells
      leaves.levels = insitu_array_of(nullptr, INSITU_INT32, 0, 1);
      leaves.corners = insitu_array_of(nullptr, INSITU_INT32, 0, 3);
    }
    check(insitu_mesh_leaves(mesh, p, &leaves));
    break;
  }
  }
}

/// Ghosts and ids, which stay where cells are given again.
void give_beside_cells(ArrayReader& reader, const RecordedPiece& piece, insitu_mesh mesh, int p,
                       Keep& keep) {
  const auto give = [&](const char* name, auto&& to) {
    const bool given = piece.arrays.count(name) > 0;
    const insitu_array array = array_of(reader, piece, name, keep);
    check(to(given ? &array : nullptr));
  };
  const bool is_adaptive =
      piece.kind == RecordedPiece::Kind::patch || piece.kind == RecordedPiece::Kind::leaves;
  if (!is_adaptive) {
    give("ghosts", [&](const insitu_array* a) {
      return insitu_mesh_ghosts(mesh, p, a, piece.convention);
    });
    give("global ids of vertices", [&](const insitu_array* a) {
      return insitu_mesh_global_ids(mesh, p, INSITU_VERTEX, a);
    });
  }
  give("global ids of cells", [&](const insitu_array* a) {
    return insitu_mesh_global_ids(mesh, p, INSITU_CELL, a);
  });
}

/// The cells of a patch within an array that has its layers of ghosts around them.
insitu_array within_ghosts(insitu_array array, const insitu_patch& patch) {
  std::int64_t size[3], first = 0, stride = bytes_of(array.type) * array.components;
  bool any = false;
  for (int a = 0; a < 3; ++a) {
    size[a] = patch.cells[a] + patch.ghosts_before[a] + patch.ghosts_after[a];
    any = any || size[a] != patch.cells[a];
  }
  if (!any || array.count != size[0] * size[1] * size[2])
    return array; // of which the commit says what is wrong
  for (int a = 0; a < 3; ++a) {
    first += patch.ghosts_before[a] * stride;
    array.extent[a] = patch.cells[a];
    array.stride[a] = stride;
    stride *= size[a];
  }
  array.count = patch.cells[0] * patch.cells[1] * patch.cells[2];
  array.data = static_cast<const std::byte*>(array.data) + first;
  return array;
}

} // namespace

std::vector<insitu::Mesh> RecordedMeshes::meshes() const {
  std::vector<insitu::Mesh> out;
  for (const std::string& name : order_)
    out.push_back(known_.at(name).mesh);
  return out;
}

Record RecordedMeshes::give(insitu::Session& session, const std::string& path) {
  const std::unique_ptr<RecordSource> source = open_record(path);
  Record record = read_record(*source);
  try {
    for (const RecordedMesh& mesh : record.meshes) {
      const auto [at, is_new] = known_.try_emplace(mesh.name);
      if (is_new) {
        at->second.mesh = session.mesh(mesh.name);
        order_.push_back(mesh.name);
      }
      give(*source, mesh, at->second);
    }
  } catch (const insitu::Error& e) {
    throw FileError(path, e.what());
  }
  return record;
}

void RecordedMeshes::give(const RecordSource& source, const RecordedMesh& mesh, Known& to) {
  ArrayReader reader(source);
  const insitu_mesh handle = to.mesh.handle();
  const bool other_cells = !to.given || mesh.topology != to.topology ||
                           mesh.pieces.size() != to.pieces;
  const bool other_points = other_cells || mesh.geometry != to.geometry;
  Keep cells, points, values;
  check(insitu_mesh_frame(handle, &mesh.frame));
  check(insitu_mesh_separate_pieces(handle, mesh.separate_pieces));
  if (mesh.is_adaptive) {
    insitu_amr levels = mesh.levels;
    levels.ratios = mesh.ratios.empty() ? nullptr : mesh.ratios.data();
    check(insitu_mesh_amr(handle, &levels));
  }
  for (std::size_t i = 0; i < mesh.pieces.size(); ++i) {
    const RecordedPiece& piece = mesh.pieces[i];
    const int p = int(i);
    if (other_cells) {
      give_cells(reader, piece, handle, p, cells);
      give_beside_cells(reader, piece, handle, p, cells);
    }
    if (other_points && piece.arrays.count("points") > 0) {
      const insitu_array array = array_of(reader, piece, "points", points);
      check(insitu_mesh_points(handle, p, &array, 1));
    }
    const bool hides = piece.arrays.count("hidden points") > 0;
    const insitu_array hidden = array_of(reader, piece, "hidden points", values);
    if (!mesh.is_adaptive)
      check(insitu_mesh_hidden_points(handle, p, hides ? &hidden : nullptr));
  }
  if (to.pieces > mesh.pieces.size())
    check(insitu_mesh_drop_pieces(handle, std::int32_t(mesh.pieces.size())));
  // Fields that are gone, or have lost blank values, which add up, are taken away first.
  std::map<std::string, std::vector<double>> blanks;
  for (const RecordedMesh::Field& field : mesh.fields)
    blanks[field.name] = field.blanks;
  const auto has_lost = [](const std::vector<double>& now, const std::vector<double>& before) {
    return now.size() < before.size() ||
           !std::equal(before.begin(), before.end(), now.begin(), [](double x, double y) {
             return x == y || (std::isnan(x) && std::isnan(y));
           });
  };
  for (const auto& [name, before] : to.blanks)
    if (const auto now = blanks.find(name); now == blanks.end() || has_lost(now->second, before))
      check(insitu_mesh_remove_field(handle, name.c_str()));
  for (const RecordedMesh::Field& field : mesh.fields) {
    bool any = false;
    for (std::size_t i = 0; i < mesh.pieces.size(); ++i)
      for (const RecordedField& on : mesh.pieces[i].fields) {
        if (on.name != field.name)
          continue;
        insitu_array array = reader.read(on.array, values);
        if (mesh.pieces[i].kind == RecordedPiece::Kind::patch)
          array = within_ghosts(array, mesh.pieces[i].patch);
        check(insitu_mesh_field(handle, int(i), field.name.c_str(), on.association, &array, 1));
        any = true;
      }
    for (const double blank : field.blanks)
      if (any)
        check(insitu_mesh_field_blank(handle, field.name.c_str(), blank));
    if (!any)
      blanks.erase(field.name);
  }
  reader.check_sums();
  to.blanks = std::move(blanks);
  if (other_cells)
    to.cells = std::move(cells);
  if (other_points)
    to.points = std::move(points);
  to.values = std::move(values);
  to.given = true;
  to.topology = mesh.topology;
  to.geometry = mesh.geometry;
  to.pieces = mesh.pieces.size();
}

} // namespace insitu_replay
