// A solver on an adaptive mesh that registers anything: whatever its bytes say, every call ends in
// a status with a message, never in a crash, and nothing is read outside the arrays. Input is a
// list of calls, one byte each, followed by the bytes that choose their arguments.
//
// Patches are small, or so large that they have to be refused; arrays are as large as the patch or
// the leaves that they are for, ghosts included, or claim what has to be refused.
#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <vector>

#include "promises.h"

namespace {

using fuzz::Bytes;
using fuzz::check;
using fuzz::require;

constexpr std::int64_t wild[] = {std::numeric_limits<std::int64_t>::min(),
                                 std::numeric_limits<std::int64_t>::max(),
                                 -(std::int64_t(1) << 30) - 1,
                                 std::int64_t(1) << 30,
                                 INT32_MIN,
                                 INT32_MAX};
/// Where patches and leaves of good luck lie: at either end of what indices there are, too.
constexpr std::int64_t places[] = {0, 0, 0, -4, (1 << 30) - 8, -(1 << 30)};

class Solver {
public:
  explicit Solver(Bytes input) : in_(input) { place_ = places[in_.below(6)]; }

  void run() {
    for (int calls = 0; calls < 40 && !in_.empty(); ++calls)
      call();
  }

private:
  /// What a piece is as far as its fields go.
  struct Piece {
    std::array<std::int64_t, 3> cells{0, 1, 1};
    std::array<std::int64_t, 3> before{}, after{};
    std::int64_t count() const { return cells[0] * cells[1] * cells[2]; }
  };

  void call() {
    const unsigned piece = in_.one_in(3) ? in_.below(4) : 0;
    switch (in_.below(13)) {
    case 0:
    case 1:
      good_mesh();
      break;
    case 2:
      levels();
      break;
    case 3:
    case 4:
      patch(piece);
      break;
    case 5:
    case 6:
      leaves(piece);
      break;
    case 7:
      field(piece);
      break;
    case 8:
      check(insitu_mesh_drop_pieces(mesh_, std::int32_t(in_.below(6)) - 1));
      break;
    case 9: // leaves change, and the solver says so
      if (last_ != nullptr)
        write(*last_, last_type_, last_is_level_);
      check(insitu_mesh_changed(mesh_, in_.below(16)));
      break;
    case 10: {
      insitu_validation v = insitu_validation_default();
      check(insitu_mesh_validate(mesh_, &v));
      check(insitu_mesh_remove_field(mesh_, in_.name()));
      const insitu_array a = insitu_array_of(&zero_, INSITU_FLOAT64, 1, 1);
      require(!check(insitu_mesh_points(mesh_, 0, &a, 1)) || !adaptive_, "no points");
      break;
    }
    default:
      commit();
    }
  }

  void commit() {
    insitu_commit_report report;
    if (!fuzz::commit(mesh_, report))
      return;
    insitu_amr_info info = insitu_amr_info_default();
    std::int64_t cells = report.cells;
    if (adaptive_) {
      require(insitu_mesh_amr_info(mesh_, &info) == INSITU_OK, "what was made");
      require(info.leaves >= 0 && info.masked >= 0 && info.bytes >= 0, "counts");
      cells = info.leaves + info.masked;
    }
    fuzz::ask(in_, mesh_, cells);
  }

  /// A patch of 4^3 cells with ghosts, and a finer one over its middle.
  void good_mesh() {
    insitu_amr amr = insitu_amr_default();
    amr.level_count = 3;
    const std::int32_t ratios[] = {in_.one_in(2) ? 4 : 2, 2};
    amr.ratios = ratios;
    amr.spacing[0] = 0.5;
    amr.reconstruction = insitu_reconstruction(in_.one_in(4));
    if (!check(insitu_mesh_amr(mesh_, &amr)))
      return;
    adaptive_ = true;
    const auto give = [&](unsigned p, std::int32_t level, std::int64_t lower, std::int64_t cells,
                          std::int64_t ghosts) {
      insitu_patch patch = insitu_patch_default();
      patch.level = level;
      for (int a = 0; a < 3; ++a) {
        patch.lower[a] = lower;
        patch.cells[a] = cells;
        patch.ghosts_before[a] = patch.ghosts_after[a] = std::int32_t(ghosts);
      }
      give_patch(p, patch);
      give_field(p, "f", INSITU_FLOAT64, false);
    };
    give(0, 0, 0, 4, in_.below(3));
    give(1, 1, 2 * ratios[0], 2 * ratios[0], in_.below(2));
    check(insitu_mesh_drop_pieces(mesh_, 2));
  }

  void levels() {
    insitu_amr amr = insitu_amr_default();
    for (int a = 0; a < 3; ++a) {
      amr.origin[a] = in_.one_in(4) ? in_.real() : 0.0;
      amr.spacing[a] = in_.one_in(4) ? in_.real() : 1.0;
    }
    amr.level_count =
        in_.one_in(8) ? std::int32_t(in_.byte()) - 2 : 1 + std::int32_t(in_.below(31));
    std::vector<std::int32_t> ratios(256);
    for (std::int32_t& r : ratios)
      r = in_.one_in(6) ? 4 : 2;
    if (in_.one_in(8))
      ratios[in_.below(8)] = std::int32_t(in_.byte()) - 4;
    amr.ratios = in_.one_in(2) ? ratios.data() : nullptr;
    amr.finest_first = std::int32_t(in_.one_in(16) ? in_.byte() : in_.below(2));
    amr.reconstruction = insitu_reconstruction(in_.one_in(16) ? in_.byte() : in_.below(2));
    if (in_.one_in(32))
      amr.size = in_.byte();
    if (in_.one_in(4))
      amr.dimensions = in_.one_in(16) ? std::int32_t(in_.byte()) : 2;
    adaptive_ |= check(insitu_mesh_amr(mesh_, &amr));
  }

  std::int64_t place() {
    return in_.one_in(32) ? wild[in_.below(6)] : place_ + std::int64_t(in_.below(16)) - 4;
  }

  void patch(unsigned piece) {
    insitu_patch p = insitu_patch_default();
    p.level = std::int32_t(in_.one_in(16) ? in_.byte() : in_.below(4));
    for (int a = 0; a < 3; ++a) {
      p.lower[a] = place();
      p.cells[a] = 1 + in_.below(6);
      p.ghosts_before[a] = std::int32_t(in_.one_in(4) ? 1 + in_.below(2) : 0);
      p.ghosts_after[a] = std::int32_t(in_.one_in(4) ? 1 + in_.below(2) : 0);
    }
    if (in_.one_in(24)) // more cells than can be told apart, or none
      for (int a = 0; a < 3; ++a)
        p.cells[a] =
            in_.one_in(8) ? -std::int64_t(in_.byte()) : std::int64_t(1) << (11 + in_.below(20));
    if (in_.one_in(24)) {
      std::int32_t* const layers = in_.one_in(2) ? p.ghosts_before : p.ghosts_after;
      const unsigned axis = in_.below(3);
      layers[axis] = in_.one_in(2) ? -std::int32_t(in_.byte()) : INT32_MAX;
    }
    if (in_.one_in(32))
      p.size = in_.byte();
    give_patch(piece, p);
    if (in_.one_in(2))
      give_field(piece, "f", INSITU_FLOAT64, false);
  }

  void give_patch(unsigned piece, const insitu_patch& p) {
    if (!check(insitu_mesh_patch(mesh_, std::int32_t(piece), &p)))
      return;
    Piece& to = pieces_[piece];
    for (std::size_t a = 0; a < 3; ++a) {
      to.cells[a] = p.cells[a];
      to.before[a] = p.ghosts_before[a];
      to.after[a] = p.ghosts_after[a];
    }
  }

  template <class T>
  static void put(std::uint8_t* to, T value) {
    std::memcpy(to, &value, sizeof value);
  }
  /// A level, or an index along some axis.
  void write(std::uint8_t& to, insitu_type type, bool is_level) {
    const std::int64_t value = !is_level        ? place()
                               : in_.one_in(32) ? std::int64_t(in_.byte()) - 1
                                                : std::int64_t(in_.below(in_.one_in(6) ? 31 : 4));
    if (type == INSITU_UINT8)
      put(&to, std::uint8_t(value));
    else if (type == INSITU_INT32)
      put(&to, std::int32_t(std::uint64_t(value)));
    else
      put(&to, value);
  }

  /// Levels or corners, an item a leaf: packed, in records, or behind pointers of which one may be
  /// null.
  insitu_array numbers(insitu_type type, std::int32_t components, std::int64_t n, bool is_level) {
    insitu_array a = insitu_array_of(nullptr, type, n, components);
    if (in_.one_in(32)) {
      fuzz::make_impossible(in_, a);
      return a;
    }
    const std::int64_t item = type == INSITU_UINT8 ? 1 : type == INSITU_INT32 ? 4 : 8;
    const bool records = in_.one_in(3), backwards = in_.one_in(6), indirect = in_.one_in(4);
    const std::int64_t step = item * components + (records ? 1 + in_.below(9) : 0);
    std::vector<std::uint8_t>& memory = memory_.emplace_back(std::size_t(step * n));
    for (std::int64_t i = 0; i < n; ++i)
      for (std::int32_t c = 0; c < components; ++c)
        write(memory[std::size_t(i * step + c * item)], type, is_level);
    if (n > 0) {
      last_ = &memory[std::size_t(step) * in_.below(unsigned(n))];
      last_type_ = type;
      last_is_level_ = is_level;
    }
    if (!indirect) {
      a.data = memory.data() + (backwards && n > 0 ? step * (n - 1) : 0);
      a.stride[0] = backwards ? -step : step;
    } else {
      a = behind_pointers(a, memory, step);
    }
    if (n == 0 && in_.one_in(2))
      a.data = nullptr;
    return a;
  }

  /// The array, reached through pointers to before its items.
  insitu_array behind_pointers(insitu_array a, std::vector<std::uint8_t>& memory,
                               std::int64_t step) {
    const std::int64_t offset = std::int64_t(in_.below(3)) * 8 - 8;
    std::vector<std::uint8_t>& pointers = memory_.emplace_back(std::size_t(8 * a.count));
    for (std::int64_t i = 0; i < a.count; ++i)
      put(pointers.data() + 8 * i,
          reinterpret_cast<std::uintptr_t>(memory.data()) + std::uintptr_t(i * step - offset));
    if (a.count > 0 && in_.one_in(12))
      put(pointers.data() + 8 * in_.below(unsigned(a.count)), std::uintptr_t(0));
    a.data = pointers.data();
    a.indirect = in_.one_in(16) ? 2 : 1;
    a.offset = offset;
    a.stride[0] = 0;
    return a;
  }

  void leaves(unsigned piece) {
    insitu_leaves l = insitu_leaves_default();
    const std::int64_t n = in_.one_in(3) ? 0 : in_.count(), other = in_.one_in(24) ? n + 1 : n;
    constexpr insitu_type types[] = {INSITU_UINT8, INSITU_INT32, INSITU_INT64, INSITU_FLOAT32};
    l.levels = numbers(types[in_.below(in_.one_in(16) ? 4 : 3)], 1, n, true);
    l.corners =
        numbers(types[1 + in_.below(in_.one_in(16) ? 3 : 2)], in_.one_in(32) ? 2 : 3, other, false);
    l.corner_bits = std::int32_t(in_.one_in(3) ? in_.below(34) : 0) - 1;
    for (int a = 0; a < 3; ++a)
      l.offset[a] = in_.one_in(24)  ? wild[in_.below(6)]
                    : in_.one_in(8) ? std::int64_t(in_.byte()) - 99
                                    : 0;
    if (n == 8 && in_.one_in(2)) // eight that fill a cell
      return octant(piece);
    if (check(insitu_mesh_leaves(mesh_, std::int32_t(piece), &l)))
      pieces_[piece] = {{n, 1, 1}, {}, {}};
    if (in_.one_in(2))
      give_field(piece, "f", INSITU_FLOAT64, false);
  }

  void octant(unsigned piece) {
    std::vector<std::uint8_t>& memory = memory_.emplace_back(8 * 4 * 4);
    const std::int64_t at = std::clamp<std::int64_t>(place(), -1000, 1000);
    for (std::int32_t o = 0; o < 8; ++o) {
      const std::int32_t leaf[4] = {1, std::int32_t(2 * at) + (o & 1), (o >> 1 & 1), o >> 2};
      std::memcpy(memory.data() + 16 * o, leaf, sizeof leaf);
    }
    insitu_leaves l = insitu_leaves_default();
    l.levels = insitu_array_of(memory.data(), INSITU_INT32, 8, 1);
    l.corners = insitu_array_of(memory.data() + 4, INSITU_INT32, 8, 3);
    l.levels.stride[0] = l.corners.stride[0] = 16;
    if (check(insitu_mesh_leaves(mesh_, std::int32_t(piece), &l)))
      pieces_[piece] = {{8, 1, 1}, {}, {}};
    give_field(piece, "f", INSITU_FLOAT64, false);
  }

  void field(unsigned piece) {
    constexpr insitu_type types[] = {INSITU_FLOAT32, INSITU_FLOAT64, INSITU_INT32};
    give_field(piece, in_.name(), types[in_.below(in_.one_in(16) ? 3 : 2)], true);
  }

  /// A field of as many values as the piece has cells and ghosts, in either order; `wrongly`:
  /// sometimes of other numbers, packed though it has ghosts, on vertices, or behind pointers.
  void give_field(unsigned piece, const char* name, insitu_type type, bool wrongly) {
    const Piece& p = pieces_[piece];
    constexpr std::int64_t most = 64; // a larger patch has to be refused before its field is read
    const bool large = p.cells[0] > most || p.cells[1] > most || p.cells[2] > most;
    const std::int32_t components = wrongly ? 1 + std::int32_t(in_.below(4)) : 1;
    const std::int64_t item = type == INSITU_FLOAT64 ? 8 : 4, size = item * components;
    insitu_array a = insitu_array_of(&zero_, type, large ? 1 : p.count(), components);
    if (wrongly && in_.one_in(12)) {
      fuzz::make_impossible(in_, a);
    } else if (!large) {
      std::int64_t next = size, first = 0, stride[3];
      const bool c_order = in_.one_in(2);
      for (int i = 0; i < 3; ++i) {
        const std::size_t axis = std::size_t(c_order ? 2 - i : i);
        stride[axis] = next;
        first += p.before[axis] * next;
        next *= p.before[axis] + p.cells[axis] + p.after[axis];
      }
      // With as much around it: the patch may later be given again, with other ghosts.
      first += next;
      std::vector<std::uint8_t>& memory = memory_.emplace_back(std::size_t(3 * next));
      for (std::int64_t at = 0; at < 3 * next; at += item)
        type == INSITU_FLOAT64 ? put(memory.data() + at, in_.real())
                               : put(memory.data() + at, float(in_.real()));
      a.data = memory.data() + first;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        a.extent[axis] = p.cells[axis];
        a.stride[axis] = stride[axis];
      }
      if (p.count() == 0) // leaves may be none
        std::fill_n(a.extent, 3, 0);
      spoil(a, memory, wrongly, size);
    }
    check(insitu_mesh_field(mesh_, std::int32_t(piece), name,
                            wrongly && in_.one_in(16) ? INSITU_VERTEX : INSITU_CELL, &a, 1));
  }

  void spoil(insitu_array& a, std::vector<std::uint8_t>& memory, bool wrongly, std::int64_t size) {
    if (!wrongly)
      return;
    const unsigned how = in_.below(16);
    if (how == 1 && a.count > 0) { // packed, without room for ghosts
      a.data = memory.data() + memory.size() / 3;
      std::fill_n(a.stride, 3, 0);
    } else if (how == 2 && a.count > 1) { // too few
      std::fill_n(a.extent, 3, 0);
      std::fill_n(a.stride, 3, 0);
      a.data = memory.data() + memory.size() / 3;
      --a.count;
    } else if (how == 3) {
      std::fill_n(a.extent, 3, 0);
      std::fill_n(a.stride, 3, 0);
      a = behind_pointers(a, memory, size);
    }
  }

  Bytes in_;
  std::deque<std::vector<std::uint8_t>> memory_;
  std::array<Piece, 4> pieces_;
  std::int64_t place_ = 0;
  bool adaptive_ = false;
  std::uint8_t* last_ = nullptr; ///< a number of leaves
  insitu_type last_type_ = INSITU_UINT8;
  bool last_is_level_ = false;
  double zero_ = 0.0;
  const fuzz::Session session_{in_.one_in(8)}; ///< closed before the arrays go
  const insitu_mesh mesh_ = session_.mesh;
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Solver(Bytes(data, size)).run();
  return 0;
}
