#include "records/record.h"

#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "core/status.h"
#include "file_error.h"
#include "output/files/checksum.h"

namespace insitu_replay {

namespace {

using insitu::output::HdfDataset;
using insitu::output::HdfReader;
using Json = nlohmann::ordered_json;

const std::string description_path = "/insitu/description", scene_path = "/insitu/scene";
constexpr std::int64_t most_numbers = std::int64_t(1) << 56;

/// The library's errors begin with "cannot read 'FILE': ", and this program's with the file.
[[noreturn]] void rethrow(const std::string& path, const insitu::core::Error& e) {
  const std::string before = "cannot read '" + path + "': ";
  const std::string what = e.what();
  throw FileError(path, what.starts_with(before) ? what.substr(before.size()) : what);
}

class HdfSource final : public RecordSource {
  template <class Ask>
  auto asked(Ask&& ask) const {
    try {
      return ask();
    } catch (const insitu::core::Error& e) {
      rethrow(path_, e);
    }
  }

public:
  explicit HdfSource(const std::string& file) : path_(file), file_(file) {}

  HdfDataset dataset(const std::string& where) const override {
    return asked([&] { return file_.dataset(where); });
  }
  void read(const std::string& where, const HdfDataset& dataset, std::int64_t first,
            std::int64_t count, std::byte* to) const override {
    asked([&] { file_.read(where, dataset, first, count, to); });
  }
  std::vector<std::int64_t> checksums(const std::string& where) const override {
    return asked([&] { return file_.attribute(where, "checksums"); });
  }
  std::string path() const override { return path_; }

private:
  std::string path_;
  HdfReader file_;
};

/// A dataset of text, which has its checksum.
std::string read_text(const RecordSource& source, const std::string& where) {
  const HdfDataset dataset = source.dataset(where);
  if (dataset.type != INSITU_UINT8)
    source.refuse(where, "is no text");
  std::string text(std::size_t(dataset.numbers()), '\0');
  source.read(where, dataset, 0, dataset.numbers(), reinterpret_cast<std::byte*>(text.data()));
  insitu::output::Checksum sum;
  sum.add(text);
  if (source.checksums(where) != std::vector<std::int64_t>{std::int64_t(sum.sum())})
    source.refuse(where, "is damaged: its checksum is another one");
  return text;
}

/// Reads the description, and deals the datasets' items out to the arrays in its order.
class DescriptionReader {
public:
  DescriptionReader(const RecordSource& source, const Json& json) : source_(source), json_(json) {}

  Record read() {
    if (integer(json_, "version") != 1)
      refuse("is of version " + std::to_string(integer(json_, "version")) + ", 1 expected");
    Record out;
    out.cycle = integer(json_, "cycle");
    out.time = number(json_.at("time"));
    if (!std::isfinite(out.time))
      refuse("the time is not finite");
    out.scene_file = json_.at("scene_file").get<std::string>();
    out.scene_text = read_text(source_, scene_path);
    std::set<std::string> names;
    for (const Json& mesh : list(json_, "meshes")) {
      folder_ = "/insitu/mesh " + std::to_string(out.meshes.size());
      out.meshes.push_back(read_mesh(mesh));
      if (!names.insert(out.meshes.back().name).second)
        refuse("mesh '" + out.meshes.back().name + "' is there twice");
    }
    for (const auto& [where, taken] : taken_)
      if (taken.items != taken.most)
        source_.refuse(where, "has " + std::to_string(taken.most) + " items, but the pieces take " +
                                  std::to_string(taken.items));
    return out;
  }

private:
  [[noreturn]] void refuse(const std::string& what) const {
    source_.refuse(description_path, what);
  }

  static const Json& list(const Json& of, const char* key) {
    const Json& found = of.at(key);
    if (!found.is_array())
      throw Json::other_error::create(0, std::string("'") + key + "' is no list", &of);
    return found;
  }

  /// Within what the API's counts allow, so that sums and products stay in 64 bits.
  std::int64_t integer(const Json& json) const {
    if (!json.is_number_integer() ||
        (json.is_number_unsigned() &&
         json.get<std::uint64_t>() > std::uint64_t(std::numeric_limits<std::int64_t>::max())))
      refuse("holds " + json.dump() + " where an integer is expected");
    return json.get<std::int64_t>();
  }
  std::int64_t integer(const Json& of, const char* key) const { return integer(of.at(key)); }
  std::int64_t integer(const Json& of, const char* key, std::int64_t low, std::int64_t high) const {
    const std::int64_t n = integer(of, key);
    if (n < low || n > high)
      refuse(std::string("'") + key + "' is " + std::to_string(n) + ", " + std::to_string(low) +
             " to " + std::to_string(high) + " expected");
    return n;
  }
  std::int64_t count(const Json& of, const char* key) const {
    return integer(of, key, 0, most_numbers);
  }
  /// A number of one of the API's enumerations or 32-bit members, which the API looks at.
  int small(const Json& of, const char* key) const {
    return int(integer(of, key, std::numeric_limits<int>::min(), std::numeric_limits<int>::max()));
  }
  /// JSON has no numbers for what is not finite.
  double number(const Json& json) const {
    if (json.is_null() || json == "nan")
      return std::numeric_limits<double>::quiet_NaN();
    if (json == "inf" || json == "-inf")
      return json == "inf" ? HUGE_VAL : -HUGE_VAL;
    if (!json.is_number())
      refuse("holds " + json.dump() + " where a number is expected");
    return json.get<double>();
  }
  void three(const Json& of, const char* key, double* to) const {
    for (std::size_t a = 0; a < 3; ++a)
      to[a] = number(list(of, key).at(a));
  }
  template <class Integer>
  void three_integers(const Json& of, const char* key, Integer* to) const {
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t n = integer(list(of, key).at(a));
      if (n < std::numeric_limits<Integer>::min() || n > std::numeric_limits<Integer>::max())
        refuse(std::string("'") + key + "' holds " + std::to_string(n));
      to[a] = Integer(n);
    }
  }

  RecordedMesh read_mesh(const Json& json) {
    RecordedMesh out;
    out.name = json.at("name").get<std::string>();
    const Json& frame = json.at("frame");
    out.frame.kind = insitu_frame_kind(small(frame, "kind"));
    three(frame, "origin", out.frame.origin);
    out.frame.utm_zone = small(frame, "utm_zone");
    out.frame.utm_north = small(frame, "utm_north");
    out.frame.angle = insitu_angle(small(frame, "angle"));
    out.frame.length = insitu_length(small(frame, "length"));
    out.frame.vertical = insitu_vertical(small(frame, "vertical"));
    out.separate_pieces = json.at("separate_pieces").get<bool>();
    if (out.is_adaptive = json.contains("adaptive"); out.is_adaptive)
      read_levels(json["adaptive"], out);
    out.processes = 0;
    for (const Json& process : list(json, "processes"))
      read_process(process, out);
    return out;
  }

  void read_levels(const Json& json, RecordedMesh& out) const {
    three(json, "origin", out.levels.origin);
    three(json, "spacing", out.levels.spacing);
    out.levels.level_count = small(json, "level_count");
    if (json.contains("dimensions"))
      out.levels.dimensions = small(json, "dimensions");
    for (const Json& ratio : list(json, "ratios"))
      out.ratios.push_back(std::int32_t(integer(ratio)));
    if (out.levels.level_count < 1 || out.ratios.size() != std::size_t(out.levels.level_count) - 1)
      refuse(std::to_string(out.ratios.size()) + " ratios of " +
             std::to_string(out.levels.level_count) + " levels");
    out.levels.finest_first = json.at("finest_first").get<bool>();
    out.levels.reconstruction = insitu_reconstruction(small(json, "reconstruction"));
  }

  void read_process(const Json& json, RecordedMesh& out) {
    process_ = out.processes++;
    // Of several processes the sum: it grows whichever of them has others.
    out.topology += count(json, "topology");
    out.geometry += count(json, "geometry");
    for (const Json& field : list(json, "fields")) {
      RecordedMesh::Field read{field.at("name").get<std::string>(), {}};
      for (const Json& blank : list(field, "blanks"))
        read.blanks.push_back(number(blank));
      bool known = false;
      for (const RecordedMesh::Field& other : out.fields)
        known = known || other.name == read.name;
      if (!known)
        out.fields.push_back(std::move(read));
    }
    for (const Json& piece : list(json, "pieces"))
      out.pieces.push_back(read_piece(piece));
  }

  RecordedPiece read_piece(const Json& json) {
    RecordedPiece out;
    const auto kind = json.at("kind").get<std::string>();
    if (kind == "cells")
      read_cells(json, out);
    else if (kind == "faces")
      read_faces(json, out);
    else if (kind == "block")
      read_block(json, out);
    else if (kind == "patch")
      read_patch(json, out);
    else if (kind == "leaves")
      read_leaves(json, out);
    else if (kind != "none")
      refuse("a piece is of the unknown kind '" + kind + "'");
    if (json.contains("ghost_convention"))
      out.convention = insitu_ghost_convention(small(json, "ghost_convention"));
    for (const auto& [name, array] : json.at("arrays").items())
      out.arrays[name] = read_array(array);
    for (const auto& [name, array] : json.at("fields").items()) {
      const bool on_cells = name.starts_with("cell ");
      if (!on_cells && !name.starts_with("vertex "))
        refuse("a field is called '" + name + "', neither on cells nor on vertices");
      out.fields.push_back({name.substr(on_cells ? 5 : 7), on_cells ? INSITU_CELL : INSITU_VERTEX,
                            read_array(array)});
    }
    return out;
  }

  void read_cells(const Json& json, RecordedPiece& out) const {
    out.kind = RecordedPiece::Kind::cells;
    out.cells.layout = insitu_layout(small(json, "layout"));
    out.cells.shape = insitu_shape(small(json, "shape"));
    out.cells.count = count(json, "count");
    out.cells.index_base = small(json, "index_base");
  }
  void read_faces(const Json& json, RecordedPiece& out) const {
    out.kind = RecordedPiece::Kind::faces;
    out.faces.form = insitu_faces_form(small(json, "form"));
    out.faces.index_base = small(json, "index_base");
    out.faces.cell_count = count(json, "cell_count");
    out.faces.face_count = count(json, "face_count");
    out.faces.boundary_count = count(json, "boundary_count");
    out.faces.far_cells = count(json, "far_cells");
  }
  void read_block(const Json& json, RecordedPiece& out) const {
    out.kind = RecordedPiece::Kind::block;
    out.block.kind = insitu_block_kind(small(json, "block"));
    three_integers(json, "vertices", out.block.vertices);
    three(json, "origin", out.block.origin);
    three(json, "spacing", out.block.spacing);
    three_integers(json, "first", out.block.first);
    out.block.dimensions = small(json, "dimensions");
  }
  void read_patch(const Json& json, RecordedPiece& out) const {
    out.kind = RecordedPiece::Kind::patch;
    out.patch.level = small(json, "level");
    three_integers(json, "lower", out.patch.lower);
    three_integers(json, "cells", out.patch.cells);
    three_integers(json, "ghosts_before", out.patch.ghosts_before);
    three_integers(json, "ghosts_after", out.patch.ghosts_after);
    for (int a = 0; a < 3; ++a)
      if (out.patch.ghosts_before[a] < 0 || out.patch.ghosts_before[a] > 1 ||
          out.patch.ghosts_after[a] < 0 || out.patch.ghosts_after[a] > 1 ||
          out.patch.cells[a] < 1 || out.patch.cells[a] > std::int64_t(1) << 31)
        refuse("a patch has cells or ghosts that cannot be");
  }
  void read_leaves(const Json& json, RecordedPiece& out) const {
    out.kind = RecordedPiece::Kind::leaves;
    out.leaves.corner_bits = small(json, "corner_bits");
    three_integers(json, "offset", out.leaves.offset);
  }

  /// What is taken of a dataset so far.
  struct Taken {
    HdfDataset dataset;
    std::int64_t items = 0, most = 0;
  };

  RecordedArray read_array(const Json& json) {
    RecordedArray out;
    const auto name = json.at(0).get<std::string>();
    out.dataset = folder_ + "/" + name;
    out.process = process_;
    const std::int64_t components = integer(json.at(1));
    out.count = integer(json.at(2));
    constexpr int most_components = 1 << 16;
    if (components < 1 || components > most_components || out.count < 0 ||
        out.count > most_numbers / components)
      refuse("an array of '" + name + "' has " + std::to_string(out.count) + " items of " +
             std::to_string(components) + " components");
    out.components = int(components);
    auto [at, is_new] = taken_.try_emplace(out.dataset);
    Taken& taken = at->second;
    if (is_new)
      taken.dataset = source_.dataset(out.dataset);
    const std::int64_t numbers = taken.dataset.numbers();
    // Items of the dataset are numbers here: ids of cells of several shapes lie in one.
    taken.most = numbers;
    if (out.count * components > numbers - taken.items)
      source_.refuse(out.dataset,
                     "has " + std::to_string(numbers) + " numbers, fewer than the pieces take");
    out.first = taken.items;
    taken.items += out.count * components;
    return out;
  }

  const RecordSource& source_;
  const Json& json_;
  std::string folder_; ///< of the mesh
  int process_ = 0;
  std::map<std::string, Taken> taken_; ///< by dataset
};

} // namespace

bool is_record(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& c : ending)
    c = char(std::tolower(static_cast<unsigned char>(c)));
  if (ending != ".hdf")
    return false;
  try {
    return HdfReader(path).has(description_path);
  } catch (const insitu::core::Error& e) {
    rethrow(path, e);
  }
}

std::unique_ptr<RecordSource> open_record(const std::string& path) {
  try {
    return std::make_unique<HdfSource>(path);
  } catch (const insitu::core::Error& e) {
    rethrow(path, e);
  }
}

Record read_record(const RecordSource& source) {
  const std::string text = read_text(source, description_path);
  const Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded())
    source.refuse(description_path, "is no JSON");
  try {
    return DescriptionReader(source, json).read();
  } catch (const Json::exception& e) {
    source.refuse(description_path, e.what());
  }
}

} // namespace insitu_replay
