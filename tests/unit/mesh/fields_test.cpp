// Fields, ghost conventions, the copy audit, and reads within the arrays alone.
#include <gtest/gtest.h>

#include "accel/tree/value_ranges.h"
#include "core/status.h"
#include "fixtures/committed.h"

using namespace insitu;
using math::Vec3d;

namespace {

test::TestMesh box(test::MeshKind kind, int size) {
  return test::make_mesh({.kind = kind, .size = size}, 21);
}

std::string message_of(const std::function<void()>& call, insitu_status status) {
  try {
    call();
  } catch (const core::Error& e) {
    EXPECT_EQ(e.status(), status) << e.what();
    return e.what();
  }
  return "no error";
}

void expect_in(const std::string& text, const std::string& message) {
  EXPECT_NE(message.find(text), std::string::npos) << message;
}

} // namespace

TEST(Fields, AnyComponentCountAndOrder) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 2));
  const auto n = std::size_t(m.arrays.vertex_count());
  for (const int components : {1, 2, 3, 6, 9}) {
    const auto c_count = std::size_t(components);
    std::vector<float> together(n * c_count), columns(n * c_count);
    for (std::size_t v = 0; v < n; ++v)
      for (std::size_t c = 0; c < c_count; ++c)
        together[v * c_count + c] = columns[c * n + v] = float(v) + 1000 * float(c);
    insitu_array a = insitu_array_of(together.data(), INSITU_FLOAT32, std::int64_t(n), components);
    m.mesh.mesh().set_field(0, "together", INSITU_VERTEX, &a, 1);
    a.data = columns.data();
    a.component_stride = std::int64_t(4 * n);
    m.mesh.mesh().set_field(0, "columns", INSITU_VERTEX, &a, 1);
    m.commit();
    for (const char* name : {"together", "columns"}) {
      const mesh::FieldView f = m.mesh.mesh().field(name);
      ASSERT_EQ(f.components, components);
      for (std::size_t v = 0; v < n; ++v)
        for (int c = 0; c < components; ++c)
          ASSERT_EQ(f.pieces[0].load(std::int64_t(v), c), double(v) + 1000.0 * c) << name;
    }
  }
}

TEST(Fields, ThatDoNotFitAreRefusedByName) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 2));
  mesh::Mesh& mesh = m.mesh.mesh();
  const std::vector<double> values(27);
  const auto give = [&](std::int64_t count, insitu_association association) {
    const insitu_array a = insitu_array_of(values.data(), INSITU_FLOAT64, count, 1);
    mesh.set_field(0, "pressure", association, &a, 1);
  };
  give(26, INSITU_VERTEX);
  expect_in("26 values for 27 vertices", message_of([&] { m.commit(); }, INSITU_ERROR_FIELD));
  give(9, INSITU_CELL);
  expect_in("9 values for 8 cells", message_of([&] { m.commit(); }, INSITU_ERROR_FIELD));
  give(8, INSITU_CELL);
  m.commit();
  expect_in("did you mean 'pressure'",
            message_of([&] { (void)mesh.field("presure"); }, INSITU_ERROR_FIELD));
  expect_in("association",
            message_of([&] { give(8, insitu_association(2)); }, INSITU_ERROR_ARGUMENT));
  expect_in("empty", message_of(
                         [&] {
                           const insitu_array a =
                               insitu_array_of(values.data(), INSITU_FLOAT64, 8, 1);
                           mesh.set_field(0, "", INSITU_CELL, &a, 1);
                         },
                         INSITU_ERROR_ARGUMENT));
  // A second piece must have the field as well, with as many components.
  const insitu_array points = m.arrays.point_array();
  const insitu_cells cells = m.arrays.cells();
  mesh.set_points(1, &points, 1);
  mesh.set_cells(1, &cells);
  expect_in("piece 1 has no values", message_of([&] { m.commit(); }, INSITU_ERROR_FIELD));
  const insitu_array pair = insitu_array_of(values.data(), INSITU_FLOAT64, 8, 2);
  expect_in("2 components on cells, but other pieces have 1",
            message_of([&] { mesh.set_field(1, "pressure", INSITU_CELL, &pair, 1); },
                       INSITU_ERROR_ARGUMENT));
  const insitu_array one = insitu_array_of(values.data(), INSITU_FLOAT64, 8, 1);
  mesh.set_field(1, "pressure", INSITU_CELL, &one, 1);
  m.commit();
  EXPECT_EQ(mesh.view().cell_count(), 16);
}

TEST(Ghosts, CountByTheirConvention) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 2));
  mesh::Mesh& mesh = m.mesh.mesh();
  // VTK: duplicate 1, refined 8, hidden 32 take a cell out; exterior 16 and the like do not.
  const std::uint8_t bits[8] = {0, 1, 2, 4, 8, 16, 32, 255};
  const insitu_array a = insitu_array_of(bits, INSITU_UINT8, 8, 1);
  const auto owned = [&](insitu_ghost_convention convention) {
    mesh.set_ghosts(0, &a, convention);
    m.commit();
    std::string out;
    for (std::int64_t c = 0; c < 8; ++c)
      out += mesh.view().pieces[0].owns(c) ? '1' : '0';
    EXPECT_EQ(std::count(out.begin(), out.end(), '1'), m.mesh.tree().cell_count());
    return out;
  };
  EXPECT_EQ(owned(INSITU_GHOSTS_VTK), "10110100");
  EXPECT_EQ(owned(INSITU_GHOSTS_ASCENT), "10000000");
  insitu_array shorter = a;
  shorter.count = 7;
  mesh.set_ghosts(0, &shorter, INSITU_GHOSTS_VTK);
  expect_in("7 ghost values for 8 cells", message_of([&] { m.commit(); }, INSITU_ERROR_MESH));
  insitu_array wide = a;
  wide.components = 2;
  expect_in("one uint8 a cell", message_of([&] { mesh.set_ghosts(0, &wide, INSITU_GHOSTS_VTK); },
                                           INSITU_ERROR_ARGUMENT));
  expect_in("convention", message_of([&] { mesh.set_ghosts(0, &a, insitu_ghost_convention(2)); },
                                     INSITU_ERROR_ARGUMENT));
}

TEST(Audit, ShowsThePointersThatKernelsRead) {
  fixtures::Committed m(box(test::MeshKind::mixed, 2));
  const auto n = std::size_t(m.arrays.vertex_count());
  std::vector<double> u(n, 1), v(n, 2);
  insitu_array velocity[2] = {insitu_array_of(u.data(), INSITU_FLOAT64, std::int64_t(n), 1),
                              insitu_array_of(v.data(), INSITU_FLOAT64, std::int64_t(n), 1)};
  velocity[1].converted = "was int32";
  m.mesh.mesh().set_field(0, "velocity", INSITU_VERTEX, velocity, 2);
  m.commit();
  const mesh::PieceView& piece = m.mesh.mesh().view().pieces[0];
  const mesh::FieldView field = m.mesh.mesh().field("velocity");
  const std::vector<insitu_audit_entry> audit = m.mesh.mesh().audit();
  const auto entry = [&](const std::string& name) {
    for (const insitu_audit_entry& e : audit)
      if (e.name == name)
        return e;
    ADD_FAILURE() << name;
    return insitu_audit_entry{};
  };
  ASSERT_EQ(audit.size(), 6u);
  EXPECT_EQ(entry("piece 0 points").data, m.arrays.points.data());
  EXPECT_EQ(entry("piece 0 points").data, static_cast<const void*>(piece.points.component[0]));
  EXPECT_EQ(entry("piece 0 points").bytes, std::int64_t(24 * n));
  EXPECT_EQ(entry("piece 0 connectivity").data, m.arrays.ids.data());
  EXPECT_EQ(entry("piece 0 connectivity").data, static_cast<const void*>(piece.connectivity.data));
  EXPECT_EQ(entry("piece 0 types").data, static_cast<const void*>(piece.types));
  EXPECT_EQ(entry("piece 0 offsets").data, static_cast<const void*>(piece.offsets.data));
  EXPECT_EQ(entry("piece 0 field 'velocity' component 0").data, u.data());
  EXPECT_EQ(entry("piece 0 field 'velocity' component 0").data,
            static_cast<const void*>(field.pieces[0].component[0]));
  EXPECT_EQ(entry("piece 0 field 'velocity' component 0").borrowed, 1);
  EXPECT_EQ(entry("piece 0 field 'velocity' component 1").data,
            static_cast<const void*>(field.pieces[0].component[1]));
  EXPECT_EQ(entry("piece 0 field 'velocity' component 1").borrowed, 0);
  EXPECT_STREQ(entry("piece 0 field 'velocity' component 1").reason, "was int32");
  std::int64_t borrowed = 0;
  for (const insitu_audit_entry& e : audit)
    borrowed += e.borrowed ? e.bytes : 0;
  EXPECT_EQ(m.mesh.mesh().bytes_borrowed(), borrowed);
  // Strict mode names the copy.
  m.mesh.mesh().set_changed(INSITU_CHANGED_FIELDS);
  expect_in("'velocity' component 1: strict mode refuses a copy (was int32)",
            message_of([&] { m.mesh.commit(m.threads, m.log, m.memory, true); },
                       INSITU_ERROR_CONVERSION));
}

// Every array ends (or begins) at a page that must not be touched.
TEST(Views, ReadWithinTheArraysAlone) {
  using fixtures::GuardedBytes;
  for (const auto where : {GuardedBytes::At::end, GuardedBytes::At::start})
    for (const auto kind :
         {test::MeshKind::hexahedra, test::MeshKind::tetrahedra, test::MeshKind::wedges,
          test::MeshKind::pyramids, test::MeshKind::mixed})
      for (const int layout : {0, 1, 2}) { // by shape, mixed, padded
        const fixtures::SolverArrays arrays{box(kind, 5)};
        std::vector<std::int32_t> padded;
        for (std::size_t c = 0; c < arrays.types.size(); ++c)
          for (std::int64_t v = arrays.offsets[c]; v < arrays.offsets[c] + 8; ++v)
            padded.push_back(v < arrays.offsets[c + 1] ? arrays.ids[std::size_t(v)] : -1);
        std::vector<std::int64_t> starts = arrays.offsets;
        starts.pop_back(); // n offsets, not n + 1
        const std::vector<std::uint8_t> ghosts(arrays.types.size(), 0);
        const GuardedBytes points = GuardedBytes::copy_of(arrays.points, where),
                           ids = GuardedBytes::copy_of(layout == 2 ? padded : arrays.ids, where),
                           types = GuardedBytes::copy_of(arrays.types, where),
                           offsets = GuardedBytes::copy_of(starts, where),
                           ghost_bits = GuardedBytes::copy_of(ghosts, where),
                           values = GuardedBytes::copy_of(arrays.points, where);
        insitu_cells cells = arrays.cells();
        if (layout == 2) {
          cells.layout = INSITU_LAYOUT_PADDED;
          cells.shape = INSITU_HEXAHEDRON;
          cells.connectivity = insitu_array_of(ids.data(), INSITU_INT32, cells.count, 8);
        } else if (layout == 1 || !arrays.uniform) {
          cells.layout = INSITU_LAYOUT_MIXED;
          cells.connectivity =
              insitu_array_of(ids.data(), INSITU_INT32, std::int64_t(arrays.ids.size()), 1);
          cells.types = insitu_array_of(types.data(), INSITU_UINT8, cells.count, 1);
          cells.offsets = insitu_array_of(offsets.data(), INSITU_INT64, cells.count, 1);
        } else {
          cells.connectivity.data = ids.data();
        }
        const insitu_array xyz =
            insitu_array_of(points.data(), INSITU_FLOAT64, arrays.vertex_count(), 3);
        const insitu_array f =
            insitu_array_of(values.data(), INSITU_FLOAT64, arrays.vertex_count(), 3);
        const insitu_array bits = insitu_array_of(ghost_bits.data(), INSITU_UINT8, cells.count, 1);
        fixtures::Committed m;
        mesh::Mesh& mesh = m.mesh.mesh();
        mesh.set_points(0, &xyz, 1);
        mesh.set_cells(0, &cells);
        mesh.set_ghosts(0, &bits, INSITU_GHOSTS_VTK);
        mesh.set_field(0, "f", INSITU_VERTEX, &f, 1);
        m.commit();
        m.commit(INSITU_CHANGED_GEOMETRY);
        mesh.keep_earlier({{"f"}}, m.threads);
        const mesh::FieldView field = mesh.field("f");
        const accel::ValueRanges ranges(m.mesh.tree(), mesh.view(), field, -1, m.threads, m.memory);
        EXPECT_GT(ranges.max(), 0);
        std::vector<Vec3d> at;
        for (std::int64_t c = 0; c < cells.count; ++c) {
          mesh::CellVertices cell;
          mesh::gather(mesh.view(), c, cell);
          Vec3d mean{};
          for (int v = 0; v < cell.count; ++v)
            mean += cell.x[v] / double(cell.count);
          at.push_back(mean);
        }
        std::vector<query::Location> found(at.size());
        const query::Sampler sampler = m.sampler();
        sampler.locate(m.threads, at, found);
        for (std::size_t i = 0; i < at.size(); ++i) {
          ASSERT_EQ(found[i].cell, std::int64_t(i));
          double value[3];
          sampler.interpolate(field, found[i], value);
          ASSERT_NEAR(value[0], at[i].x, 1e-12);
        }
      }
}

namespace {

/// Commits, refits and locates with coordinates in guarded memory: item i at first + i stride, its
/// components `component` bytes apart.
template <class Real>
void check_guarded(test::MeshKind kind, std::int64_t first, std::int64_t stride,
                   std::int64_t component, std::size_t size, fixtures::GuardedBytes::At where) {
  const fixtures::SolverArrays arrays{box(kind, 4)};
  const fixtures::GuardedBytes memory(size, where);
  for (std::int64_t v = 0; v < arrays.vertex_count(); ++v)
    for (std::int64_t c = 0; c < 3; ++c) {
      const auto x = Real(arrays.points[std::size_t(3 * v + c)]);
      std::memcpy(memory.data() + first + v * stride + c * component, &x, sizeof x);
    }
  std::vector<std::int64_t> wide(arrays.ids.begin(), arrays.ids.end());
  const fixtures::GuardedBytes ids = fixtures::GuardedBytes::copy_of(wide, where);
  insitu_array points =
      insitu_array_of(memory.data() + first, sizeof(Real) == 4 ? INSITU_FLOAT32 : INSITU_FLOAT64,
                      arrays.vertex_count(), 3);
  points.stride[0] = stride;
  points.component_stride = component;
  insitu_cells cells = arrays.cells();
  cells.connectivity.data = ids.data();
  cells.connectivity.type = INSITU_INT64;
  fixtures::Committed m;
  m.mesh.mesh().set_points(0, &points, 1);
  m.mesh.mesh().set_cells(0, &cells);
  m.commit();
  ASSERT_EQ(m.commit(INSITU_CHANGED_GEOMETRY).action, INSITU_REFIT);
  std::vector<Vec3d> at(std::size_t(arrays.vertex_count()));
  for (std::size_t v = 0; v < at.size(); ++v)
    at[v] = m.mesh.mesh().view().pieces[0].point(std::int64_t(v));
  std::vector<query::Location> found(at.size());
  m.sampler().locate(m.threads, at, found);
  for (const query::Location& f : found)
    ASSERT_TRUE(f);
}

template <class Real>
void check_guarded_layouts() {
  using At = fixtures::GuardedBytes::At;
  constexpr auto item = std::int64_t(sizeof(Real));
  for (const auto kind : {test::MeshKind::hexahedra, test::MeshKind::tetrahedra,
                          test::MeshKind::wedges, test::MeshKind::pyramids}) {
    const auto n = fixtures::SolverArrays(box(kind, 4)).vertex_count();
    for (const At where : {At::end, At::start}) {
      for (const std::int64_t record : {3 * item, 3 * item + 1, 4 * item, 7 * item + 3}) {
        const std::int64_t size = (n - 1) * record + 3 * item; // no padding after the last
        check_guarded<Real>(kind, 0, record, item, std::size_t(size), where);
        check_guarded<Real>(kind, (n - 1) * record, -record, item, std::size_t(size), where);
        // Components from z to x.
        check_guarded<Real>(kind, 2 * item, record, -item, std::size_t(size), where);
      }
      check_guarded<Real>(kind, 0, item, n * item, std::size_t(3 * n * item), where);
    }
  }
}

} // namespace

TEST(Views, ReadCoordinatesOfAnyLayoutWithinThem) {
  check_guarded_layouts<double>();
  check_guarded_layouts<float>();
}
