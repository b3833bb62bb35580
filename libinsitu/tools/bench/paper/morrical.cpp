#include <algorithm>
#include <cmath>
#include <functional>

#include "paper/morrical_cases.h"
#include "paper/paper.h"
#include "paper/papers_figures.h"
#include "report/format.h"

namespace insitu::bench::paper {

namespace {

const char* papers_name(Method method) {
  constexpr const char* names[] = {
      "cuda-bvh = bvh", "rtx-bvh = user_geometry", "rtx-rep-faces = replicated_faces",
      "rtx-shrd-faces = shared_faces", "rtx-shrd-bilinear-faces = shared_bilinear_faces"};
  return names[int(method)];
}

constexpr std::int64_t one_group = std::int64_t(1) << 20;

class Bench {
public:
  explicit Bench(const Options& o) : bench_(o) {
    for (const MorricalSet& d : morrical_sets)
      cases_.push_back(bench_.measure(d));
  }

  Tables tables() {
    Tables out;
    out.title = format(
        "Morrical, Wald, Usher and Pascucci 2020, Accelerating Unstructured Mesh Point Location "
        "with RT Cores; %d thread%s",
        bench_.threads(), bench_.threads() == 1 ? "" : "s");
    out.tables = {memory(), rates("2", "uniform", &MethodCase::uniform),
                  random(), volume(),
                  peers(),  power()};
    out.notes = {
        "Left out: the authors' data sets. Ours stand in for them, in their proportions: boxes of "
        "tetrahedra with edges graded 1e4-fold (fusion), of even ones (jets, agul-t), of islands "
        "that fill a twentieth (jpn), and of wedges; what a machine does per element or sample "
        "compares, and each method over the reference method of the same machine."};
    name_absent(out.notes);
    for (const MorricalCase& c : cases_)
      for (const auto& backend : c.of)
        for (const MethodCase& m : backend)
          out.failed = out.failed || m.lost + m.other > 0;
    return out;
  }

private:
  // The tables.

  Table begin(const std::string& number, const std::string& title,
              const std::string& caption) const {
    Table t;
    t.key = "morrical-" + number;
    t.title = "Table " + number + ": " + title;
    t.caption = caption;
    t.label = "method";
    for (const MorricalSet& d : morrical_sets)
      t.columns.push_back(d.name);
    std::vector<Cell> ours, theirs;
    for (std::size_t i = 0; i < morrical_set_count; ++i) {
      ours.emplace_back(cases_[i].cells);
      theirs.emplace_back(format("%gM", morrical_sets[i].millions));
    }
    t.add("elements", "here", ours);
    t.add("elements", "paper", theirs);
    return t;
  }
  static void name_absent(std::vector<std::string>& notes) {
    for (int b = 0; b < accel::backend_count; ++b)
      if (const std::string why = query::why_unavailable(Backend(b)); !why.empty())
        notes.push_back("Left out: " + std::string(name(Backend(b))) + ", " + why +
                        (Backend(b) == Backend::optix
                             ? ". The rows of ray methods are Embree's, on the processor"
                             : "") +
                        ".");
  }
  std::vector<Cell> row(const std::function<Cell(const MorricalCase&)>& value) const {
    std::vector<Cell> cells;
    for (const MorricalCase& c : cases_)
      cells.push_back(value(c));
    return cells;
  }
  static std::vector<Cell> quoted_row(const double (&figures)[6], double factor = 1.0) {
    std::vector<Cell> cells;
    for (const double f : figures)
      cells.push_back(f < 0 ? Cell(f == oom ? "oom" : "NA") : Cell(factor * f));
    return cells;
  }

  Table memory() const {
    Table t = begin("1", "memory, bytes an element",
                    "Final: the method's structures and the mesh with one field (here in double). "
                    "Peak: while building, all at once (no p/s) and in groups of a million "
                    "primitives (w/ p/s), but for meshes of no more, which are one group. The "
                    "paper's bytes (G = "
                    "1e9) over its elements, on Turing.");
    for (int m = 0; m < accel::method_count; ++m) {
      const std::string section = papers_name(Method(m));
      for (int b = 0; b < accel::backend_count; ++b) {
        if (!is_here(b, m))
          continue;
        const std::string where = std::string(name(Backend(b))) + ", ";
        const auto bytes = [&](std::int64_t Sizes::*which) {
          return row([&](const MorricalCase& c) {
            const std::int64_t n = c.of[b][m].sizes.*which;
            return n ? Cell((double(n) + c.mesh_bytes) / double(c.cells), "%.0f") : Cell();
          });
        };
        if (accel::uses_faces(Method(m)))
          t.add(section, where + "faces an element", row([&](const MorricalCase& c) {
                  return Cell(double(c.of[b][m].sizes.primitives) / double(c.cells));
                }));
        if (Method(m) == Method::bvh) {
          t.add(section, where + "peak", bytes(&Sizes::peak));
        } else {
          t.add(section, where + "peak (no p/s)", bytes(&Sizes::peak_whole));
          t.add(section, where + "peak (w/ p/s)", row([&](const MorricalCase& c) {
                  const Sizes& s = c.of[b][m].sizes;
                  return s.primitives > one_group
                             ? Cell((double(s.peak) + c.mesh_bytes) / double(c.cells), "%.0f")
                             : Cell();
                }));
        }
        t.add(section, where + "final", bytes(&Sizes::bytes));
      }
      for (const MemoryFigures& f : morrical_memory)
        if (f.method == m) {
          std::vector<Cell> cells;
          for (std::size_t i = 0; i < morrical_set_count; ++i)
            cells.push_back(f.of[i] < 0 ? Cell(f.of[i] == oom ? "oom" : "NA")
                                        : Cell(f.of[i] / morrical_sets[i].millions,
                                               f.of[i] < 200 ? "%.3g" : "%.0f"));
          t.add(section, std::string("paper, ") + f.row, cells);
        }
    }
    t.left_out.push_back("the Volta half of the paper's columns (no ray tracing hardware).");
    return t;
  }

  Table rates(const std::string& number, const std::string& pattern,
              double MethodCase::*rate) const {
    Table t =
        begin(number, "synthetic " + pattern + ", million samples a second",
              std::string(number == "2" ? "A point an element, at its centre, in the "
                                          "elements' order."
                                        : "Random places in random elements.") +
                  " Here in `fast`: on a device, and for the two kinds of shared faces, by "
                  "the papers' rules in float; on the processor replicated_faces and "
                  "user_geometry ask the cell in exact arithmetic behind Embree's rays in "
                  "float, and bvh answers as in standard, in double. Values as the data set "
                  "has them, of elements (agul) or vertices. Below: over the reference method "
                  "of the same machine, which compares.");
    for (const bool relative : {false, true}) {
      const std::string section = relative ? "over cuda-bvh = bvh" : "million a second";
      for (int b = 0; b < accel::backend_count; ++b)
        for (int m = relative ? 1 : 0; m < accel::method_count; ++m)
          if (is_here(b, m))
            t.add(section, std::string(name(Backend(b))) + ", " + papers_name(Method(m)),
                  row([&](const MorricalCase& c) {
                    const int reference = Backend(b) == Backend::optix ? int(Backend::cuda) : b;
                    const double r = c.of[b][m].*rate;
                    return Cell(relative ? r / (c.of[reference][0].*rate) : r);
                  }));
      for (const RateFigures& f : morrical_rates) {
        if (f.table != number || (relative && f.method == 0))
          continue;
        double figures[6];
        for (std::size_t i = 0; i < morrical_set_count; ++i) {
          const RateFigures& reference = *(&f - f.method);
          figures[i] = relative && f.of[i] > 0 ? f.of[i] / reference.of[i] : f.of[i];
        }
        t.add(section, std::string("paper, ") + f.machine + ", " + morrical_rows[f.method],
              quoted_row(figures));
      }
    }
    t.left_out.push_back("the paper's rows of other cards with ray tracing hardware than the "
                         "Titan RTX: RTX 2080, RTX 2080 Ti, RTX 8000.");
    return t;
  }

  Table random() const {
    Table t = rates("3", "random", &MethodCase::random);
    for (const bool lost : {false, true})
      for (int b = 0; b < accel::backend_count; ++b)
        for (int m = 0; m < accel::method_count; ++m) {
          if (!is_here(b, m))
            continue;
          const std::string row_name =
              std::string(name(Backend(b))) + ", " + papers_name(Method(m));
          if (lost) {
            t.add("points lost (standard)", row_name,
                  row([&](const MorricalCase& c) { return Cell(c.of[b][m].lost); }));
          } else if (Method(m) == Method::bvh) {
            t.add("what certainty costs: million a second", row_name + ", standard",
                  row([&](const MorricalCase& c) { return Cell(c.of[b][m].random_standard); }));
            t.add("what certainty costs: million a second", row_name + ", exact",
                  row([&](const MorricalCase& c) { return Cell(c.of[b][m].random_exact); }));
          }
        }
    return t;
  }

  Table volume() const {
    Table t = begin("4", "volume rendering, frames of 1024 x 1024 a second",
                    format("Samples about an element apart along the view's rays, "
                           "located in batches by each method (one tile of 16 x 16 in 256 is "
                           "timed; where these have many samples, as many stretches of them, "
                           "evenly apart and the same for all methods of a backend); whole frame: "
                           "the renderer's own march, at %d x %d, which ends "
                           "saturated rays and skips what is empty.",
                           bench_.frame_size(), bench_.frame_size()));
    for (int b = 0; b < accel::backend_count; ++b)
      for (int m = 0; m < accel::method_count; ++m)
        if (is_here(b, m))
          t.add("here", std::string(name(Backend(b))) + ", " + papers_name(Method(m)),
                row([&](const MorricalCase& c) {
                  return Cell(1e6 * c.of[b][m].view / c.view_samples);
                }));
    t.add("here", "cpu, bvh, whole frame",
          row([](const MorricalCase& c) { return Cell(1 / c.frame_seconds); }));
    t.add("here", "million samples a frame",
          row([](const MorricalCase& c) { return Cell(1e-6 * c.view_samples); }));
    for (int b = 0; b < accel::backend_count; ++b)
      for (int m = 1; m < accel::method_count; ++m)
        if (is_here(b, m))
          t.add("over cuda-bvh = bvh",
                std::string(name(Backend(b))) + ", " + papers_name(Method(m)),
                row([&](const MorricalCase& c) {
                  return Cell(c.of[b][m].view /
                              c.of[Backend(b) == Backend::optix ? int(Backend::cuda) : b][0].view);
                }));
    for (const RateFigures& f : morrical_rates)
      if (f.table == std::string("4"))
        t.add("paper", std::string(f.machine) + ", " + morrical_rows[f.method], quoted_row(f.of));
    return t;
  }

  Table peers() const {
    Table t = begin("5", "against other renderers, frames of 1024 x 1024 a second",
                    "Here: the renderer's frame, and vtkUnstructuredGridVolumeRayCastMapper's, "
                    "which marches from tetrahedron to tetrahedron, on one thread. Paper: OSPRay "
                    "on an i9-9920X, the "
                    "others on an RTX 8000.");
    t.label = "renderer";
    t.add("here", "ours", row([](const MorricalCase& c) { return Cell(1 / c.frame_seconds); }));
    t.add("here", "VTK", row([](const MorricalCase& c) { return Cell(1 / c.vtk_seconds); }));
    for (const PeerFigures& f : morrical_peers)
      t.add("paper", f.renderer, quoted_row(f.of));
    t.left_out.push_back(
        "ParaView's projected tetrahedra, OSPRay and IndeX, which are not here; the "
        "data set scivis-h. VTK draws values of vertices only: none for agul.");
    if (std::isnan(cases_[0].vtk_seconds))
      t.left_out.push_back("VTK's frames: " + cases_[0].vtk_why + ".");
    return t;
  }

  Table power() const {
    Table t;
    t.key = "morrical-9.4";
    t.title = "Section 9.4: power drawn";
    t.caption =
        "Watts while samples along view rays are located (table 4), and joules a million of "
        "them; the paper's watts are of its triangle methods on tetrahedra, and cuda-bvh's "
        "and rtx-bvh's, about the card's most.";
    t.label = "method";
    for (const MorricalSet& d : morrical_sets)
      t.columns.push_back(d.name);
    for (int b = 0; b < accel::backend_count; ++b)
      for (int m = 0; m < accel::method_count; ++m)
        if (is_here(b, m) && (b == 0 ? bench_.processor() : bench_.card()).works()) {
          const std::string row_name =
              std::string(name(Backend(b))) + ", " + papers_name(Method(m));
          t.add("watts", row_name,
                row([&](const MorricalCase& c) { return Cell(c.of[b][m].watts); }));
          t.add("joules a million samples", row_name,
                row([&](const MorricalCase& c) { return Cell(c.of[b][m].joules); }));
        }
    std::stable_sort(t.rows.begin(), t.rows.end(), [](const Table::Row& a, const Table::Row& c) {
      return a.section > c.section; // watts first
    });
    const struct {
      const char* card;
      double boxes, triangles;
    } papers[] = {{"RTX 2080", 225, 170},
                  {"RTX 2080 Ti", 260, 250},
                  {"Titan RTX", 280, 230},
                  {"RTX 8000", 260, 191}};
    for (const auto& p : papers) {
      t.add("paper, watts", std::string(p.card) + ", cuda-bvh and rtx-bvh",
            std::vector<Cell>(morrical_set_count, p.boxes));
      std::vector<Cell> cells(4, p.triangles);
      cells.resize(morrical_set_count, "NA");
      t.add("paper, watts", std::string(p.card) + ", triangle methods", cells);
    }
    if (!bench_.processor().works())
      t.left_out.push_back("the processor's: " + bench_.processor().why() + ".");
    if (!bench_.card().works())
      t.left_out.push_back("a card's: " + bench_.card().why() + ".");
    return t;
  }

  MorricalBench bench_;
  std::vector<MorricalCase> cases_;
};

} // namespace

Tables morrical(const Options& options) {
  return Bench(options).tables();
}

} // namespace insitu::bench::paper
