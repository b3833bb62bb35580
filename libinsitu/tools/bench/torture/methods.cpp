#include "torture/methods.h"

#include <algorithm>

#include "commit/committed_mesh.h"
#include "core/context.h"
#include "core/random.h"
#include "peers/peers.h"
#include "setup.h"

namespace insitu::bench::torture {

namespace {

using math::Vec3d;

enum class Way { batch, single, hinted };

/// A hint in turn: the cell that the point was made from, the answer before, any cell.
std::int64_t hint_for(std::size_t i, const Point& point, std::int64_t before, std::int64_t cells) {
  if (i % 3 == 0)
    return point.made_in;
  return i % 3 == 1 ? before : std::int64_t(core::random_bits(22, i, 0) % std::uint64_t(cells));
}

Answers ours(const query::Sampler& sampler, const core::Threads& threads,
             const std::vector<Point>& points, insitu_accuracy accuracy, Way way) {
  query::LocateOptions options;
  options.accuracy = accuracy;
  std::vector<query::Location> found(points.size());
  Answers out;
  out.reasons.resize(points.size());
  if (way == Way::batch) {
    std::vector<Vec3d> at;
    for (const Point& p : points)
      at.push_back(p.at);
    std::vector<std::uint8_t> reasons(points.size());
    sampler.locate(threads, at, found, options, reasons);
    std::transform(reasons.begin(), reasons.end(), out.reasons.begin(),
                   [](std::uint8_t reason) { return query::Reason(reason); });
  } else {
    std::int64_t before = -1;
    for (std::size_t i = 0; i < points.size(); ++i) {
      std::int64_t hint = -1;
      if (way == Way::hinted) {
        hint = hint_for(i, points[i], before, sampler.mesh().cell_count());
        out.hints.push_back(hint);
      }
      found[i] = sampler.locate(points[i].at, hint, options, &out.reasons[i]);
      before = found[i].cell;
    }
  }
  for (const query::Location& at : found) {
    out.cells.push_back(at.cell);
    out.parametric.push_back(at.parametric);
  }
  return out;
}

} // namespace

std::vector<Method> answer_by_all(const Case& c, const std::vector<Point>& points,
                                  std::vector<std::string>& columns) {
  std::vector<Method> out;
  core::Context context(1, core::Log(INSITU_LOG_ERROR, nullptr, nullptr));
  commit::CommittedMesh mesh("torture", context.memory);
  const std::vector<float> floats(c.mesh.points.begin(), c.mesh.points.end());
  const insitu_array xyz =
      c.float32 ? insitu_array_of(floats.data(), INSITU_FLOAT32, c.mesh.vertex_count(), 3)
                : insitu_array_of(c.mesh.points.data(), INSITU_FLOAT64, c.mesh.vertex_count(), 3);
  const insitu_cells cells = cells_of(c.mesh);
  mesh.mesh().set_points(0, &xyz, 1);
  mesh.mesh().set_cells(0, &cells);
  mesh.commit(context.threads, context.log, context.memory, false);
  columns = {"standard", "exact"};
  constexpr const char* ways[] = {"batch", "single", "hinted"};
  for (int column = 0; column < 2; ++column)
    for (int way = 0; way < 3; ++way)
      out.push_back({columns[std::size_t(column)] + "_" + ways[way], column,
                     ours(mesh.sampler(), context.threads, points,
                          column == 0 ? INSITU_STANDARD : INSITU_EXACT, Way(way))});

  const std::vector<double> field = workload::vertex_field(c.mesh);
  std::vector<Vec3d> at;
  for (const Point& p : points)
    at.push_back(p.at);
  for (const auto& peer : make_peers(c.mesh, field)) {
    if (!peer->tells_cells())
      continue;
    peer->build();
    Answers answers{
        std::vector<std::int64_t>(points.size()), std::vector<Vec3d>(points.size()), {}, {}};
    peer->locate(at, answers.cells, answers.parametric);
    columns.emplace_back(peer->name());
    out.push_back({peer->name(), int(columns.size()) - 1, std::move(answers)});
  }
  return out;
}

} // namespace insitu::bench::torture
