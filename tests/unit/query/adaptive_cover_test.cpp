#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <gtest/gtest.h>
#include <vector>

#include "cells/exact/decide.h"
#include "core/random.h"
#include "mesh/box.h"
#include "unit/query/registered_amr.h"

/// Every point of the domain lies in one cell of the dual, and the solver's cells may lie anyhow in
/// its memory.
namespace insitu::test {
namespace {

using math::Vec3d;

double field(const Vec3d& p) {
  return double(float(std::sin(3.0 * p.x) + p.y * p.z));
}

/// The owning cells whose boxes meet each box of a grid.
class Bins {
public:
  explicit Bins(const mesh::MeshView& view, const Vec3d& low, const Vec3d& high)
      : low_(low), cells_(side * side * side) {
    for (int a = 0; a < 3; ++a)
      per_unit_[a] = side / (high[a] - low[a]);
    for (std::int64_t flat = 0; flat < view.cell_count(); ++flat) {
      const std::int32_t piece = view.piece_of(flat);
      if (!view.pieces[piece].owns(flat - view.first_cell[piece]))
        continue;
      mesh::CellVertices cell;
      mesh::gather(view, flat, cell);
      const mesh::Box box = mesh::box_of(cell);
      const auto from = bin(box.low), to = bin(box.high);
      for (int k = from[2]; k <= to[2]; ++k)
        for (int j = from[1]; j <= to[1]; ++j)
          for (int i = from[0]; i <= to[0]; ++i)
            cells_[std::size_t(i + side * (j + side * k))].push_back(
                {std::int64_t(held_.size()), box});
      held_.push_back({flat, cell});
    }
  }

  struct Owners {
    int inside = 0, on_boundary = 0;
    std::int64_t lowest = -1;
  };
  Owners owners(const Vec3d& p) const {
    Owners found;
    const auto at = bin(p);
    for (const auto& [number, box] : cells_[std::size_t(at[0] + side * (at[1] + side * at[2]))]) {
      if (!box.holds(p))
        continue;
      const auto& [flat, cell] = held_[std::size_t(number)];
      const cells::Reason why = cells::decide(cell.shape, cell.x, p).reason();
      if (why == cells::Reason::outside)
        continue;
      ++(why == cells::Reason::certified || why == cells::Reason::exact ? found.inside
                                                                        : found.on_boundary);
      if (found.lowest < 0)
        found.lowest = flat;
    }
    return found;
  }

private:
  static constexpr int side = 24;
  std::array<int, 3> bin(const Vec3d& p) const {
    std::array<int, 3> at;
    for (int a = 0; a < 3; ++a)
      at[std::size_t(a)] = std::clamp(int((p[a] - low_[a]) * per_unit_[a]), 0, side - 1);
    return at;
  }

  struct Held {
    std::int64_t flat;
    mesh::CellVertices cell;
  };
  Vec3d low_;
  double per_unit_[3];
  std::vector<Held> held_;
  std::vector<std::vector<std::pair<std::int64_t, mesh::Box>>> cells_;
};

/// A million points in all, half of them at halves of the finest leaves, where faces meet.
TEST(AdaptiveCover, EachPointIsOwnedOnce) {
  std::vector<Recipe> recipes;
  for (int kind = 0; kind < 5; ++kind)
    recipes.push_back({.seed = 3, .kind = kind, .roots = 2, .levels = 3});
  recipes.push_back({.seed = 3, .kind = 0, .roots = 2, .levels = 4});
  recipes.push_back({.seed = 1, .kind = 5, .roots = 1, .levels = 7});
  recipes.push_back({.seed = 2, .kind = 5, .roots = 2, .levels = 6});
  constexpr int count = 125000;
  std::int64_t on_boundary = 0;
  for (const Recipe& recipe : recipes) {
    RegisteredAmr mesh(recipe, INSITU_DUAL, field);
    const query::Sampler sampler = mesh.committed.sampler();
    const mesh::AmrView& view = mesh.amr.view();
    const std::vector<Leaf> leaves = leaves_of(mesh.amr);
    const Bins bins(sampler.mesh(), sampler.tree().bounds_min(), sampler.tree().bounds_max());
    std::vector<Vec3d> points;
    for (int i = 0; i < count; ++i) {
      const auto r = [&](int c) {
        return core::random_unit(recipe.seed, std::uint64_t(i), std::uint64_t(c));
      };
      const Leaf& leaf = leaves[std::size_t(r(0) * double(leaves.size()))];
      const int finer = view.finest_depth() + 1 - leaf.depth;
      Vec3d p;
      for (int a = 0; a < 3; ++a) {
        const std::int64_t first = leaf.index[std::size_t(a)] << finer, n = 1 << finer;
        const double low = view.lattice.place(a, leaf.depth, 2 * leaf.index[std::size_t(a)]);
        p[a] = i % 2 ? low + r(1 + a) * view.lattice.width(a, leaf.depth)
                     : view.lattice.place(a, view.finest_depth() + 1,
                                          2 * (first + std::int64_t(r(1 + a) * double(n))) +
                                              int(2 * r(4 + a)));
      }
      points.push_back(p);
    }
    std::vector<query::Location> at(points.size());
    sampler.locate(mesh.committed.threads, points, at);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Bins::Owners owners = bins.owners(points[i]);
      ASSERT_TRUE(owners.inside == 1 ? owners.on_boundary == 0
                                     : owners.inside == 0 && owners.on_boundary >= 1)
          << recipe.name() << " point " << i << ": strictly in " << owners.inside
          << " cells, on the boundary of " << owners.on_boundary;
      ASSERT_EQ(at[i].cell, owners.lowest) << recipe.name() << " point " << i;
      on_boundary += owners.on_boundary > 1;
    }
  }
  EXPECT_GT(on_boundary, 50000);
}

/// How the cells' numbers lie in the solver's memory.
enum class Layout { packed, float32, one_of_a_record, behind_pointers, from_the_end };

/// A piece's numbers in a layout.
struct Stored {
  struct Record {
    std::int32_t id;
    float number32;
    double before, number;
  };
  std::vector<double> doubles;
  std::vector<float> floats;
  std::vector<Record> records;
  std::vector<const Record*> pointers;
  insitu_array array;

  Stored(const std::vector<double>& values, Layout layout) {
    const auto n = std::int64_t(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      doubles.push_back(values[values.size() - 1 - i]);
      floats.push_back(float(values[i]));
      records.push_back({std::int32_t(i), floats.back(), -1.0, values[i]});
    }
    for (const Record& r : records)
      pointers.push_back(&r);
    switch (layout) {
    case Layout::packed:
      array = insitu_array_of(values.data(), INSITU_FLOAT64, n, 1);
      break;
    case Layout::float32:
      array = insitu_array_of(floats.data(), INSITU_FLOAT32, n, 1);
      break;
    case Layout::one_of_a_record:
      array = insitu_array_of(&records.data()->number, INSITU_FLOAT64, n, 1);
      array.stride[0] = sizeof(Record);
      break;
    case Layout::behind_pointers:
      array = insitu_array_of(pointers.data(), INSITU_FLOAT32, n, 1);
      array.indirect = 1;
      array.offset = offsetof(Record, number32);
      break;
    case Layout::from_the_end:
      array = insitu_array_of(&doubles.back(), INSITU_FLOAT64, n, 1);
      array.stride[0] = -std::int64_t(sizeof(double));
      break;
    }
  }
};

/// Of numbers that 32 bits hold: every sample has the same bits.
TEST(AdaptiveLayouts, SamplesAreTheSameHoweverCellsLie) {
  for (const Recipe& recipe : {Recipe{.seed = 1, .kind = 5, .roots = 2, .levels = 7},
                               Recipe{.seed = 2, .kind = 0, .roots = 2, .levels = 3},
                               Recipe{.seed = 2, .kind = 2, .roots = 2, .levels = 3}})
    for (const insitu_reconstruction reconstruction : {INSITU_DUAL, INSITU_NEAREST}) {
      RegisteredAmr mesh(recipe, reconstruction, field);
      if (reconstruction == INSITU_DUAL && recipe.kind == 5) {
        ASSERT_GT(mesh.committed.mesh.amr_info().repaired, 0);
      }
      const query::Sampler sampler = mesh.committed.sampler();
      const Vec3d low = sampler.tree().bounds_min(), size = sampler.tree().bounds_max() - low;
      std::vector<Vec3d> points;
      for (int i = 0; i < 20000; ++i) {
        Vec3d p;
        for (int a = 0; a < 3; ++a)
          p[a] = low[a] + size[a] * core::random_unit(4, std::uint64_t(i), std::uint64_t(a));
        points.push_back(p);
      }
      std::vector<double> expected;
      for (const Layout layout : {Layout::packed, Layout::float32, Layout::one_of_a_record,
                                  Layout::behind_pointers, Layout::from_the_end}) {
        std::vector<Stored> stored;
        stored.reserve(mesh.values.size());
        for (std::size_t p = 0; p < mesh.values.size(); ++p) {
          stored.emplace_back(mesh.values[p], layout);
          mesh.committed.mesh.mesh().set_field(std::int32_t(p), "f", INSITU_CELL,
                                               &stored.back().array, 1);
        }
        mesh.committed.commit(INSITU_CHANGED_ALL);
        const query::Sampler now = mesh.committed.sampler();
        const mesh::FieldView f = mesh.committed.mesh.mesh().field("f");
        std::vector<double> samples;
        for (const Vec3d& p : points) {
          const query::Location at = now.locate(p);
          samples.push_back(-7.0);
          if (at)
            now.interpolate(f, at, &samples.back());
        }
        if (layout == Layout::packed) {
          expected = samples;
          ASSERT_GT(std::count_if(samples.begin(), samples.end(), [](double v) { return v != -7; }),
                    10000);
        }
        // Of numbers in 32 bits, what split leaves have is rounded to these.
        const bool short_ones = layout == Layout::float32 || layout == Layout::behind_pointers;
        const bool split = mesh.committed.mesh.amr_info().repaired > 0;
        const double rounding = short_ones && split ? 0x1p-23 : 0.0;
        for (std::size_t i = 0; i < samples.size(); ++i)
          ASSERT_NEAR(samples[i], expected[i], rounding * std::fabs(expected[i]))
              << recipe.name() << ", layout " << int(layout);
      }
    }
}

/// Levels that the caller counts from the finest on: the same cells, the same samples.
TEST(AdaptiveLayouts, LevelsMayBeCountedFromTheFinest) {
  for (const int kind : {0, 1}) {
    const Recipe recipe{.seed = 2, .kind = kind, .roots = 2, .levels = 3};
    RegisteredAmr mesh(recipe, INSITU_DUAL, field);
    AmrMesh turned = make_mesh(recipe);
    fixtures::Committed other(0);
    const mesh::AmrView& view = mesh.amr.view();
    insitu_amr levels = insitu_amr_default();
    for (int a = 0; a < 3; ++a) {
      levels.origin[a] = view.lattice.origin[a];
      levels.spacing[a] = view.lattice.spacing[a];
    }
    levels.level_count = view.level_count;
    levels.finest_first = 1;
    levels.reconstruction = INSITU_DUAL;
    other.mesh.mesh().set_amr(&levels);
    for (std::size_t p = 0; p < turned.pieces.size(); ++p) {
      AmrPiece& piece = turned.pieces[p];
      const auto id = std::int32_t(p);
      const std::int64_t n = piece.cell_count();
      if (piece.is_patch) {
        insitu_patch patch = insitu_patch_default();
        patch.level = view.level_count - 1 - piece.level;
        std::copy(piece.lower.begin(), piece.lower.end(), patch.lower);
        std::copy(piece.size.begin(), piece.size.end(), patch.cells);
        other.mesh.mesh().set_patch(id, &patch);
      } else {
        for (std::int32_t& level : piece.levels)
          level = view.level_count - 1 - level;
        insitu_leaves leaves = insitu_leaves_default();
        leaves.levels = insitu_array_of(piece.levels.data(), INSITU_INT32, n, 1);
        leaves.corners = insitu_array_of(mesh.corners[p].data(), INSITU_INT64, n, 3);
        other.mesh.mesh().set_leaves(id, &leaves);
      }
      const insitu_array array = insitu_array_of(mesh.values[p].data(), INSITU_FLOAT64, n, 1);
      other.mesh.mesh().set_field(id, "f", INSITU_CELL, &array, 1);
    }
    other.commit();
    const query::Sampler a = mesh.committed.sampler(), b = other.sampler();
    ASSERT_EQ(a.mesh().cell_count(), b.mesh().cell_count());
    int inside = 0;
    for (int i = 0; i < 5000; ++i) {
      const Vec3d low = a.tree().bounds_min(), size = a.tree().bounds_max() - low;
      Vec3d p;
      for (int c = 0; c < 3; ++c)
        p[c] = low[c] + size[c] * core::random_unit(6, std::uint64_t(i), std::uint64_t(c));
      const query::Location one = a.locate(p), two = b.locate(p);
      ASSERT_EQ(one.cell, two.cell) << recipe.name() << " point " << i;
      if (!one)
        continue;
      ++inside;
      double v, w;
      a.interpolate(mesh.committed.mesh.mesh().field("f"), one, &v);
      b.interpolate(other.mesh.mesh().field("f"), two, &w);
      ASSERT_EQ(v, w);
    }
    EXPECT_GT(inside, 1000);
  }
}

} // namespace
} // namespace insitu::test
