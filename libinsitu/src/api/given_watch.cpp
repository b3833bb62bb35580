#include "api/given_watch.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sys/mman.h>
#include <unistd.h>

#include "core/status.h"

namespace insitu::api {

namespace {

/// Whether a process may read all of the range; the system walks its maps, not the memory.
bool is_mapped(const mesh::ExternalArray::Range& range) {
  const auto page = std::uintptr_t(sysconf(_SC_PAGESIZE));
  const std::uintptr_t begin = range.begin / page * page;
  return range.begin >= range.end ||
         msync(reinterpret_cast<void*>(begin), range.end - begin, MS_ASYNC) == 0 || errno != ENOMEM;
}

/// Of the bits of some items: the first ones, where freed memory changes first, and others evenly
/// spread.
std::uint64_t sample_of(const mesh::ExternalArray& a) {
  constexpr std::int64_t first = 4, others = 60;
  const auto size = std::size_t(mesh::size_of(a.type));
  const std::int64_t n = a.layout.count;
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&](std::int64_t item) {
    for (int c = 0; c < a.components; ++c) {
      std::uint64_t value = 0;
      std::memcpy(&value, a.at(item, c), size);
      hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 29;
    }
  };
  for (std::int64_t i = 0; i < std::min(n, first); ++i)
    add(i);
  for (std::int64_t k = 0; k < others && n > first; ++k)
    add(first + (n - first - 1) * k / (others - 1));
  return hash;
}

bool can_sample(const mesh::ExternalArray& a) {
  return a.memory == INSITU_HOST && !a.indirect && a.components <= 16 && is_mapped(a.range());
}

} // namespace

void GivenWatch::note_field(const mesh::Mesh& mesh, std::int32_t piece, const std::string& field) {
  const std::string of = "field '" + field + "'";
  mesh.visit_piece_fields(
      piece, [&](const mesh::ExternalArray& array, const std::string& name, mesh::Mesh::ArrayKind) {
        if (name.find(of) == std::string::npos)
          return;
        fields_.erase(name);
        if (can_sample(array))
          fields_.insert({name, {array, sample_of(array)}});
      });
}

void GivenWatch::told(std::uint32_t what) {
  if (what & INSITU_CHANGED_FIELDS)
    fields_.clear();
}

void GivenWatch::check(const mesh::Mesh& mesh, const core::Log& log) {
  const auto text = [&](const std::string& array) {
    return "mesh '" + mesh.name() + "', " + array + ": ";
  };
  constexpr const char* temporary =
      "a temporary? Fortran hands a copy of a section to an explicit-shape dummy, and frees it "
      "when the procedure ends; give the array itself, or an assumed-shape or pointer dummy";
  mesh.visit_arrays([&](const mesh::ExternalArray& array, const std::string& name,
                        mesh::Mesh::ArrayKind) {
    if (array.memory == INSITU_HOST && !is_mapped(array.range()))
      throw core::Error(INSITU_ERROR_ARGUMENT,
                        text(name) + "the memory that was given is there no more; " + temporary);
  });
  for (const auto& [name, given] : fields_)
    if (can_sample(given.array) && sample_of(given.array) != given.sample)
      log.warning(text(name) +
                  "the values are not those that were given, and insitu_mesh_changed has not been "
                  "called since. If the solver did not compute them in between, this is " +
                  temporary);
  fields_.clear();
}

} // namespace insitu::api
