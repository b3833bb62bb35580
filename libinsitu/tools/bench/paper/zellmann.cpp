#include <algorithm>
#include <cmath>

#include "accuracy/images.h"
#include "commands.h"
#include "report/format.h"
#include "commands/kept_frames.h"
#include "paper/paper.h"
#include "paper/papers_figures.h"
#include "paper/zellmann_meshes.h"

namespace insitu::bench::paper {

namespace {

Cell quoted(double figure, const char* pattern = "%.3g") {
  return figure == oom ? Cell("oom") : figure < 0 ? Cell() : Cell(figure, pattern);
}

class Bench {
public:
  explicit Bench(const Options& o) : o_(o), size_(o.quick ? 32 : o.size) {
    one_.key = "zellmann-1";
    one_.title = "Table 1: elements of the dual mesh, as a regular one and with gridlets";
    one_.caption =
        "Of the reference, vertices at one place are one. "
        "Pyramids and wedges are the same in both, tetrahedra too (the paper lists none). "
        "Gridlets hold full and empty cells; the paper's columns of these count scalars "
        "(its table 2 adds up with them), so ours are given as both. The paper in "
        "millions, gridlets in thousands.";
    one_.label = "model";
    one_.columns = {"leaves",       "ref. verts",  "ref. hexes",  "ref. elems",   "tets",
                    "pyrs",         "wedges",      "verts",       "hexes",        "elems",
                    "gridlets",     "full cells",  "empty cells", "full scalars", "empty scalars",
                    "elems / ref.", "stitching, %"};
    two_.key = "zellmann-2";
    two_.title = "Table 2: compression of cubes as gridlets, gigabytes";
    two_.caption = "As the paper counts: 16 bytes a vertex with its scalar, 32 a hexahedron and a "
                   "gridlet, 4 a gridlet's scalar; gridlets of 8^3 cells.";
    two_.label = "model";
    two_.columns = {"perfect cubes", "gridlets", "compression 1 :"};
    three_.key = "zellmann-3";
    three_.title = "Table 3: memory, bytes an element of the regular dual mesh";
    three_.caption =
        "Data: cells and values, without what locates them; total: with it; peak: while "
        "it is built. Here the reference is the same dual mesh as plain hexahedra, "
        "pyramids and so on through the same library, vertices at one place made one "
        "(coordinates and values in double); the solver's own arrays are left out of both. The "
        "paper's gigabytes "
        "(2^30) over its elements.";
    three_.label = "model";
    three_.columns = {
        "ref. data",         "peak", "total", "ours data", "peak", "total", "data, ours / ref.",
        "total, ours / ref."};
    three_.left_out = {"Quick Clusters, the compressed BVH and ExaBrick here: samplers of other "
                       "papers."};
    four_.key = "zellmann-4";
    four_.title = "Table 4: multi-scattering path tracing, frames of 1024 x 1024 a second";
    four_.caption =
        format("A single convergence frame (one path a pixel), isotropic phase function, "
               "uniform white dome; here at %d x %d on %d thread%s, scaled by pixels. "
               "Majorants are made before. Difference: of both meshes' ray-marched frames, the "
               "root of the mean square over colours; paths differ by their noise, "
               "since majorants are of other macrocells.",
               size_, size_, o.threads, o.threads == 1 ? "" : "s");
    four_.label = "model";
    four_.columns = {"Ref.", "Quick Cl.",   "Compressed",    "ExaBrick",
                     "Ours", "ours / ref.", "points a path", "difference"};
    four_.left_out = three_.left_out;
    six_.key = "zellmann-6";
    six_.title = "Figure 6: construction by refinement level, seconds";
    six_.caption = "The library builds all levels of a dual mesh at once, its gridlets, stitching "
                   "cells and repair. A row each for the mesh cut off at a level: whole, and what "
                   "the level adds. The paper's single-threaded clustering with std::map took "
                   "between 50 s and six minutes for its four data sets.";
    six_.label = "model, finest level";
    six_.columns = {"leaves", "gridlets", "seconds", "added s", "Mleaves/s"};
    six_.left_out = {"the paper's bars (a figure without numbers)."};
  }

  Tables tables() {
    Tables out;
    out.title = "Zellmann, Wu, Ma and Wald 2023, Memory-Efficient GPU Volume Path Tracing of AMR "
                "Data Using the Dual Mesh";
    out.notes = {
        "Left out: the authors' data sets. Ours are blocks of three levels about a sphere "
        "(in place of the block-structured Landing Gear), an octree refined about a front "
        "with two cells of buffer, levels differing by one at most (of Exajet, LANL "
        "Impact, whose regions are many cells thick: a shell about a front is all surface, "
        "so its share of stitching cells, in table 1, is larger at any size), and, as the "
        "hard case, a random octree about a wavy sphere whose levels "
        "differ by more. On the processor; a card's samplers of adaptive "
        "meshes are not measured here."};
    std::vector<Table> orbits;
    for (const auto make :
         {AdaptiveCase::of_blocks, AdaptiveCase::of_front, AdaptiveCase::of_octree}) {
      progress("making an adaptive mesh");
      const AdaptiveCase mesh = make(o_.cells[0]);
      levels(mesh);
      const Held ours = hold(mesh, o_.threads);
      const Held reference = hold_reference(ours, o_.threads);
      counts(mesh, ours, reference);
      frames(mesh, ours, reference);
      Orbit orbit =
          measure_orbit(mesh, ours, reference, o_.quick ? 4 : 50, std::max(32, size_ / 2), 1);
      out.failed = out.failed || orbit.failed;
      orbits.push_back(std::move(orbit.figure_7));
      orbits.push_back(std::move(orbit.figure_8));
      out.files.emplace_back(std::string("zellmann-7-") + mesh.key() + ".svg", orbit.plot);
    }
    add_papers();
    out.tables = {one_, two_, three_, four_, six_};
    for (const std::size_t figure : {0, 1})
      for (std::size_t i = figure; i < orbits.size(); i += 2)
        out.tables.push_back(orbits[i]);
    return out;
  }

private:
  void levels(const AdaptiveCase& mesh) {
    double before = 0.0;
    for (int n = 1; n <= mesh.level_count(); ++n) {
      progress(format("figure 6, %s, %d levels", mesh.name(), n));
      const AdaptiveCase cut = mesh.cut(n);
      core::Context context(o_.threads, core::Log());
      const auto committed = cut.make(context.memory);
      std::vector<double> seconds;
      for (int i = 0; i <= o_.repetitions; ++i) { // the first touches pages
        committed->mesh().set_changed(INSITU_CHANGED_ALL);
        committed->commit(context.threads, context.log, context.memory, true);
        if (i > 0)
          seconds.push_back(committed->amr_info().build_s);
      }
      std::sort(seconds.begin(), seconds.end());
      const double s = seconds[seconds.size() / 2];
      const insitu_amr_info info = committed->amr_info();
      six_.add(mesh.name(), std::to_string(n - 1),
               {info.leaves, info.gridlets, s, s - before, 1e-6 * double(info.leaves) / s});
      before = s;
    }
  }

  void counts(const AdaptiveCase& mesh, const Held& ours, const Held& reference) {
    const mesh::MeshView& dual = ours.mesh->mesh().view();
    const DualStatistics s = statistics_of(dual);
    const std::int64_t elements = reference.plain.cells();
    one_.add("here", mesh.name(),
             {ours.mesh->amr_info().leaves, std::int64_t(reference.plain.values.size()),
              s.hexahedra + s.full_cells, elements, s.tetrahedra, s.pyramids, s.wedges, s.vertices,
              s.hexahedra, s.stitching(), s.gridlets, s.full_cells, s.empty_cells, s.full_scalars,
              s.empty_scalars, double(s.stitching() + s.gridlets) / double(elements),
              Cell(100.0 * double(s.stitching()) / double(elements), "%.1f")});
    const CubeBytes bytes = cube_bytes(dual, s.full_cells);
    constexpr double gigabyte = 1 << 30;
    two_.add(
        "here", mesh.name(),
        {bytes.hexahedra / gigabyte, bytes.gridlets / gigabyte, Cell(bytes.compression(), "%.2f")});
    const double n = double(elements);
    three_.add("here", mesh.name(),
               {Cell(reference.data / n, "%.1f"), Cell(reference.peak / n, "%.1f"),
                Cell(reference.total / n, "%.1f"), Cell(ours.data / n, "%.1f"),
                Cell(ours.peak / n, "%.1f"), Cell(ours.total / n, "%.1f"),
                Cell(ours.data / reference.data, "%.2f"),
                Cell(ours.total / reference.total, "%.2f")});
  }

  void frames(const AdaptiveCase& mesh, const Held& ours, const Held& reference) {
    double fps[2], points = 0.0;
    core::Image image[2];
    for (const bool is_ours : {false, true}) {
      progress(format("table 4, %s, %s", mesh.name(), is_ours ? "gridlets" : "reference"));
      const Held& held = is_ours ? ours : reference;
      KeptFrames frames(*held.mesh, held.context->memory, held.context->threads);
      render::FrameStatistics statistics;
      const double seconds =
          frames.time(path_frame(*held.mesh, size_), o_.repetitions, &statistics);
      fps[is_ours] = double(size_) * size_ / (1024.0 * 1024.0) / seconds;
      points = double(statistics.paths.locations) / double(statistics.paths.paths);
      image[is_ours] = frames.draw(march_frame(*held.mesh, size_)).color;
    }
    four_.add("here", mesh.name(),
              {fps[0], Cell(), Cell(), Cell(), fps[1], Cell(fps[1] / fps[0], "%.2f"), points,
               Cell(accuracy::rms_error(image[0], image[1]), "%.1e")});
  }

  void add_papers() {
    for (std::size_t i = 0; i < std::size(zellmann_figures); ++i) {
      const DualFigures& d = zellmann_duals[i];
      const AmrFigures& f = zellmann_figures[i];
      one_.add(
          "paper", d.model,
          {Cell(), quoted(d.vertices), quoted(d.hexahedra), quoted(d.elements), Cell(),
           quoted(d.pyramids), quoted(d.wedges), quoted(d.own_vertices), quoted(d.own_hexahedra),
           quoted(d.own_elements), quoted(d.gridlets, "%.0f"), Cell(), Cell(), quoted(d.full),
           quoted(d.empty),
           d.own_elements < 0 ? Cell() : Cell((d.own_elements + 1e-3 * d.gridlets) / d.elements),
           d.own_elements < 0 ? Cell() : Cell(100.0 * d.own_elements / d.elements, "%.1f")});
      two_.add("paper", d.model, {f.cubes, f.gridlets, f.rate});
      const auto bytes = [&](const double(&gigabytes)[3], int which) {
        return quoted(gigabytes[which] < 0
                          ? gigabytes[which]
                          : gigabytes[which] * double(1 << 30) / (1e6 * d.elements),
                      "%.1f");
      };
      three_.add("paper", d.model,
                 {bytes(f.reference, 0), bytes(f.reference, 1), bytes(f.reference, 2),
                  bytes(f.ours, 0), bytes(f.ours, 1), bytes(f.ours, 2),
                  Cell(f.ours[0] / f.reference[0], "%.2f"),
                  f.reference[2] < 0 ? Cell() : Cell(f.ours[2] / f.reference[2], "%.2f")});
      four_.add("paper", d.model,
                {quoted(f.fps[0]), quoted(f.fps[1]), quoted(f.fps[2]), quoted(f.fps[3]),
                 quoted(f.fps[4]), f.fps[0] < 0 ? Cell() : Cell(f.fps[4] / f.fps[0], "%.2f")});
    }
    const struct {
      const char* name;
      const double (AmrFigures::*figures)[3];
    } others[] = {{"Quick Clusters", &AmrFigures::quick_clusters},
                  {"Compressed", &AmrFigures::compressed},
                  {"ExaBrick", &AmrFigures::exabrick}};
    for (const auto& other : others)
      for (std::size_t i = 0; i < std::size(zellmann_figures); ++i) {
        std::vector<Cell> cells(3);
        for (const double g : zellmann_figures[i].*other.figures)
          cells.push_back(
              quoted(g < 0 ? g : g * double(1 << 30) / (1e6 * zellmann_duals[i].elements), "%.1f"));
        three_.add(std::string("paper, ") + other.name + " in place of ours",
                   zellmann_duals[i].model, cells);
      }
  }

  const Options& o_;
  int size_;
  Table one_, two_, three_, four_, six_;
};

} // namespace

Tables zellmann(const Options& options) {
  return Bench(options).tables();
}

} // namespace insitu::bench::paper
