// External arrays: every type, stride, order of dimensions and record is read in place, and every
// wrong one is refused by name.
#include <climits>
#include <gtest/gtest.h>
#include <random>

#include "core/device_memory.h"
#include "core/status.h"
#include "fixtures/arrays.h"
#include "mesh/registered/mesh.h"

using namespace insitu;

namespace {

core::Error error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const core::Error& e) {
    return e;
  }
  return {INSITU_OK, "no error"};
}

void expect_refused(const insitu_array& array, const std::string& text,
                    insitu_status status = INSITU_ERROR_ARGUMENT) {
  const core::Error e = error_of([&] { (void)mesh::adopt(&array, "x"); });
  EXPECT_EQ(e.status(), status) << e.what();
  EXPECT_NE(std::string(e.what()).find(text), std::string::npos) << e.what();
}

/// Dimensions i, j, k and the component in any order in memory, forwards or backwards, with any
/// number of bytes between them.
struct RandomLayout {
  std::int64_t extent[3], stride[3], component_stride;
  int components;
  std::vector<std::byte> bytes;
  std::int64_t base = 0;

  RandomLayout(std::mt19937_64& random, int item, int component_count)
      : components(component_count) {
    const auto below = [&](int n) { return std::int64_t(random() % std::uint64_t(n)); };
    for (std::int64_t& e : extent)
      e = 1 + below(5);
    int order[4] = {0, 1, 2, 3};
    std::shuffle(order, order + 4, random);
    std::int64_t step = item, used = 0;
    for (const int d : order) {
      const std::int64_t n = d == 3 ? components : extent[d];
      step += below(3) == 0 ? below(7) : 0; // padding, so that items need not be aligned
      const bool backwards = below(3) == 0;
      if (backwards)
        base += step * (n - 1);
      (d == 3 ? component_stride : stride[d]) = backwards ? -step : step;
      used += step * (n - 1);
      step = std::max(step * n, step);
    }
    bytes.resize(std::size_t(used + item), std::byte{0xa5});
  }
  std::int64_t at(std::int64_t i, std::int64_t j, std::int64_t k, int c) const {
    return base + i * stride[0] + j * stride[1] + k * stride[2] + c * component_stride;
  }
  insitu_array array(insitu_type type) const {
    insitu_array a = insitu_array_of(bytes.data() + base, type, 0, components);
    std::copy(extent, extent + 3, a.extent);
    std::copy(stride, stride + 3, a.stride);
    a.component_stride = component_stride;
    return a;
  }
};

template <class Real>
void check_random_layouts(insitu_type type, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (int trial = 0; trial < 2000; ++trial) {
    RandomLayout l(random, sizeof(Real), 3);
    const auto value = [&](std::int64_t id, int c) { return Real(1000 * c) + Real(id) / 8; };
    std::int64_t id = 0;
    for (std::int64_t k = 0; k < l.extent[2]; ++k)
      for (std::int64_t j = 0; j < l.extent[1]; ++j)
        for (std::int64_t i = 0; i < l.extent[0]; ++i, ++id)
          for (int c = 0; c < 3; ++c) {
            const Real v = value(id, c);
            std::memcpy(l.bytes.data() + l.at(i, j, k, c), &v, sizeof v);
          }
    core::Memory memory;
    mesh::Mesh mesh("m", memory);
    const insitu_array points = l.array(type);
    mesh.set_points(0, &points, 1);
    // The field is the same memory, one array a component.
    insitu_array parts[3];
    for (int c = 0; c < 3; ++c) {
      parts[c] = points;
      parts[c].data = l.bytes.data() + l.base + c * l.component_stride;
      parts[c].components = 1;
      parts[c].component_stride = 0;
    }
    mesh.set_field(0, "f", INSITU_VERTEX, parts, 3);
    const std::int32_t ids[8] = {};
    insitu_cells one = insitu_cells_default(); // of a piece without cells nothing is read
    one.count = 1;
    one.connectivity = insitu_array_of(ids, INSITU_INT32, 1, 8);
    mesh.set_cells(0, &one);
    mesh.update();
    ASSERT_EQ(mesh.view().vertex_count(), id);
    const mesh::FieldView field = mesh.field("f");
    for (std::int64_t v = 0; v < id; ++v) {
      const math::Vec3d p = mesh.view().pieces[0].point(v);
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(p[c], double(value(v, c))) << "seed " << seed << ", trial " << trial;
        ASSERT_EQ(field.pieces[0].load(v, c), double(value(v, c)))
            << "seed " << seed << ", trial " << trial;
      }
    }
  }
}

} // namespace

TEST(Arrays, AnyOrderStrideAndRecordIsReadInPlace) {
  check_random_layouts<double>(INSITU_FLOAT64, 1);
  check_random_layouts<float>(INSITU_FLOAT32, 2);
}

TEST(Arrays, DefaultsArePackedAndInterleaved) {
  const double xyz[12] = {0, 1, 2, 10, 11, 12, 20, 21, 22, 30, 31, 32};
  const insitu_array a = insitu_array_of(xyz, INSITU_FLOAT64, 4, 3);
  const mesh::ExternalArray adopted = mesh::adopt(&a, "x");
  EXPECT_TRUE(adopted.layout.linear);
  EXPECT_EQ(adopted.layout.stride[0], 24);
  EXPECT_EQ(adopted.component_stride, 8);
  EXPECT_EQ(adopted.bytes(), 96);
  EXPECT_EQ(adopted.data, reinterpret_cast<const std::byte*>(xyz));
  // With a component stride, items are adjacent.
  insitu_array planar = a;
  planar.component_stride = 32;
  EXPECT_EQ(mesh::adopt(&planar, "x").layout.stride[0], 8);
}

TEST(Arrays, SectionsOfLargerArraysAreRead) {
  // Rows 1 to 3 and columns 2 to 5 of a 6 x 8 array, every second column, upwards.
  float whole[6][8];
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 8; ++c)
      whole[r][c] = float(10 * r + c);
  insitu_array a = insitu_array_default();
  a.data = &whole[3][2];
  a.type = INSITU_FLOAT32;
  a.extent[0] = 2;
  a.extent[1] = 3; // extent 2 is left 0
  a.stride[0] = 2 * std::int64_t(sizeof(float));
  a.stride[1] = -8 * std::int64_t(sizeof(float));
  const mesh::ExternalArray s = mesh::adopt(&a, "x");
  ASSERT_EQ(s.layout.count, 6);
  EXPECT_FALSE(s.layout.linear);
  const float expected[6] = {32, 34, 22, 24, 12, 14};
  for (std::int64_t i = 0; i < 6; ++i)
    EXPECT_EQ(mesh::load_as<float>(s.data + s.layout.offset(i)), expected[i]);
}

TEST(Arrays, ASectionWithoutExtentIsEmpty) {
  insitu_array a = insitu_array_default();
  a.extent[0] = 0;
  a.extent[1] = 5; // zero by five
  const mesh::ExternalArray s = mesh::adopt(&a, "x");
  EXPECT_EQ(s.layout.count, 0);
}

TEST(Arrays, WrongOnesAreRefusedByName) {
  const double x[8] = {};
  const insitu_array good = insitu_array_of(x, INSITU_FLOAT64, 8, 1);
  const auto changed = [&](auto&& change) {
    insitu_array a = good;
    change(a);
    return a;
  };
  EXPECT_NE(std::string(error_of([] { (void)mesh::adopt(nullptr, "x"); }).what()).find("null"),
            std::string::npos);
  expect_refused(changed([](auto& a) { a.size = 3; }), "size is 3");
  expect_refused(changed([](auto& a) { a.type = insitu_type(9); }), "unknown type 9");
  expect_refused(changed([](auto& a) { a.type = insitu_type(0); }), "unknown type 0");
  expect_refused(changed([](auto& a) { a.data = nullptr; }), "data is null");
  expect_refused(changed([](auto& a) { a.count = -8; }), "-8");
  expect_refused(changed([](auto& a) { a.count = INT64_MAX; }), "count");
  expect_refused(changed([](auto& a) { a.components = 0; }), "0 components");
  expect_refused(changed([](auto& a) { a.components = INT_MIN; }), "components");
  expect_refused(changed([](auto& a) { a.components = INT_MAX; }), "components");
  if (!core::device_memory_supported())
    expect_refused(changed([](auto& a) { a.memory = INSITU_DEVICE; }), "CUDA",
                   INSITU_ERROR_UNSUPPORTED);
  expect_refused(changed([](auto& a) { a.memory = insitu_memory(7); }), "unknown memory 7");
  expect_refused(changed([](auto& a) { a.extent[0] = 7; }), "the extents hold 7");
  expect_refused(changed([](auto& a) { a.extent[1] = -1; }), "extent -1 along axis 1");
  expect_refused(changed([](auto& a) { a.extent[0] = a.extent[1] = a.extent[2] = INT64_MAX; }),
                 "extent");
  expect_refused(changed([](auto& a) { a.stride[0] = INT64_MIN; }), "stride");
  expect_refused(changed([](auto& a) { a.stride[0] = INT64_MAX; }), "stride");
  expect_refused(changed([](auto& a) {
                   a.extent[0] = a.extent[1] = 2;
                   a.extent[2] = 2;
                   a.stride[2] = INT64_MIN;
                 }),
                 "stride");
  expect_refused(changed([](auto& a) {
                   a.components = 2;
                   a.component_stride = INT64_MIN;
                 }),
                 "component_stride");
  expect_refused(changed([](auto& a) {
                   a.components = 1000;
                   a.component_stride = INT64_MAX / 100;
                 }),
                 "component_stride");
}

TEST(Arrays, ComponentsMustAgreeWithEachOther) {
  core::Memory memory;
  mesh::Mesh mesh("m", memory);
  const double x[4] = {}, y[5] = {};
  const float z[4] = {};
  const auto message = [&](std::vector<insitu_array> arrays) {
    return std::string(
        error_of([&] { mesh.set_points(0, arrays.data(), std::int32_t(arrays.size())); }).what());
  };
  const insitu_array ax = insitu_array_of(x, INSITU_FLOAT64, 4, 1),
                     ay = insitu_array_of(y, INSITU_FLOAT64, 5, 1),
                     az = insitu_array_of(z, INSITU_FLOAT32, 4, 1),
                     pair = insitu_array_of(x, INSITU_FLOAT64, 2, 2);
  EXPECT_NE(message({ax, ay, ax}).find("array 1"), std::string::npos);
  EXPECT_NE(message({ax, ay, ax}).find("count 5"), std::string::npos);
  EXPECT_NE(message({ax, ax, az}).find("float32"), std::string::npos);
  EXPECT_NE(message({ax, pair, ax}).find("one component each"), std::string::npos);
  EXPECT_EQ(message({ax, ax}), "no error"); // of a flat mesh
  EXPECT_NE(message({ax}).find("1 components, 3 expected"), std::string::npos);
  EXPECT_EQ(message({ax, ax, ax}), "no error");
  // Of equal strides but other extents: the second is 2 x 2 where the first is 4 x 1.
  insitu_array wide = ax, square = ax;
  wide.count = square.count = 0;
  wide.extent[0] = 1;
  wide.extent[1] = 4;
  wide.stride[0] = square.stride[0] = 1;
  wide.stride[1] = square.stride[1] = 8;
  wide.stride[2] = square.stride[2] = 16;
  square.extent[0] = square.extent[1] = 2;
  EXPECT_NE(message({wide, square, square}), "no error");
}
