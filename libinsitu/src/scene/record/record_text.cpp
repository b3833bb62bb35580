#include "scene/record/record_text.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "mesh/registered/dense_items.h"
#include "output/files/json_text.h"

namespace insitu::scene {

namespace {

using mesh::ExternalArray;
using output::JsonText;

/// What of a mesh goes to a file, piece by piece.
class PartWriter {
public:
  PartWriter(const commit::CommittedMesh& mesh, std::string folder)
      : mesh_(mesh), folder_(std::move(folder)) {}

  RecordedPart write() {
    const mesh::Mesh& from = mesh_.mesh();
    json_.open('{');
    const commit::CommittedMesh::Told told = mesh_.told_versions();
    json_.key("topology").value(std::int64_t(told.topology));
    json_.key("geometry").value(std::int64_t(told.geometry));
    write_fields(from.given());
    json_.key("pieces").open('[');
    for (std::int32_t p = 0; p < from.given_piece_count(); ++p)
      write_piece(from.given_piece(p));
    json_.close().close();
    part_.text = json_.text();
    return std::move(part_);
  }

private:
  void write_fields(const mesh::GivenMesh& given) {
    json_.key("fields").open('[');
    for (const mesh::GivenMesh::Field& field : given.fields) {
      json_.open('{').key("name").value(field.name).key("blanks").open('[');
      for (const double blank : field.blanks) // which JSON has no numbers for
        std::isfinite(blank) ? json_.value(blank)
                             : json_.value(std::isnan(blank) ? "nan"
                                           : blank < 0       ? "-inf"
                                                             : "inf");
      json_.close().close();
    }
    json_.close();
  }

  template <class Numbers>
  void numbers(const char* key, const Numbers& three) {
    json_.key(key).open('[');
    for (int a = 0; a < 3; ++a)
      json_.value(three[a]);
    json_.close();
  }

  void write_cells(std::monostate) { json_.value("none"); }

  void write_cells(const insitu_cells& cells) {
    json_.value("cells").key("layout").value(int(cells.layout));
    json_.key("shape").value(int(cells.shape)).key("count").value(std::int64_t(cells.count));
    json_.key("index_base").value(cells.index_base);
  }

  void write_cells(const insitu_faces& faces) {
    json_.value("faces").key("form").value(int(faces.form));
    json_.key("index_base").value(faces.index_base);
    json_.key("cell_count").value(std::int64_t(faces.cell_count));
    json_.key("face_count").value(std::int64_t(faces.face_count));
    json_.key("boundary_count").value(std::int64_t(faces.boundary_count));
    json_.key("far_cells").value(std::int64_t(faces.far_cells));
  }

  void write_cells(const insitu_block& block) {
    json_.value("block").key("block").value(int(block.kind));
    numbers("vertices", block.vertices);
    numbers("origin", block.origin);
    numbers("spacing", block.spacing);
    numbers("first", block.first);
    json_.key("dimensions").value(block.dimensions);
  }

  void write_amr(const mesh::AmrPiece& piece) {
    if (piece.kind == mesh::AmrPiece::Kind::patch) {
      const insitu_patch patch = mesh::as_read(piece.patch);
      json_.value("patch").key("level").value(patch.level);
      numbers("lower", patch.lower);
      numbers("cells", patch.cells);
      numbers("ghosts_before", patch.ghosts_before);
      numbers("ghosts_after", patch.ghosts_after);
      return;
    }
    json_.value("leaves").key("corner_bits").value(piece.corner_bits);
    numbers("offset", piece.offset);
  }

  /// Notes an array of the piece, and that its items follow those of pieces before in a dataset.
  /// flat: its items are numbers there, however many a cell has.
  void add(const std::string& name, const std::string& dataset,
           const std::vector<ExternalArray>& arrays, RecordRun run, bool flat = false) {
    const insitu_type type = arrays[0].type;
    const int components = mesh::components_of(arrays);
    std::string file = dataset + "." + mesh::type_name(type);
    if (!flat && components > 1)
      file += "x" + std::to_string(components);
    json_.key(name).open('[').value(file).value(components).value(run.items).close();
    if (flat && components > 1) {
      // Items are copied whole, whatever slice of them is asked for.
      const std::int64_t bytes = mesh::size_of(type);
      std::vector<std::byte> one(std::size_t(components * bytes));
      run.copy = [copy = run.copy, one, components, bytes](std::int64_t begin, std::int64_t end,
                                                           std::byte* to) mutable {
        for (std::int64_t at = begin; at < end;) {
          const std::int64_t item = at / components, within = at % components;
          const std::int64_t whole = (end - at) / components;
          if (within == 0 && whole > 0) {
            copy(item, item + whole, to);
            at += whole * components;
            to += whole * components * bytes;
            continue;
          }
          const std::int64_t now = std::min(end - at, components - within);
          copy(item, item + 1, one.data());
          std::copy_n(one.data() + within * bytes, now * bytes, to);
          at += now;
          to += now * bytes;
        }
      };
      run.items *= components;
    }
    stream(file, type, flat ? 1 : components).runs.push_back(std::move(run));
  }
  void add(const std::string& name, const std::vector<ExternalArray>& arrays) {
    add(name, name, arrays, run_of(arrays), name == "connectivity");
  }

  /// Rings that lie behind pointers, as rings that follow each other.
  void add_rings(const std::string& offsets, const ExternalArray& rings,
                 const ExternalArray& counts, std::int64_t base) {
    mesh::RingsBehind behind(rings, counts);
    const std::string vertices = offsets == "face offsets" ? "vertices" : "boundary vertices";
    add(vertices, vertices, {rings},
        {behind.id_count(), nullptr,
         [behind](std::int64_t begin, std::int64_t end, std::byte* to) mutable {
           behind.copy_ids(begin, end, to);
         }});
    ExternalArray places = counts; // its type alone
    places.type = INSITU_INT64;
    add(offsets, offsets, {places},
        {behind.face_count() + 1, nullptr,
         [behind, base](std::int64_t begin, std::int64_t end, std::byte* to) mutable {
           behind.copy_places(begin, end, base, to);
         }});
  }

  RecordStream& stream(const std::string& file, insitu_type type, int components) {
    const auto [at, is_new] = streams_.emplace(file, part_.streams.size());
    if (is_new)
      part_.streams.push_back({folder_ + "/" + file, type, components, {}});
    return part_.streams[at->second];
  }

  void write_piece(const mesh::GivenPiece& piece) {
    json_.open('{').key("kind");
    if (mesh_.mesh().is_adaptive())
      write_amr(piece.amr);
    else
      std::visit([&](const auto& cells) { write_cells(cells); }, piece.cells);
    if (piece.ghosts.given())
      json_.key("ghost_convention").value(int(piece.convention));
    json_.key("arrays").open('{');
    if (!piece.points.empty())
      add("points", piece.points);
    const ExternalArray* rings = nullptr; // behind pointers, until their numbers of ids come
    for (const auto& [name, array] : piece.cell_arrays)
      if (name.ends_with("vertices") && array.indirect)
        rings = &array;
      else if (rings && name.ends_with("offsets"))
        add_rings(name, *std::exchange(rings, nullptr), array,
                  std::get<insitu_faces>(piece.cells).index_base);
      else
        add(name, {array});
    if (piece.ghosts.given())
      add("ghosts", {piece.ghosts});
    if (piece.hidden_points.given())
      add("hidden points", {piece.hidden_points});
    if (piece.global_ids[INSITU_VERTEX].given())
      add("global ids of vertices", {piece.global_ids[INSITU_VERTEX]});
    if (piece.global_ids[INSITU_CELL].given())
      add("global ids of cells", {piece.global_ids[INSITU_CELL]});
    json_.close().key("fields").open('{');
    const bool is_patch = piece.amr.kind == mesh::AmrPiece::Kind::patch;
    for (const mesh::GivenField& field : piece.fields)
      add((field.association == INSITU_CELL ? "cell " : "vertex ") + field.name,
          field_dataset(field), field.arrays,
          run_of(is_patch ? mesh::with_read_layers(field.arrays, piece.amr.patch) : field.arrays));
    json_.close().close();
  }

  const commit::CommittedMesh& mesh_;
  std::string folder_;
  JsonText json_;
  RecordedPart part_;
  std::map<std::string, std::size_t> streams_; ///< of part_, by dataset
};

} // namespace

std::string field_dataset(const mesh::GivenField& field) {
  std::string out = field.association == INSITU_CELL ? cell_field : vertex_field;
  for (const char c : field.name)
    out += c == '/' ? "%2f" : c == '%' ? "%25" : std::string(1, c);
  return out;
}

RecordedPart recorded_part(const commit::CommittedMesh& mesh, const std::string& folder) {
  return PartWriter(mesh, folder).write();
}

std::string mesh_text(const commit::CommittedMesh& mesh, const std::vector<std::string>& parts) {
  const mesh::GivenMesh given = mesh.mesh().given();
  const insitu_frame& frame = mesh.reference_frame;
  JsonText j;
  const auto numbers = [&](const char* key, const auto& of, int count) {
    j.key(key).open('[');
    for (int i = 0; i < count; ++i)
      j.value(of[i]);
    j.close();
  };
  j.open('{').key("name").value(mesh.mesh().name());
  j.key("frame").open('{').key("kind").value(int(frame.kind));
  numbers("origin", frame.origin, 3);
  j.key("utm_zone").value(frame.utm_zone).key("utm_north").value(frame.utm_north);
  j.key("angle").value(int(frame.angle)).key("length").value(int(frame.length));
  j.key("vertical").value(int(frame.vertical)).close();
  j.key("separate_pieces").value(given.separate_pieces);
  if (const mesh::AmrLevels* levels = given.levels) {
    j.key("adaptive").open('{');
    numbers("origin", levels->given_origin(), 3);
    numbers("spacing", levels->given_spacing(), 3);
    if (levels->dimensions() == 2)
      j.key("dimensions").value(2);
    j.key("level_count").value(levels->level_count).key("ratios").open('[');
    for (int l = 1; l < levels->level_count; ++l)
      j.value(1 << (levels->depth_of[l] - levels->depth_of[l - 1]));
    j.close().key("finest_first").value(levels->finest_first);
    j.key("reconstruction").value(int(levels->reconstruction)).close();
  }
  j.key("processes").open('[');
  for (const std::string& part : parts)
    j.raw(part);
  j.close().close();
  return j.text();
}

} // namespace insitu::scene
