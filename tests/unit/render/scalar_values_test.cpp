#include <cmath>
#include <gtest/gtest.h>

#include "core/random.h"
#include "render/volume/scalar_values.h"
#include "unit/query/registered_amr.h"

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

INSTANTIATE_TEST_SUITE_P(Kinds, ScalarValuesAt, testing::Values(0, 1, 2));

} // namespace
} // namespace insitu::test
