// A solver of version 0.2, in C++.
#include <cmath>
#include <cstdio>
#include <insitu/insitu.hpp>
#include <vector>

namespace {

int failures = 0;

void expect(bool holds, const char* what) {
  if (!holds) {
    std::fprintf(stderr, "%s; last message: %s\n", what, insitu_last_message());
    ++failures;
  }
}

void run() {
  std::vector<double> xyz, pressure, density{10.0, 20.0};
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 3; ++i) {
        for (const int c : {i, j, k})
          xyz.push_back(c);
        pressure.push_back(1.0 + 2.0 * i - 3.0 * j + 0.5 * k);
      }
  const std::vector<int> ids{0, 1, 4, 3, 6, 7, 10, 9, 1, 2, 5, 4, 7, 8, 11, 10};

  insitu::Options options;
  options.scene_text = "insitu: 1\nprobes:\n  - {name: q, points: [[0.5, 0.5, 0.5]], fields: [p]}\n"
                       "frames:\n  - {name: f, size: [32, 32], volume: {field: rho}}\n";
  options.threads = 2;
  int messages = 0;
  options.log = [&](insitu::LogLevel, const char*) { ++messages; };
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("m");
  mesh.points(xyz);
  mesh.hexahedra(ids);
  mesh.vertex_field("p", pressure);
  mesh.cell_field("rho", density);
  expect(mesh.commit().cells == 2, "commit");
  expect(session.execute(0, 0.0), "execute");
  mesh.changed(insitu::fields);
  expect(session.execute(1, 0.1), "execute again");

  const std::vector<double> points{0.5, 0.5, 0.5, 1.5, 0.25, 0.5, 9.0, 0.0, 0.0};
  const insitu::Samples samples = mesh.sample("p", points);
  expect(samples.found == std::vector<std::uint8_t>({1, 1, 0}), "found");
  expect(samples.cells == std::vector<std::int64_t>({0, 1, -1}), "cells");
  expect(std::abs(samples(0) - 0.75) < 1e-14 && std::abs(samples(1) - 3.5) < 1e-14, "values");
  expect(std::isnan(samples(2)), "outside");

  const insitu::Report report = session.report();
  expect(report.executions == 2 && report.frames == 2 && report.failures == 0, "report");
  expect(report.endings >= INSITU_END_COUNT && report.purposes >= INSITU_MEMORY_COUNT &&
             report.reasons >= INSITU_REASON_COUNT,
         "counts");
  expect(mesh.audit().size() == 4, "audit");
  try {
    mesh.cell_field("rho", pressure);
    mesh.commit();
    expect(false, "a field that does not fit is refused");
  } catch (const insitu::Error& e) {
    expect(e.status() != INSITU_OK, "the status of an error");
  }
  session.close();
}

} // namespace

int main() {
  try {
    run();
  } catch (const std::exception& e) {
    expect(false, e.what());
  }
  return failures != 0;
}
