#include <algorithm>
#include <cmath>
#include <memory>

#include "adaptive_meshes.h"
#include "commands.h"
#include "format.h"

namespace insitu::bench {

namespace {

using core::Threads;

constexpr int raster = 160; ///< points along an edge

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
  double error = 0.0; ///< at the cells' centres
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
public:
  explicit Bench(const Options& o)
      : o_(o), context_(o.threads, core::Log()), blocks_(workload::make_amr(o.cells[0])),
        leaves_(workload::leaves_of(blocks_)),
        random_(workload::random_amr_points(o.points > 0 ? o.points : 1'000'000)),
        raster_(workload::raster_amr_points(raster)) {
    for (std::size_t i = 0; i < leaves_.levels.size(); ++i) {
      math::Vec3d p;
      for (int a = 0; a < 3; ++a)
        p[a] = (leaves_.corners[3 * i + std::size_t(a)] + 0.5) * blocks_.width(leaves_.levels[i]);
      centres_.push_back(p);
    }
  }

  std::vector<Row> run() {
    std::vector<Row> rows;
    progress("patches, dual");
    auto patches = make(INSITU_DUAL, true);
    rows.push_back(measure("patches, dual mesh", *patches));
    {
      progress("plain dual");
      const PlainDual plain = plain_dual(*patches);
      patches.reset();
      const auto mesh = register_plain(plain, context_.memory);
      Row row = measure("the same as plain hexahedra", *mesh);
      row.leaves = rows[0].leaves;
      row.bytes += plain.bytes();
      row.bytes_values = plain.bytes_values();
      rows.push_back(row);
    }
    progress("patches, nearest");
    rows.push_back(measure("patches, nearest", *make(INSITU_NEAREST, true)));
    progress("leaves, dual");
    rows.push_back(measure("octree leaves, dual mesh", *make(INSITU_DUAL, false)));
    progress("leaves, nearest");
    rows.push_back(measure("octree leaves, nearest", *make(INSITU_NEAREST, false)));
    return rows;
  }

  const Threads& threads() const { return context_.threads; }

private:
  std::unique_ptr<query::CommittedMesh> make(insitu_reconstruction reconstruction,
                                             bool as_patches) {
    return as_patches ? register_patches(blocks_, reconstruction, context_.memory)
                      : register_leaves(leaves_, blocks_.spacing, blocks_.level_count,
                                        reconstruction, context_.memory);
  }

  Row measure(const std::string& name, query::CommittedMesh& mesh) {
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
    sample_all(mesh, random_, row.random);
    row.random_points = std::int64_t(random_.size());
    row.lost = sample_all(mesh, raster_, row.coherent);
    row.coherent_points = std::int64_t(raster_.size());
    if (m.has_stand_in())
      split_raster(mesh, row);
    Answers at_centres(centres_.size());
    sample(context_.threads, mesh, centres_, at_centres, {});
    for (std::size_t i = 0; i < centres_.size(); ++i) {
      const double error = std::fabs(at_centres.values[i] - leaves_.values[i]);
      row.error = error <= row.error ? row.error : error; // keeps a NaN
    }
    return row;
  }

  /// What a point of the raster costs in gridlets and in stitching cells.
  void split_raster(const query::CommittedMesh& mesh, Row& row) {
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

  /// Returns how many points had no value.
  std::int64_t sample_all(const query::CommittedMesh& mesh, std::span<const math::Vec3d> points,
                          Series& series) {
    Answers answers(points.size());
    sample(context_.threads, mesh, points, answers, {}); // touches pages
    for (int i = 0; i < o_.repetitions; ++i)
      series.time([&] { sample(context_.threads, mesh, points, answers, {}); });
    return std::count_if(answers.values.begin(), answers.values.end(),
                         [](double v) { return std::isnan(v); });
  }

  const Options& o_;
  core::Context context_;
  workload::AmrMesh blocks_;
  workload::AmrLeaves leaves_;
  std::vector<math::Vec3d> random_, raster_, centres_;
};

double mqps(std::int64_t points, const Series& s) {
  return 1e-6 * double(points) / s.median();
}

} // namespace

Output amr(const Options& options) {
  Bench bench(options);
  const std::vector<Row> rows = bench.run();
  Output out;
  out.text = format("adaptive mesh of %s leaves in 3 levels, %d thread%s, medians of %d\n\n",
                    grouped(rows[0].leaves).c_str(), bench.threads().count(),
                    bench.threads().count() == 1 ? "" : "s", options.repetitions);
  out.text += format("%-28s %8s %9s %8s %8s %8s %8s %8s %6s %9s\n", "", "build s", "Mleaves/s",
                     "fields s", "random", "raster", "MB", "tree MB", "lost", "error");
  out.json = "{\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& r = rows[i];
    const double random = mqps(r.random_points, r.random);
    const double coherent = mqps(r.coherent_points, r.coherent);
    out.text += format("%-28s %8.3f %9.2f %8.3f %8.2f %8.2f %8.1f %8.1f %6lld %9.1e\n",
                       r.name.c_str(), r.build.median(), 1e-6 * double(r.leaves) / r.build.median(),
                       r.fields.median(), random, coherent, 1e-6 * double(r.bytes + r.bytes_values),
                       1e-6 * double(r.bytes_tree), static_cast<long long>(r.lost), r.error);
    out.json += format("  %s: {\"leaves\": %lld, \"build_s\": %s, \"fields_s\": %s, "
                       "\"mqps\": %s, \"mqps_raster\": %s, \"bytes\": %lld, ",
                       quoted(r.name).c_str(), static_cast<long long>(r.leaves),
                       number(r.build.median()).c_str(), number(r.fields.median()).c_str(),
                       number(random).c_str(), number(coherent).c_str(),
                       static_cast<long long>(r.bytes + r.bytes_values + r.bytes_tree));
    if (r.info)
      out.json +=
          format("\"compression\": %s, \"gridlets\": %lld, \"cubes\": %lld, "
                 "\"stitching\": %lld, \"folded\": %lld, \"repaired\": %lld, ",
                 number(r.compression).c_str(), static_cast<long long>(r.info->gridlets),
                 static_cast<long long>(r.info->cubes), static_cast<long long>(r.info->stitching),
                 static_cast<long long>(r.info->folded), static_cast<long long>(r.info->repaired));
    out.json +=
        format("\"lost\": %lld, \"max_error_at_centres\": %s}%s\n", static_cast<long long>(r.lost),
               number(r.error).c_str(), i + 1 < rows.size() ? "," : "");
  }
  out.json += "}\n";
  const insitu_amr_info& info = *rows[0].info;
  out.text += format("\ndual mesh of the patches: %s gridlets of %s cubes, %s stitching cells, "
                     "%s folded, %s leaves split\n",
                     grouped(info.gridlets).c_str(), grouped(info.cubes).c_str(),
                     grouped(info.stitching).c_str(), grouped(info.folded).c_str(),
                     grouped(info.repaired).c_str());
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
  out.text += "million samples a second of one field at random points and on a raster of 160^3; "
              "error: at the cells' centres\n";
  return out;
}

} // namespace insitu::bench
