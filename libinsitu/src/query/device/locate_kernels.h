#pragma once

#include <cstdint>

#include "cells/exact/decide.h"
#include "device/stream.h"
#include "query/device/searched_mesh.h"

/// The kernels behind locate_points(), and what they hand to the host.
namespace insitu::query::on_device {

using device::KernelField;
using device::StreamHandle;

constexpr int most_fields = 32; ///< of one launch

/// Where answers go, on the device; null for what is not wanted.
struct Outputs {
  std::int64_t* cells = nullptr;
  double* parametric = nullptr;
  std::uint8_t* reasons = nullptr;
  const KernelField* fields = nullptr;
  int field_count = 0;
  bool needs_map = false; ///< parametric coordinates or vertex fields are wanted
  double* values[most_fields] = {};
};

/// A point left open, with the lowest cell that is known to hold it so far, and why it does.
struct OpenPoint {
  std::uint32_t point; ///< `none`: asked again, with others
  std::uint32_t unused;
  unsigned long long best; ///< the cell, and the decision's code in the low byte
};
constexpr unsigned long long no_cell = ~0ull;
INSITU_HD constexpr unsigned long long as_best(std::uint32_t cell, cells::Decision decision) {
  return (unsigned long long)(cell) << 8 | (unsigned long long)(decision.code());
}
/// One that may hold an open point, by its place in the list of those.
struct OpenPair {
  std::uint32_t open, cell;
};
/// The point of a slice and the cell that holds it.
struct OwnedPoint {
  std::uint32_t point, cell;
  cells::Decision decision;
};

/// Lists that kernels append to.
struct Lists {
  enum Counter { open, pair, again, left, hard, kept, asked, counter_count };
  std::uint32_t* counters = nullptr;
  OpenPoint* open_points = nullptr; ///< [points of the slice]
  OpenPair* pairs = nullptr;        ///< [pair_room]
  OpenPair* left_pairs = nullptr;   ///< [pair_room] that double-double does not decide either
  std::uint32_t pair_room = 0;
  std::uint32_t* again_points = nullptr; ///< [points]: there was no room for their pairs
  OwnedPoint* hard_points = nullptr;     ///< [points]: Newton's method does not find them
};

struct LocateArguments {
  SearchedMesh in;
  const double* points = nullptr;
  std::uint32_t count = 0;
  const std::uint32_t* subset = nullptr;     ///< [count] numbers of points, or null: all
  const std::uint32_t* candidates = nullptr; ///< by point, or null
  const std::uint32_t* others = nullptr;     ///< the same, next
  Outputs out;
  Lists lists;
};

void launch_locate(const LocateArguments& arguments, StreamHandle stream);
/// `fast`: the first cell in float; the candidates, if given, as they are.
void launch_locate_fast(const LocateArguments& arguments, StreamHandle stream);

/// Vertices of a cell and the point that it may hold, for the host.
struct PairData {
  math::Vec3d x[8];
  math::Vec3d p;
  std::uint32_t cell;
  mesh::Shape shape;
};
/// Decides [0, count) of the pairs in double-double; what that cannot is left.
void launch_decide_pairs(const LocateArguments& arguments, std::uint32_t count,
                         StreamHandle stream);
/// Of left pairs [first, first + count).
void launch_gather_left(const LocateArguments& arguments, std::uint32_t first, std::uint32_t count,
                        PairData* out, StreamHandle stream);
/// What the host decided of them; `outside` where the cell does not hold the point.
void launch_take_decided(const LocateArguments& arguments, std::uint32_t first, std::uint32_t count,
                         const cells::Decision* decided, StreamHandle stream);
/// The same as launch_gather_left of hard points.
void launch_gather_hard(const LocateArguments& arguments, std::uint32_t first, std::uint32_t count,
                        PairData* out, StreamHandle stream);
/// Writes the answers of `count` open points; may leave hard points.
void launch_finish(const LocateArguments& arguments, std::uint32_t count, StreamHandle stream);
/// Writes the answers of points whose parametric coordinates are known as well.
void launch_finish_at(const LocateArguments& arguments, const OwnedPoint* owned,
                      const math::Vec3d* parametric, std::uint32_t count, StreamHandle stream);

} // namespace insitu::query::on_device
