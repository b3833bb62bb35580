/// A soak outside the suite: random and adversarial points on meshes of every kind, against exact
/// containment cell by cell, for as long as one likes.
///
///   containment_soak [points, 1e8] [seed, 1]
///
/// Checks, per point: the owner by every way to ask (batch and single; standard and exact), the
/// pack filter's proofs, and for one in ten thousand exact containment itself against the rational
/// oracle. Prints what it met, and how far the parametric coordinates map off the point at worst;
/// at a failure the seed and the least mesh (one or two cells) that still fails.

#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "cases.h"
#include "cells/exact/contain_exact.h"
#include "fixtures/committed.h"
#include "lanes.h"
#include "oracle.h"

namespace insitu::test {
namespace {

using cells::Containment;

struct Recipe {
  const char* name;
  MeshOptions options;
  bool valid; ///< no cell folds: the residual of parametric coordinates means something
};

const Recipe recipes[] = {
    {"aligned", {.jitter = 0.0}, true},
    {"jitter 0.2", {.jitter = 0.2}, true},
    {"jitter 0.2, dyadic", {.jitter = 0.2, .snap = 0x1p-5}, true},
    {"offset 1e7", {.jitter = 0.2, .offset = 1e7}, true},
    {"offset 1e7, dyadic", {.jitter = 0.2, .offset = 1e7, .snap = 0x1p-8}, true},
    {"aspect 1e6", {.jitter = 0.2, .scale = {1, 1, 1e-6}}, true},
    {"aspect 1e6 at 1e7", {.jitter = 0.2, .offset = 1e7, .scale = {1e6, 1e3, 1}}, true},
    {"nearly flat faces", {.jitter = 1e-15}, true},
    {"jitter 0.4", {.jitter = 0.4}, false},
    {"collapsed", {.jitter = 0.2, .snap = 0x1p-5, .collapse = 0.3}, false},
    {"tangled", {.jitter = 1.5}, false},
};
constexpr MeshKind kinds[] = {MeshKind::hexahedra, MeshKind::voxels,     MeshKind::wedges,
                              MeshKind::pyramids,  MeshKind::tetrahedra, MeshKind::mixed};

struct Totals {
  long long points = 0, held = 0, tied = 0, proofs = 0, undecided = 0, oracle = 0;
  double worst_residual = 0.0;
};

/// One mesh, committed, with what the checks need at hand.
class Bed {
public:
  explicit Bed(const TestMesh& from) : mesh(from), committed(from, 1) {
    for (const MeshCell& cell : mesh.cells) {
      vertices.push_back(mesh.cell_vertices(cell));
      boxes.push_back(bounds_of(cell.shape, vertices.back().data()));
    }
  }

  /// The lowest cell that holds p, or -1.
  std::int64_t owner(const Vec3d& p, Containment* where = nullptr) const {
    for (std::size_t c = 0; c < boxes.size(); ++c) {
      if (!boxes[c].holds(p))
        continue;
      const Containment found =
          cells::contain_exact(mesh.cells[c].shape, vertices[c].data(), p).where;
      if (!cells::holds(found))
        continue;
      if (where)
        *where = found;
      return std::int64_t(c);
    }
    return -1;
  }

  const TestMesh& mesh;
  fixtures::Committed committed;
  std::vector<Vertices> vertices;
  std::vector<Bounds> boxes;
};

query::LocateOptions with(insitu_accuracy accuracy) {
  query::LocateOptions options;
  options.accuracy = accuracy;
  return options;
}

/// Whether some way to ask gives another owner; `answer` is that one.
bool differs(const Bed& bed, const Vec3d& p, std::int64_t& answer) {
  const std::int64_t expected = bed.owner(p);
  for (const insitu_accuracy accuracy : {INSITU_EXACT, INSITU_STANDARD}) {
    query::Location batch;
    bed.committed.sampler().locate(bed.committed.threads, std::span(&p, 1), std::span(&batch, 1),
                                   with(accuracy));
    const query::Location single = bed.committed.sampler().locate(p, -1, with(accuracy));
    for (const query::Location& l : {batch, single})
      if (l.cell != expected) {
        answer = l.cell;
        return true;
      }
  }
  return false;
}

void print_cell(const Bed& bed, std::int64_t cell, const Vec3d& p) {
  if (cell >= 0)
    std::printf(
        "cell %lld: %s", static_cast<long long>(cell),
        describe(bed.mesh.cells[std::size_t(cell)].shape, bed.vertices[std::size_t(cell)].data(), p)
            .c_str());
}

[[noreturn]] void fail(const Bed& bed, const Vec3d& p, std::uint64_t seed, const Recipe& recipe,
                       MeshKind kind, std::int64_t expected, std::int64_t answer) {
  std::printf("FAILED: seed %llu, %s, mesh kind %d: owner %lld expected, %lld found\n",
              static_cast<unsigned long long>(seed), recipe.name, int(kind),
              static_cast<long long>(expected), static_cast<long long>(answer));
  // Does it take the whole mesh, or these two cells, or one?
  for (const bool first : {true, false}) {
    TestMesh small = bed.mesh;
    small.cells.clear();
    for (const std::int64_t c : {expected, answer})
      if (c >= 0 && (!first || small.cells.empty()))
        small.cells.push_back(bed.mesh.cells[std::size_t(c)]);
    if (small.cells.empty())
      continue;
    const Bed reduced(small);
    std::int64_t again = -1;
    if (differs(reduced, p, again)) {
      std::printf("fails on %zu cell(s) alone, owner %lld expected, %lld found\n",
                  small.cells.size(), static_cast<long long>(reduced.owner(p)),
                  static_cast<long long>(again));
      for (std::size_t c = 0; c < small.cells.size(); ++c)
        print_cell(reduced, std::int64_t(c), p);
      std::exit(1);
    }
  }
  std::printf("fails in the whole mesh only\n");
  print_cell(bed, expected, p);
  print_cell(bed, answer, p);
  std::exit(1);
}

/// The distance of the answer's image from p, in roundings of the cell's extent, the worst axis.
double residual(const Bed& bed, const query::Location& l, const Vec3d& p) {
  const auto c = std::size_t(l.cell);
  const Vertices& v = bed.vertices[c];
  // Relative to vertex 0, as the map is computed: at offsets its own rounding would be seen.
  Vertices about = v;
  for (Vec3d& x : about)
    x = x - v[0];
  const Vec3d image = cells::map_to_physical(bed.mesh.cells[c].shape, about.data(), l.parametric);
  const Vec3d f = image - (p - v[0]), size = bed.boxes[c].high - bed.boxes[c].low;
  double worst = 0.0;
  for (int a = 0; a < 3; ++a)
    if (size[a] > 0)
      worst = std::fmax(worst, std::fabs(f[a]) / (size[a] * 0x1p-53));
  return worst;
}

void check_filter(const Bed& bed, const std::vector<Vec3d>& points, Random& random, Totals& totals,
                  std::uint64_t seed) {
  const auto c = std::size_t(random.below(int(bed.mesh.cells.size())));
  const Shape shape = bed.mesh.cells[c].shape;
  LaneBlock block;
  std::vector<Vec3d> asked;
  for (const Vec3d& p : points)
    if (bed.boxes[c].holds(p) && block.count < LaneBlock::size) {
      block.add(shape, bed.vertices[c].data(), p);
      asked.push_back(p);
    }
  while (block.count % 8 != 0)
    block.add(shape, bed.vertices[c].data(), bed.vertices[c][0]);
  cells::FilterResult results[LaneBlock::size];
  filter_lanes(shape, block, results);
  for (std::size_t k = 0; k < asked.size(); ++k) {
    ++totals.proofs;
    if (results[k] == cells::FilterResult::undecided) {
      ++totals.undecided;
      continue;
    }
    const Containment truth = cells::contain_exact(shape, bed.vertices[c].data(), asked[k]).where;
    if (truth !=
        (results[k] == cells::FilterResult::inside ? Containment::inside : Containment::outside)) {
      std::printf("FAILED: seed %llu: the pack filter's proof is wrong\n%s",
                  static_cast<unsigned long long>(seed),
                  describe(shape, bed.vertices[c].data(), asked[k]).c_str());
      std::exit(1);
    }
  }
}

/// One mesh and its points.
void round(const Recipe& recipe, MeshKind kind, std::uint64_t seed, int count, Totals& totals) {
  Random random(seed);
  MeshOptions options = recipe.options;
  options.kind = kind;
  const TestMesh mesh = make_mesh(options, random);
  const Bed bed(mesh);
  std::vector<Vec3d> points(static_cast<std::size_t>(count));
  const Vec3d margin = 0.02 * (mesh.high - mesh.low);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i % 16 != 0) {
      points[i] = random.uniform(mesh.low - margin, mesh.high + margin);
    } else {
      const auto c = std::size_t(random.below(int(mesh.cells.size())));
      points[i] =
          adversarial_point(mesh.cells[c].shape, bed.vertices[c].data(), random, options.snap > 0);
    }
  }
  std::vector<query::Location> exact(points.size()), standard(points.size());
  const query::Sampler sampler = bed.committed.sampler();
  sampler.locate(bed.committed.threads, points, exact, with(INSITU_EXACT));
  sampler.locate(bed.committed.threads, points, standard, with(INSITU_STANDARD));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d& p = points[i];
    Containment where = Containment::outside;
    const std::int64_t expected = bed.owner(p, &where);
    for (const auto* answers : {&exact, &standard})
      if ((*answers)[i].cell != expected)
        fail(bed, p, seed, recipe, kind, expected, (*answers)[i].cell);
    std::int64_t answer = -1;
    if (i % 64 == 0 && differs(bed, p, answer))
      fail(bed, p, seed, recipe, kind, expected, answer);
    ++totals.points;
    totals.held += expected >= 0;
    totals.tied += expected >= 0 && where != Containment::inside;
    if (expected >= 0 && recipe.valid)
      totals.worst_residual = std::fmax(totals.worst_residual, residual(bed, exact[i], p));
    if (i % 10000 == 16 && expected >= 0) {
      ++totals.oracle;
      const auto c = std::size_t(expected);
      if (oracle_contain(mesh.cells[c].shape, bed.vertices[c].data(), p, random.bits()) != where) {
        std::printf("FAILED: seed %llu: contain_exact and the oracle differ\n%s",
                    static_cast<unsigned long long>(seed),
                    describe(mesh.cells[c].shape, bed.vertices[c].data(), p).c_str());
        std::exit(1);
      }
    }
  }
  for (int k = 0; k < 4; ++k)
    check_filter(bed, points, random, totals, seed);
}

void run(double wanted, std::uint64_t seed) {
  constexpr int points_per_mesh = 20000;
  Totals totals;
  const auto start = std::chrono::steady_clock::now();
  double said = 0.0;
  while (double(totals.points) < wanted)
    for (const Recipe& recipe : recipes)
      for (const MeshKind kind : kinds) {
        round(recipe, kind, seed++, points_per_mesh, totals);
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        const bool last = double(totals.points) >= wanted;
        if (seconds - said > 30.0 || last) {
          said = seconds;
          std::printf("%.0f s: %lld points, %lld held, %lld of them on faces, edges or vertices; "
                      "%lld filter proofs, %lld undecided; %lld asked of the oracle; next seed "
                      "%llu; worst residual %.3g roundings\n",
                      seconds, totals.points, totals.held, totals.tied, totals.proofs,
                      totals.undecided, totals.oracle, static_cast<unsigned long long>(seed),
                      totals.worst_residual);
          std::fflush(stdout);
        }
        if (last)
          return;
      }
}

} // namespace
} // namespace insitu::test

int main(int argc, char** argv) {
  insitu::test::run(argc > 1 ? std::atof(argv[1]) : 1e8,
                    argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1);
  std::printf("no failure\n");
}
