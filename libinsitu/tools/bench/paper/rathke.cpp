#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "commands.h"
#include "commands/kept_frames.h"
#include "commands/lattice_rays.h"
#include "paper/paper.h"
#include "paper/papers_figures.h"
#include "render/structures/structures.h"
#include "render/surface/tiles/isosurface_tile.h"
#include "report/format.h"

namespace insitu::bench::paper {

namespace {

using math::Vec3d;

constexpr std::size_t group_count = std::size(rathke_groups);

/// What stands in for a data set: the mesh, and a field of as much detail.
struct StandIn {
  workload::Kind kind;
  workload::Spacing spacing;
  double waves; ///< of the field along the box
};
constexpr StandIn stand_ins[] = {{workload::Kind::tetrahedra, workload::Spacing::even, 0.5},
                                 {workload::Kind::tetrahedra, workload::Spacing::even, 1.0},
                                 {workload::Kind::tetrahedra, workload::Spacing::even, 3.0},
                                 {workload::Kind::tetrahedra, workload::Spacing::graded, 0.5},
                                 {workload::Kind::hexahedra, workload::Spacing::even, 2.0}};

/// Between -3 and 3; its level 0 is a surface without boundary within the box.
double field(const Vec3d& p, double waves) {
  const double w = 2 * M_PI * waves;
  return std::cos(w * p.x) + std::cos(w * p.y) + std::cos(w * p.z);
}

int size_of(const Options& options) {
  return options.quick ? 64 : options.size / 16 * 16;
}

class DataSet {
public:
  DataSet(const Options& options, std::size_t which)
      : o_(with(options, which)), setup_(o_), size_(size_of(options)) {
    for (std::size_t v = 0; v < setup_.field.size(); ++v)
      setup_.field[v] = field(setup_.mesh.point(std::int64_t(v)), stand_ins[which].waves);
    mesh_ = setup_.register_mesh();
    setup_.commit(*mesh_);
  }

  std::int64_t cells() const { return setup_.mesh.cell_count(); }
  const core::Threads& threads() const { return setup_.context.threads; }

  render::FrameSettings volume() const {
    return standard_frame(mesh_->sampler(), mesh_->mesh().field("f"), -3.0, 3.0, size_);
  }
  std::vector<render::IsosurfaceSettings> surface(render::RootSearch search) const {
    render::IsosurfaceSettings s;
    s.field = render::ScalarField{mesh_->mesh().field("f"), 0};
    s.values = {0.0};
    s.search = search;
    return {s};
  }

  /// How rays look for the surface.
  enum class Way {
    tiles,    ///< cell by cell in tiles of the screen, as frames do
    packets,  ///< 16 rays that share nodes, as light on surfaces does; the first hit ends a ray
    alone,    ///< ray by ray, exact search
    shuffled, ///< the same in an order that no two neighbours share cells in
    neubauer  ///< ray by ray, the paper's two interpolations
  };
  /// Million rays a second that look for the surface, without shading, on one core.
  double surface_rays(Way way, std::int64_t* hits) const {
    const auto settings =
        surface(way == Way::neubauer ? render::RootSearch::neubauer : render::RootSearch::exact);
    core::Memory memory;
    render::Structures structures(memory);
    const query::Sampler sampler = mesh_->sampler();
    const core::Threads one(1);
    structures.begin(sampler, mesh_->tree_version(), mesh_->fields_version(), one);
    const render::IsosurfaceTracer tracer(sampler, settings, structures, false);
    const render::RayGenerator rays(volume().camera, size_, size_);
    Series series;
    for (int i = 0; i < o_.repetitions; ++i)
      series.time([&] {
        *hits = way == Way::tiles     ? hits_of_tiles(tracer, rays)
                : way == Way::packets ? hits_of_packets(tracer, rays)
                                      : hits_alone(tracer, rays, way == Way::shuffled);
      });
    return 1e-6 * double(size_) * size_ / series.for_ratio(1);
  }

  /// Million rays a second of whole frames, on all threads asked for.
  double frame_rays(bool isosurface) const {
    render::FrameSettings settings = volume();
    if (isosurface) {
      settings.volume.reset();
      settings.isosurfaces = surface(render::RootSearch::exact);
    }
    core::Memory memory;
    KeptFrames frames(*mesh_, memory, threads());
    return 1e-6 * double(size_) * size_ / frames.time(settings, o_.repetitions);
  }

  /// Million rays a second whose samples are located in groups, on one core; `step` in units of the
  /// default. The samples of a ray are added up.
  double grouped_rays(int group, double step, double* samples_a_ray) const {
    render::FrameSettings settings = volume();
    settings.volume->step_factor *= step;
    std::vector<double> rates;
    for (int i = 0; i < o_.repetitions; ++i) {
      const LatticeCost cost = locate_lattice(mesh_->sampler(), settings, group, o_.quick ? 2 : 4);
      rates.push_back(1e-6 * double(cost.rays) / cost.seconds);
      *samples_a_ray = double(cost.samples) / double(cost.rays);
    }
    std::sort(rates.begin(), rates.end());
    return rates[rates.size() / 2];
  }

private:
  std::int64_t hits_of_tiles(const render::IsosurfaceTracer& tracer,
                             const render::RayGenerator& rays) const {
    using render::IsosurfaceTile;
    IsosurfaceTile tile;
    std::vector<render::SurfaceHit> found;
    render::SurfaceCounts counts;
    std::int64_t hits = 0;
    for (int y0 = 0; y0 < size_; y0 += IsosurfaceTile::side)
      for (int x0 = 0; x0 < size_; x0 += IsosurfaceTile::side) {
        const int x1 = std::min(x0 + IsosurfaceTile::side, size_);
        const int y1 = std::min(y0 + IsosurfaceTile::side, size_);
        tile.trace(tracer, rays, {}, x0, y0, x1, y1, counts);
        for (int y = y0; y < y1; ++y)
          for (int x = x0; x < x1; ++x) {
            found.clear();
            tile.hits(x, y, found);
            hits += !found.empty();
          }
      }
    return hits;
  }

  /// The pixel that comes i-th, in tiles of 4 x 4 of tiles of 16 x 16.
  render::Ray ray_of(const render::RayGenerator& rays, std::int32_t i) const {
    const int tile = i / 256, across = size_ / 16, block = i / 16 % 16;
    return rays(tile % across * 16 + block % 4 * 4 + i % 4,
                tile / across * 16 + block / 4 * 4 + i / 4 % 4);
  }

  std::int64_t hits_of_packets(const render::IsosurfaceTracer& tracer,
                               const render::RayGenerator& rays) const {
    const std::vector<render::Stretch> ahead{{0, HUGE_VAL}};
    render::LightRay packet[16];
    render::SurfaceCounts counts;
    std::int64_t hits = 0;
    for (std::int32_t i = 0; i < size_ * size_; i += 16) {
      for (std::int32_t k = 0; k < 16; ++k)
        packet[k] = {ray_of(rays, i + k), &ahead};
      tracer.trace(packet, counts);
      hits += std::count_if(std::begin(packet), std::end(packet),
                            [](const render::LightRay& ray) { return ray.open < 1; });
    }
    return hits;
  }

  std::int64_t hits_alone(const render::IsosurfaceTracer& tracer, const render::RayGenerator& rays,
                          bool shuffled) const {
    std::vector<std::int32_t> order(std::size_t(size_ * size_));
    std::iota(order.begin(), order.end(), 0);
    if (shuffled)
      order = workload::permutation(std::int64_t(order.size()), 6, 0);
    std::vector<render::SurfaceHit> found;
    render::SurfaceCounts counts;
    std::int64_t hits = 0;
    for (const std::int32_t i : order) {
      tracer.trace(ray_of(rays, i), found, counts);
      hits += !found.empty();
    }
    return hits;
  }

  static Options with(const Options& options, std::size_t which) {
    Options o = options;
    o.kind = stand_ins[which].kind;
    o.spacing = stand_ins[which].spacing;
    o.cells = {std::min(options.cells[0], std::int64_t(1e6 * rathke_figures[which].millions))};
    return o;
  }
  const Options o_;
  Setup setup_;
  int size_;
  std::unique_ptr<commit::CommittedMesh> mesh_;
};

const char* const sizes_note =
    "Left out: the authors' data sets. Ours are boxes of the same cells, of the "
    "paper's number or of --cells, "
    "with waves as a field; SF1's has edges graded 1e4-fold.";

std::vector<std::string> group_columns() {
  std::vector<std::string> out;
  for (const int g : rathke_groups)
    out.push_back(std::to_string(g));
  return out;
}

class Bench {
public:
  explicit Bench(const Options& o) : o_(o) {
    one_.key = "rathke-1";
    one_.title = "Table 1: traversal for isosurfaces, million rays a second";
    one_.caption =
        format("Here on one core, rays of %d x %d pixels", size_of(o), size_of(o)) +
        ", structures made before: as frames look for surfaces, cell by cell in tiles of the "
        "screen; in packets of 16 rays that share nodes, as rays of shadows and occlusion do, "
        "which end at any hit (the paper's packets have 8, and end at the first); ray by ray, in "
        "the order of tiles and in random order, which tells what neighbouring rays' cells in the "
        "cache are worth; all by exact search, and ray by ray by Neubauer's two interpolations, as "
        "in the paper. The paper's rates a core are over its 20.";
    one_.label = "data set";
    one_.columns = {"cells",
                    "rays hit",
                    "tiles",
                    "packets",
                    "alone",
                    "random",
                    "Neubauer, alone",
                    "paper: cells, M",
                    "SPMD",
                    "packeted",
                    "SPMD a core",
                    "packeted a core",
                    "tiles over packeted"};
    one_.left_out = {"a ray a SIMD lane, each with a node of its own (SPMD)."};
    two_.key = "rathke-2";
    two_.title = "Table 2: volumes by sample group size and data set, million rays a second";
    two_.caption =
        "Here on one core: samples half a cell apart, located in bundles of 16 x 16 rays "
        "with so many samples of each ray at once, nothing skipped, no ray ended early; "
        "the paper's on its 20 cores.";
    two_.label = "data set";
    two_.columns = group_columns();
    two_.columns.push_back("samples a ray");
    four_.key = "rathke-4";
    four_.title = "Table 4: isosurfaces (ISO) and volumes (DVR), million rays a second";
    four_.caption =
        format("Whole frames of %d x %d with their shading, without shadows, what frames share "
               "made before, on %d "
               "thread%s; the paper's on its Xeon node, a core of it, and its Phi node.",
               size_of(o), size_of(o), o.threads, o.threads == 1 ? "" : "s");
    four_.label = "data set";
    four_.columns = {"cells",        "ISO",        "DVR",    "ISO a thread",
                     "DVR a thread", "paper: ISO", "DVR",    "ISO a core",
                     "DVR a core",   "Phi ISO",    "Phi DVR"};
    four_.left_out = {"a Xeon Phi."};
    three_.key = "rathke-3";
    three_.title = "Table 3: volumes by sample group size and step, million rays a second";
    three_.caption = "As table 2; steps over that of table 2 (half a cell; the paper's 10).";
    three_.label = "step";
    three_.columns = two_.columns;
  }

  Tables tables() {
    for (std::size_t d = 0; d < std::size(rathke_figures); ++d) {
      progress(std::string("making the mesh for ") + rathke_figures[d].data_set);
      const DataSet data(o_, d);
      if (wants(1))
        row_of_one(data, rathke_figures[d]);
      if (wants(2))
        row_of_two(data, rathke_figures[d]);
      if (wants(4))
        row_of_four(data, rathke_figures[d]);
      if (wants(3) && (d == 1 || d == 4))
        rows_of_three(data, d == 1 ? "Jets, tetrahedra" : "Earthquake, hexahedra");
    }
    if (wants(2))
      end_two();
    if (wants(3))
      for (const StepFigures& f : rathke_steps)
        three_.add("paper, Jets", format("%g", f.step / 10), quoted(f.of_group));
    Tables out;
    out.title = "Rathke, Wald, Chiu and Brownlee 2015, SIMD Parallel Ray Tracing of Homogeneous "
                "Polyhedral Grids";
    out.notes = {sizes_note};
    out.notes.insert(out.notes.end(), other_hits_.begin(), other_hits_.end());
    out.failed = !other_hits_.empty();
    for (int t = 1; t <= 4; ++t)
      if (wants(t))
        out.tables.push_back(*std::array{&one_, &two_, &three_, &four_}[std::size_t(t - 1)]);
    return out;
  }

private:
  bool wants(int table) const { return o_.table == 0 || o_.table == table; }
  static std::vector<Cell> quoted(const double (&figures)[6]) {
    return {std::begin(figures), std::end(figures)};
  }

  void row_of_one(const DataSet& data, const RathkeFigures& paper) {
    progress(std::string(paper.data_set) + ", isosurface");
    using Way = DataSet::Way;
    std::int64_t hits = 0, others = 0;
    const double tiles = data.surface_rays(Way::tiles, &hits);
    std::vector<Cell> cells{data.cells(), hits, tiles};
    for (const Way way : {Way::packets, Way::alone, Way::shuffled, Way::neubauer}) {
      cells.emplace_back(data.surface_rays(way, &others));
      if (way != Way::neubauer && others != hits) // rays that hit are the same whatever the way
        other_hits_.push_back(format("%s: %lld rays hit, but %lld in tiles", paper.data_set,
                                     static_cast<long long>(others), static_cast<long long>(hits)));
    }
    const double a_core = paper.packeted / rathke_cores;
    for (const Cell& cell : {Cell(format("%g %s", paper.millions, paper.cells)), Cell(paper.spmd),
                             Cell(paper.packeted), Cell(paper.spmd / rathke_cores), Cell(a_core),
                             Cell(tiles / a_core)})
      cells.push_back(cell);
    one_.add("", paper.data_set, cells);
  }

  void row_of_two(const DataSet& data, const RathkeFigures& paper) {
    std::vector<Cell> cells;
    double samples = 0.0;
    for (std::size_t g = 0; g < group_count; ++g) {
      progress(format("%s, groups of %d", paper.data_set, rathke_groups[g]));
      const double rate = data.grouped_rays(rathke_groups[g], 1.0, &samples);
      cells.emplace_back(rate);
      if (g == 0)
        first_.push_back(rate);
      over_one_[g] += rate / first_.back() / double(std::size(rathke_figures));
    }
    cells.emplace_back(samples, "%.1f");
    two_.add("here", format("%s (%s)", paper.data_set, bench::grouped(data.cells()).c_str()),
             cells);
  }
  void end_two() {
    std::vector<Cell> ours, theirs;
    for (std::size_t g = 0; g < group_count; ++g) {
      double sum = 0.0;
      for (const RathkeFigures& f : rathke_figures)
        sum += f.of_group[g] / f.of_group[0] / double(std::size(rathke_figures));
      ours.emplace_back(over_one_[g], "%.2f");
      theirs.emplace_back(sum, "%.2f");
    }
    two_.add("here", "over groups of 1, mean", ours);
    for (const RathkeFigures& f : rathke_figures)
      two_.add("paper", format("%s (%gM)", f.data_set, f.millions), quoted(f.of_group));
    two_.add("paper", "over groups of 1, mean", theirs);
  }

  void rows_of_three(const DataSet& data, const std::string& name) {
    for (const StepFigures& f : rathke_steps) {
      std::vector<Cell> cells;
      double samples = 0.0;
      for (const int group : rathke_groups) {
        progress(name + format(", step %g, groups of %d", f.step / 10, group));
        cells.emplace_back(data.grouped_rays(group, f.step / 10, &samples));
      }
      cells.emplace_back(samples, "%.1f");
      three_.add("here, " + name, format("%g", f.step / 10), cells);
    }
  }

  void row_of_four(const DataSet& data, const RathkeFigures& paper) {
    progress(std::string(paper.data_set) + ", frames");
    const double iso = data.frame_rays(true), dvr = data.frame_rays(false);
    const int threads = data.threads().count();
    four_.add("", paper.data_set,
              {data.cells(), iso, dvr, iso / threads, dvr / threads, paper.iso, paper.dvr,
               paper.iso / rathke_cores, paper.dvr / rathke_cores, paper.phi_iso, paper.phi_dvr});
  }

  const Options& o_;
  Table one_, two_, three_, four_;
  std::vector<std::string> other_hits_;
  std::vector<double> first_;
  double over_one_[group_count] = {};
};

} // namespace

Tables rathke(const Options& options) {
  return Bench(options).tables();
}

} // namespace insitu::bench::paper
