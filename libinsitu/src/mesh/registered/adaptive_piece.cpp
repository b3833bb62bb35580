#include "mesh/registered/adaptive_piece.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "core/caller_struct.h"

namespace insitu::mesh {

using core::Error;

namespace {

static_assert(AmrView::most_levels == INSITU_AMR_MOST_LEVELS);

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
  throw Error(INSITU_ERROR_ARGUMENT, name + ": " + what);
}

std::string text(std::int64_t number) {
  return std::to_string(number);
}

std::string real_text(double number) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.17g", number);
  return buffer;
}

std::string text(const std::int64_t (&index)[3]) {
  return "(" + text(index[0]) + ", " + text(index[1]) + ", " + text(index[2]) + ")";
}

/// Origin and spacing of one axis; half the finest cell must still move a coordinate.
void check_axis(const insitu_amr& amr, int axis, int finest, const std::string& name) {
  const double origin = amr.origin[axis], h = amr.spacing[axis];
  const std::string along = " along axis " + text(axis) + " is ";
  if (!std::isfinite(origin))
    refuse(name, "origin" + along + real_text(origin));
  constexpr double most = 1e290; // far from overflow at any index, from underflow at any depth
  if (!(h >= 1 / most && h <= most))
    refuse(name, "spacing" + along + real_text(h) + ", a positive length expected");
  const double half = h * Lattice::power(finest + 1);
  if (origin + half == origin || origin - half == origin)
    refuse(name, "origin" + along + real_text(origin) + ", too large for cells of " +
                     real_text(2 * half));
}

} // namespace

math::Vec3d AmrLevels::given_origin() const {
  return {lattice.origin[0], lattice.origin[1],
          lattice.is_flat != 0 ? lattice.plane : lattice.origin[2]};
}

math::Vec3d AmrLevels::given_spacing() const {
  return {lattice.spacing[0], lattice.spacing[1], lattice.is_flat != 0 ? 1.0 : lattice.spacing[2]};
}

FlatFacts AmrLevels::flat_facts() const {
  FlatFacts facts;
  if (lattice.is_flat == 0)
    return facts;
  facts.least = facts.greatest = lattice.plane;
  const int power = std::ilogb(std::min(lattice.spacing[0], lattice.spacing[1]));
  facts.lengths[std::size_t(std::clamp(FlatFacts::middle + power, 0, FlatFacts::powers - 1))] = 1;
  return facts;
}

bool AmrLevels::same_cells(const AmrLevels& other) const {
  return level_count == other.level_count && dimensions() == other.dimensions() &&
         lattice.plane == other.lattice.plane && finest_first == other.finest_first &&
         std::equal(lattice.origin, lattice.origin + 3, other.lattice.origin) &&
         std::equal(lattice.spacing, lattice.spacing + 3, other.lattice.spacing) &&
         std::equal(depth_of, depth_of + level_count, other.depth_of);
}

/// The cells that points are located in are as thick as other flat meshes' are: the dual's, which
/// reach from the lower faces of the leaves to their centres, or the leaves.
static void set_plane(double plane, const std::string& name, AmrLevels& levels) {
  if (!std::isfinite(plane))
    refuse(name, "origin along axis 2, the plane, is " + real_text(plane));
  levels.lattice.is_flat = 1;
  levels.lattice.plane = plane;
  const FlatSlab slab = FlatSlab::of(levels.flat_facts());
  levels.lattice.origin[2] = slab.low;
  levels.lattice.spacing[2] =
      (levels.reconstruction == INSITU_DUAL ? 2.0 : 1.0) * (slab.high - slab.low);
}

AmrLevels adopt_levels(const insitu_amr* given, const std::string& name) {
  const insitu_amr copy = core::from_caller(given, name), *const amr = &copy;
  if (amr->level_count < 1 || amr->level_count > INSITU_AMR_MOST_LEVELS)
    refuse(name,
           text(amr->level_count) + " levels, 1 to " + text(INSITU_AMR_MOST_LEVELS) + " expected");
  if (amr->finest_first != 0 && amr->finest_first != 1)
    refuse(name, "finest_first " + text(amr->finest_first) + ", 0 or 1 expected");
  if (amr->dimensions != 2 && amr->dimensions != 3)
    refuse(name, "dimensions " + text(amr->dimensions) + ", 2 or 3 expected");
  if (amr->reconstruction != INSITU_DUAL && amr->reconstruction != INSITU_NEAREST)
    refuse(name, "unknown reconstruction " + text(int(amr->reconstruction)));
  AmrLevels out;
  out.level_count = amr->level_count;
  out.finest_first = amr->finest_first != 0;
  out.reconstruction = amr->reconstruction;
  for (int l = 1; l < amr->level_count; ++l) {
    const int ratio = amr->ratios ? amr->ratios[l - 1] : 2;
    if (ratio != 2 && ratio != 4)
      refuse(name, "refinement ratio " + text(ratio) + " between levels " + text(l - 1) + " and " +
                       text(l) + " from the coarsest, 2 or 4 expected");
    const int depth = out.depth_of[l - 1] + (ratio == 2 ? 1 : 2);
    if (depth > Lattice::most_depth)
      refuse(name, "the ratios of " + text(amr->level_count) + " levels multiply to more than 2^" +
                       text(Lattice::most_depth));
    out.depth_of[l] = std::int8_t(depth);
  }
  const bool is_flat = amr->dimensions == 2;
  for (int a = 0; a < (is_flat ? 2 : 3); ++a) {
    check_axis(*amr, a, out.depth_of[out.level_count - 1], name);
    out.lattice.origin[a] = amr->origin[a];
    out.lattice.spacing[a] = amr->spacing[a];
  }
  if (is_flat)
    set_plane(amr->origin[2], name, out);
  return out;
}

AmrPiece adopt_patch(const insitu_patch* given, bool is_flat, const std::string& name) {
  insitu_patch copy = core::from_caller(given, name);
  if (is_flat) {
    copy.lower[2] = copy.ghosts_before[2] = copy.ghosts_after[2] = 0;
    copy.cells[2] = 1;
  }
  const insitu_patch* const patch = &copy;
  double product = 1; // exact as far as it matters
  for (int a = 0; a < 3; ++a) {
    const std::int64_t n = patch->cells[a], lower = patch->lower[a];
    const std::string along = " along axis " + text(a);
    constexpr std::int64_t most = 2 * Lattice::largest_index;
    if (n < 1 || n > most)
      refuse(name, text(n) + " cells" + along + ", 1 to " + text(most) + " expected");
    if (lower < -Lattice::largest_index || lower > Lattice::largest_index - n)
      refuse(name, text(n) + " cells from index " + text(lower) + along + "; indices from " +
                       text(-Lattice::largest_index) + " to " + text(Lattice::largest_index - 1) +
                       " expected");
    product *= double(n);
    for (const std::int32_t layers : {patch->ghosts_before[a], patch->ghosts_after[a]})
      if (constexpr int most_layers = 1 << 20; layers < 0 || layers > most_layers)
        refuse(name, text(layers) + " layers of ghosts" + along + ", 0 to " + text(most_layers) +
                         " expected");
  }
  if (product > 0x1p62)
    refuse(name, text(patch->cells) + " cells are more than 64 bits count");
  AmrPiece out;
  out.kind = AmrPiece::Kind::patch;
  out.patch = *patch;
  return out;
}

AmrPiece adopt_leaves(const insitu_leaves* given, bool is_flat, const std::string& name) {
  const insitu_leaves copy = core::from_caller(given, name), *const leaves = &copy;
  AmrPiece out;
  out.kind = AmrPiece::Kind::leaves;
  out.levels = adopt(&leaves->levels, name + ", levels", Pointers::followed);
  out.corners = adopt(&leaves->corners, name + ", corners", Pointers::followed);
  const ExternalArray &levels = out.levels, &corners = out.corners;
  if (levels.type != INSITU_UINT8)
    if (levels.type != INSITU_INT32 && levels.type != INSITU_INT64)
      refuse(name, std::string("levels: type ") + type_name(levels.type) +
                       ", uint8, int32 or int64 expected");
  require_integer(corners, name + ", corners");
  if (levels.components != 1 || (corners.components != 3 && !(is_flat && corners.components == 2)))
    refuse(name, text(levels.components) + " components of levels and " + text(corners.components) +
                     " of corners, 1 and " + (is_flat ? "2" : "3") + " expected");
  out.is_flat = is_flat;
  for (const ExternalArray* a : {&levels, &corners}) {
    const char* const what = a == &levels ? "levels" : "corners";
    if (a->memory != INSITU_HOST)
      throw Error(INSITU_ERROR_UNSUPPORTED,
                  name + ", " + what + ": in device memory; leaves are read on the host");
    if (!a->layout.linear && !a->indirect)
      refuse(name, std::string(what) + ": items must be evenly spaced");
  }
  if (levels.layout.count != corners.layout.count)
    refuse(name,
           text(levels.layout.count) + " levels, but " + text(corners.layout.count) + " corners");
  constexpr int most_bits = Lattice::most_depth;
  if (leaves->corner_bits < -1 || leaves->corner_bits > most_bits)
    refuse(name,
           "corner_bits " + text(leaves->corner_bits) + ", -1 to " + text(most_bits) + " expected");
  out.corner_bits = leaves->corner_bits;
  for (int a = 0; a < 3; ++a) {
    constexpr std::int64_t most = std::int64_t(1) << 61; // sums with corners stay in 64 bits
    out.offset[a] = is_flat && a == 2 ? 0 : leaves->offset[a];
    if (out.offset[a] < -most || out.offset[a] > most)
      refuse(name, "offset " + text(leaves->offset) + ", at most 2^61 expected");
  }
  return out;
}

AmrPieceView view_of(const AmrPiece& piece, const AmrLevels& levels, const std::string& name) {
  AmrPieceView v;
  v.is_patch = piece.kind == AmrPiece::Kind::patch;
  if (v.is_patch) {
    const insitu_patch& p = piece.patch;
    if (p.level < 0 || p.level >= levels.level_count)
      refuse(name, "level " + text(p.level) + ", 0 to " + text(levels.level_count - 1) +
                       " expected (insitu_mesh_amr)");
    v.depth = levels.depth(p.level);
    v.cell_count = p.cells[0] * p.cells[1] * p.cells[2];
    std::copy(p.lower, p.lower + 3, v.lower);
    std::copy(p.cells, p.cells + 3, v.size);
    for (int a = 0; a < 3; ++a)
      v.ghost_faces |= std::uint8_t((p.ghosts_before[a] > 0 ? 1 << 2 * a : 0) |
                                    (p.ghosts_after[a] > 0 ? 2 << 2 * a : 0));
    return v;
  }
  const ExternalArray &l = piece.levels, &c = piece.corners;
  v.cell_count = l.layout.count;
  v.levels = l.data;
  v.levels_stride = l.layout.stride[0];
  v.level_bytes = size_of(l.type);
  v.levels_indirect = l.indirect;
  v.levels_behind = l.offset;
  v.corner_stride = c.layout.stride[0];
  v.corner_is_int32 = c.type == INSITU_INT32;
  v.corner_depth = piece.corner_bits;
  v.corner_indirect = c.indirect;
  for (int a = 0; a < 3; ++a) {
    if (piece.is_flat && a == 2)
      continue;
    const std::int64_t step = a * c.component_stride;
    v.corner[a] = c.indirect || !c.data ? c.data : c.data + step;
    v.corner_behind[a] = c.offset + step;
    v.offset[a] = piece.offset[a];
  }
  return v;
}

std::string why_no_ghosts(const insitu_patch& patch, const ExternalArray& array) {
  if (array.indirect)
    return "indirect; the fields of a patch with ghosts are reached by strides";
  const ItemLayout& layout = array.layout;
  if (layout.extent[0] != patch.cells[0] || layout.extent[1] != patch.cells[1])
    return "extents " + text(layout.extent[0]) + ", " + text(layout.extent[1]) +
           "; those of the patch expected, " + text(patch.cells[0]) + ", " + text(patch.cells[1]) +
           ": its ghosts are reached by the strides between them";
  // Axes with more than one cell, the one of the smallest steps first.
  struct Axis {
    int axis;
    std::int64_t step, cells;
  } axes[3];
  int count = 0;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t n = patch.cells[a] + patch.ghosts_before[a] + patch.ghosts_after[a];
    if (n == 1)
      continue;
    const Axis next = {a, std::abs(layout.stride[a]), n};
    int at = count++;
    for (; at > 0 && axes[at - 1].step > next.step; --at)
      axes[at] = axes[at - 1];
    axes[at] = next;
  }
  for (int i = 1; i < count; ++i)
    if (const Axis& a = axes[i - 1], &b = axes[i]; b.step / a.cells < a.step)
      return "stride " + text(b.step) + " along axis " + text(b.axis) +
             " leaves no room for ghosts: " + text(a.cells) +
             " cells, ghosts among them, of stride " + text(a.step) + " along axis " + text(a.axis);
  return {};
}

std::int64_t first_bad(std::int64_t n, const core::Threads* threads,
                       core::FunctionRef<bool(std::int64_t)> is_bad) {
  std::atomic<std::int64_t> first{n}; // the lowest, whatever the threads
  const auto search = [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end && i < first.load(std::memory_order_relaxed); ++i)
      if (is_bad(i)) {
        std::int64_t now = first.load();
        while (i < now && !first.compare_exchange_weak(now, i)) {
        }
      }
  };
  constexpr std::int64_t grain = 1 << 14;
  if (threads)
    threads->parallel_for(n, grain, search);
  else
    search(0, n);
  return first;
}

namespace {

/// What is wrong with a leaf: empty if nothing is.
class LeafCheck {
public:
  LeafCheck(const AmrPieceView& view, const AmrLevels& levels) : view_(view), levels_(levels) {}

  bool is_bad(std::int64_t leaf) const {
    if (has_null(leaf))
      return true;
    const std::int64_t level = view_.raw_level(leaf);
    if (level < 0 || level >= levels_.level_count)
      return true;
    const int shift = shift_of(level);
    if (shift < 0)
      return true;
    for (int a = 0; a < 3; ++a)
      if (loses_bits(leaf, a, shift) || is_too_far(leaf, a, shift))
        return true;
    return false;
  }

  std::string explain(std::int64_t leaf) const {
    if (has_null(leaf))
      return "its pointer is null";
    std::int64_t level = view_.raw_level(leaf);
    if (view_.level_bytes == 1)
      level &= 0xff;
    if (level < 0 || level >= levels_.level_count)
      return "level " + text(level) + ", 0 to " + text(levels_.level_count - 1) + " expected";
    const int shift = shift_of(level), depth = levels_.depth(level);
    const std::string at =
        "level " + text(level) + ", corner " + corner_text(leaf) + " in cells of 1/2^";
    if (shift < 0)
      return at + text(view_.corner_depth) + " of the coarsest spacing: coarser than its level's " +
             "1/2^" + text(depth);
    const std::string unit = text(view_.corner_depth < 0 ? depth : view_.corner_depth);
    for (int a = 0; a < 3; ++a)
      if (loses_bits(leaf, a, shift))
        return at + unit + ": not on its level's lattice, multiples of " +
               text(std::int64_t(1) << shift) + " expected";
    return at + unit + ": indices from " + text(-Lattice::largest_index) + " to " +
           text(Lattice::largest_index - 1) + " of its level's cells expected";
  }

private:
  bool has_null(std::int64_t leaf) const {
    const auto null_at = [](const std::byte* p) { return !load_as<const std::byte*>(p); };
    return (view_.levels_indirect && null_at(view_.levels + leaf * view_.levels_stride)) ||
           (view_.corner_indirect && null_at(view_.corner[0] + leaf * view_.corner_stride));
  }
  int shift_of(std::int64_t level) const {
    return view_.corner_depth < 0 ? 0 : view_.corner_depth - levels_.depth(level);
  }
  std::int64_t place(std::int64_t leaf, int axis) const {
    constexpr std::int64_t most = std::int64_t(1) << 61; // farther is too far in any case
    return std::clamp(view_.raw_corner(leaf, axis), -most, most - 1) + view_.offset[axis];
  }
  bool loses_bits(std::int64_t leaf, int axis, int shift) const {
    return (place(leaf, axis) & ((std::int64_t(1) << shift) - 1)) != 0;
  }
  bool is_too_far(std::int64_t leaf, int axis, int shift) const {
    const std::int64_t index = place(leaf, axis) >> shift;
    return index < -Lattice::largest_index || index >= Lattice::largest_index;
  }
  std::string corner_text(std::int64_t leaf) const {
    std::int64_t corner[3];
    for (int a = 0; a < 3; ++a)
      corner[a] = view_.raw_corner(leaf, a);
    const std::int64_t* o = view_.offset;
    return text(corner) + (o[0] || o[1] || o[2] ? " + offset " + text(view_.offset) : "");
  }

  const AmrPieceView& view_;
  const AmrLevels& levels_;
};

} // namespace

void check_leaves(const AmrPiece& piece, const AmrPieceView& view, const AmrLevels& levels,
                  const std::string& name, const core::Threads* threads) {
  if (piece.kind != AmrPiece::Kind::leaves)
    return;
  const LeafCheck check(view, levels);
  const std::int64_t leaf =
      first_bad(view.cell_count, threads, [&](std::int64_t i) { return check.is_bad(i); });
  if (leaf < view.cell_count)
    throw Error(INSITU_ERROR_MESH, name + ", leaf " + text(leaf) + ": " + check.explain(leaf));
}

} // namespace insitu::mesh
