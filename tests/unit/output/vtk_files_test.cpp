#include <gtest/gtest.h>

#include "core/status.h"
#include "output/vtk/file_series.h"
#include "output/vtk/xml_text.h"
#include "output/vtk/xml_vtk.h"
#include "unit/output/folder.h"

namespace {

using insitu::core::Error;
using namespace insitu::output;
using test::content;
using test::Folder;
using test::put;

TEST(VtkFiles, CountsThatDoNotFitAreNamed) {
  const Folder folder;
  const std::vector<double> xyz(9), two(2);
  VtkPolyData data;
  data.points = vtk_array("Points", xyz, 3);
  data.point_data = {vtk_array("age", two)};
  try {
    write_vtp(folder / "p.vtp", data);
    FAIL() << "written";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), INSITU_ERROR_ARGUMENT);
    EXPECT_NE(std::string(error.what()).find("'age': 3 items expected, 2 given"), std::string::npos)
        << error.what();
  }
  data.point_data.clear();
  for (const std::vector<std::int64_t>& ends :
       {std::vector<std::int64_t>{2}, {2, 1, 3}, {4}, {-1, 3}, {1, 1, 3}}) {
    data.line_ends = ends;
    EXPECT_THROW(write_vtp(folder / "p.vtp", data), Error);
  }
  const std::vector<std::int64_t> ends{2}, ids{0, 3};
  data.line_ends = ends;
  data.line_points = ids;
  EXPECT_THROW(write_vtp(folder / "p.vtp", data), Error);
  data.line_ends = {};
  data.line_points = {};
  for (const std::vector<std::int64_t>& quads :
       {std::vector<std::int64_t>{0, 1, 2}, {0, 1, 2, 3}, {0, 1, 2, -1}, {0, 1, 2, 0, 1}}) {
    data.quads = quads;
    EXPECT_THROW(write_vtp(folder / "p.vtp", data), Error);
  }
  EXPECT_THROW(vtk_array("v", two, 3), Error);
  EXPECT_EQ(folder.count(), 0u);
}

TEST(Pvd, EachAddLeavesAWholeIndex) {
  const Folder folder;
  const std::string path = folder / "drifters.pvd";
  FileSeries series(path);
  series.add(0, "d_0.vtp");
  series.add(0.1, "a&b\"<.vtp");
  EXPECT_EQ(content(path),
            "<?xml version=\"1.0\"?>\n"
            "<VTKFile type=\"Collection\" version=\"1.0\">\n <Collection>\n"
            "  <DataSet timestep=\"0\" part=\"0\" file=\"d_0.vtp\"/>\n"
            "  <DataSet timestep=\"0.1\" part=\"0\" file=\"a&amp;b&quot;&lt;.vtp\"/>\n"
            " </Collection>\n</VTKFile>\n");
}

TEST(Pvd, ARestartedRunContinues) {
  const Folder folder;
  const std::string path = folder / "drifters.pvd";
  {
    FileSeries series(path, true); // nothing there yet
    for (int i = 0; i < 5; ++i) {
      series.add(0.1 * i, "a & b_" + std::to_string(i) + ".vtp");
    }
  }
  FileSeries series(path, true);
  ASSERT_EQ(series.entries().size(), 5u);
  EXPECT_EQ(series.entries()[3].first, 0.1 * 3);
  EXPECT_EQ(series.entries()[3].second, "a & b_3.vtp");
  series.add(0.1 * 2, "again.vtp"); // from a checkpoint: later entries go
  ASSERT_EQ(series.entries().size(), 3u);
  EXPECT_EQ(series.entries()[2].second, "again.vtp");
  EXPECT_EQ(FileSeries(path).entries().size(), 0u);
}

TEST(Pvd, TimesMayDescend) {
  const Folder folder;
  const std::string path = folder / "drifters.pvd";
  {
    FileSeries series(path, true, true);
    for (int i = 5; i-- > 0;) {
      series.add(0.1 * i, "d_" + std::to_string(i) + ".vtp");
    }
    ASSERT_EQ(series.entries().size(), 5u);
  }
  FileSeries series(path, true, true);
  series.add(0.1 * 2, "again.vtp"); // from a checkpoint: those that came after go
  ASSERT_EQ(series.entries().size(), 3u);
  EXPECT_EQ(series.entries()[0].first, 0.1 * 4);
  EXPECT_EQ(series.entries()[2].second, "again.vtp");
  series.add(0.1, "on.vtp");
  EXPECT_EQ(series.entries().size(), 4u);
}

TEST(Pvd, AForeignIndexIsNotContinued) {
  const Folder folder;
  put(folder / "x.pvd", "<?xml version=\"1.0\"?>\n<VTKFile>\n<Other/>\n</VTKFile>\n");
  EXPECT_THROW(FileSeries(folder / "x.pvd", true), Error);
}

TEST(Series, IsParaViewsJsonAndContinues) {
  const Folder folder;
  const std::string path = folder / "run.hdf.series";
  {
    FileSeries series(path, true);
    series.add(0, "run_0.hdf");
    series.add(0.1, "a\\b\"\n.hdf");
    series.add(0.2, "run_2.hdf");
  }
  EXPECT_EQ(content(path), "{\"file-series-version\": \"1.0\", \"files\": [\n"
                           "  {\"time\": 0, \"name\": \"run_0.hdf\"},\n"
                           "  {\"time\": 0.1, \"name\": \"a\\\\b\\\"\\u000a.hdf\"},\n"
                           "  {\"time\": 0.2, \"name\": \"run_2.hdf\"}\n"
                           "]}\n");
  FileSeries series(path, true);
  ASSERT_EQ(series.entries().size(), 3u);
  EXPECT_EQ(series.entries()[1].second, "a\\b\"\n.hdf");
  series.add(0.15, "again.hdf");
  ASSERT_EQ(series.entries().size(), 3u);
  EXPECT_EQ(series.entries()[2].second, "again.hdf");
}

TEST(XmlText, EscapesAndBack) {
  const std::string text = "a<b>&\"c\"\n\r &amp;";
  EXPECT_EQ(xml_unescape(xml_escape(text)), text);
  EXPECT_EQ(xml_escape(text).find('<'), std::string::npos);
  EXPECT_EQ(xml_escape("\x01"), " ");
}

} // namespace
