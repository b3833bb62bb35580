// insitu-replay on what other programs write: all steps of a run in one file or folder; and
// --check.
#include "replay.h"

#ifdef REPLAY_EXODUS
#include <vtkExodusIIWriter.h>
#endif
#ifdef REPLAY_NETCDF
#include <netcdf.h>
#endif

using namespace vtk_meshes;

namespace {

struct Elsewhere : Replay {
  void foam(const std::string& name, const std::string& kind, const std::string& body) const {
    fs::create_directories((folder / name).parent_path());
    put(name, "FoamFile { version 2.0; format ascii; class " + kind + "; object " +
                  fs::path(name).filename().string() + "; }\n" + body);
  }
  /// A case of two cubes along x, of which the field p is 3 and 4 at time 0, and 5 and 6 at time
  /// 0.5.
  void write_case() const {
    foam("case/system/controlDict", "dictionary",
         "application icoFoam; startFrom startTime; startTime 0; stopAt endTime; endTime 0.5;\n"
         "deltaT 0.5; writeControl timeStep; writeInterval 1; writeFormat ascii;\n");
    foam("case/constant/polyMesh/points", "vectorField",
         "12\n(\n(0 0 0)\n(1 0 0)\n(2 0 0)\n(0 1 0)\n(1 1 0)\n(2 1 0)\n"
         "(0 0 1)\n(1 0 1)\n(2 0 1)\n(0 1 1)\n(1 1 1)\n(2 1 1)\n)\n");
    foam("case/constant/polyMesh/faces", "faceList",
         "11\n(\n4(1 4 10 7)\n4(0 6 9 3)\n4(2 5 11 8)\n4(0 1 7 6)\n4(1 2 8 7)\n4(3 9 10 4)\n"
         "4(4 10 11 5)\n4(0 3 4 1)\n4(1 4 5 2)\n4(6 7 10 9)\n4(7 8 11 10)\n)\n");
    foam("case/constant/polyMesh/owner", "labelList",
         "11\n(\n0\n0\n1\n0\n1\n0\n1\n0\n1\n0\n1\n)\n");
    foam("case/constant/polyMesh/neighbour", "labelList", "1\n(\n1\n)\n");
    foam("case/constant/polyMesh/boundary", "polyBoundaryMesh",
         "1\n(\nwalls { type wall; nFaces 10; startFace 1; }\n)\n");
    for (const auto& [time, values] : {std::pair{"0", "3 4"}, {"0.5", "5 6"}})
      foam(std::string("case/") + time + "/p", "volScalarField",
           std::string("dimensions [0 2 -2 0 0 0 0]; internalField nonuniform List<scalar> 2(") +
               values + "); boundaryField { walls { type zeroGradient; } }\n");
  }
};

} // namespace

#ifdef REPLAY_OPENFOAM
TEST_F(Elsewhere, ACaseOfOpenFoamWithAllItsTimes) {
  write_case();
  put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: [[0.5, 0.5, 0.5], [1.5, 0.5, 0.5]], "
                    "fields: [p]}\n");
  put("case/case.foam", "");
  for (const std::string name : {"case", "case/case.foam"}) {
    const Outcome o = run("--scene scene.yaml --out out " + name);
    ASSERT_EQ(o.code, 0) << o.err;
    const std::vector<Row> table = rows("out/g.csv");
    ASSERT_EQ(table.size(), 4u) << name;
    const double p[] = {3, 4, 5, 6}, time[] = {0, 0, 0.5, 0.5}, cycle[] = {0, 0, 1, 1};
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(table[i].at("p"), p[i]);
      EXPECT_EQ(table[i].at("time"), time[i]);
      EXPECT_EQ(table[i].at("cycle"), cycle[i]);
      EXPECT_EQ(table[i].at("cell"), double(i % 2));
    }
  }
  fs::remove(folder / "case/constant/polyMesh/owner");
  const Outcome o = run("--scene scene.yaml --out out case");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("case: "), std::string::npos) << o.err;
}
#endif

#ifdef REPLAY_EXODUS
TEST_F(Elsewhere, Exodus) {
  const auto grid = unstructured(2, {VTK_HEXAHEDRON}, 0.0);
  { // which closes the file
    vtkNew<vtkExodusIIWriter> writer;
    writer->SetFileName(path("run.exo").c_str());
    writer->SetInputData(grid);
    writer->Write();
  }
  const Outcome o = run("--scene scene.yaml --out out run.exo");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Row> table = rows("out/g.csv");
  ASSERT_EQ(table.size(), 3u);
  EXPECT_NEAR(table[0].at("linear"), linear({0.4, 0.3, 0.2}),
              1e-12); // of weights of rounded numbers
  EXPECT_NEAR(table[1].at("linear"), linear({1.5, 1.5, 1.5}), 1e-12);
  EXPECT_TRUE(std::isnan(table[2].at("linear")));
  const std::string whole_file = contents(path("run.exo"));
  for (const std::size_t length : {std::size_t(0), std::size_t(100), whole_file.size() / 4,
                                   whole_file.size() / 2, whole_file.size() - 100}) {
    put("cut.exo", whole_file.substr(0, length));
    const Outcome cut = run("--scene scene.yaml --out out_cut cut.exo");
    EXPECT_EQ(cut.code, 1) << length << " of " << whole_file.size();
    EXPECT_NE(cut.err.find("cut.exo"), std::string::npos) << length << ": " << cut.err;
  }
}
#endif

#ifdef REPLAY_NETCDF
/// Longitudes, latitudes and depths of the CF conventions: VTK's reader makes depths heights.
TEST_F(Elsewhere, LayersInLongitudeAndLatitude) {
  int file = 0, dims[4], time = 0, axes[3], temp = 0;
  ASSERT_EQ(nc_create(path("sea.nc").c_str(), NC_CLOBBER, &file), NC_NOERR);
  nc_def_dim(file, "time", 2, &dims[0]);
  nc_def_dim(file, "lev", 3, &dims[1]);
  nc_def_dim(file, "lat", 4, &dims[2]);
  nc_def_dim(file, "lon", 5, &dims[3]);
  const auto define = [&](const char* name, int dim, const char* units) {
    int id = 0;
    nc_def_var(file, name, NC_DOUBLE, 1, &dims[dim], &id);
    nc_put_att_text(file, id, "units", std::string(units).size(), units);
    return id;
  };
  time = define("time", 0, "days since 2000-01-01");
  axes[0] = define("lev", 1, "m");
  nc_put_att_text(file, axes[0], "positive", 4, "down");
  axes[1] = define("lat", 2, "degrees_north");
  axes[2] = define("lon", 3, "degrees_east");
  nc_def_var(file, "temp", NC_DOUBLE, 4, dims, &temp);
  nc_enddef(file);
  std::vector<double> values(120);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = double(i);
  const double times[] = {0, 1}, levels[] = {0, 10, 30}, lats[] = {40, 41, 42, 43},
               lons[] = {0, 1, 2, 3, 4};
  nc_put_var_double(file, time, times);
  nc_put_var_double(file, axes[0], levels);
  nc_put_var_double(file, axes[1], lats);
  nc_put_var_double(file, axes[2], lons);
  nc_put_var_double(file, temp, values.data());
  ASSERT_EQ(nc_close(file), NC_NOERR);
  put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: [[1, 41, -10], [1.5, 41.5, -5]], "
                    "frame: mesh, fields: [temp]}\n");
  for (const std::string said : {"", "--frame geodetic ", "--frame cartesian "}) {
    const Outcome o = run("--scene scene.yaml " + said + "--out out sea.nc");
    ASSERT_EQ(o.code, 0) << o.err;
    const std::vector<Row> table = rows("out/g.csv");
    ASSERT_EQ(table.size(), 4u);
    EXPECT_EQ(table[0].at("temp"), 26.0); // level 1, latitude 1, longitude 1
    EXPECT_EQ(table[1].at("temp"), 19.0); // the mean of eight
    EXPECT_EQ(table[2].at("temp"), 86.0);
    EXPECT_EQ(table[3].at("time"), 86400.0);
    fs::remove_all(folder / "out");
  }
  const std::string whole = contents(path("sea.nc"));
  put("cut.nc", whole.substr(0, whole.size() - 500)); // of which the netCDF library reads zeros
  const Outcome cut = run("--scene scene.yaml --out out cut.nc");
  EXPECT_EQ(cut.code, 1);
  EXPECT_NE(cut.err.find("cut.nc: variable 'temp': its values end at byte " +
                         std::to_string(whole.size())),
            std::string::npos)
      << cut.err;
  // Points in a frame of the Earth are found, as the file's units tell the mesh's.
  put("globe.yaml", "insitu: 1\nprobes:\n  - {name: g, points: [[1, 41, -10]], frame: geodetic, "
                    "fields: [temp]}\n");
  EXPECT_EQ(run("--scene globe.yaml --out out sea.nc").code, 0);
  EXPECT_NEAR(rows("out/g.csv").at(0).at("temp"), 26.0, 1e-9);
}
#endif

TEST_F(Elsewhere, CheckIsADryRun) {
  mesh("m_0.vtu", 0.0, 40, 4.0);
  put("good.yaml",
      "insitu: 1\nevery: 5\nprobes:\n  - {name: g, points: points.csv, fields: [linear], "
      "output: [csv, netcdf]}\nframes:\n  - {name: f, volume: {field: linear}, every: 10}\n"
      "checkpoint: {every: 100}\n");
  Outcome o = run("--check --scene good.yaml --out nothing m_0.vtu");
  EXPECT_EQ(o.code, 0) << o.err;
  for (const char* line :
       {"mesh 'mesh': 8 cells, 27 vertices\n", "  field 'linear' on vertices, 1 component\n",
        "1 step\n", "  nothing/g.csv (every 5)\n", "  nothing/g.nc (every 5)\n",
        "  nothing/f_*.png (every 10)\n", "  nothing/checkpoint_*.insitu (every 100)\n",
        " are kept"})
    EXPECT_NE(o.out.find(line), std::string::npos) << line << "\n" << o.out;
  EXPECT_FALSE(fs::exists(folder / "nothing"));
  put("field.yaml", "insitu: 1\nprobes:\n  - {name: g, points: points.csv, fields: [liner]}\n");
  o = run("--check --scene field.yaml m_0.vtu");
  EXPECT_EQ(o.code, 3);
  EXPECT_NE(o.err.find("probe 'g' of mesh 'mesh': "), std::string::npos) << o.err;
  EXPECT_NE(o.err.find("did you mean 'linear'?"), std::string::npos) << o.err;
  put("key.yaml", "insitu: 1\nprobse: []\n");
  o = run("--check --scene key.yaml m_0.vtu");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("did you mean 'probes'?"), std::string::npos) << o.err;
  EXPECT_EQ(run("--check --plan --scene good.yaml m_0.vtu").code, 2);
}

/// Of an index entries of one time go by their names, whatever their order in it.
TEST_F(Elsewhere, SeriesGoByTimeThenByName) {
  for (int i = 0; i < 3; ++i)
    mesh("m_" + std::to_string(i) + ".vtu", i, 0);
  put("m.series",
      "{\"file-series-version\": \"1.0\", \"files\": [{\"name\": \"m_2.vtu\", \"time\": 1}, "
      "{\"name\": \"m_1.vtu\", \"time\": 1}, {\"name\": \"m_0.vtu\", \"time\": 0}]}");
  const Outcome o = run("--scene scene.yaml --out out m.series");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Row> table = rows("out/g.csv");
  ASSERT_EQ(table.size(), 9u);
  for (std::size_t i = 0; i < 3; ++i) { // their cycles are all 0, and counted on
    EXPECT_EQ(table[3 * i].at("cycle"), double(i));
    EXPECT_NEAR(table[3 * i].at("linear"), table[0].at("linear") + double(i), 1e-12);
  }
}
