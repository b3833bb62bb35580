// The C API with a locator on a device: host and device arrays, streams, refusals.
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "insitu/insitu.h"

#include "on_device.h"
#include "query/device/device_locator.h"
#include "workload/mesh.h"
#include "workload/queries.h"

using namespace insitu;
using test::OnDevice;

namespace {

#define REQUIRE_OK(call) ASSERT_EQ(call, INSITU_OK) << insitu_last_message()

insitu_array on_device(const void* data, insitu_type type, std::int64_t count, int components) {
  insitu_array a = insitu_array_of(data, type, count, components);
  a.memory = INSITU_DEVICE;
  return a;
}

struct Answers {
  explicit Answers(std::size_t n) : cells(n), parametric(3 * n), found(n), reasons(n), values(n) {}
  std::vector<std::int64_t> cells;
  std::vector<double> parametric;
  std::vector<std::uint8_t> found, reasons;
  std::vector<double> values;
};

/// Equal, bit for bit where it is a number.
void expect_same(const std::vector<double>& a, const std::vector<double>& b, const char* what) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    ASSERT_TRUE(a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i])))
        << what << " " << i << ": " << a[i] << " against " << b[i];
}

class GpuApi : public testing::Test {
protected:
  void SetUp() override {
    if (const std::string why = query::why_unavailable(accel::Backend::cuda); !why.empty())
      GTEST_SKIP() << why;
    mesh_ = workload::make_box(workload::Kind::hexahedra, 12, 0.2);
    field_ = workload::vertex_field(mesh_);
    for (const auto pattern :
         {workload::Pattern::random, workload::Pattern::vertices, workload::Pattern::faces})
      for (const math::Vec3d& p : workload::make_queries(mesh_, pattern, 2000).points)
        points_.insert(points_.end(), {p.x, p.y, p.z});
    points_.insert(points_.end(), {2.0, 2.0, 2.0, NAN, 0.5, 0.5});
    count_ = points_.size() / 3;
    ASSERT_EQ(insitu_session_open(nullptr, &session_), INSITU_OK);
    ASSERT_EQ(insitu_session_mesh(session_, "host", &host_), INSITU_OK);
    give(host_, INSITU_HOST, mesh_.points.data(), mesh_.connectivity.data(), field_.data());
    ASSERT_EQ(insitu_mesh_commit(host_, nullptr), INSITU_OK);
  }
  void TearDown() override { insitu_session_close(&session_); }

  void give(insitu_mesh to, insitu_memory memory, const double* points, const std::int32_t* ids,
            const double* field) {
    insitu_array a = insitu_array_of(points, INSITU_FLOAT64, mesh_.vertex_count(), 3);
    a.memory = memory;
    REQUIRE_OK(insitu_mesh_points(to, 0, &a, 1));
    insitu_cells cells = insitu_cells_default();
    cells.count = mesh_.cell_count();
    cells.connectivity = insitu_array_of(ids, INSITU_INT32, cells.count, 8);
    cells.connectivity.memory = memory;
    REQUIRE_OK(insitu_mesh_cells(to, 0, &cells));
    a = insitu_array_of(field, INSITU_FLOAT64, mesh_.vertex_count(), 1);
    a.memory = memory;
    REQUIRE_OK(insitu_mesh_field(to, 0, "f", INSITU_VERTEX, &a, 1));
  }

  void choose(insitu_mesh to, insitu_method method, insitu_backend backend) {
    insitu_locator l = insitu_locator_default();
    l.method = method;
    l.backend = backend;
    REQUIRE_OK(insitu_mesh_locator(to, &l));
    REQUIRE_OK(insitu_mesh_commit(to, nullptr));
  }

  insitu_sample_args args(const insitu_array& points, Answers& out, double** values) const {
    static const char* const names[] = {"f"};
    insitu_sample_args s = insitu_sample_args_default();
    s.locate.points = &points;
    s.locate.accuracy = INSITU_EXACT;
    s.locate.cell_base = 1;
    s.locate.cells = out.cells.data();
    s.locate.parametric = out.parametric.data();
    s.locate.found = out.found.data();
    s.locate.reasons = out.reasons.data();
    s.fields = names;
    s.field_count = 1;
    *values = out.values.data();
    s.values = values;
    return s;
  }

  Answers sample_host(insitu_mesh mesh) {
    Answers out(count_);
    const insitu_array points =
        insitu_array_of(points_.data(), INSITU_FLOAT64, std::int64_t(count_), 3);
    double* values = nullptr;
    const insitu_sample_args s = args(points, out, &values);
    EXPECT_EQ(insitu_mesh_sample(mesh, &s), INSITU_OK) << insitu_last_message();
    return out;
  }

  void expect_answers(const Answers& got, const Answers& expected) {
    EXPECT_EQ(got.cells, expected.cells);
    EXPECT_EQ(got.found, expected.found);
    expect_same(got.parametric, expected.parametric, "coordinate");
    expect_same(got.values, expected.values, "value");
  }

  workload::Mesh mesh_;
  std::vector<double> field_, points_;
  std::size_t count_ = 0;
  insitu_session session_ = nullptr;
  insitu_mesh host_ = nullptr;
};

} // namespace

TEST_F(GpuApi, SmallHostArraysThroughTheDevice) {
  const Answers expected = sample_host(host_);
  choose(host_, INSITU_METHOD_BVH, INSITU_BACKEND_CUDA);
  expect_answers(sample_host(host_), expected);
  insitu_locator_info info = insitu_locator_info_default();
  REQUIRE_OK(insitu_mesh_locator_info(host_, &info));
  EXPECT_EQ(info.backend, INSITU_BACKEND_CUDA);
  EXPECT_EQ(info.primitives, mesh_.cell_count());
  EXPECT_GT(info.bytes_copied, 0);
  EXPECT_GT(info.settled_on_host, 0); // points on vertices and faces

  // A scalar asked for alone, and back on the CPU.
  double value = 0.0;
  const double p[3] = {0.5, 0.5, 0.5};
  REQUIRE_OK(insitu_mesh_sample_point(host_, "f", p, &value, nullptr));
  EXPECT_NEAR(value, 3.0, 1e-12);
  choose(host_, INSITU_METHOD_BVH, INSITU_BACKEND_CPU);
  expect_answers(sample_host(host_), expected);
}

TEST_F(GpuApi, SmallDeviceArraysInPlace) {
  const Answers expected = sample_host(host_);
  const OnDevice<double> coordinates(mesh_.points), field(field_), points(points_);
  const OnDevice<std::int32_t> ids(mesh_.connectivity);
  insitu_mesh device = nullptr;
  REQUIRE_OK(insitu_session_mesh(session_, "device", &device));
  give(device, INSITU_DEVICE, coordinates.data(), ids.data(), field.data());
  REQUIRE_OK(insitu_mesh_commit(device, nullptr));
  insitu_locator_info info = insitu_locator_info_default();
  REQUIRE_OK(insitu_mesh_locator_info(device, &info));
  EXPECT_EQ(info.backend, INSITU_BACKEND_CUDA);
  EXPECT_EQ(info.bytes_copied, 0) << "arrays on the device are read in place";
  EXPECT_STREQ(info.reason, "the mesh lies in device memory");

  insitu_validation valid = insitu_validation_default();
  REQUIRE_OK(insitu_mesh_validate(device, &valid));
  EXPECT_EQ(valid.cells, mesh_.cell_count());
  EXPECT_EQ(valid.folded_cells, 0);
  REQUIRE_OK(insitu_mesh_commit(device, nullptr));
  expect_answers(sample_host(device), expected); // host points, host answers

  const device::Stream stream;
  const OnDevice<std::int64_t> cells(count_);
  const OnDevice<double> parametric(3 * count_), values(count_);
  const OnDevice<std::uint8_t> found(count_), reasons(count_);
  const insitu_array there = on_device(points.data(), INSITU_FLOAT64, std::int64_t(count_), 3);
  Answers unused(0);
  double* to = nullptr;
  insitu_sample_args s = args(there, unused, &to);
  to = values.data();
  s.locate.cells = cells.data();
  s.locate.parametric = parametric.data();
  s.locate.found = found.data();
  s.locate.reasons = reasons.data();
  s.locate.memory = INSITU_DEVICE;
  s.locate.stream = stream.get();
  REQUIRE_OK(insitu_mesh_sample(device, &s));
  stream.wait("answering");
  Answers got(0);
  got.cells = cells.read();
  got.parametric = parametric.read();
  got.found = found.read();
  got.values = values.read();
  expect_answers(got, expected);

  // Moved on the device: a refit, no copy.
  for (double& x : mesh_.points)
    x *= 2.0;
  device::copy_to_device(coordinates.data(), mesh_.points.data(), mesh_.points.size() * 8, nullptr,
                         "moving vertices");
  device::wait(nullptr, "moving vertices");
  REQUIRE_OK(insitu_mesh_changed(device, INSITU_CHANGED_GEOMETRY));
  insitu_commit_report report = insitu_commit_report_default();
  REQUIRE_OK(insitu_mesh_commit(device, &report));
  EXPECT_EQ(report.action, INSITU_REFIT);
  REQUIRE_OK(insitu_mesh_changed(host_, INSITU_CHANGED_GEOMETRY));
  REQUIRE_OK(insitu_mesh_commit(host_, nullptr));
  expect_answers(sample_host(device), sample_host(host_));
}

TEST_F(GpuApi, SmallTracersGoOnTheDevice) {
  // u = (y - 1/2, 1/2 - x, 0): a turn about the box's middle, which linear cells hold exactly.
  std::vector<double> velocity;
  for (std::size_t i = 0; i < mesh_.points.size(); i += 3)
    velocity.insert(velocity.end(), {mesh_.points[i + 1] - 0.5, 0.5 - mesh_.points[i], 0.0});
  const insitu_array u = insitu_array_of(velocity.data(), INSITU_FLOAT64, mesh_.vertex_count(), 3);
  REQUIRE_OK(insitu_mesh_field(host_, 0, "u", INSITU_VERTEX, &u, 1));
  choose(host_, INSITU_METHOD_BVH, INSITU_BACKEND_CUDA);
  std::vector<double> seeds;
  for (int i = 0; i < 100; ++i)
    seeds.insert(seeds.end(), {0.5 + 0.004 * i, 0.5, 0.01 + 0.009 * i});
  seeds.insert(seeds.end(), {0.99, 0.99, 0.5, 3.0, 3.0, 3.0}); // one will leave, one is outside
  const std::size_t n = seeds.size() / 3;
  const OnDevice<double> positions(seeds);
  const OnDevice<std::uint32_t> cells(std::vector<std::uint32_t>(n, 0xffffffffu));
  const OnDevice<std::uint8_t> endings(std::vector<std::uint8_t>(n, INSITU_END_ALIVE));
  insitu_advance_args args = insitu_advance_args_default();
  args.velocity = "u";
  args.positions = positions.data();
  args.cells = cells.data();
  args.endings = endings.data();
  args.count = std::int64_t(n);
  args.steps = 400;
  args.step = 2.0 * 3.14159265358979323846 / 400.0; // once around
  REQUIRE_OK(insitu_mesh_advance(host_, &args));
  const std::vector<double> at = positions.read();
  const std::vector<std::uint8_t> end = endings.read();
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(end[i], INSITU_END_ALIVE) << i;
    for (std::size_t a = 0; a < 3; ++a) // RK4: 2 pi h^4 / 120 of the radius
      EXPECT_NEAR(at[3 * i + a], seeds[3 * i + a], 4e-9) << i;
  }
  EXPECT_EQ(end[100], INSITU_END_LEFT);
  EXPECT_EQ(end[101], INSITU_END_SEED_OUTSIDE);
  args.velocity = "f";
  EXPECT_EQ(insitu_mesh_advance(host_, &args), INSITU_ERROR_ARGUMENT);
  EXPECT_NE(std::string(insitu_last_message()).find("1 components"), std::string::npos);
}

TEST_F(GpuApi, Refusals) {
  // Device arguments without a device locator, and what is not had with them.
  const insitu_array points = on_device(points_.data(), INSITU_FLOAT64, std::int64_t(count_), 3);
  insitu_locate_args a = insitu_locate_args_default();
  a.points = &points;
  a.memory = INSITU_DEVICE;
  EXPECT_EQ(insitu_mesh_locate(host_, &a), INSITU_ERROR_UNSUPPORTED);
  EXPECT_NE(std::string(insitu_last_message()).find("locator"), std::string::npos)
      << insitu_last_message();
  choose(host_, INSITU_METHOD_BVH, INSITU_BACKEND_CUDA);
  insitu_frame frame = insitu_frame_default();
  a.frame = &frame;
  EXPECT_EQ(insitu_mesh_locate(host_, &a), INSITU_ERROR_UNSUPPORTED);

  // The device has no such method; the CPU cannot read the device.
  insitu_locator l = insitu_locator_default();
  l.method = INSITU_METHOD_SHARED_FACES;
  l.backend = INSITU_BACKEND_CUDA;
  EXPECT_EQ(insitu_mesh_locator(host_, &l), INSITU_ERROR_UNSUPPORTED);

  // An id out of range on the device is found before anything is built.
  std::vector<std::int32_t> bad = mesh_.connectivity;
  bad[100] = 1 << 30;
  const OnDevice<double> coordinates(mesh_.points), field(field_);
  const OnDevice<std::int32_t> ids(bad);
  insitu_mesh device = nullptr;
  REQUIRE_OK(insitu_session_mesh(session_, "bad", &device));
  give(device, INSITU_DEVICE, coordinates.data(), ids.data(), field.data());
  EXPECT_EQ(insitu_mesh_commit(device, nullptr), INSITU_ERROR_MESH);
  EXPECT_NE(std::string(insitu_last_message()).find("1073741824"), std::string::npos)
      << insitu_last_message();
}

TEST_F(GpuApi, ScenesSayWhatNeedsTheHost) {
  const OnDevice<double> coordinates(mesh_.points), field(field_);
  const OnDevice<std::int32_t> ids(mesh_.connectivity);
  insitu_session_options options = insitu_session_options_default();
  options.scene_text = "insitu: 1\nframes: [{name: a, size: [8, 8], volume: {field: f}}]\n";
  options.log = [](insitu_log_level, const char*, void*) {};
  insitu_session session = nullptr;
  REQUIRE_OK(insitu_session_open(&options, &session));
  insitu_mesh device = nullptr;
  REQUIRE_OK(insitu_session_mesh(session, "m", &device));
  give(device, INSITU_DEVICE, coordinates.data(), ids.data(), field.data());
  EXPECT_EQ(insitu_session_execute(session, 0, 0.0), INSITU_ERROR_ACTION);
  EXPECT_NE(std::string(insitu_last_message()).find("device memory"), std::string::npos)
      << insitu_last_message();
  REQUIRE_OK(insitu_session_close(&session));
}
