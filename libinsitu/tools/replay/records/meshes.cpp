#include "records/meshes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "file_error.h"
#include "output/files/checksum.h"

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

  /// Throws FileError for datasets that are not as they were written, of those that were read
  /// whole.
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
          source_.refuse(where, "is damaged: its checksum of process " + std::to_string(of.second) +
                                    " is another one");
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
insitu_array array_of(const PieceArrays& arrays, const char* name) {
  const auto found = arrays.find(name);
  return found == arrays.end() ? insitu_array_default() : found->second;
}

void give_cells(const RecordedPiece& piece, const PieceArrays& arrays, insitu_mesh mesh, int p) {
  const auto array = [&](const char* name) { return array_of(arrays, name); };
  switch (piece.kind) {
  case RecordedPiece::Kind::none:
    break;
  case RecordedPiece::Kind::cells: {
    insitu_cells cells = piece.cells;
    cells.connectivity = array("connectivity");
    cells.types = array("types");
    cells.offsets = array("offsets");
    check(insitu_mesh_cells(mesh, p, &cells));
    break;
  }
  case RecordedPiece::Kind::faces: {
    insitu_faces faces = piece.faces;
    faces.vertices = array("vertices");
    faces.offsets = array("face offsets");
    faces.owner = array("owner");
    faces.neighbour = array("neighbour");
    faces.boundary_vertices = array("boundary vertices");
    faces.boundary_offsets = array("boundary offsets");
    faces.boundary_owner = array("boundary owner");
    faces.cell_faces = array("cell faces");
    faces.cell_offsets = array("cell offsets");
    check(insitu_mesh_faces(mesh, p, &faces));
    break;
  }
  case RecordedPiece::Kind::block: {
    insitu_block block = piece.block;
    block.coordinates[0] = array("coordinates 0");
    block.coordinates[1] = array("coordinates 1");
    block.coordinates[2] = array("coordinates 2");
    check(insitu_mesh_block(mesh, p, &block));
    break;
  }
  case RecordedPiece::Kind::patch:
    check(insitu_mesh_patch(mesh, p, &piece.patch));
    break;
  case RecordedPiece::Kind::leaves: {
    insitu_leaves leaves = piece.leaves;
    leaves.levels = array("levels");
    leaves.corners = array("corners");
    if (arrays.count("levels") == 0) { // a piece without cells
      leaves.levels = insitu_array_of(nullptr, INSITU_INT32, 0, 1);
      leaves.corners = insitu_array_of(nullptr, INSITU_INT32, 0, 3);
    }
    check(insitu_mesh_leaves(mesh, p, &leaves));
    break;
  }
  }
}

/// Ghosts and ids, which stay where cells are given again.
void give_beside_cells(const RecordedPiece& piece, const PieceArrays& arrays, insitu_mesh mesh,
                       int p, bool is_adaptive) {
  const auto find = [&](const char* name) {
    const auto found = arrays.find(name);
    return found == arrays.end() ? nullptr : &found->second;
  };
  if (!is_adaptive) {
    check(insitu_mesh_ghosts(mesh, p, find("ghosts"), piece.convention));
    check(insitu_mesh_global_ids(mesh, p, INSITU_VERTEX, find("global ids of vertices")));
  }
  check(insitu_mesh_global_ids(mesh, p, INSITU_CELL, find("global ids of cells")));
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

/// Gives one mesh of a record.
class RecordedMeshes::Giver {
public:
  Giver(const RecordSource& source, const RecordedMesh& mesh, Known& to)
      : reader_(source), mesh_(mesh), to_(to), handle_(to.mesh.handle()),
        other_cells_(!to.given || mesh.topology != to.topology || mesh.pieces.size() != to.pieces),
        other_points_(other_cells_ || mesh.geometry != to.geometry) {}

  void give() {
    check(insitu_mesh_frame(handle_, &mesh_.frame));
    check(insitu_mesh_separate_pieces(handle_, mesh_.separate_pieces));
    if (mesh_.is_adaptive) {
      insitu_amr levels = mesh_.levels;
      levels.ratios = mesh_.ratios.empty() ? nullptr : mesh_.ratios.data();
      check(insitu_mesh_amr(handle_, &levels));
    }
    if (other_cells_)
      give_all_cells();
    if (other_points_)
      give_points();
    give_hidden_points();
    give_fields();
    reader_.check_sums();
    if (other_cells_)
      to_.cells = std::move(cells_);
    if (other_points_)
      to_.points = std::move(points_);
    to_.values = std::move(values_);
    to_.given = true;
    to_.topology = mesh_.topology;
    to_.geometry = mesh_.geometry;
    to_.pieces = mesh_.pieces.size();
  }

private:
  void give_all_cells() {
    to_.of_cells.assign(mesh_.pieces.size(), {});
    for (std::size_t p = 0; p < mesh_.pieces.size(); ++p) {
      for (const auto& [name, array] : mesh_.pieces[p].arrays)
        if (name != "points" && name != "hidden points")
          to_.of_cells[p][name] = reader_.read(array, cells_);
      if (mesh_.processes > 1)
        hide_ghosts(mesh_.pieces[p], to_.of_cells[p]);
    }
    to_.assembly.reset();
    if (mesh_.processes > 1 && !mesh_.is_adaptive)
      to_.assembly = Assembly::make(mesh_, to_.of_cells);
    if (to_.assembly) {
      const insitu_cells cells = to_.assembly->cells();
      check(insitu_mesh_cells(handle_, 0, &cells));
      check(insitu_mesh_ghosts(handle_, 0, nullptr, INSITU_GHOSTS_VTK));
      for (const insitu_association on : {INSITU_VERTEX, INSITU_CELL}) {
        const insitu_array ids = to_.assembly->global_ids(on);
        check(insitu_mesh_global_ids(handle_, 0, on, &ids));
      }
    } else {
      for (std::size_t p = 0; p < mesh_.pieces.size(); ++p) {
        give_cells(mesh_.pieces[p], to_.of_cells[p], handle_, int(p));
        give_beside_cells(mesh_.pieces[p], to_.of_cells[p], handle_, int(p), mesh_.is_adaptive);
      }
    }
    const std::size_t pieces = to_.assembly ? 1 : mesh_.pieces.size();
    if (to_.pieces > pieces)
      check(insitu_mesh_drop_pieces(handle_, std::int32_t(pieces)));
  }

  /// The array of that name of each piece; null where a piece has none.
  std::vector<const insitu_array*> of_pieces(const char* name, Keep& keep,
                                             std::vector<insitu_array>& read) {
    read.reserve(mesh_.pieces.size());
    std::vector<const insitu_array*> out(mesh_.pieces.size(), nullptr);
    for (std::size_t p = 0; p < mesh_.pieces.size(); ++p)
      if (const auto found = mesh_.pieces[p].arrays.find(name);
          found != mesh_.pieces[p].arrays.end()) {
        read.push_back(reader_.read(found->second, keep));
        out[p] = &read.back();
      }
    return out;
  }

  void give_points() {
    std::vector<insitu_array> read;
    const auto points = of_pieces("points", points_, read);
    if (to_.assembly) {
      const std::vector<double> all = to_.assembly->points(mesh_, to_.of_cells, points);
      const auto* const bytes = reinterpret_cast<const std::byte*>(all.data());
      const auto& kept = points_.emplace_back(new std::byte[8 * all.size()]);
      std::copy(bytes, bytes + 8 * all.size(), kept.get());
      const insitu_array array =
          insitu_array_of(kept.get(), INSITU_FLOAT64, to_.assembly->count(INSITU_VERTEX), 3);
      check(insitu_mesh_points(handle_, 0, &array, 1));
      return;
    }
    for (std::size_t p = 0; p < points.size(); ++p)
      if (points[p])
        check(insitu_mesh_points(handle_, int(p), points[p], 1));
  }

  /// An array of all pieces' values, of which some piece has one.
  insitu_array assembled(insitu_association on, const std::vector<const insitu_array*>& from) {
    const insitu_array* first = nullptr;
    for (const insitu_array* const array : from)
      first = first ? first : array;
    const std::size_t item = std::size_t(first->components) * std::size_t(bytes_of(first->type));
    for (const insitu_array* const array : from)
      if (array && (array->type != first->type || array->components != first->components))
        throw insitu::Error(
            INSITU_ERROR_UNSUPPORTED,
            "processes have an array of different types, and cells whose global ids "
            "do not ascend from process to process");
    const std::int64_t count = to_.assembly->count(on);
    const auto& kept = values_.emplace_back(new std::byte[item * std::size_t(count)]);
    to_.assembly->gather(on, from, item, kept.get());
    return insitu_array_of(kept.get(), first->type, count, first->components);
  }

  void give_hidden_points() {
    std::vector<insitu_array> read;
    const auto hidden = of_pieces("hidden points", values_, read);
    if (mesh_.is_adaptive)
      return;
    if (to_.assembly) {
      const insitu_array all =
          read.empty() ? insitu_array_default() : assembled(INSITU_VERTEX, hidden);
      check(insitu_mesh_hidden_points(handle_, 0, read.empty() ? nullptr : &all));
      return;
    }
    for (std::size_t p = 0; p < hidden.size(); ++p)
      check(insitu_mesh_hidden_points(handle_, int(p), hidden[p]));
  }

  void give_fields() {
    // Fields that are gone, or have lost blank values, which add up, are taken away first.
    std::map<std::string, std::vector<double>> blanks;
    for (const RecordedMesh::Field& field : mesh_.fields)
      blanks[field.name] = field.blanks;
    for (const auto& [name, before] : to_.blanks)
      if (const auto now = blanks.find(name); now == blanks.end() || has_lost(now->second, before))
        check(insitu_mesh_remove_field(handle_, name.c_str()));
    for (const RecordedMesh::Field& field : mesh_.fields) {
      if (!give_field(field.name)) {
        blanks.erase(field.name);
        continue;
      }
      for (const double blank : field.blanks)
        check(insitu_mesh_field_blank(handle_, field.name.c_str(), blank));
    }
    to_.blanks = std::move(blanks);
  }

  /// Returns whether a piece has it.
  bool give_field(const std::string& name) {
    std::vector<insitu_array> read;
    read.reserve(mesh_.pieces.size());
    std::vector<const insitu_array*> arrays(mesh_.pieces.size(), nullptr);
    insitu_association on = INSITU_VERTEX;
    for (std::size_t p = 0; p < mesh_.pieces.size(); ++p)
      for (const RecordedField& field : mesh_.pieces[p].fields) {
        if (field.name != name || arrays[p])
          continue;
        read.push_back(reader_.read(field.array, values_));
        if (mesh_.pieces[p].kind == RecordedPiece::Kind::patch)
          read.back() = within_ghosts(read.back(), mesh_.pieces[p].patch);
        arrays[p] = &read.back();
        on = field.association;
      }
    if (read.empty())
      return false;
    if (to_.assembly) {
      const insitu_array all = assembled(on, arrays);
      check(insitu_mesh_field(handle_, 0, name.c_str(), on, &all, 1));
      return true;
    }
    for (std::size_t p = 0; p < arrays.size(); ++p)
      if (arrays[p])
        check(insitu_mesh_field(handle_, int(p), name.c_str(), on, arrays[p], 1));
    return true;
  }

  static bool has_lost(const std::vector<double>& now, const std::vector<double>& before) {
    return now.size() < before.size() ||
           !std::equal(before.begin(), before.end(), now.begin(), [](double x, double y) {
             return x == y || (std::isnan(x) && std::isnan(y));
           });
  }

  ArrayReader reader_;
  RecordedMesh mesh_; ///< whose ghosts may become hidden ones
  Known& to_;
  insitu_mesh handle_;
  bool other_cells_, other_points_;
  Keep cells_, points_, values_; ///< arrays that the session reads from now on
};

std::vector<std::pair<std::string, insitu::Mesh>> RecordedMeshes::meshes() const {
  std::vector<std::pair<std::string, insitu::Mesh>> out;
  for (const std::string& name : order_)
    out.emplace_back(name, known_.at(name).mesh);
  return out;
}

Record RecordedMeshes::give(insitu::Session& session, const std::string& path) {
  const std::unique_ptr<RecordSource> source = open_record(path);
  Record record = read_record(*source);
  give(session, *source, record);
  return record;
}

void RecordedMeshes::give(insitu::Session& session, const RecordSource& source,
                          const Record& record) {
  try {
    for (const RecordedMesh& mesh : record.meshes) {
      const auto [at, is_new] = known_.try_emplace(mesh.name);
      if (is_new) {
        at->second.mesh = session.mesh(mesh.name);
        order_.push_back(mesh.name);
      }
      Giver(source, mesh, at->second).give();
    }
  } catch (const insitu::Error& e) {
    throw FileError(source.path(), e.what());
  }
}

} // namespace insitu_replay
