// insitu-replay run as a program in a folder of its own.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIntArray.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "insitu/vtk.hpp"

#include "../vtk/meshes.h"

namespace fs = std::filesystem;

struct Outcome {
  int code;
  std::string out, err;
};

inline std::string contents(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

using Row = std::map<std::string, double>; ///< by column; NaN where empty

struct Replay : testing::Test {
  fs::path folder = fs::path(testing::TempDir()) /
                    ("insitu_replay_" + std::to_string(getpid()) + "_" +
                     testing::UnitTest::GetInstance()->current_test_info()->name());
  void SetUp() override {
    fs::remove_all(folder);
    fs::create_directories(folder);
    put("points.csv", "x,y,z\n0.4,0.3,0.2\n1.5,1.5,1.5\n9,9,9\n");
    put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: points.csv, fields: [linear]}\n");
  }
  void TearDown() override { fs::remove_all(folder); }

  std::string path(const std::string& name) const { return (folder / name).string(); }
  void put(const std::string& name, const std::string& text) const {
    std::ofstream(path(name)) << text;
  }
  /// A .vtu file.
  void write(const std::string& name, vtkUnstructuredGrid* grid) const {
    vtkNew<vtkXMLUnstructuredGridWriter> writer;
    writer->SetFileName(path(name).c_str());
    writer->SetInputData(grid);
    ASSERT_EQ(writer->Write(), 1);
  }
  /// A file of probed points, three numbers each, to the bit.
  void put_points(const std::string& name, const std::vector<double>& xyz) const {
    std::string text = "x,y,z\n";
    for (std::size_t i = 0; i < xyz.size(); ++i) {
      char number[40];
      std::snprintf(number, sizeof number, "%.17g%c", xyz[i], i % 3 == 2 ? '\n' : ',');
      text += number;
    }
    put(name, text);
  }
  /// A 2^3 mesh whose field is linear + add, with cycle and time as field data where not negative.
  void mesh(const std::string& name, double add, int cycle = -1, double time = -1.0,
            int type = VTK_HEXAHEDRON) const {
    const auto grid = vtk_meshes::unstructured(2, {type}, 0.1);
    auto* values = vtkDoubleArray::SafeDownCast(grid->GetPointData()->GetArray("linear"));
    for (vtkIdType i = 0; i < values->GetNumberOfValues(); ++i)
      values->SetValue(i, values->GetValue(i) + add);
    if (cycle >= 0) {
      vtkNew<vtkIntArray> array;
      array->SetName("CYCLE");
      array->InsertNextValue(cycle);
      grid->GetFieldData()->AddArray(array);
    }
    if (time >= 0.0) {
      vtkNew<vtkDoubleArray> array;
      array->SetName("TimeValue");
      array->InsertNextValue(time);
      grid->GetFieldData()->AddArray(array);
    }
    insitu::vtk::write(path(name), grid);
  }
  Outcome run(const std::string& arguments) const {
    const std::string command = "cd '" + folder.string() + "' && '" REPLAY_PROGRAM "' " +
                                arguments + " > out.txt 2> err.txt";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(path("out.txt")),
            contents(path("err.txt"))};
  }
  /// Expects that a dry run prints these lines, or says `mistake` of an item, and writes nothing
  /// into the folder `nothing`.
  void expect_checked(const std::string& arguments, const std::vector<std::string>& lines,
                      const std::string& mistake = "") const {
    const Outcome o = run("--check --out nothing " + arguments);
    EXPECT_EQ(o.code, mistake.empty() ? 0 : 3) << o.err;
    for (const std::string& line : lines)
      EXPECT_NE(o.out.find(line), std::string::npos) << line << "\n" << o.out;
    EXPECT_NE(o.err.find(mistake), std::string::npos) << o.err;
    EXPECT_FALSE(fs::exists(folder / "nothing"));
  }
  std::vector<Row> rows(const std::string& name) const {
    std::ifstream in(path(name));
    std::string line, cell;
    std::vector<std::string> columns;
    std::getline(in, line);
    for (std::istringstream header(line); std::getline(header, cell, ',');)
      columns.push_back(cell);
    std::vector<Row> out;
    while (std::getline(in, line)) {
      std::istringstream cells(line + ",");
      Row& row = out.emplace_back();
      for (const std::string& column : columns) {
        std::getline(cells, cell, ',');
        row[column] = cell.empty() ? NAN : std::strtod(cell.c_str(), nullptr);
      }
    }
    return out;
  }
};
