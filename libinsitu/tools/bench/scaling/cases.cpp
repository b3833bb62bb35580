#include "scaling/cases.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <time.h>

#include "advect/pathlines.h"
#include "commands.h"
#include "commit/committed_mesh.h"
#include "commit/halo/everywhere.h"
#include "core/context.h"
#include "core/random.h"
#include "render/processes/frame_part.h"
#include "render/processes/whole_facts.h"
#include "render/structures/structures.h"
#include "scaling/layout.h"
#include "scaling/leaves.h"
#include "scene/tracers/mesh_homes.h"

namespace insitu::bench::scaling {

using math::Vec3d;
using parallel::Reduction;

namespace {

constexpr VertexFields vertex_fields{2, 4}; // the distance and the velocity

double seconds_by(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values.empty() ? 0.0 : values[values.size() / 2];
}

/// One process of a run: its part of the mesh, and the work on it.
class Process {
public:
  Process(parallel::World& world, const Options& options, bool weak)
      : world_(world), o_(options), weak_(weak),
        layout_(make_layout(world.size(), weak ? options.cells[0] / 8 : options.cells[0], weak,
                            options.jitter)),
        context_(options.threads, core::Log()), part_(make_part(layout_, world.rank())) {}

  std::vector<Row> run() {
    commits();
    const double points = items(double(o_.points));
    locate(std::int64_t(points));
    tracers(std::int64_t(points / 4));
    frames();
    adaptive();
    return std::move(rows_);
  }

private:
  bool alone() const { return world_.size() == 1; }
  /// Weak runs have an eighth of the items on each process.
  double items(double of_all) const { return weak_ ? of_all / 8 * world_.size() : of_all; }
  Vec3d random_point(std::uint64_t seed, std::uint64_t i, const Vec3d& low,
                     const Vec3d& high) const {
    Vec3d x;
    for (int a = 0; a < 3; ++a)
      x[a] = std::lerp(low[a], high[a], core::random_unit(seed, i, std::uint64_t(a)));
    return x;
  }

  /// prepare() before each repetition is not measured.
  template <class Prepare, class Work>
  Row& measure(const std::string& name, const Cost& model, Prepare&& prepare, Work&& work) {
    std::vector<double> seconds, works, imbalances;
    Row row{name, weak_, world_.size(), model, {}, 0, 0, 1, 0, 0, 0};
    for (int i = 0; i < o_.repetitions; ++i) {
      prepare();
      world_.agree(nullptr); // all begin together
      const parallel::Traffic before = world_.traffic();
      const double wall = seconds_by(CLOCK_MONOTONIC), busy = seconds_by(CLOCK_PROCESS_CPUTIME_ID);
      work();
      const parallel::Traffic& now = world_.traffic();
      double longest[] = {seconds_by(CLOCK_MONOTONIC) - wall,
                          seconds_by(CLOCK_PROCESS_CPUTIME_ID) - busy -
                              (now.processor_seconds - before.processor_seconds)};
      std::int64_t sums[] = {std::llround(1e9 * longest[1]), now.messages - before.messages,
                             now.bytes - before.bytes};
      row.counted.exchanges = double(now.exchanges - before.exchanges);
      row.reductions = double(now.reductions - before.reductions);
      world_.reduce(std::span(sums), Reduction::sum);
      world_.reduce(std::span(longest), Reduction::greatest);
      seconds.push_back(longest[0]);
      works.push_back(1e-9 * double(sums[0]));
      imbalances.push_back(works.back() > 0 ? longest[1] * world_.size() / works.back() : 1.0);
      row.counted.messages = double(sums[1]);
      row.counted.bytes = double(sums[2]);
    }
    row.counted.items = model.items;
    row.seconds = median(seconds);
    row.work = median(works);
    row.imbalance = median(imbalances);
    rows_.push_back(row);
    return rows_.back();
  }

  void commit() { mesh_->commit(context_.threads, context_.log, context_.memory, true); }
  void meet_others() {
    if (!alone())
      mesh_->update_halo(world_, context_.threads, context_.log);
  }

  void register_mesh() {
    mesh_ = std::make_unique<commit::CommittedMesh>("bench", context_.memory);
    const std::int64_t vertices = part_.vertex_count(), count = std::int64_t(part_.ids.size());
    insitu_cells cells = insitu_cells_default();
    cells.count = count;
    cells.shape = INSITU_HEXAHEDRON;
    cells.connectivity = insitu_array_of(part_.connectivity.data(), INSITU_INT32, count, 8);
    const insitu_array points = insitu_array_of(part_.points.data(), INSITU_FLOAT64, vertices, 3);
    const insitu_array ids = insitu_array_of(part_.ids.data(), INSITU_INT64, count, 1);
    const insitu_array distance =
        insitu_array_of(part_.distance.data(), INSITU_FLOAT64, vertices, 1);
    const insitu_array velocity =
        insitu_array_of(part_.velocity.data(), INSITU_FLOAT64, vertices, 3);
    mesh::Mesh& to = mesh_->mesh();
    to.set_is_part(!alone());
    to.set_points(0, &points, 1);
    to.set_cells(0, &cells);
    to.set_global_ids(0, INSITU_CELL, &ids);
    to.set_field(0, "f", INSITU_VERTEX, &distance, 1);
    to.set_field(0, "velocity", INSITU_VERTEX, &velocity, 1);
  }

  void commits() {
    Row& found = measure(
        "commit: new cells",
        alone() ? Cost{double(layout_.cell_count()), 0, 0, 0} : found_halo(layout_, vertex_fields),
        [&] { register_mesh(); },
        [&] {
          commit();
          meet_others();
          (void)mesh_->tree(); // as in a session: asked for once the halo is there
        });
    std::int64_t cells = mesh_->halo() ? mesh_->halo()->cell_count() : 0;
    world_.reduce(std::span(&cells, 1), Reduction::sum);
    found.halo_cells = double(cells);
    found.halo_cells_by_model = halo_cells(layout_);
    const auto move = [&] {
      mesh_->mesh().set_changed(INSITU_CHANGED_GEOMETRY | INSITU_CHANGED_FIELDS);
    };
    for (int step = 0; step < 4; ++step) { // of the first ones seams are looked at again
      move();
      commit();
      meet_others();
    }
    measure("commit: moved",
            alone() ? Cost{double(layout_.cell_count()), 0, 0, 0}
                    : refreshed_halo(layout_, vertex_fields),
            move, [&] {
              commit();
              meet_others();
              (void)mesh_->tree();
            });
    mesh_->look_for_folds(context_.threads);
  }

  void locate(std::int64_t count) {
    std::vector<Vec3d> here, anywhere;
    const Layout::Part part = layout_.part(world_.rank());
    const Vec3d low = layout_.low(part), high = layout_.high(part), size = layout_.size();
    const std::int64_t mine = count / world_.size();
    for (std::int64_t i = mine * world_.rank(); i < mine * (world_.rank() + 1); ++i) {
      here.push_back(random_point(2, std::uint64_t(i), low, high));
      anywhere.push_back(random_point(2, std::uint64_t(i), {}, size));
    }
    Answers answers(here.size());
    const double points = double(mine * world_.size());
    measure(
        "locate, own points", Cost{points, 0, 0, 0}, [] {},
        [&] { sample(context_.threads, *mesh_, here, answers, {}); });
    const std::vector<std::string> fields{"f"};
    std::int64_t owned = 0;
    measure(
        "locate, everywhere", alone() ? Cost{points, 0, 0, 0} : asked_everywhere(layout_, points),
        [] {},
        [&] {
          if (alone())
            return sample(context_.threads, *mesh_, anywhere, answers, {});
          commit::Everywhere everywhere(*mesh_, world_);
          everywhere.sample(anywhere, fields, {}, context_.threads,
                            [&](std::size_t, std::span<const commit::OwnerOfAll> owners,
                                std::span<const double>) {
                              owned += std::ranges::count_if(
                                  owners, [](const commit::OwnerOfAll& o) { return bool(o); });
                            });
        });
  }

  void tracers(std::int64_t count) {
    std::vector<Vec3d> seeds;
    for (std::int64_t i = 0; i < count; ++i)
      seeds.push_back(random_point(3, std::uint64_t(i), {}, layout_.size()));
    advect::TracerSettings settings;
    settings.integrator.face_aware = true;
    const double seconds = 2 * layout_.width; // some cells
    const scene::MeshHomes homes(*mesh_);
    const advect::Across across{world_, homes};
    const query::Sampler sampler = mesh_->sampler();
    const mesh::FieldView velocity = mesh_->mesh().field("velocity");
    std::unique_ptr<advect::Tracer> tracer;
    Cost model = alone() ? Cost{} : moved_particles(layout_, double(count), seconds);
    model.items = double(count);
    measure(
        "tracers", model,
        [&] {
          tracer = std::make_unique<advect::Tracer>(settings, context_.memory);
          if (alone())
            tracer->seed(seeds, 0.0);
          else
            tracer->seed(seeds, 0.0, sampler, across);
        },
        [&] {
          if (alone())
            tracer->advance(sampler, velocity, {}, 0.0, seconds, context_.threads);
          else
            tracer->advance(across, sampler, velocity, {}, 0.0, seconds, context_.threads);
        });
  }

  void frames() {
    const Vec3d size = layout_.size();
    const double least = std::min({size.x, size.y, size.z}), radius = 0.4 * least;
    const double most = 0.5 * std::sqrt(dot(size, size)), step = 0.5 * layout_.width;
    render::FrameSettings bare;
    bare.width = bare.height = o_.size;
    bare.camera = render::Camera::around({}, size, 30, 20, 1.2);
    const render::ScalarField field{mesh_->mesh().field("f"), 0};
    render::FrameSettings volume = bare;
    // Everything shows, and nothing hides the rest.
    volume.volume = render::VolumeSettings{
        field, {render::ColorMap::built_in("viridis"), 0.0, most, {{0.0, 0.002}, {most, 0.004}}}};
    volume.volume->step = step;
    volume.volume->unit_distance = 0.01 * most;
    render::FrameSettings integrated = volume;
    integrated.volume->preintegrated = true;
    render::FrameSettings surface = bare;
    surface.isosurfaces.push_back({field, {radius}, 0.5});
    if (!alone())
      mesh_->set_whole_facts(
          render::whole_facts(world_, mesh::find_facts(mesh_->mesh().view(), &context_.threads)));
    const Cost of_volume = drawn_volume(layout_, volume, step);
    draw("frame: volume", of_volume, volume);
    draw("frame: pre-integrated", of_volume, integrated);
    draw("frame: standard", composited_volume(layout_, volume, step), volume,
         render::Compositing::standard);
    draw("frame: isosurface", drawn_sphere(layout_, surface, 0.5 * size, radius), surface);
  }

  void draw(const std::string& name, Cost model, const render::FrameSettings& settings,
            render::Compositing compositing = render::Compositing::exact) {
    if (alone())
      model = {model.items, 0, 0, 0};
    const std::int64_t own = mesh_->mesh().view().own_cell_count();
    render::FramePart part{
        world_, own, [&](std::int64_t flat) { return mesh_->mesh().global_id(INSITU_CELL, flat); }};
    part.compositing = compositing;
    std::unique_ptr<render::Structures> structures;
    measure(
        name, model, [&] { structures = std::make_unique<render::Structures>(context_.memory); },
        [&] {
          const query::Sampler sampler = mesh_->own_sampler();
          structures->begin(sampler, 0, 0, context_.threads);
          if (alone())
            (void)render::render_frame(sampler, settings, *structures, context_.threads);
          else
            (void)render::render_shared_frame(part, sampler, settings, *structures,
                                              context_.threads);
        });
  }

  /// An octree, its dual and the leaves around this process's.
  void adaptive() {
    const LeafLayout layout(world_.size(), weak_ ? o_.cells[0] / 8 : o_.cells[0], weak_);
    const LeafCosts costs = cost_of_leaves(layout);
    const PartLeaves leaves = make_leaves(layout, world_.rank());
    const std::int64_t count = std::int64_t(leaves.levels.size());
    insitu_amr amr = insitu_amr_default();
    std::ranges::fill(amr.spacing, layout.coarse.width);
    amr.level_count = 2;
    insitu_leaves given = insitu_leaves_default();
    given.levels = insitu_array_of(leaves.levels.data(), INSITU_INT32, count, 1);
    given.corners = insitu_array_of(leaves.corners.data(), INSITU_INT32, count, 3);
    const insitu_array values = insitu_array_of(leaves.values.data(), INSITU_FLOAT64, count, 1);
    const auto commit_all = [&] {
      commit();
      meet_others();
      (void)mesh_->mesh().field("f"); // at the dual's vertices
    };
    Row& found = measure(
        "adaptive: new leaves", costs.found,
        [&] {
          mesh_ = std::make_unique<commit::CommittedMesh>("bench", context_.memory);
          mesh::Mesh& to = mesh_->mesh();
          to.set_is_part(!alone());
          to.set_amr(&amr);
          to.set_leaves(0, &given);
          to.set_field(0, "f", INSITU_CELL, &values, 1);
        },
        commit_all);
    std::int64_t halo = mesh_->halo() ? mesh_->halo()->cell_count() : 0;
    world_.reduce(std::span(&halo, 1), Reduction::sum);
    found.halo_cells = double(halo);
    found.halo_cells_by_model = costs.halo_leaves;
    measure(
        "adaptive: new values", costs.refreshed,
        [&] { mesh_->mesh().set_changed(INSITU_CHANGED_FIELDS); }, commit_all);
  }

  parallel::World& world_;
  const Options& o_;
  const bool weak_;
  const Layout layout_;
  core::Context context_;
  PartMesh part_;
  std::unique_ptr<commit::CommittedMesh> mesh_;
  std::vector<Row> rows_;
};

} // namespace

std::vector<Row> measure(parallel::World& world, const Options& options) {
  std::vector<Row> rows;
  for (const bool weak : {false, true})
    for (Row& row : Process(world, options, weak).run())
      rows.push_back(std::move(row));
  return rows;
}

} // namespace insitu::bench::scaling
