// What the targets that register meshes share: bytes that choose, promises of the library,
// questions after a commit.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <vector>

#include "insitu/insitu.h"

namespace fuzz {

inline void require(bool holds, const char* what) {
  if (!holds) {
    std::fprintf(stderr, "broken promise: %s; last message: %s\n", what, insitu_last_message());
    std::abort();
  }
}

/// A known status; and a message if it is a failure. True if it is none.
inline bool check(insitu_status status) {
  require(status >= INSITU_OK && status <= INSITU_ERROR_ACTION, "a status that says why");
  require(status == INSITU_OK || insitu_last_message()[0] != '\0', "a message");
  return status == INSITU_OK;
}

/// A session of one thread whose log is silent, with one mesh.
struct Session {
  insitu_session handle = nullptr;
  insitu_mesh mesh = nullptr;

  explicit Session(bool strict = false) {
    insitu_session_options options = insitu_session_options_default();
    options.threads = 1;
    options.strict = strict;
    options.log = [](insitu_log_level, const char*, void*) {};
    require(insitu_session_open(&options, &handle) == INSITU_OK, "a session");
    require(insitu_session_mesh(handle, "mesh", &mesh) == INSITU_OK, "a mesh");
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session() { require(insitu_session_close(&handle) == INSITU_OK, "the session closes"); }
};

class Bytes {
public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  bool empty() const { return at_ >= size_; }
  unsigned byte() { return empty() ? 0 : data_[at_++]; }
  unsigned below(unsigned n) { return byte() % n; }
  bool one_in(unsigned n) { return below(n) == 1; }
  /// Of items.
  std::int64_t count() { return one_in(16) ? 0 : 1 + below(32); }
  double real() {
    constexpr double special[] = {0.0,   -0.0,  NAN,    HUGE_VAL, -HUGE_VAL, 1e300,
                                  -1e37, 1e-40, 5e-324, 1e38,     1e37,      -1e-300};
    return one_in(6) ? special[below(12)] : (double(byte()) - 64.0) / 32.0;
  }
  /// Of a field.
  const char* name() {
    constexpr const char* names[] = {"f", "velocity", "", "f\n"};
    return names[below(4)];
  }

private:
  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};

/// Makes an array claim what has to be refused.
inline void make_impossible(Bytes& in, insitu_array& a) {
  static const double zero = 0.0;
  constexpr std::int64_t wild[] = {std::numeric_limits<std::int64_t>::min(),
                                   std::numeric_limits<std::int64_t>::max(),
                                   -(std::int64_t(1) << 62)};
  switch (in.below(8)) {
  case 0:
    a.size = in.byte();
    break;
  case 1:
    a.type = insitu_type(in.byte() % 2 ? 0 : 6 + in.byte());
    break;
  case 2:
    a.count = -1 - std::int64_t(in.byte());
    break;
  case 3:
    a.count = wild[in.below(2)];
    break;
  case 4:
    a.components = in.one_in(2) ? -std::int32_t(in.byte()) : INT32_MAX;
    break;
  case 5:
    a.count = 7;
    a.data = &zero;
    a.stride[0] = wild[in.below(3)];
    break;
  case 6:
    a.extent[in.below(3)] = wild[in.below(3)];
    break;
  default: // null, though it has items
    a.count = 1 + in.byte();
  }
}

/// Whether a mesh could be committed; its report holds numbers that can be.
inline bool commit(insitu_mesh mesh, insitu_commit_report& report) {
  report = insitu_commit_report_default();
  if (!check(insitu_mesh_commit(mesh, &report)))
    return false;
  require(report.cells >= 0 && report.vertices >= 0 && report.bytes >= 0 && report.cost_ratio >= 0,
          "a report");
  return true;
}

/// Asks a committed mesh of so many cells at vertices, between them and elsewhere. Polyhedra have
/// no parametric coordinates.
inline void ask(Bytes& in, insitu_mesh mesh, std::int64_t cells, bool has_polyhedra = false) {
  std::vector<double> x;
  for (unsigned i = 0; i < 12; ++i)
    x.push_back(i % 3 == 0 ? in.real() : double(in.below(9)) / 4);
  std::int64_t owner[4];
  std::uint8_t found[4];
  double parametric[12], value[16];
  double* values[1] = {value};
  const insitu_array points = insitu_array_of(x.data(), INSITU_FLOAT64, 4, 3);
  insitu_sample_args args = insitu_sample_args_default();
  args.locate.points = &points;
  args.locate.accuracy = insitu_accuracy(in.below(3));
  args.locate.cells = owner;
  args.locate.found = found;
  args.locate.parametric = parametric;
  require(insitu_mesh_locate(mesh, &args.locate) == INSITU_OK, "locate after commit");
  for (int i = 0; i < 4; ++i) {
    require(owner[i] >= -1 && owner[i] < cells, "an owner among the cells");
    require((owner[i] >= 0) == (found[i] == 1), "found is that there is an owner");
    require(std::isnan(parametric[3 * i]) == (owner[i] < 0) || has_polyhedra,
            "parametric coordinates inside");
    require(std::isnan(parametric[3 * i]) || owner[i] >= 0, "no parametric coordinates outside");
  }
  const char* field = in.name();
  args.fields = &field;
  args.field_count = 1;
  args.values = values;
  int32_t components = 0;
  if (check(insitu_mesh_field_info(mesh, field, &components, nullptr)) && components <= 4)
    require(insitu_mesh_sample(mesh, &args) == INSITU_OK, "sample after commit");
}

} // namespace fuzz
