#include "mesh/registered/flat_piece.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <mutex>

#include "core/status.h"
#include "mesh/ghosts.h"

namespace insitu::mesh {

using math::Vec3d;

namespace {

constexpr std::int64_t cell_grain = 1 << 14;

template <class Work>
void for_all(std::int64_t count, const core::Threads* threads, Work&& work) {
  if (threads)
    threads->parallel_for(count, cell_grain, work);
  else if (count > 0)
    work(0, count);
}

} // namespace

void FlatFacts::add(const FlatFacts& other) {
  least = std::min(least, other.least);
  greatest = std::max(greatest, other.greatest);
  for (std::size_t e = 0; e < lengths.size(); ++e)
    lengths[e] += other.lengths[e];
  volumes += other.volumes;
}

FlatSlab FlatSlab::of(const FlatFacts& facts) {
  std::int64_t all = 0, below = 0;
  for (const std::int64_t n : facts.lengths)
    all += n;
  int power = 0;
  for (int e = 0; e < FlatFacts::powers && 2 * below < all; ++e) {
    below += facts.lengths[std::size_t(e)];
    power = e - FlatFacts::middle;
  }
  FlatSlab slab;
  slab.plane = facts.any() ? facts.least : 0.0;
  constexpr int apart = 19; // of the 24 binary digits of float32
  if (slab.plane != 0.0)
    power = std::max(power, std::ilogb(slab.plane) - apart);
  const double thickness = std::ldexp(1.0, power);
  // Both are exact, so that blocks of origin and spacing have them, too.
  const double centre = std::nearbyint(std::ldexp(slab.plane, 20 - power));
  slab.low = std::ldexp(centre, power - 20) - 0.5 * thickness;
  slab.high = slab.low + thickness;
  return slab;
}

FlatCell FlatSource::cell(std::int64_t c) const {
  FlatCell out;
  const auto id = [&](const std::byte* at) {
    return from_base(load_index(at, given_.connectivity.is_int32), given_.index_base);
  };
  int shape = cells_.shape;
  if (cells_.kind == FlatCells::Kind::block) {
    const std::int64_t row = c / (given_.block_vertices[0] - 1);
    const std::int64_t v = c + row; // a row has one vertex more than cells
    out = {4, {v, v + 1, v + 1 + given_.block_vertices[0], v + given_.block_vertices[0]}};
    return out;
  }
  const std::byte* base = given_.connectivity.data + c * given_.connectivity.stride;
  if (cells_.kind == FlatCells::Kind::mixed) {
    shape = load_as<std::uint8_t>(given_.types + c * given_.types_stride);
    if (!is_flat_shape(shape))
      return out;
    const std::int64_t start = from_base(given_.offsets.load(c), given_.index_base);
    if (start < 0 || start > given_.connectivity.count - vertex_count_of(shape))
      return out;
    base = given_.connectivity.data + start * given_.id_stride;
  }
  const int most = vertex_count_of(shape);
  while (out.count < most) {
    const std::int64_t v = id(base + out.count * given_.id_stride);
    if (cells_.kind == FlatCells::Kind::padded && v < 0)
      break;
    out.ids[out.count++] = v;
  }
  if (shape == 8 && out.count == 4)
    std::swap(out.ids[2], out.ids[3]); // around it
  return out;
}

Vec3d FlatSource::point(std::int64_t id) const {
  if (given_.implicit_points)
    return given_.point(id);
  const PointsView& points = given_.points;
  const std::int64_t o = points.layout.offset(id);
  const auto component = [&](int c) {
    return load_real(points.component[c] + o, points.is_float32);
  };
  return {component(0), component(1), has_third_ ? component(2) : 0.0};
}

bool FlatSource::is_sound(const FlatCell& cell) const {
  for (int v = 0; v < cell.count; ++v)
    if (cell.ids[v] < 0 || cell.ids[v] >= vertices_)
      return false;
  return cell.count >= 3;
}

std::string FlatSource::fault(std::int64_t c) const {
  const FlatCell cell = this->cell(c);
  if (cells_.kind == FlatCells::Kind::mixed) {
    const int type = load_as<std::uint8_t>(given_.types + c * given_.types_stride);
    const std::int64_t given = given_.offsets.load(c);
    if (!is_flat_shape(type))
      return "type " + std::to_string(type) + ", 5, 8 or 9 expected of a flat mesh";
    const int n = vertex_count_of(type);
    if (cell.count == 0)
      return "its " + std::to_string(n) + " ids start at " + std::to_string(given) + " of " +
             std::to_string(given_.connectivity.count) + " in connectivity";
    if (c + 1 < given_.offsets.count && from_base(given_.offsets.load(c + 1), given) != n)
      return std::to_string(from_base(given_.offsets.load(c + 1), given)) +
             " ids between its offsets, " + std::to_string(n) + " expected";
  }
  if (cell.count < 3)
    return std::to_string(cell.count) + " ids before the padding, 3 or 4 expected";
  for (int v = 0; v < cell.count; ++v)
    if (cell.ids[v] < 0 || cell.ids[v] >= vertices_)
      return "vertex " + std::to_string(v) + " has id " +
             std::to_string(from_base(cell.ids[v], -given_.index_base)) + ", " +
             std::to_string(given_.index_base) + " to " +
             std::to_string(vertices_ - 1 + given_.index_base) + " expected";
  return {};
}

/// From one vertex to another, the short way round.
Vec3d FlatSource::step(std::int64_t from, std::int64_t to) const {
  Vec3d d = point(to) - point(from);
  if (turn_ > 0.0 && std::isfinite(d.x))
    d.x = std::remainder(d.x, turn_);
  return d;
}

double FlatSource::area(const FlatCell& cell) const {
  double sum = 0.0, around = 0.0, latitude = 0.0;
  for (int v = 0; v < cell.count; ++v) {
    const std::int64_t a = cell.ids[v], b = cell.ids[(v + 1) % cell.count];
    around += step(a, b).x;
    latitude += point(a).y;
    const Vec3d p = step(cell.ids[0], a), q = step(cell.ids[0], b);
    sum += p.x * q.y - p.y * q.x;
  }
  if (turn_ > 0.0 && std::abs(around) > 0.5 * turn_) // a pole is within
    return latitude < 0.0 ? -around : around;
  return sum;
}

void FlatSource::look(const std::string& name, const core::Threads* threads,
                      FlatFacts& facts) const {
  std::mutex mutex;
  std::vector<std::int64_t> faulty;
  for_all(given_.cell_count, threads, [&](std::int64_t begin, std::int64_t end) {
    FlatFacts mine;
    std::vector<std::int64_t> wrong;
    for (std::int64_t c = begin; c < end; ++c) {
      if (!given_.exists(c))
        continue;
      if (cells_.kind == FlatCells::Kind::mixed &&
          is_below_area(load_as<std::uint8_t>(given_.types + c * given_.types_stride)))
        continue; // is left out
      if (cells_.kind != FlatCells::Kind::block && !fault(c).empty()) {
        wrong.push_back(c);
        continue;
      }
      const FlatCell cell = this->cell(c);
      for (int v = 0; v < cell.count; ++v) {
        const double z = point(cell.ids[v]).z;
        mine.least = std::min(mine.least, z);
        mine.greatest = std::max(mine.greatest, z);
        const Vec3d d = step(cell.ids[v], cell.ids[(v + 1) % cell.count]);
        const double length = std::hypot(d.x, d.y);
        if (length > 0.0 && std::isfinite(length))
          ++mine.lengths[std::size_t(
              std::clamp(std::ilogb(length), 2 - FlatFacts::middle, FlatFacts::middle - 2) +
              FlatFacts::middle)];
      }
    }
    const std::lock_guard lock(mutex);
    facts.add(mine);
    faulty.insert(faulty.end(), wrong.begin(), wrong.end());
  });
  if (faulty.empty())
    return;
  std::ranges::sort(faulty);
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(4, faulty.size()); ++i)
    text += (i > 0 ? "\n" : "") + name + ", cell " + std::to_string(faulty[i]) + ": " +
            fault(faulty[i]);
  if (faulty.size() > 4)
    text += "\n(" + std::to_string(faulty.size()) + " cells with errors in all)";
  throw core::Error(INSITU_ERROR_MESH, text);
}

void FlatSource::require_plane(const std::string& name, const FlatFacts& facts) const {
  if (!has_third_ || !facts.any() || facts.least == facts.greatest)
    return;
  const double most = FlatSlab::of(facts).out_of_plane();
  Vec3d low{FlatFacts::none, FlatFacts::none, FlatFacts::none}, high = -1.0 * low;
  std::string what;
  for (std::int64_t c = 0; c < given_.cell_count; ++c) {
    const FlatCell cell = given_.exists(c) ? this->cell(c) : FlatCell{};
    for (int v = 0; v < cell.count; ++v) {
      const Vec3d p = point(cell.ids[v]);
      for (int a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], p[a]);
        high[a] = std::max(high[a], p[a]);
      }
      const double off = std::abs(p.z - facts.least);
      if (off <= most || !what.empty())
        continue;
      char text[160];
      std::snprintf(text, sizeof text, "lies %.6g out of the plane z = %.6g", off, facts.least);
      what = ", cell " + std::to_string(c) + ": vertex id " +
             std::to_string(cell.ids[v] + given_.index_base) + " " + text +
             "; triangles, pixels and quads are cells of a mesh in one plane, and ";
    }
  }
  if (what.empty())
    return;
  for (int a = 0; a < 2; ++a)
    if (high[a] - low[a] <= most)
      throw core::Error(INSITU_ERROR_MESH, name + what + "this one has constant " + "xy"[a] +
                                               ": give its two other coordinates as x and y");
  throw core::Error(INSITU_ERROR_MESH, name + what + "no surface that is curved in space");
}

void FlatPiece::make(const FlatSource& source, const FlatSlab& slab, bool other_cells,
                     const core::Threads* threads) {
  if (other_cells) {
    view_ = source.given();
    view_.parts = nullptr;
    view_.flat_vertices = source.vertex_count();
    if (source.cells().kind == FlatCells::Kind::block)
      make_block(source, slab);
    else
      make_cells(source, threads);
  } else if (source.cells().kind == FlatCells::Kind::block) {
    make_block(source, slab);
  }
  view_.vertex_count = 2 * view_.flat_vertices;
  if (!view_.implicit_points)
    make_points(source, slab, threads);
}

/// The k axis, whose direction gives the cells their orientation.
void FlatPiece::make_block(const FlatSource& source, const FlatSlab& slab) {
  const PieceView& given = source.given();
  double sense = 0.0;
  for (std::int64_t c = 0; c < given.cell_count && !(std::abs(sense) > 0.0); ++c)
    if (given.exists(c))
      sense = source.area(source.cell(c));
  top_first_ = sense < 0.0;
  view_ = given;
  view_.flat_vertices = source.vertex_count();
  view_.block_vertices[2] = 2;
  axis_[0] = top_first_ ? slab.high : slab.low;
  axis_[1] = top_first_ ? slab.low : slab.high;
  view_.origin[2] = axis_[0];
  view_.spacing[2] = axis_[1] - axis_[0];
  view_.block_first[2] = 0;
  if (!view_.axis[0])
    return;
  for (int i = 0; i < 2; ++i)
    axis32_[i] = float(axis_[i]);
  view_.axis[2] = view_.axis_is_float32 ? reinterpret_cast<const std::byte*>(axis32_)
                                        : reinterpret_cast<const std::byte*>(axis_);
  view_.axis_stride[2] = view_.axis_is_float32 ? sizeof(float) : sizeof(double);
}

void FlatPiece::make_cells(const FlatSource& source, const core::Threads* threads) {
  const FlatCells& cells = source.cells();
  const bool uniform = cells.kind == FlatCells::Kind::uniform;
  const int width = uniform && cells.shape == 5 ? 6 : 8;
  top_first_ = false;
  view_.layout = uniform ? CellLayout::uniform : CellLayout::padded;
  view_.uniform_shape = width == 6                    ? Shape::wedge
                        : uniform && cells.shape == 8 ? Shape::voxel
                                                      : Shape::hexahedron;
  view_.index_base = 0;
  view_.types = nullptr;
  view_.offsets = {};
  const bool is_int32 = source.vertex_count() < (std::int64_t(1) << 30);
  const std::int64_t size = is_int32 ? 4 : 8, count = source.given().cell_count;
  ids_.resize_discard(std::size_t(count * width * size));
  view_.connectivity = {ids_.data(), count, width * size, is_int32};
  view_.id_stride = size;
  if (is_int32)
    fill<std::int32_t>(source, width, threads);
  else
    fill<std::int64_t>(source, width, threads);
}

/// A wedge's first triangle is the upper one, a hexahedron's first quad the lower one; of cells
/// that go round clockwise it is the other.
template <class Id>
void FlatPiece::fill(const FlatSource& source, int width, const core::Threads* threads) {
  Id* const to = reinterpret_cast<Id*>(ids_.data());
  const std::int64_t above = source.vertex_count();
  const bool voxels = view_.uniform_shape == Shape::voxel;
  for_all(source.given().cell_count, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t c = begin; c < end; ++c) {
      Id* const ids = to + c * width;
      std::fill(ids, ids + width, Id(-1));
      FlatCell cell = source.cell(c);
      if (!source.is_sound(cell)) // a ghost, or left out
        continue;
      const bool clockwise = source.area(cell) < 0.0;
      const bool top_first = (cell.count == 3) != clockwise;
      if (voxels)
        std::swap(cell.ids[2], cell.ids[3]);
      for (int v = 0; v < cell.count; ++v) {
        ids[v] = Id(cell.ids[v] + (top_first ? above : 0));
        ids[cell.count + v] = Id(cell.ids[v] + (top_first ? 0 : above));
      }
    }
  });
}

void FlatPiece::make_points(const FlatSource& source, const FlatSlab& slab,
                            const core::Threads* threads) {
  const std::int64_t n = source.vertex_count();
  const bool is_float32 = source.given().points.is_float32;
  const std::int64_t size = is_float32 ? 4 : 8;
  points_.resize_discard(std::size_t(2 * n * 3 * size));
  const auto fill = [&](auto* to) {
    using Real = std::remove_pointer_t<decltype(to)>;
    const Real z[2] = {Real(top_first_ ? slab.high : slab.low),
                       Real(top_first_ ? slab.low : slab.high)};
    for_all(n, threads, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        const Vec3d p = source.point(i);
        for (int k = 0; k < 2; ++k) {
          Real* const x = to + 3 * (i + k * n);
          x[0] = Real(p.x);
          x[1] = Real(p.y);
          x[2] = std::isfinite(p.z) ? z[k] : Real(p.z); // which validation tells of
        }
      }
    });
  };
  if (is_float32)
    fill(reinterpret_cast<float*>(points_.data()));
  else
    fill(reinterpret_cast<double*>(points_.data()));
  for (int a = 0; a < 3; ++a)
    view_.points.component[a] = points_.data() + a * size;
  view_.points.layout = {2 * n, {2 * n, 1}, {3 * size, 0, 0}, true};
  view_.points.is_float32 = is_float32;
}

void LeftOutCells::make(const PieceView& given, bool (*leaves_out)(int type),
                        const core::Threads* threads) {
  ghosts_.resize_discard(std::size_t(given.cell_count));
  counts_ = {};
  std::mutex mutex;
  for_all(given.cell_count, threads, [&](std::int64_t begin, std::int64_t end) {
    std::array<std::int64_t, 3> counts{};
    for (std::int64_t c = begin; c < end; ++c) {
      const int type = load_as<std::uint8_t>(given.types + c * given.types_stride);
      std::uint8_t& ghost = ghosts_[std::size_t(c)];
      ghost = given.exists(c) ? 0 : is_duplicate(given, c) ? 1 : 2;
      if (!leaves_out(type))
        continue;
      counts[type <= 2 ? 0 : type <= 4 || type == 21 ? 1 : 2] += ghost == 0;
      ghost = 2;
    }
    const std::lock_guard lock(mutex);
    for (std::size_t k = 0; k < counts.size(); ++k)
      counts_[k] += counts[k];
  });
}

void LeftOutCells::put_in(PieceView& view) const {
  set_ghosts(view, ghosts_.data(), 3);
}

} // namespace insitu::mesh
