#include "commands/amr_sizes.h"

#include <algorithm>
#include <vector>

#include "commands.h"
#include "report/format.h"
#include "report/json.h"
#include "measure.h"
#include "paper/zellmann_meshes.h"
#include "report/report.h"

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
  Json json;
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
    std::string key = s.mesh + " of " + std::to_string(s.info.leaves);
    while (json.contains(key)) // the least sizes are alike
      key += ", again";
    json[key] = {{"leaves", s.info.leaves},
                 {"build_s", number(s.build_s)},
                 {"compression", number(s.compression)},
                 {"gridlets", s.dual.gridlets},
                 {"stitching", s.dual.stitching()},
                 {"tetrahedra", s.dual.tetrahedra},
                 {"pyramids", s.dual.pyramids},
                 {"wedges", s.dual.wedges},
                 {"hexahedra", s.dual.hexahedra},
                 {"full", s.dual.full_cells},
                 {"empty", s.dual.empty_cells},
                 {"folded", s.info.folded},
                 {"repaired", s.info.repaired},
                 {"folded_after", s.dual.folded},
                 {"data_bytes", number(s.data)},
                 {"peak_bytes", number(s.peak)},
                 {"bytes", number(s.total)}};
  }
  out.json = json_text(json);
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
