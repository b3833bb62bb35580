// 06: when things are wrong the solver goes on, and knows what and where. Then: what the library
// did, what it holds, and which arrays it reads in place.
#include <functional>
#include <insitu/insitu.hpp>
#include <iostream>

namespace {

/// 1 unless the call fails as expected.
int expect(insitu_status expected, const std::function<void()>& call) {
  try {
    call();
  } catch (const insitu::Error& e) {
    std::cout << insitu_status_name(e.status()) << ": " << e.what() << '\n';
    return e.status() != expected;
  }
  return 1;
}

} // namespace

int main() try {
  const auto log = [](insitu::LogLevel, const char* message) {
    std::cout << "log: " << message << '\n';
  };
  int wrong = 0;

  // A scene with a typo.
  wrong += expect(INSITU_ERROR_SCENE,
                  [&] { insitu::Session({.scene_text = "insitu: 1\nprobs: []\n", .log = log}); });

  // A mesh with an id out of range. It is refused; the arrays are corrected, and all is well.
  const std::vector<double> xyz{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, pressure{1, 2, 3, 4};
  std::vector<int> ids{0, 1, 2, 9};
  insitu::Session session({.log = log});
  insitu::Mesh mesh = session.mesh("m");
  mesh.points(xyz);
  mesh.tetrahedra(ids);
  wrong += expect(INSITU_ERROR_MESH, [&] { mesh.commit(); });
  ids[3] = 3;
  mesh.changed(insitu::topology);
  const insitu::CommitReport report = mesh.commit();
  std::cout << "commit: " << report.cells << " cell, " << report.bytes << " bytes held, "
            << report.seconds << " s\n";

  // Sizes and names that do not fit.
  wrong += expect(INSITU_ERROR_ARGUMENT, [&] {
    mesh.vertex_field("v", insitu::Array(pressure).components(3)); // 4 values, 3 components
  });
  mesh.vertex_field("pressure", pressure);
  mesh.commit();
  wrong += expect(INSITU_ERROR_FIELD, [&] { (void)mesh.sample("presure", xyz); });

  // Which arrays are read in place.
  for (const insitu::AuditEntry& entry : mesh.audit()) {
    std::cout << entry.name << ": " << (entry.borrowed ? "in place" : entry.reason) << '\n';
    wrong += !entry.borrowed;
  }
  const insitu::Report totals = session.report();
  std::cout << totals.rebuilds << " rebuild, " << totals.bytes_held << " bytes held, "
            << totals.bytes_borrowed << " bytes borrowed\n";

  // A mesh whose session is closed is found out.
  session.close();
  wrong += expect(INSITU_ERROR_HANDLE, [&] { mesh.commit(); });
  return wrong;
} catch (const insitu::Error& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
