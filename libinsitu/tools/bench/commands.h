#pragma once

#include <span>
#include <vector>

#include "options.h"
#include "query/sampler.h"
#include "report/report.h"
#include "setup.h"

namespace insitu::bench {

/// What a command prints, and its figures.
struct Output {
  std::string text, json;
  int exit_code = 0;
  std::string advice = {};        ///< a sentence made from the figures, where there is one
  std::string csv = {}, svg = {}; ///< of effects
};
Report commit(const Options& options);
Report locate(const Options& options);
Output run_torture(const Options& options);
Output scale(const Options& options);
Output methods(const Options& options);
Output amr(const Options& options);
Output effects(const Options& options);
Output advect(const Options& options);
Output render(const Options& options);
Output accuracy_command(const Options& options);
Output paper_command(const Options& options);
Output scaling_command(const Options& options);
Output sections(const Options& options);

/// The answers to a set of queries: cells as ids or -1, and the field (NaN outside).
struct Answers {
  explicit Answers(std::size_t points) : locations(points), cells(points), values(points) {}
  std::vector<query::Location> locations;
  std::vector<std::int64_t> cells;
  std::vector<double> values;
};

/// Locates and interpolates "f", as insitu_mesh_sample does; leaves answers.locations.
void sample(const core::Threads& threads, const commit::CommittedMesh& mesh,
            std::span<const math::Vec3d> points, Answers& answers,
            const query::LocateOptions& options);

/// Points located one a call, in microseconds; hinted: by the answer before.
struct Latency {
  double single = 0.0, single_exact = 0.0, hinted = 0.0;
  std::int64_t found = 0; ///< so that no call is optimised away
};
Latency time_single_points(const query::Sampler& sampler, std::span<const math::Vec3d> points);

/// A sample of one field, and of options.fields at once, through a session of insitu.h of its own.
struct FieldTimes {
  Series one, all;
};
FieldTimes time_fields(const Options& options, const workload::Mesh& mesh,
                       const std::vector<double>& field, std::span<const math::Vec3d> points);

/// What the queries make the tree do, on average.
struct Work {
  double nodes = 0.0, candidates = 0.0; ///< a query
};
Work count_work(const accel::Tree& tree, std::span<const math::Vec3d> points);

} // namespace insitu::bench
