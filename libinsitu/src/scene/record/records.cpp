#include "scene/record/records.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "output/files/checksum.h"
#include "output/files/json_text.h"
#include "scene/record/record_file.h"
#include "scene/record/record_text.h"
#include "scene/record/vtk_shown.h"

namespace insitu::scene {

namespace {

std::string absolute(const std::string& path) {
  std::error_code error;
  return path.empty() ? path : std::filesystem::absolute(path, error).lexically_normal().string();
}

void write_text(output::HdfWriter& file, const std::string& where, const std::string& text) {
  const auto size = std::int64_t(text.size());
  file.make_dataset(where, INSITU_UINT8, std::span(&size, 1));
  file.write(where, 0, std::as_bytes(std::span(text)));
  output::Checksum sum;
  sum.add(text);
  const auto bits = std::int64_t(sum.sum());
  file.set_attribute(where, "checksums", std::span(&bits, 1));
}

} // namespace

void Records::write(const std::string& path, const RecordedStep& step, MeshList meshes,
                    bool descends) {
  for (const commit::CommittedMesh* mesh : meshes)
    world_.agree_after([&] {
      if (mesh->lies_on_device())
        throw core::Error(INSITU_ERROR_UNSUPPORTED,
                          "record '" + path + "': mesh '" + mesh->mesh().name() +
                              "' lies in device memory; records are of meshes in host memory");
    });
  RecordFile file(path, context_, world_);
  std::optional<VtkShown> shown; // of the first mesh of which there is anything to show
  std::vector<std::string> texts;
  for (const commit::CommittedMesh* mesh : meshes) {
    const std::string folder = "/insitu/mesh " + std::to_string(texts.size());
    RecordedPart part;
    world_.agree_after([&] { part = recorded_part(*mesh, folder); });
    std::map<std::string, std::vector<std::int64_t>> extents;
    std::vector<RecordStream> made;
    if (!shown) {
      shown.emplace(*mesh, folder, world_);
      if (shown->any())
        world_.agree_after([&] {
          extents = shown->extents(part.streams);
          made = shown->streams();
        });
      else
        shown.reset();
    }
    file.write(part.streams, extents);
    if (!made.empty())
      file.write(made);
    const std::vector<std::string> parts = file.gather(part.text);
    world_.agree_after(
        [&] { texts.push_back(file.at_root() ? mesh_text(*mesh, parts) : std::string()); });
  }
  world_.agree_after([&] {
    if (!file.at_root())
      return;
    if (shown)
      shown->finish(file, step.cycle, step.time);
    output::JsonText json;
    json.open('{').key("version").value(record_version).key("cycle").value(step.cycle);
    json.key("time").value(step.time).key("scene_file").value(absolute(step.scene_file));
    json.key("meshes").open('[');
    for (const std::string& text : texts)
      json.raw(text);
    json.close().close();
    write_text(*file.at_root(), "/insitu/scene", step.scene_text);
    write_text(*file.at_root(), "/insitu/description", json.text());
    file.at_root()->commit();
    ++statistics_.files;
    add_to_series(path, step.time, descends);
  });
}

void Records::add_to_series(const std::string& path, double time, bool descends) {
  const std::string index = series_path(path);
  if (index.empty())
    return;
  auto series = series_.find(index);
  if (series == series_.end()) {
    try {
      series = series_.emplace(index, output::FileSeries(index, true, descends)).first;
    } catch (const core::Error&) { // not one of ours: replaced
      series = series_.emplace(index, output::FileSeries(index)).first;
    }
  }
  series->second.add(time, std::filesystem::path(path).filename().string());
}

std::string record_path(const std::string& folder, std::int64_t cycle) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%06lld", static_cast<long long>(cycle));
  return folder + "/record_" + digits + ".hdf";
}

std::string series_path(const std::string& path) {
  const std::filesystem::path whole(path);
  std::string stem = whole.stem().string();
  const std::size_t length = stem.size();
  while (!stem.empty() && std::isdigit(static_cast<unsigned char>(stem.back())))
    stem.pop_back();
  if (stem.size() == length)
    return {};
  while (!stem.empty() && (stem.back() == '_' || stem.back() == '-' || stem.back() == '.'))
    stem.pop_back();
  return stem.empty()
             ? std::string()
             : (whole.parent_path() / (stem + whole.extension().string() + ".series")).string();
}

} // namespace insitu::scene
