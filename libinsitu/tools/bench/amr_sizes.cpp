#include "amr_sizes.h"

#include <algorithm>
#include <vector>

#include "commands.h"
#include "format.h"
#include "measure.h"
#include "paper/zellmann_meshes.h"
#include "report.h"

namespace insitu::bench {

namespace {

/// A dual mesh of one size.
struct Size {
  std::string mesh;
  insitu_amr_info info;
  DualStatistics dual;
  double build_s = 0.0, compression = 0.0;
  double data = 0.0, peak = 0.0, total = 0.0; ///< bytes; see paper::Held
};

Size measure(const paper::AdaptiveCase& mesh, const Options& o) {
  paper::Held held = paper::hold(mesh, o.threads);
  Size out{mesh.name(),
           held.mesh->amr_info(),
           statistics_of(held.mesh->mesh().view()),
           0,
           0,
           held.data,
           held.peak,
           held.total};
  out.compression = cube_bytes(held.mesh->mesh().view(), out.info.cubes).compression();
  Series build; // of leaves, dual mesh and tree, from pages that were touched
  for (int i = 0; i < o.repetitions; ++i)
    build.time([&] {
      held.mesh->mesh().set_changed(INSITU_CHANGED_ALL);
      held.mesh->commit(held.context->threads, held.context->log, held.context->memory, true);
    });
  out.build_s = build.median();
  return out;
}

/// The power of the leaves that the build's time goes with.
double power_of_leaves(const std::vector<Size>& sizes, const std::string& mesh) {
  std::vector<double> leaves, seconds;
  for (const Size& s : sizes)
    if (s.mesh == mesh) {
      leaves.push_back(double(s.info.leaves));
      seconds.push_back(s.build_s);
    }
  return power_of(leaves, seconds);
}

} // namespace

Output measure_amr_sizes(const Options& options) {
  std::vector<Size> sizes;
  for (const auto make : {paper::AdaptiveCase::of_blocks, paper::AdaptiveCase::of_front,
                          paper::AdaptiveCase::of_balanced_octree, paper::AdaptiveCase::of_octree})
    for (const std::int64_t part : {64, 16, 4, 1}) {
      const std::int64_t cells = std::max<std::int64_t>(options.cells[0] / part, 1000);
      const paper::AdaptiveCase mesh = make(cells);
      progress(format("%s of about %lld cells", mesh.name(), static_cast<long long>(cells)));
      sizes.push_back(measure(mesh, options));
    }
  Output out;
  out.json = "{";
  out.text = format("dual meshes by number of leaves; the counts of Zellmann 2023, tables 1 and 2 "
                    "(full and empty: cells of gridlets;\nstit%%: stitching cells of all that are "
                    "not empty; folded: cells before leaves are split, and after)\n\n"
                    "%-15s %10s %8s %9s %9s %10s %8s %8s %8s %8s %9s %5s %7s %7s %6s %6s\n",
                    "", "leaves", "build s", "Mleaves/s", "gridlets", "full", "empty", "tets",
                    "pyrs", "wedges", "hexes", "stit%", "folded", "split", "folded", "1 :");
  for (const Size& s : sizes) {
    const double rate = 1e-6 * double(s.info.leaves) / s.build_s;
    out.text +=
        format("%-15s %10s %8.4f %9.2f %9s %10s %8s %8s %8s %8s %9s %5.1f %7s %7s %6s %6.2f\n",
               s.mesh.c_str(), grouped(s.info.leaves).c_str(), s.build_s, rate,
               grouped(s.info.gridlets).c_str(), grouped(s.dual.full_cells).c_str(),
               grouped(s.dual.empty_cells).c_str(), grouped(s.dual.tetrahedra).c_str(),
               grouped(s.dual.pyramids).c_str(), grouped(s.dual.wedges).c_str(),
               grouped(s.dual.hexahedra).c_str(),
               100.0 * double(s.dual.stitching()) / double(s.dual.stitching() + s.dual.full_cells),
               grouped(s.info.folded).c_str(), grouped(s.info.repaired).c_str(),
               grouped(s.dual.folded).c_str(), s.compression);
    out.json += format(
        "%s\n  \"%s of %lld\": {\"leaves\": %lld, \"build_s\": %s, \"compression\": %s, "
        "\"gridlets\": %lld, \"stitching\": %lld, \"tetrahedra\": %lld, \"pyramids\": %lld, "
        "\"wedges\": %lld, \"hexahedra\": %lld, \"full\": %lld, \"empty\": %lld, \"folded\": %lld, "
        "\"repaired\": %lld, \"folded_after\": %lld, \"data_bytes\": %s, \"peak_bytes\": %s, "
        "\"bytes\": %s}",
        &s == &sizes[0] ? "" : ",", s.mesh.c_str(), static_cast<long long>(s.info.leaves),
        static_cast<long long>(s.info.leaves), number(s.build_s).c_str(),
        number(s.compression).c_str(), static_cast<long long>(s.dual.gridlets),
        static_cast<long long>(s.dual.stitching()), static_cast<long long>(s.dual.tetrahedra),
        static_cast<long long>(s.dual.pyramids), static_cast<long long>(s.dual.wedges),
        static_cast<long long>(s.dual.hexahedra), static_cast<long long>(s.dual.full_cells),
        static_cast<long long>(s.dual.empty_cells), static_cast<long long>(s.info.folded),
        static_cast<long long>(s.info.repaired), static_cast<long long>(s.dual.folded),
        number(s.data).c_str(), number(s.peak).c_str(), number(s.total).c_str());
  }
  out.json += "\n}\n";
  out.text +=
      format("\nbuild times go as the leaves to the power of %.2f in blocks, of %.2f in "
             "front octrees, of %.2f in balanced ones, of %.2f in random ones\n\n"
             "memory, bytes a leaf (table 3: data, peak, total)\n",
             power_of_leaves(sizes, "blocks"), power_of_leaves(sizes, "front octree"),
             power_of_leaves(sizes, "balanced octree"), power_of_leaves(sizes, "random octree"));
  for (const Size& s : sizes) {
    const auto leaves = double(s.info.leaves);
    out.text +=
        format("%-15s %10s %8.1f %9.1f %9.1f\n", s.mesh.c_str(), grouped(s.info.leaves).c_str(),
               s.data / leaves, s.peak / leaves, s.total / leaves);
  }
  return out;
}

} // namespace insitu::bench
