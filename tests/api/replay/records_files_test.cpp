// The files of records: adaptive meshes, what VTK's reader shows of them, and what damage says.
#include <hdf5.h>
#include <vtkCallbackCommand.h>
#include <vtkCellData.h>
#include <vtkHDFReader.h>
#include <vtkIdList.h>
#include <vtkImageData.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include "records.h"

using namespace records;

namespace {

struct RecordFiles : Records {
  /// Records one step of a mesh; returns the file's path.
  std::string record(const std::function<void(insitu_session, Arrays&)>& give,
                     const std::string& name = "step_7.hdf") {
    insitu_session session = nullptr;
    check(insitu_session_open(nullptr, &session));
    Arrays arrays;
    give(session, arrays);
    check(insitu_session_execute(session, 7, 0.5));
    check(insitu_session_record(session, path(name).c_str()));
    check(insitu_session_close(&session));
    return path(name);
  }
  static void give_cubes(insitu_session session, Arrays& arrays, bool ghosts = false) {
    const Lattice lattice(3);
    const insitu_mesh mesh = mesh_of(session);
    for (const int piece : {0, 1}) {
      const Lattice moved(3, piece);
      const insitu_array points = arrays.keep(moved.points, 3);
      check(insitu_mesh_points(mesh, piece, &points, 1));
      insitu_cells cells = insitu_cells_default();
      cells.connectivity = arrays.keep(lattice.ids, 8);
      cells.count = 27;
      check(insitu_mesh_cells(mesh, piece, &cells));
      if (ghosts) {
        std::vector<std::uint8_t> of_cells(27, 0);
        of_cells[5] = 4;
        const insitu_array array = arrays.keep(of_cells);
        check(insitu_mesh_ghosts(mesh, piece, &array, INSITU_GHOSTS_ASCENT));
      }
      give_fields(mesh, moved, 0.5, arrays, piece);
    }
  }
  static void give_block(insitu_session session, Arrays& arrays) {
    const Lattice lattice(3);
    insitu_block block = insitu_block_default();
    block.kind = INSITU_BLOCK_UNIFORM;
    for (int a = 0; a < 3; ++a) {
      block.vertices[a] = 4;
      block.spacing[a] = 1.0 / 3;
      block.first[a] = a;
    }
    const insitu_mesh mesh = mesh_of(session);
    check(insitu_mesh_block(mesh, 0, &block));
    give_fields(mesh, lattice, 0.5, arrays);
  }
};

/// What VTK's reader makes of a file, without an error.
vtkSmartPointer<vtkDataObject> read_by_vtk(const std::string& file) {
  const auto fail = [](vtkObject*, unsigned long, void*, void* text) {
    ADD_FAILURE() << static_cast<const char*>(text);
  };
  vtkNew<vtkCallbackCommand> errors;
  errors->SetCallback(fail);
  vtkNew<vtkHDFReader> reader;
  reader->AddObserver(vtkCommand::ErrorEvent, errors);
  reader->SetFileName(file.c_str());
  reader->Update();
  return reader->GetOutputDataObject(0);
}

void expect_values(vtkDataArray* array, const std::vector<double>& expected) {
  ASSERT_TRUE(array);
  ASSERT_EQ(array->GetNumberOfValues(), vtkIdType(expected.size()));
  const int components = array->GetNumberOfComponents();
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_EQ(array->GetComponent(vtkIdType(i) / components, int(i) % components), expected[i]);
}

} // namespace

/// Patches whose fields have layers of ghosts, on two levels, which move at a regrid.
TEST_F(RecordFiles, PatchesWithGhosts) {
  same_again([&](insitu_session session, int step, Arrays& arrays) {
    const insitu_mesh mesh = mesh_of(session);
    insitu_amr amr = insitu_amr_default();
    amr.level_count = 2;
    for (int a = 0; a < 3; ++a)
      amr.spacing[a] = 0.25;
    check(insitu_mesh_amr(mesh, &amr));
    for (const int level : {0, 1}) {
      insitu_patch patch = insitu_patch_default();
      patch.level = level;
      for (int a = 0; a < 3; ++a) {
        patch.cells[a] = 4;
        patch.lower[a] = level == 0 ? 0 : (step < 2 ? 2 : 4);
        patch.ghosts_before[a] = patch.ghosts_after[a] = 2;
      }
      if (step == 0 || step == 2)
        check(insitu_mesh_patch(mesh, level, &patch));
      for (const auto& [name, components] : {std::pair{"p", 1}, {"c", 1}, {"u", 3}}) {
        std::vector<double> values(std::size_t(8 * 8 * 8 * components));
        for (std::size_t i = 0; i < values.size(); ++i)
          values[i] = std::sin(0.01 * double(i) + step + level);
        insitu_array array = arrays.keep(values, components);
        const std::int64_t bytes = 8 * components;
        array.data = static_cast<const char*>(array.data) + 2 * (1 + 8 + 64) * bytes;
        array.count = 64;
        for (int a = 0; a < 3; ++a)
          array.extent[a] = 4;
        array.stride[0] = bytes;
        array.stride[1] = 8 * bytes;
        array.stride[2] = 64 * bytes;
        give_field(mesh, name, INSITU_CELL, array, level);
      }
    }
  });
}

/// Leaves that lie behind pointers, with their values.
TEST_F(RecordFiles, LeavesBehindPointers) {
  struct Leaf {
    double p, u[3], c;
    std::int32_t level, corner[3];
  };
  std::deque<std::vector<Leaf>> records; // of all steps
  std::deque<std::vector<const Leaf*>> pointers;
  same_again([&](insitu_session session, int step, Arrays&) {
    std::vector<Leaf>& leaves = records.emplace_back();
    const auto add = [&](std::int32_t level, std::int32_t i, std::int32_t j, std::int32_t k) {
      const double s = std::sin(0.3 * double(leaves.size()) + step);
      leaves.push_back({s, {0.1, s, 0.2}, -s, level, {i, j, k}});
    };
    for (int c = 0; c < 64; ++c)
      if (c != (step < 2 ? 21 : 42))
        add(0, c % 4, c / 4 % 4, c / 16);
      else
        for (int f = 0; f < 8; ++f)
          add(1, 2 * (c % 4) + f % 2, 2 * (c / 4 % 4) + f / 2 % 2, 2 * (c / 16) + f / 4);
    std::vector<const Leaf*>& to = pointers.emplace_back();
    for (const Leaf& leaf : leaves)
      to.push_back(&leaf);
    const auto behind = [&](std::size_t offset, insitu_type type, int components) {
      insitu_array array = insitu_array_of(to.data(), type, std::int64_t(to.size()), components);
      array.indirect = 1;
      array.offset = std::int64_t(offset);
      return array;
    };
    const insitu_mesh mesh = mesh_of(session);
    insitu_amr amr = insitu_amr_default();
    amr.level_count = 2;
    for (int a = 0; a < 3; ++a)
      amr.spacing[a] = 0.25;
    check(insitu_mesh_amr(mesh, &amr));
    insitu_leaves given = insitu_leaves_default();
    given.levels = behind(offsetof(Leaf, level), INSITU_INT32, 1);
    given.corners = behind(offsetof(Leaf, corner), INSITU_INT32, 3);
    check(insitu_mesh_leaves(mesh, 0, &given));
    give_field(mesh, "p", INSITU_CELL, behind(offsetof(Leaf, p), INSITU_FLOAT64, 1));
    give_field(mesh, "u", INSITU_CELL, behind(offsetof(Leaf, u), INSITU_FLOAT64, 3));
    give_field(mesh, "c", INSITU_CELL, behind(offsetof(Leaf, c), INSITU_FLOAT64, 1));
  });
}

/// Leaves of quadtrees, and a patch, in the plane of the scene's points.
TEST_F(RecordFiles, AdaptiveMeshesOfTwoDimensions) {
  same_again([&](insitu_session session, int step, Arrays& arrays) {
    std::vector<std::int32_t> levels, corners;
    for (int c = 0; c < 16; ++c)
      if (c != (step < 2 ? 5 : 10)) {
        levels.push_back(0);
        corners.insert(corners.end(), {c % 4, c / 4});
      } else {
        for (int f = 0; f < 4; ++f) {
          levels.push_back(1);
          corners.insert(corners.end(), {2 * (c % 4) + f % 2, 2 * (c / 4) + f / 2});
        }
      }
    const insitu_mesh mesh = mesh_of(session);
    insitu_amr amr = insitu_amr_default();
    amr.level_count = 2;
    amr.dimensions = 2;
    amr.spacing[0] = amr.spacing[1] = 0.25;
    amr.origin[2] = 0.5;
    check(insitu_mesh_amr(mesh, &amr));
    insitu_leaves leaves = insitu_leaves_default();
    leaves.levels = arrays.keep(levels);
    leaves.corners = arrays.keep(corners, 2);
    check(insitu_mesh_leaves(mesh, 0, &leaves));
    insitu_patch patch = insitu_patch_default();
    patch.level = 1;
    patch.lower[0] = 8;
    patch.cells[0] = 2;
    patch.cells[1] = 8;
    check(insitu_mesh_patch(mesh, 1, &patch));
    for (const int piece : {0, 1})
      for (const auto& [name, components] : {std::pair{"p", 1}, {"c", 1}, {"u", 2}}) {
        std::vector<double> values((piece == 0 ? levels.size() : 16) * std::size_t(components));
        for (std::size_t i = 0; i < values.size(); ++i)
          values[i] = std::sin(0.3 * double(i) + step + piece);
        give_field(mesh, name, INSITU_CELL, arrays.keep(values, components), piece);
      }
  });
}

TEST_F(RecordFiles, VtksReaderShowsCells) {
  const std::string file =
      record([](auto session, Arrays& arrays) { give_cubes(session, arrays); });
  EXPECT_TRUE(vtkNew<vtkHDFReader>()->CanReadFile(file.c_str()));
  const auto shown = read_by_vtk(file);
  auto* const grid = vtkUnstructuredGrid::SafeDownCast(shown);
  ASSERT_TRUE(grid);
  ASSERT_EQ(grid->GetNumberOfCells(), 54);
  ASSERT_EQ(grid->GetNumberOfPoints(), 128);
  std::vector<double> p, u, c;
  for (const int piece : {0, 1}) {
    const Lattice lattice(3, piece);
    for (auto [to, values] : {std::pair{&p, lattice.field(0.5)},
                              {&u, lattice.velocity(0.5)},
                              {&c, lattice.of_cells(0.5)}})
      to->insert(to->end(), values.begin(), values.end());
    double x[3];
    for (vtkIdType v = 0; v < 64; ++v) {
      grid->GetPoint(64 * piece + v, x);
      for (std::size_t a = 0; a < 3; ++a)
        EXPECT_EQ(x[a], lattice.points[3 * std::size_t(v) + a]);
    }
    vtkNew<vtkIdList> ids;
    for (vtkIdType cell = 0; cell < 27; ++cell) {
      EXPECT_EQ(grid->GetCellType(27 * piece + cell), VTK_HEXAHEDRON);
      grid->GetCellPoints(27 * piece + cell, ids);
      ASSERT_EQ(ids->GetNumberOfIds(), 8);
      for (vtkIdType v = 0; v < 8; ++v)
        EXPECT_EQ(ids->GetId(v), 64 * piece + lattice.ids[std::size_t(8 * cell + v)]);
    }
  }
  expect_values(grid->GetPointData()->GetArray("p"), p);
  expect_values(grid->GetPointData()->GetArray("u"), u);
  expect_values(grid->GetCellData()->GetArray("c"), c);
  ASSERT_TRUE(grid->GetFieldData()->GetArray("TimeValue"));
  EXPECT_EQ(grid->GetFieldData()->GetArray("TimeValue")->GetComponent(0, 0), 0.5);
  EXPECT_EQ(contents(path("step.hdf.series")), "{\"file-series-version\": \"1.0\", \"files\": [\n"
                                               "  {\"time\": 0.5, \"name\": \"step_7.hdf\"}\n]}\n");
}

/// Those of another convention are VTK's there.
TEST_F(RecordFiles, VtksReaderShowsGhosts) {
  const std::string file =
      record([](auto session, Arrays& arrays) { give_cubes(session, arrays, true); });
  const auto shown = read_by_vtk(file);
  auto* const grid = vtkUnstructuredGrid::SafeDownCast(shown);
  ASSERT_TRUE(grid);
  vtkDataArray* const ghosts = grid->GetCellData()->GetArray("vtkGhostType");
  ASSERT_TRUE(ghosts);
  for (vtkIdType c = 0; c < 54; ++c)
    EXPECT_EQ(ghosts->GetComponent(c, 0), c % 27 == 5 ? 1 : 0);
}

TEST_F(RecordFiles, VtksReaderShowsAUniformBlock) {
  const std::string file =
      record([](auto session, Arrays& arrays) { give_block(session, arrays); });
  const auto shown = read_by_vtk(file);
  auto* const image = vtkImageData::SafeDownCast(shown);
  ASSERT_TRUE(image);
  ASSERT_EQ(image->GetNumberOfPoints(), 64);
  for (int a = 0; a < 3; ++a) {
    EXPECT_EQ(image->GetOrigin()[a], a * (1.0 / 3));
    EXPECT_EQ(image->GetSpacing()[a], 1.0 / 3);
  }
  const Lattice lattice(3);
  expect_values(image->GetPointData()->GetArray("p"), lattice.field(0.5));
  expect_values(image->GetPointData()->GetArray("u"), lattice.velocity(0.5));
  EXPECT_EQ(image->GetCellData()->GetNumberOfArrays(), 0); // which this reader reads wrongly
}

/// Without what is this library's in it, a record is a VTKHDF file like any other.
TEST_F(RecordFiles, VtkhdfOfOtherProgramsIsRead) {
  const std::string file =
      record([](auto session, Arrays& arrays) { give_cubes(session, arrays, true); });
  ASSERT_EQ(run("--probe points.csv --out record step_7.hdf").code, 0);
  const hid_t hdf = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  ASSERT_GE(H5Ldelete(hdf, "/insitu", H5P_DEFAULT), 0);
  H5Fclose(hdf);
  const Outcome o = run("--probe points.csv --out vtkhdf step_7.hdf");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Row> expected = rows("record/probe.csv"), found = rows("vtkhdf/probe.csv");
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    for (const char* column : {"cycle", "time", "p", "u_y", "c"})
      EXPECT_TRUE(found[i].at(column) == expected[i].at(column) ||
                  (std::isnan(found[i].at(column)) && std::isnan(expected[i].at(column))))
          << i << column;
}

/// A file that is cut short anywhere, or of which any byte is another one, is refused with its name
/// and the path in it, or is as good as before: nothing is answered wrongly.
TEST_F(RecordFiles, DamageIsTold) {
  const std::string file =
      record([](auto session, Arrays& arrays) { give_block(session, arrays); });
  const std::string whole = contents(file);
  const auto probe = [&](const std::string& bytes) {
    std::ofstream(path("bad.hdf"), std::ios::binary) << bytes;
    return run("--probe points.csv --out probed bad.hdf");
  };
  ASSERT_EQ(probe(whole).code, 0);
  const std::string expected = contents(path("probed/probe.csv"));
  for (const std::size_t size :
       {std::size_t(0), std::size_t(100), whole.size() / 2, whole.size() - 1}) {
    const Outcome o = probe(whole.substr(0, size));
    EXPECT_EQ(o.code, 1) << size;
    EXPECT_NE(o.err.find("bad.hdf: "), std::string::npos) << o.err;
  }
  int refused = 0;
  constexpr std::size_t tries = 24;
  for (std::size_t i = 0; i < tries; ++i) {
    std::string bytes = whole;
    bytes[i * (whole.size() - 1) / (tries - 1)] ^= 0x55;
    const Outcome o = probe(bytes);
    if (o.code == 0) {
      EXPECT_EQ(contents(path("probed/probe.csv")), expected) << i;
      continue;
    }
    ++refused;
    EXPECT_EQ(o.code, 1) << i << o.err;
    EXPECT_NE(o.err.find("bad.hdf: "), std::string::npos) << i << o.err;
    EXPECT_EQ(o.err.find("HDF5-DIAG"), std::string::npos);
  }
  EXPECT_GT(refused, 4);
}

TEST_F(RecordFiles, AreOfTheLastExecuteAlone) {
  insitu_session session = nullptr;
  check(insitu_session_open(nullptr, &session));
  Arrays arrays;
  give_block(session, arrays);
  EXPECT_EQ(insitu_session_record(session, path("early.hdf").c_str()), INSITU_ERROR_ORDER);
  check(insitu_session_execute(session, 0, 0.0));
  EXPECT_EQ(insitu_session_record(session, path("no/such/place.hdf").c_str()), INSITU_OK);
  EXPECT_EQ(insitu_session_record(session, "/proc/none/x.hdf"), INSITU_ERROR_FILE);
  EXPECT_NE(std::string(insitu_last_message()).find("/proc/none"), std::string::npos);
  check(insitu_mesh_changed(mesh_of(session), INSITU_CHANGED_FIELDS));
  EXPECT_EQ(insitu_session_record(session, path("late.hdf").c_str()), INSITU_ERROR_ORDER);
  EXPECT_FALSE(fs::exists(path("early.hdf")));
  EXPECT_FALSE(fs::exists(path("late.hdf")));
  check(insitu_session_close(&session));
}
