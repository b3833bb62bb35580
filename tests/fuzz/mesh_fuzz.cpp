// A solver that registers anything: whatever its bytes say, every call ends in a status with a
// message, never in a crash, and nothing is read outside the arrays. Input is a list of calls, one
// byte each, followed by the bytes that choose their arguments.
//
// The arrays are as large as they claim to be, or claim what has to be refused: a claim of memory
// that is not there cannot be told from the truth.
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <initializer_list>
#include <limits>
#include <vector>

#include "promises.h"

namespace {

using fuzz::Bytes;
using fuzz::check;
using fuzz::require;

class Solver {
public:
  explicit Solver(Bytes input) : in_(input) {}

  void run() {
    for (int calls = 0; calls < 40 && !in_.empty(); ++calls)
      call();
  }

private:
  void call() {
    const auto piece = std::int32_t(in_.one_in(8) ? in_.below(4) - 1 : 0);
    switch (in_.below(13)) {
    case 0:
      good_mesh();
      break;
    case 1: {
      const insitu_array a = reals(in_.one_in(8) ? 2 : 3, in_.count());
      check(insitu_mesh_points(mesh_, piece, &a, 1));
      break;
    }
    case 2: {
      const std::int64_t n = in_.count();
      const insitu_array a[3] = {reals(1, n), reals(1, n), reals(1, in_.one_in(8) ? n + 1 : n)};
      check(insitu_mesh_points(mesh_, piece, a, in_.one_in(8) ? 2 : 3));
      break;
    }
    case 3:
      cells(piece);
      break;
    case 4:
      block(piece);
      break;
    case 5: {
      const insitu_array a = reals(1 + std::int32_t(in_.below(4)), in_.count());
      check(insitu_mesh_field(mesh_, piece, in_.name(), insitu_association(in_.below(3)), &a, 1));
      break;
    }
    case 6: {
      const insitu_array a = array(INSITU_UINT8, 1, in_.count());
      check(insitu_mesh_ghosts(mesh_, piece, in_.one_in(4) ? nullptr : &a,
                               insitu_ghost_convention(in_.below(3))));
      break;
    }
    case 7:
      check(insitu_mesh_remove_field(mesh_, in_.name()));
      break;
    case 8: // the arrays change, and the solver says so
      spoil();
      check(insitu_mesh_changed(mesh_, INSITU_CHANGED_ALL));
      break;
    case 9: // the vertices move
      move();
      check(insitu_mesh_changed(mesh_, INSITU_CHANGED_GEOMETRY));
      break;
    case 10: {
      insitu_validation v = insitu_validation_default();
      check(insitu_mesh_validate(mesh_, &v));
      require(v.index_errors + v.shape_errors + v.coordinate_errors <= v.cells, "counts of cells");
      int32_t entries = 0;
      check(insitu_mesh_audit(mesh_, nullptr, &entries));
      require(entries >= 0, "a count of arrays");
      break;
    }
    default:
      commit();
    }
  }

  void commit() {
    insitu_commit_report report;
    if (fuzz::commit(mesh_, report))
      fuzz::ask(in_, mesh_, report.cells);
  }

  // Arguments.

  std::int64_t index() {
    constexpr std::int64_t special[] = {-1,        std::numeric_limits<std::int64_t>::min(),
                                        INT32_MAX, std::numeric_limits<std::int64_t>::max(),
                                        INT32_MIN, 27};
    return in_.one_in(24) ? special[in_.below(6)] : std::int64_t(in_.below(28));
  }
  insitu_array reals(std::int32_t components, std::int64_t n) {
    return array(in_.one_in(2) ? INSITU_FLOAT32 : INSITU_FLOAT64, components, n);
  }

  /// An array of its own memory: packed, planar, padded, backwards, unaligned; or an impossible
  /// one.
  insitu_array array(insitu_type type, std::int32_t components, std::int64_t n) {
    insitu_array a = insitu_array_of(nullptr, type, n, components);
    if (in_.one_in(24)) {
      fuzz::make_impossible(in_, a);
      return a;
    }
    const std::int64_t item = type == INSITU_UINT8                             ? 1
                              : type == INSITU_FLOAT32 || type == INSITU_INT32 ? 4
                                                                               : 8;
    std::int64_t stride = item * components, component = item, extents[3] = {n, 1, 1};
    const unsigned arrangement = in_.below(5);
    if (arrangement == 1) { // planar
      component = item * n;
      stride = item;
    } else if (arrangement == 2) { // records
      stride += in_.below(7);
    } else if (arrangement == 3) {
      stride = -stride;
    } else if (arrangement == 4 && n % 2 == 0) { // rows of a larger array
      extents[0] = n / 2;
      extents[1] = 2;
    }
    const std::int64_t row = stride * extents[0] + (extents[1] > 1 ? 8 : 0);
    const std::int64_t reach = (stride < 0 ? -stride : stride) * n + component * components + 64;
    std::vector<std::uint8_t>& memory = memory_.emplace_back(std::size_t(reach));
    // Numbers of the array's type over all of it, packed; other strides read parts of them.
    for (std::int64_t o = 0; o + item <= reach; o += item)
      write(type, memory.data() + o);
    a.data = memory.data() + (stride < 0 ? -stride * (n - 1 > 0 ? n - 1 : 0) : 0);
    a.stride[0] = arrangement == 0 ? 0 : stride;
    a.component_stride = arrangement == 0 ? 0 : component;
    if (extents[1] > 1) {
      std::memcpy(a.extent, extents, sizeof extents);
      a.stride[1] = row;
    }
    if (n == 0 && in_.one_in(2))
      a.data = nullptr;
    if (in_.one_in(32))
      a.converted = "fuzzed";
    last_ = {type, memory.data(), reach / item};
    return a;
  }

  void write(insitu_type type, std::uint8_t* to) {
    const auto put = [&](auto value) { std::memcpy(to, &value, sizeof value); };
    switch (type) {
    case INSITU_FLOAT32:
      return put(float(in_.real()));
    case INSITU_FLOAT64:
      return put(in_.real());
    case INSITU_INT32:
      return put(std::int32_t(std::uint64_t(index())));
    case INSITU_INT64:
      return put(index());
    case INSITU_UINT8:
      return put(std::uint8_t(types_ ? first_type_ + in_.below(7) : in_.byte()));
    }
  }

  void cells(std::int32_t piece) {
    insitu_cells c = insitu_cells_default();
    c.count = in_.one_in(24) ? -1 - std::int64_t(in_.byte()) : in_.count();
    c.layout = insitu_layout(in_.below(in_.one_in(8) ? 5 : 3));
    constexpr std::int32_t shapes[] = {10, 11, 12, 13, 14, 5, 8, 9};
    c.shape = insitu_shape(in_.one_in(8) ? in_.byte() : shapes[in_.below(8)]);
    c.index_base = std::int32_t(in_.below(in_.one_in(8) ? 3 : 2));
    constexpr std::int32_t vertices[] = {3, 0, 0, 4, 4, 4, 8, 8, 6, 5}; // from 5 on
    const std::int64_t held = in_.one_in(8) ? in_.count() : (c.count > 0 ? c.count : 1);
    const insitu_type integer = in_.one_in(2) ? INSITU_INT32 : INSITU_INT64;
    const bool is_flat = c.shape == 5 || c.shape == 8 || c.shape == 9;
    const bool known = is_flat || (c.shape >= 10 && c.shape <= 14);
    const std::int32_t ids = c.layout == INSITU_LAYOUT_PADDED ? (is_flat ? 4 : 8)
                             : known && !in_.one_in(16)       ? vertices[c.shape - 5]
                                                              : 1 + std::int32_t(in_.below(9));
    c.connectivity =
        c.layout == INSITU_LAYOUT_MIXED ? array(integer, 1, 8 * held) : array(integer, ids, held);
    types_ = true;
    first_type_ = in_.one_in(2) ? 9 : 3;
    c.types = array(INSITU_UINT8, 1, held);
    types_ = false;
    c.offsets = array(in_.one_in(2) ? INSITU_INT64 : INSITU_INT32, 1, held + in_.below(2));
    check(insitu_mesh_cells(mesh_, piece, &c));
  }

  void block(std::int32_t piece) {
    insitu_block b = insitu_block_default();
    b.kind = insitu_block_kind(in_.below(in_.one_in(8) ? 5 : 3));
    b.dimensions = in_.one_in(4) ? 2 : 3;
    for (int a = 0; a < 3; ++a) {
      b.vertices[a] = in_.one_in(16) ? std::int64_t(in_.byte()) - 250 : 1 + in_.below(4);
      b.origin[a] = in_.real();
      b.spacing[a] = in_.one_in(4) ? in_.real() : 0.5;
      b.coordinates[a] = reals(1, in_.one_in(8) ? in_.count() : 4);
    }
    if (b.dimensions == 2 && !in_.one_in(8))
      b.vertices[2] = 1;
    check(insitu_mesh_block(mesh_, piece, &b));
  }

  /// A box of 2 x 2 x 2 hexahedra, so that the calls that follow get further.
  void good_mesh() {
    std::vector<std::uint8_t>& points = memory_.emplace_back(27 * 24);
    std::vector<std::uint8_t>& ids = memory_.emplace_back(64 * 4);
    std::vector<std::uint8_t>& values = memory_.emplace_back(27 * 8);
    for (int v = 0; v < 27; ++v) {
      const double x[3] = {double(v % 3), double(v / 3 % 3), double(v / 9)};
      std::memcpy(points.data() + 24 * v, x, sizeof x);
      std::memcpy(values.data() + 8 * v, x, 8);
    }
    constexpr std::int32_t corner[8] = {0, 1, 4, 3, 9, 10, 13, 12};
    for (int c = 0; c < 8; ++c)
      for (int v = 0; v < 8; ++v) {
        const std::int32_t id = corner[v] + c % 2 + 3 * (c / 2 % 2) + 9 * (c / 4);
        std::memcpy(ids.data() + 4 * (8 * c + v), &id, 4);
      }
    insitu_array a = insitu_array_of(points.data(), INSITU_FLOAT64, 27, 3);
    insitu_cells c = insitu_cells_default();
    c.count = 8;
    c.connectivity = insitu_array_of(ids.data(), INSITU_INT32, 8, 8);
    check(insitu_mesh_points(mesh_, 0, &a, 1));
    check(insitu_mesh_cells(mesh_, 0, &c));
    a = insitu_array_of(values.data(), INSITU_FLOAT64, 27, 1);
    check(insitu_mesh_field(mesh_, 0, "f", INSITU_VERTEX, &a, 1));
    good_points_ = points.data();
    last_ = {INSITU_INT32, ids.data(), 64};
  }

  void spoil() {
    for (unsigned n = in_.below(4); n > 0 && last_.items > 0; --n) {
      const std::int64_t item = last_.type == INSITU_UINT8                                   ? 1
                                : last_.type == INSITU_FLOAT32 || last_.type == INSITU_INT32 ? 4
                                                                                             : 8;
      write(last_.type, last_.data + item * (in_.byte() % last_.items));
    }
  }

  void move() {
    for (unsigned n = in_.below(4); n > 0 && good_points_; --n) {
      const double x = in_.real();
      std::memcpy(good_points_ + 8 * (in_.byte() % 81), &x, 8);
    }
  }

  struct Last {
    insitu_type type = INSITU_UINT8;
    std::uint8_t* data = nullptr;
    std::int64_t items = 0;
  };

  Bytes in_;
  std::deque<std::vector<std::uint8_t>> memory_;
  std::uint8_t* good_points_ = nullptr;
  Last last_;
  bool types_ = false;
  int first_type_ = 9;
  const fuzz::Session session_{in_.one_in(8)}; ///< closed before the arrays go
  const insitu_mesh mesh_ = session_.mesh;
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Solver(Bytes(data, size)).run();
  return 0;
}
