#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>

#include "adaptive_meshes.h"
#include "commands/amr_frames.h"
#include "commands/amr_sizes.h"
#include "commands.h"
#include "report/format.h"
#include "peers/openvkl_parts.h"

namespace insitu::bench {

namespace {

using core::Threads;

/// Points of the raster along an edge: the workload's, or fewer where few are asked for.
int raster_side(const Options& o) {
  return o.points > 0 ? std::clamp(int(std::cbrt(double(o.points))), 1, 160) : 160;
}

/// One way to keep one mesh.
struct Row {
  std::string name;
  std::int64_t leaves = 0;
  Series build;            ///< a regrid: from the solver's arrays to ready to sample one field
  Series fields;           ///< a commit of new values, up to ready
  Series random, coherent; ///< a sample of one field at every point
  std::int64_t random_points = 0, coherent_points = 0;
  std::int64_t bytes = 0, bytes_values = 0, bytes_tree = 0;
  std::int64_t lost = 0;
  double error = 0.0;                ///< at the cells' centres
  std::int64_t wrong_at_centres = 0; ///< by more than float rounds
  /// Open VKL at the same points, in turns, by the method that is this one's peer.
  struct {
    Series random, coherent;
    int width = 0; ///< points abreast
    bool empty() const { return random.empty(); }
  } peer;
  std::optional<insitu_amr_info> info;
  // Of the dual mesh:
  double compression = 0.0;
  struct Part {
    double share = 0.0;       ///< of the raster's points
    double nanoseconds = 0.0; ///< a sample of one of them alone
    double certified = 0.0;   ///< of them, proven strictly inside in floating point
  } in_gridlets, in_stitching;
};

class Bench {
  using Method = OpenVklAmr::Method;

public:
  explicit Bench(const Options& o)
      : o_(o), context_(o.threads, core::Log()), blocks_(workload::make_amr(o.cells[0])),
        leaves_(workload::leaves_of(blocks_)),
        random_(workload::random_amr_points(o.points > 0 ? o.points : 1'000'000)),
        raster_(workload::raster_amr_points(raster_side(o))) {
    look_at(leaves_, blocks_.spacing);
    if (o.peers)
      peer_ = make_openvkl_amr(blocks_, context_.threads.count());
  }

  std::vector<Row> run() {
    std::vector<Row> rows;
    Series peer_build = build_peer();
    progress("patches, dual");
    auto patches = make(INSITU_DUAL, true);
    rows.push_back(measure("patches, dual mesh", *patches, Method::octant));
    rows.push_back(as_plain(std::move(patches), rows[0].leaves));
    progress("patches, nearest");
    rows.push_back(measure("patches, nearest", *make(INSITU_NEAREST, true), Method::finest));
    progress("leaves, dual");
    rows.push_back(measure("octree leaves, dual mesh", *make(INSITU_DUAL, false)));
    progress("leaves, nearest");
    rows.push_back(measure("octree leaves, nearest", *make(INSITU_NEAREST, false)));
    add_octree(rows, "front octree", workload::make_front_octree(o_.cells[0]));
    add_octree(rows, "random octree", workload::make_octree(o_.cells[0]));
    look_at(leaves_, blocks_.spacing);
    if (peer_) {
      rows.push_back(peer_row("Open VKL, octant", Method::octant, peer_build, rows[0]));
      rows.push_back(peer_row("Open VKL, finest", Method::finest, peer_build, rows[2]));
    }
    return rows;
  }

  const Threads& threads() const { return context_.threads; }

private:
  std::unique_ptr<commit::CommittedMesh> make(insitu_reconstruction reconstruction,
                                              bool as_patches) {
    return as_patches ? register_patches(blocks_, reconstruction, context_.memory)
                      : register_leaves(leaves_, blocks_.spacing, blocks_.level_count,
                                        reconstruction, context_.memory);
  }

  /// Values at the centres of these leaves are what rows are held against from here on.
  void look_at(const workload::AmrLeaves& leaves, double spacing) {
    at_centres_ = leaves.values;
    centres_.resize(leaves.levels.size());
    for (std::size_t i = 0; i < centres_.size(); ++i)
      for (int a = 0; a < 3; ++a)
        centres_[i][a] = (leaves.corners[3 * i + std::size_t(a)] + 0.5) * spacing /
                         double(1 << leaves.levels[i]);
  }

  /// The dual mesh of one that is no longer needed, vertices at one place made one.
  Row as_plain(std::unique_ptr<commit::CommittedMesh> dual, std::int64_t leaves) {
    progress("plain dual");
    const PlainDual plain = welded(plain_dual(*dual));
    dual.reset();
    const auto mesh = register_plain(plain, context_.memory);
    Row row = measure("the same as plain hexahedra", *mesh);
    row.leaves = leaves;
    row.bytes += plain.bytes();
    row.bytes_values = plain.bytes_values();
    return row;
  }

  void add_octree(std::vector<Row>& rows, const std::string& name, const workload::Octree& octree) {
    progress(name);
    look_at(octree.leaves, octree.spacing);
    auto dual = register_leaves(octree.leaves, octree.spacing, octree.level_count, INSITU_DUAL,
                                context_.memory);
    rows.push_back(measure(name + ", dual mesh", *dual));
    const std::int64_t leaves = rows.back().leaves;
    rows.push_back(as_plain(std::move(dual), leaves));
    rows.back().name = name + ", plain cells";
  }

  Series build_peer() {
    Series build;
    if (!peer_)
      return build;
    progress("Open VKL");
    peer_->build(); // touches pages
    for (int i = 0; i < o_.repetitions; ++i)
      build.time([&] { peer_->build(); });
    return build;
  }

  /// ours: the row that was measured in turns with it.
  Row peer_row(const std::string& name, Method method, const Series& build, const Row& ours) {
    Row row;
    row.name = name;
    row.leaves = ours.leaves;
    row.build = build;
    row.random = ours.peer.random;
    row.random_points = ours.random_points;
    row.coherent = ours.peer.coherent;
    row.coherent_points = ours.coherent_points;
    row.bytes_values = peer_->bytes_values();
    row.bytes_tree = peer_->bytes();
    const auto sample = [&](const std::vector<math::Vec3d>& points) {
      peer_->set_points(points);
      return peer_->sample(method, context_.threads);
    };
    row.lost = lost(sample(raster_));
    check_centres(sample(centres_), row);
    return row;
  }

  Row measure(const std::string& name, commit::CommittedMesh& mesh,
              std::optional<Method> peer = std::nullopt) {
    Row row;
    row.name = name;
    const auto commit = [&](std::uint32_t what) {
      mesh.mesh().set_changed(what);
      mesh.commit(context_.threads, context_.log, context_.memory, true);
      (void)mesh.mesh().field("f"); // gathered when asked for
    };
    commit(INSITU_CHANGED_ALL); // touches pages
    for (int i = 0; i < o_.repetitions; ++i) {
      row.build.time([&] { commit(INSITU_CHANGED_ALL); });
      row.fields.time([&] { commit(INSITU_CHANGED_FIELDS); });
    }
    const mesh::Mesh& m = mesh.mesh();
    if (m.is_adaptive()) {
      row.info = mesh.amr_info();
      row.leaves = row.info->leaves;
      row.bytes = row.info->bytes;
      if (m.has_stand_in())
        row.compression = cube_bytes(m.view(), row.info->cubes).compression();
      row.bytes_values = context_.memory.current(INSITU_MEMORY_GATHERED);
    }
    row.bytes_tree = mesh.tree().bytes();
    row.peer.width = peer_ ? peer_->width() : 0;
    if (!peer_)
      peer.reset();
    sample_all(mesh, random_, row.random, peer, &row.peer.random);
    row.random_points = std::int64_t(random_.size());
    row.lost = sample_all(mesh, raster_, row.coherent, peer, &row.peer.coherent);
    row.coherent_points = std::int64_t(raster_.size());
    if (m.has_stand_in())
      split_raster(mesh, row);
    std::vector<double> at_centres(centres_.size());
    sample(mesh, centres_, at_centres);
    check_centres(std::span<const double>(at_centres), row);
    return row;
  }

  template <class T>
  void check_centres(std::span<const T> values, Row& row) const {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double error = std::fabs(double(values[i]) - at_centres_[i]);
      row.error = error <= row.error ? row.error : error; // keeps a NaN
      row.wrong_at_centres += !(error <= 1e-5);           // values reach 6
    }
  }
  template <class T>
  static std::int64_t lost(std::span<const T> values) {
    return std::count_if(values.begin(), values.end(), [](T v) { return std::isnan(v); });
  }

  /// What a point of the raster costs in gridlets and in stitching cells.
  void split_raster(const commit::CommittedMesh& mesh, Row& row) {
    const query::Sampler sampler = mesh.sampler();
    std::vector<query::Location> at(raster_.size());
    std::vector<std::uint8_t> reasons(raster_.size());
    sampler.locate(context_.threads, raster_, at, {}, reasons);
    const std::int64_t first = sampler.mesh().first_cell[1];
    for (const bool gridlets : {true, false}) {
      Row::Part& part = gridlets ? row.in_gridlets : row.in_stitching;
      std::vector<math::Vec3d> points;
      std::int64_t certified = 0;
      for (std::size_t i = 0; i < at.size(); ++i)
        if (at[i] && (at[i].cell < first) == gridlets) {
          points.push_back(raster_[i]);
          certified += reasons[i] == std::uint8_t(query::Reason::certified);
        }
      if (points.empty())
        continue;
      Series series;
      (void)sample_all(mesh, points, series);
      part.share = double(points.size()) / double(raster_.size());
      part.nanoseconds = 1e9 * series.median() / double(points.size());
      part.certified = double(certified) / double(points.size());
    }
  }

  /// Values alone, as Open VKL gives them.
  void sample(const commit::CommittedMesh& mesh, std::span<const math::Vec3d> points,
              std::vector<double>& values) const {
    const query::Sampler sampler = mesh.sampler();
    const mesh::FieldView field = mesh.mesh().field("f");
    double* const to = values.data();
    sampler.visit(context_.threads, points, {}, [&](const query::Answered& answered) {
      sampler.interpolate(std::span(&field, 1), answered, 0, &to);
    });
  }

  /// Returns how many points had no value. With a peer's method: that too, in turns.
  std::int64_t sample_all(const commit::CommittedMesh& mesh, std::span<const math::Vec3d> points,
                          Series& series, std::optional<Method> peer = std::nullopt,
                          Series* peers_series = nullptr) {
    std::vector<double> values(points.size());
    sample(mesh, points, values); // touches pages
    if (peer)
      peer_->set_points(points);
    for (int i = 0; i < o_.repetitions; ++i) {
      series.time([&] { sample(mesh, points, values); });
      if (peer)
        peers_series->time([&] { (void)peer_->sample(*peer, context_.threads); });
    }
    return lost(std::span<const double>(values));
  }

  const Options& o_;
  core::Context context_;
  workload::AmrMesh blocks_;
  workload::AmrLeaves leaves_;
  std::vector<math::Vec3d> random_, raster_, centres_;
  std::vector<double> at_centres_;
  std::unique_ptr<OpenVklAmr> peer_;
};

double mqps(std::int64_t points, const Series& s) {
  return 1e-6 * double(points) / s.median();
}

} // namespace

Output amr(const Options& options) {
  if (options.sizes)
    return measure_amr_sizes(options);
  Bench bench(options);
  const std::vector<Row> rows = bench.run();
  const auto times = [&](const Series& theirs, const Series& ours) {
    return theirs.for_ratio(bench.threads().count()) / ours.for_ratio(bench.threads().count());
  };
  Output out;
  out.text = format("adaptive mesh of %s leaves in 3 levels, %d thread%s, medians of %d\n\n",
                    grouped(rows[0].leaves).c_str(), bench.threads().count(),
                    bench.threads().count() == 1 ? "" : "s", options.repetitions);
  out.text += format("%-28s %8s %9s %8s %8s %8s %8s %8s %6s %9s %8s\n", "", "build s", "Mleaves/s",
                     "fields s", "random", "raster", "MB", "tree MB", "lost", "error", "wrong");
  AmrFrames frames = measure_amr_frames(options);
  out.exit_code = frames.differ ? 1 : 0;
  Json& json = frames.json;
  for (const Row& r : rows) {
    const double random = mqps(r.random_points, r.random);
    const double coherent = mqps(r.coherent_points, r.coherent);
    const std::string fields = r.fields.empty() ? "-" : format("%.3f", r.fields.median());
    out.text +=
        format("%-28s %8.3f %9.2f %8s %8.2f %8.2f %8.1f %8.1f %6lld %9.1e %8lld\n", r.name.c_str(),
               r.build.median(), 1e-6 * double(r.leaves) / r.build.median(), fields.c_str(), random,
               coherent, 1e-6 * double(r.bytes + r.bytes_values), 1e-6 * double(r.bytes_tree),
               static_cast<long long>(r.lost), r.error, static_cast<long long>(r.wrong_at_centres));
    Json& row = json[r.name];
    row = {{"leaves", r.leaves},
           {"build_s", number(r.build.median())},
           {"fields_s", r.fields.empty() ? Json() : number(r.fields.median())},
           {"mqps", number(random)},
           {"mqps_raster", number(coherent)},
           {"bytes", r.bytes + r.bytes_values + r.bytes_tree}};
    if (r.info)
      row.update({{"compression", number(r.compression)},
                  {"gridlets", r.info->gridlets},
                  {"cubes", r.info->cubes},
                  {"stitching", r.info->stitching},
                  {"folded", r.info->folded},
                  {"repaired", r.info->repaired}});
    if (!r.peer.empty())
      row.update({{"ratio_random", number(times(r.peer.random, r.random))},
                  {"ratio_raster", number(times(r.peer.coherent, r.coherent))}});
    row.update({{"lost", r.lost},
                {"max_error_at_centres", number(r.error)},
                {"wrong_at_centres", r.wrong_at_centres}});
  }
  out.json = json_text(json);
  const insitu_amr_info& info = *rows[0].info;
  out.text += format("\ndual mesh of the patches: %s gridlets of %s cubes, %s stitching cells, "
                     "%s folded, %s leaves split\n",
                     grouped(info.gridlets).c_str(), grouped(info.cubes).c_str(),
                     grouped(info.stitching).c_str(), grouped(info.folded).c_str(),
                     grouped(info.repaired).c_str());
  for (const Row& r : rows)
    if (r.info && r.name.find(" octree, ") != std::string::npos)
      out.text +=
          format("%s of %s leaves: %s gridlets of %s cubes, %s stitching cells (%.0f %%)\n",
                 r.name.c_str(), grouped(r.leaves).c_str(), grouped(r.info->gridlets).c_str(),
                 grouped(r.info->cubes).c_str(), grouped(r.info->stitching).c_str(),
                 100.0 * double(r.info->stitching) / double(r.info->stitching + r.info->cubes));
  out.text += format("cubes as gridlets take 1 : %.2f of their bytes as hexahedra (Zellmann 2023, "
                     "table 2: 1 : 7.5 to 1 : 8.3)\n",
                     rows[0].compression);
  const Row::Part &in = rows[0].in_gridlets, &out_of = rows[0].in_stitching;
  out.text +=
      format("of the raster's points %.0f %% lie in gridlets and take %.0f ns each, the others "
             "%.0f ns; %.1f and %.1f %% are proven inside\n"
             "in floating point, and the others lie on faces or go to exact arithmetic\n",
             100 * in.share, in.nanoseconds, out_of.nanoseconds, 100 * in.certified,
             100 * out_of.certified);
  out.text += format("million samples a second of one field at random points and on a raster of "
                     "%d^3; error: at the cells' centres\n(wrong: by more than 1e-5)\n",
                     raster_side(options));
  out.text += "\n" + frames.text;
  if (!options.peers)
    return out;
  out.text += "\n";
  if (rows[0].peer.empty()) {
    out.text += std::string("no samples by Open VKL: ") + no_openvkl + "\n";
    return out;
  }
  for (const auto& [ours, theirs, row] :
       {std::tuple{"dual mesh", "octant", &rows[0]}, {"nearest", "finest", &rows[2]}})
    out.text += format("%s of patches over Open VKL's %s, in turns: %.2f times as many samples a "
                       "second at random points, %.2f on the raster\n",
                       ours, theirs, times(row->peer.random, row->random),
                       times(row->peer.coherent, row->coherent));
  out.text +=
      format("Open VKL: %d wide, in float; a build with its values in float beforehand; MB: "
             "these values; tree MB: all it allocates\n",
             rows[0].peer.width);
  return out;
}

} // namespace insitu::bench
