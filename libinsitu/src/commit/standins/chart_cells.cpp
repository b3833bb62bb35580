#include "commit/standins/chart_cells.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/status.h"

namespace insitu::commit {

namespace {

using geo::ChartUnits;
using geo::Pole;
using math::Vec3d;

constexpr std::int64_t grain = 4096;
constexpr double infinity = std::numeric_limits<double>::infinity();
/// Of half a turn: an edge across a pole ends on meridians that are half a turn apart, to rounding,
/// and belongs to cells that hold the pole.
constexpr double slack = 1e-9;

/// One cell's longitudes made continuous.
struct Span {
  double first = 0.0;                            ///< the longitude that the others are kept near to
  double low = infinity, high = -infinity;       ///< longitudes
  double lowest = infinity, highest = -infinity; ///< latitudes
  bool pole_is_odd = false; ///< a vertex at a pole has a longitude that says nothing

  double width() const { return high - low; }
};

/// Runs f(begin, end, result) over chunks of cells; the results, in order.
template <class Result, class F>
std::vector<Result> over_cells(const mesh::MeshView& mesh, const core::Threads& threads, F&& f) {
  const std::int64_t count = mesh.cell_count();
  std::vector<Result> out(std::size_t((count + grain - 1) / grain));
  threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    f(begin, end, out[std::size_t(begin / grain)]);
  });
  return out;
}

} // namespace

/// Of single cells.
struct ChartSearch::Look {
  struct Chunk {
    ChartFacts facts;
    double east = -infinity;
    std::vector<Odd> odd;
    std::string error;
  };

  Look(const std::string& name, const mesh::MeshView& mesh, const ChartUnits& units)
      : name_(name), mesh_(mesh), units_(units), turn_(units.turn()), quarter_(units.quarter()) {}

  /// A vertex this near counts as at the pole: rounding of the coordinates' type.
  double pole_from(const mesh::PieceView& piece) const {
    return quarter_ * (1.0 - (piece.points.is_float32 || piece.axis_is_float32 ? 1e-7 : 1e-14));
  }

  void cells(std::int64_t begin, std::int64_t end, Chunk& out) const {
    mesh::CellVertices c;
    for (std::int64_t flat = begin; flat < end; ++flat)
      if (gather(flat, c))
        cell(flat, c, out);
  }

  /// False for cells that do not exist or have no place.
  bool gather(std::int64_t flat, mesh::CellVertices& c) const {
    const std::int32_t p = mesh_.piece_of(flat);
    if (!mesh_.pieces[p].exists(flat - mesh_.first_cell[p]))
      return false;
    mesh::gather(mesh_, flat, c);
    bool finite = true;
    for (int v = 0; v < c.count; ++v)
      finite &= std::isfinite(c.x[v].x) & std::isfinite(c.x[v].y) & std::isfinite(c.x[v].z);
    return finite && c.count > 0;
  }

  Span span_of(const mesh::CellVertices& c) const {
    Span s;
    const double pole = pole_from(mesh_.pieces[c.piece]);
    int first = 0;
    while (first < c.count - 1 && std::abs(c.x[first].y) >= pole)
      ++first;
    s.first = c.x[first].x;
    double pole_low = infinity, pole_high = -infinity;
    for (int v = 0; v < c.count; ++v) {
      const Vec3d& x = c.x[v];
      s.lowest = std::min(s.lowest, x.y);
      s.highest = std::max(s.highest, x.y);
      const double lon = x.x + turns_to(units_, s.first, x.x) * turn_;
      const bool at_pole = std::abs(x.y) >= pole && v != first;
      double& low = at_pole ? pole_low : s.low;
      double& high = at_pole ? pole_high : s.high;
      low = std::min(low, lon);
      high = std::max(high, lon);
    }
    // A lattice's cell has its full width there too.
    const double tolerance = 1e-6 * s.width();
    s.pole_is_odd =
        pole_low <= pole_high && (s.width() == 0.0 || std::abs(pole_low - s.low) > tolerance ||
                                  std::abs(pole_high - s.high) > tolerance);
    return s;
  }

  /// Whether every half circle of longitude has a vertex: the cell goes around a pole.
  bool surrounds_pole(const mesh::CellVertices& c) const {
    double lon[8];
    for (int v = 0; v < c.count; ++v) { // sorted
      const double x = geo::longitude_from(0.0, units_, c.x[v].x);
      int at = v;
      for (; at > 0 && lon[at - 1] > x; --at)
        lon[at] = lon[at - 1];
      lon[at] = x;
    }
    double gap = lon[0] + turn_ - lon[c.count - 1];
    for (int v = 1; v < c.count; ++v)
      gap = std::max(gap, lon[v] - lon[v - 1]);
    return gap <= 0.5 * turn_ * (1.0 + slack);
  }

  std::string at(std::int64_t flat, const mesh::CellVertices& c) const {
    return "mesh '" + name_ + "', piece " + std::to_string(c.piece) + ", cell " +
           std::to_string(flat - mesh_.first_cell[c.piece]) + ": ";
  }

  std::string number(double value) const {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", value);
    return text + std::string(units_.radians ? " radians" : " degrees");
  }

  void cell(std::int64_t flat, const mesh::CellVertices& c, Chunk& out) const {
    const mesh::PieceView& piece = mesh_.pieces[c.piece];
    double low = infinity, high = -infinity, lowest = infinity, highest = -infinity;
    for (int v = 0; v < c.count; ++v) {
      low = std::min(low, c.x[v].x);
      high = std::max(high, c.x[v].x);
      lowest = std::min(lowest, c.x[v].y);
      highest = std::max(highest, c.x[v].y);
    }
    if (std::max(-lowest, highest) > quarter_ * (1.0 + 1e-7) && out.error.empty())
      out.error = at(flat, c) + "a vertex has the latitude " +
                  number(-lowest > highest ? lowest : highest) + "; at most " + number(quarter_) +
                  " expected (points are longitude, latitude, height)";
    const bool touches_pole = std::max(-lowest, highest) >= pole_from(piece);
    // An implicit block's longitudes are those of its axes: they never jump.
    const bool lattice = piece.layout == mesh::CellLayout::block && piece.implicit_points;
    const bool jumps = high - low >= 0.5 * turn_ * (1.0 - slack);
    const auto width = [&] { return jumps || touches_pole ? span_of(c).width() : high - low; };
    const bool polar =
        !lattice && (jumps || touches_pole) && (span_of(c).pole_is_odd || surrounds_pole(c));
    if (!piece.is_halo)
      note_slant(width, lowest, highest, out.facts);
    if (lattice || !(polar || jumps)) {
      out.east = std::max(out.east, high);
      if (!piece.is_halo)
        out.facts.west = std::min(out.facts.west, low);
      return;
    }
    const Pole pole = !polar ? Pole::none : lowest + highest > 0 ? Pole::north : Pole::south;
    const double from_equator = pole == Pole::north ? lowest : -highest;
    if (polar && from_equator < quarter_ / 3 && out.error.empty())
      out.error = at(flat, c) +
                  "it spans half a turn of longitude or more, or holds a pole, and "
                  "reaches down to the latitude " +
                  number(pole == Pole::north ? lowest : highest) +
                  "; cells that hold a pole may "
                  "reach down to " +
                  number(quarter_ / 3) + ", others span less than half a turn";
    out.odd.push_back({flat, pole});
    if (polar && !piece.is_halo) {
      double& least = out.facts.polar[pole == Pole::south];
      least = std::min(least, from_equator);
    }
  }

private:
  /// East turns much from one vertex to the next of a cell that spans so many degrees.
  template <class Width>
  void note_slant(Width&& width, double lowest, double highest, ChartFacts& facts) const {
    const bool north = lowest >= quarter_ * 2 / 3, south = -highest >= quarter_ * 2 / 3;
    if ((!north && !south) || !(width() > turn_ / 18))
      return;
    double& least = facts.slanted[!north];
    least = std::min(least, north ? lowest : -highest);
  }

  const std::string& name_;
  const mesh::MeshView& mesh_;
  ChartUnits units_;
  double turn_, quarter_;
};

namespace {

/// Copies of a cell that wraps, moved so that they lie where its points' images are.
template <class Look>
void copy_over_seam(const Look& look, const mesh::MeshView& mesh, const query::ChartImage& image,
                    std::int64_t flat, std::vector<ChartCopy>& copies) {
  mesh::CellVertices c;
  mesh::gather(mesh, flat, c);
  const double turn = image.units.turn();
  const auto s = look.span_of(c);
  const int turns = -int(std::floor((s.low - image.west) / turn));
  copies.push_back({Pole::none, turns, flat, s.first});
  if (s.high + turns * turn > image.west + turn)
    copies.push_back({Pole::none, turns - 1, flat, s.first});
}

/// All cells that may hold a point whose image lies on the pole's chart. The cap is convex there
/// (cos lon cos lat >= sin of its latitude), and a cell lies within the hull of its vertices; the
/// box around them is larger.
template <class Look>
void copy_to_pole(const Look& look, const mesh::MeshView& mesh, const query::ChartImage& image,
                  Pole pole, const core::Threads& threads, std::vector<ChartCopy>& copies) {
  const ChartUnits& units = image.units;
  const double from = pole == Pole::north ? image.north_from : -image.south_from;
  const double sin_from = geo::sin_cos(units, from).sin, cap = units.quarter() - from;
  struct Found {
    std::vector<ChartCopy> copies;
    std::string error;
  };
  const auto chunks =
      over_cells<Found>(mesh, threads, [&](std::int64_t begin, std::int64_t end, Found& found) {
        mesh::CellVertices c;
        for (std::int64_t flat = begin; flat < end; ++flat) {
          if (!look.gather(flat, c))
            continue;
          double nearest = infinity; // of the vertices to the pole
          for (int v = 0; v < c.count; ++v)
            nearest =
                std::min(nearest, units.quarter() - (pole == Pole::north ? c.x[v].y : -c.x[v].y));
          // A chord between vertices passes the pole at cos(half their angle) of their distance.
          if (nearest > 4.0 * cap && nearest > units.quarter() / 3)
            continue;
          Vec3d low{infinity, infinity, 0}, high{-infinity, -infinity, 0};
          for (int v = 0; v < c.count; ++v) {
            const Vec3d q = geo::between_charts(units, Pole::none, pole, c.x[v]);
            for (int a = 0; a < 2; ++a) {
              low[a] = std::min(low[a], q[a]);
              high[a] = std::max(high[a], q[a]);
            }
          }
          const double lon = std::max({low.x, -high.x, 0.0}), lat = std::max({low.y, -high.y, 0.0});
          if (geo::sin_cos(units, lon).cos * geo::sin_cos(units, lat).cos < sin_from * (1.0 - 1e-9))
            continue;
          if (std::max({-low.x, high.x, -low.y, high.y}) > 0.9 * units.quarter()) {
            if (found.error.empty())
              found.error = look.at(flat, c) + "it reaches from the latitude " + look.number(from) +
                            ", where a pole's chart begins, to the equator; "
                            "cells near a pole have to be smaller";
            continue;
          }
          found.copies.push_back({pole, 0, flat, 0.0});
        }
      });
  for (const Found& found : chunks) {
    if (!found.error.empty())
      throw core::Error(INSITU_ERROR_MESH, found.error);
    copies.insert(copies.end(), found.copies.begin(), found.copies.end());
  }
}

} // namespace

int turns_to(const ChartUnits& units, double first, double longitude) {
  return int(std::lround((first - longitude) / units.turn()));
}

void ChartFacts::add(const ChartFacts& other) {
  ChartFacts theirs = other;
  std::ranges::transform(numbers(), theirs.numbers(), numbers().begin(),
                         [](double a, double b) { return std::min(a, b); });
}

ChartSearch::ChartSearch(const std::string& mesh_name, const mesh::MeshView& mesh,
                         const ChartUnits& units, const core::Threads& threads)
    : name_(mesh_name), mesh_(mesh), units_(units), threads_(threads) {
  const Look look(name_, mesh_, units_);
  const auto chunks = over_cells<Look::Chunk>(
      mesh_, threads_,
      [&](std::int64_t begin, std::int64_t end, auto& out) { look.cells(begin, end, out); });
  for (const Look::Chunk& chunk : chunks) {
    if (!chunk.error.empty())
      throw core::Error(INSITU_ERROR_MESH, chunk.error);
    facts_.add(chunk.facts);
    east_ = std::max(east_, chunk.east);
    odd_.insert(odd_.end(), chunk.odd.begin(), chunk.odd.end());
  }
}

ChartCells ChartSearch::find(const ChartFacts& whole) const {
  const Look look(name_, mesh_, units_);
  ChartCells out;
  std::vector<std::int64_t> wrapping;
  for (const Odd& odd : odd_) {
    out.hidden.push_back(odd.cell);
    if (odd.pole == Pole::none)
      wrapping.push_back(odd.cell);
  }
  out.image.units = units_;
  out.image.west = std::isfinite(whole.west) ? whole.west : -0.5 * units_.turn();
  // Cells beyond one turn (a piece given at 540 beside one at 0) come to where the images are.
  const double end = out.image.west + units_.turn();
  if (east_ > end + 1e-6 * units_.turn()) {
    const auto beyond = over_cells<std::vector<std::int64_t>>(
        mesh_, threads_,
        [&](std::int64_t begin, std::int64_t stop, std::vector<std::int64_t>& found) {
          mesh::CellVertices c;
          for (std::int64_t flat = begin; flat < stop; ++flat)
            if (look.gather(flat, c) && look.span_of(c).high > end + 1e-6 * units_.turn() &&
                !std::ranges::binary_search(odd_, flat, {}, &Odd::cell))
              found.push_back(flat);
        });
    for (const auto& found : beyond) {
      wrapping.insert(wrapping.end(), found.begin(), found.end());
      out.hidden.insert(out.hidden.end(), found.begin(), found.end());
    }
    std::sort(wrapping.begin(), wrapping.end());
    std::sort(out.hidden.begin(), out.hidden.end());
  }
  for (const std::int64_t flat : wrapping)
    copy_over_seam(look, mesh_, out.image, flat, out.copies);
  for (const Pole pole : {Pole::north, Pole::south}) {
    const std::size_t at = pole == Pole::south;
    if (!std::isfinite(whole.polar[at]))
      continue;
    const double limit = std::min(whole.polar[at], whole.slanted[at]);
    (pole == Pole::north ? out.image.north_from : out.image.south_from) =
        pole == Pole::north ? limit : -limit;
    copy_to_pole(look, mesh_, out.image, pole, threads_, out.copies);
  }
  return out;
}

} // namespace insitu::commit
