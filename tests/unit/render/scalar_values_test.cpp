#include <array>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "core/random.h"
#include "fixtures/simd_targets.h"
#include "render/volume/scalar_values.h"
#include "unit/query/registered_amr.h"
#include "unit/render/block_mesh.h"

/// Numbers at locations of a dual mesh, many at once, against ScalarField's one by one.
namespace insitu::test {
namespace {

using math::Vec3d;
using query::Location;

/// A scalar in float64, "f", and three components in float32, "v".
class Fields {
public:
  explicit Fields(const Recipe& recipe) : amr_(recipe, INSITU_DUAL, scalar) {
    const mesh::AmrView& view = amr_.amr.view();
    mesh::Mesh& mesh = amr_.committed.mesh.mesh();
    numbers_.resize(amr_.amr.pieces.size());
    for (std::size_t p = 0; p < numbers_.size(); ++p) {
      const std::int64_t n = amr_.amr.pieces[p].cell_count();
      for (std::int64_t c = 0; c < n; ++c) {
        const Vec3d x = RegisteredAmr::centre_of(view, view.cell(view.pieces[p], c));
        for (int a = 0; a < 3; ++a)
          numbers_[p].push_back(float(scalar(x) - x[a]));
      }
      const insitu_array array = insitu_array_of(numbers_[p].data(), INSITU_FLOAT32, n, 3);
      mesh.set_field(std::int32_t(p), "v", INSITU_CELL, &array, 1);
    }
    amr_.committed.commit(INSITU_CHANGED_ALL);
  }
  const commit::CommittedMesh& mesh() const { return amr_.committed.mesh; }

private:
  static double scalar(const Vec3d& x) {
    return 1.0 + x.x * (2.0 - x.y) + 0.3 * x.z * x.z - 0.1 * x.x * x.y * x.z;
  }
  RegisteredAmr amr_;
  std::vector<std::vector<float>> numbers_;
};

class ScalarValuesAt : public testing::TestWithParam<int> {};

TEST_P(ScalarValuesAt, TheBitsAreScalarFields) {
  Fields fields({.seed = 3, .kind = GetParam(), .roots = 3, .levels = 3});
  const query::Sampler sampler = fields.mesh().sampler();
  const Vec3d low = sampler.tree().bounds_min(), size = sampler.tree().bounds_max() - low;
  std::vector<Location> at;
  std::int64_t in_gridlets = 0, outside = 0;
  for (int i = 0; i < 4000; ++i) {
    Vec3d p; // one in ten or so outside; a lattice's places too, which meet faces and centres
    for (int a = 0; a < 3; ++a) {
      const double unit = 1.04 * core::random_unit(8, std::uint64_t(i), std::uint64_t(a)) - 0.02;
      p[a] = low[a] + size[a] * (i % 4 == 0 ? std::round(24.0 * unit) / 24.0 : unit);
    }
    at.push_back(sampler.locate(p));
    in_gridlets += at.back() && at.back().cell < sampler.mesh().first_cell[1];
    outside += !at.back();
  }
  ASSERT_GT(in_gridlets, 50);
  ASSERT_GT(outside, 100);
  ASSERT_LT(in_gridlets + outside, std::int64_t(at.size()) - 100) << "stitching cells";
  const mesh::FieldView f = fields.mesh().mesh().field("f"), v = fields.mesh().mesh().field("v");
  ASSERT_FALSE(f.pieces[0].is_float32);
  ASSERT_TRUE(v.pieces[0].is_float32);
  for (const render::ScalarField& scalar :
       {render::ScalarField{f, -1}, render::ScalarField{f, 0}, render::ScalarField{v, -1},
        render::ScalarField{v, 0}, render::ScalarField{v, 2}}) {
    std::vector<double> values(at.size());
    render::ScalarValues(scalar, sampler.mesh()).at(at, values.data());
    for (std::size_t i = 0; i < at.size(); ++i)
      ASSERT_EQ(values[i], at[i] ? scalar.at(sampler.mesh(), at[i]) : 0.0)
          << "component " << scalar.component << " of " << scalar.field.components << ", location "
          << i << ", cell " << at[i].cell;
  }
}

/// Samples along a few rays across the box that a bundle finds: each has the number that its
/// location says, whether its neighbours were read together with it or not.
void expect_numbers_of_locations(const query::Sampler& sampler, const render::ScalarField& scalar,
                                 const std::string& name) {
  const Vec3d low = sampler.tree().bounds_min(), size = sampler.tree().bounds_max() - low;
  std::vector<query::LatticeRay> rays;
  const Vec3d across = Vec3d{1, 0.83, 0.71} / std::sqrt(1 + 0.83 * 0.83 + 0.71 * 0.71);
  for (int i = 0; i < 256; ++i)
    rays.push_back(
        {low + Vec3d{0.013 * (i % 16) * size.x, 0.011 * (i / 16) * size.y, 0.01 * size.z}, across});
  constexpr int depth = 32;
  query::RayBundleLocator bundle(sampler, {});
  bundle.set_rays(rays, 16, 0.031 * size.x);
  const std::vector<std::uint32_t> wanted(rays.size(), ~std::uint32_t(0));
  std::vector<Location> at(rays.size() * depth);
  std::vector<query::ValueSample> samples(at.size()), alone(at.size());
  const render::ScalarValues values(scalar, sampler.mesh());
  bundle.locate(0, depth, wanted, values, samples, at);
  bundle.locate(0, depth, wanted, values, alone);
  std::int64_t found = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    found += bool(at[i]);
    ASSERT_EQ(samples[i].cell, at[i].cell) << name << ", sample " << i;
    ASSERT_EQ(alone[i].cell, at[i].cell) << name << ", sample " << i;
    if (!at[i])
      continue;
    ASSERT_EQ(samples[i].value, scalar.at(sampler.mesh(), at[i])) << name << ", sample " << i;
    ASSERT_EQ(alone[i].value, samples[i].value) << name << ", sample " << i;
  }
  EXPECT_GT(found, 1000) << name;
}

TEST_P(ScalarValuesAt, BundlesReadThemAsTheyLie) {
  Fields fields({.seed = 3, .kind = GetParam(), .roots = 3, .levels = 3});
  const query::Sampler sampler = fields.mesh().sampler();
  const mesh::FieldView f = fields.mesh().mesh().field("f"), v = fields.mesh().mesh().field("v");
  for (const std::int64_t target : fixtures::simd_targets()) {
    fixtures::use_simd_target(target);
    for (const render::ScalarField& scalar :
         {render::ScalarField{f, -1}, render::ScalarField{v, -1}, render::ScalarField{v, 2}})
      expect_numbers_of_locations(sampler, scalar,
                                  "component " + std::to_string(scalar.component) + ", " +
                                      hwy::TargetName(target));
    fixtures::use_simd_target(0);
  }
}

/// Numbers of a block's vertices, one after the other or among ghost layers, of either precision,
/// one by one or in records, or at odd addresses.
TEST(ScalarValuesIn, BlocksAsTheyLie) {
  constexpr int n = 12, wide = n + 3; // vertices along an axis, and numbers
  for (const bool uniform : {true, false}) {
    BlockMesh mesh(uniform ? INSITU_BLOCK_UNIFORM : INSITU_BLOCK_RECTILINEAR, n,
                   [](const Vec3d& p) { return 1.0 + p.x * (2.0 - p.y) + p.z * p.z; });
    std::vector<double> records, padded(wide * wide * wide, NAN);
    std::vector<float> floats;
    std::vector<std::byte> odd(8 * mesh.values.size() + 1);
    for (std::size_t i = 0; i < mesh.values.size(); ++i) {
      records.insert(records.end(), {mesh.values[i], -mesh.values[i], 3.0 * mesh.values[i]});
      floats.push_back(float(mesh.values[i]));
      padded[i % n + wide * (i / n % n + wide * (i / (n * n)))] = mesh.values[i];
    }
    std::memcpy(odd.data() + 1, mesh.values.data(), 8 * mesh.values.size());
    const std::int64_t count = std::int64_t(mesh.values.size());
    mesh::Mesh& registered = mesh.committed.mesh.mesh();
    const auto add = [&](const char* name, const insitu_array& array) {
      registered.set_field(0, name, INSITU_VERTEX, &array, 1);
    };
    add("records", insitu_array_of(records.data(), INSITU_FLOAT64, count, 3));
    add("floats", insitu_array_of(floats.data(), INSITU_FLOAT32, count, 1));
    add("odd", insitu_array_of(odd.data() + 1, INSITU_FLOAT64, count, 1));
    insitu_array layers = insitu_array_of(padded.data(), INSITU_FLOAT64, count, 1);
    for (int a = 0; a < 3; ++a) {
      layers.extent[a] = n;
      layers.stride[a] = std::array<std::int64_t, 3>{8, 8 * wide, 8 * wide * wide}[std::size_t(a)];
    }
    add("layers", layers);
    layers.data = padded.data() + (n - 1) * wide * wide;
    layers.stride[2] = -layers.stride[2];
    add("backwards", layers);
    mesh.committed.commit(INSITU_CHANGED_ALL);
    for (const std::int64_t target : fixtures::simd_targets()) {
      fixtures::use_simd_target(target);
      for (const char* name : {"f", "records", "floats", "odd", "layers", "backwards"})
        for (const int component : {-1, 0})
          expect_numbers_of_locations(mesh.committed.sampler(), {registered.field(name), component},
                                      std::string(name) + ", " + hwy::TargetName(target));
      fixtures::use_simd_target(0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, ScalarValuesAt, testing::Values(0, 1, 2));

} // namespace
} // namespace insitu::test
