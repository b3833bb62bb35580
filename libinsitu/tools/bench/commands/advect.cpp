#include "commands/advect.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "advect/lanes/lanes.h"
#include "commands.h"
#include "commands/lines_by_length.h"
#include "core/random.h"
#include "report/format.h"
#include "report/json.h"
#include "workload/flow.h"

namespace insitu::bench {

namespace {

using advect::IntegratorSettings;
using advect::Method;
using math::Vec3d;

struct Row {
  std::string name;
  double seconds = 0.0;     ///< on one thread: of the processor
  double all_seconds = 0.0; ///< on all
  advect::Work work;
  std::int64_t left = 0; ///< the box before their time
  std::int64_t lost = 0; ///< ended otherwise: none should
  double error = 0.0;    ///< root of the mean square, in cells
  double across = 0.0;   ///< the part of it that is across the line
};

class Bench {
public:
  explicit Bench(const Options& o) : o_(o), setup_(o), all_(0) {
    mesh_ = setup_.register_mesh();
    velocity_.resize(setup_.mesh.points.size());
    for (std::int64_t v = 0; v < setup_.mesh.vertex_count(); ++v)
      for (int a = 0; a < 3; ++a)
        velocity_[std::size_t(3 * v + a)] = workload::abc_flow(setup_.mesh.point(v))[a];
    const insitu_array values =
        insitu_array_of(velocity_.data(), INSITU_FLOAT64, setup_.mesh.vertex_count(), 3);
    mesh_->mesh().set_field(0, "velocity", INSITU_VERTEX, &values, 1);
    setup_.commit(*mesh_);
    mesh_->look_for_folds(all_);
    if (advect::CellsBeyond(mesh_->sampler()).lacks_neighbours()) {
      neighbours_.time([&] { mesh_->find_neighbours(all_); });
      neighbour_bytes_ = mesh_->neighbours_bytes(all_);
    }
    seeds_.resize(std::size_t(o.points > 0 ? o.points : 2000));
    for (std::size_t i = 0; i < seeds_.size(); ++i)
      for (int a = 0; a < 3; ++a)
        seeds_[i][a] = 0.2 + 0.6 * core::random_unit(12, i, std::uint64_t(a));
  }

  Output run() {
    std::vector<PeerLines> peers;
    if (o_.peers) {
      progress("vtkStreamTracer");
      peers = trace_by_vtk(setup_.mesh, velocity_, seeds_, length, 0.25, 1e-6, o_.repetitions);
    }
    // Lines about as long as VTK's; its own are held against the truth at their length.
    times_.assign(seeds_.size(), 0.12);
    if (!peers.empty())
      times_ = peers[0].times;
    truth_ = reference(times_);
    text_ = "insitu-bench advect: " + describe(o_, setup_.mesh.cell_count(), 1) + ", " +
            std::to_string(seeds_.size()) +
            " lines of the ABC flow\nError: of the ends, in cells, root of the mean square, "
            "against the same interpolated velocity integrated to 1e-13;\nacross: the part of it "
            "that is across the lines, "
            "which alone a library's lines by length are held to.\n" +
            (neighbour_bytes_ > 0
                 ? format("Cells across faces, where numbers do not tell: found in %.3f s of the "
                          "processor, %.1f MB.\n",
                          neighbours_.for_ratio(1), 1e-6 * double(neighbour_bytes_))
                 : std::string()) +
            "\n" +
            format("%-34s %9s %9s %9s %9s %8s %9s %9s %6s %6s\n", "", "s, core",
                   format("s, %d", all_.count()).c_str(), "M step/s", "M eval/s", "eval/st",
                   "error", "across", "left", "lost");
    json_ = {{"lines", seeds_.size()}, {"rows", Json::array()}, {"peers", Json::array()}};
    for (const double cells : {1.0, 0.5, 0.25, 0.125})
      for (const bool aware : {false, true})
        add(measure(Method::rk4, aware, cells));
    for (const bool aware : {false, true})
      for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-6, 1e-8})
        add(measure(Method::dopri5, aware, tolerance));
    for (const double tolerance : {1e-2, 1e-4})
      add(measure(Method::bs32, false, tolerance));
    for (const PeerLines& peer : peers)
      add(peer);
    return {text_, json_text(json_), 0};
  }

private:
  static constexpr double length = 0.4; ///< of VTK's lines

  struct Ends {
    std::int64_t left = 0, lost = 0;
  };
  double cell() const { return setup_.mesh.cell_size; }

  /// Ends of all lines; vertices are kept for as long as a line lasts, as who wants lines does.
  std::vector<Vec3d> trace(const IntegratorSettings& settings, const std::vector<double>& times,
                           const core::Threads& threads, advect::Work& work, Ends& ended) {
    constexpr std::int64_t grain = 256;
    const query::Sampler sampler = mesh_->sampler();
    const auto beyond = advect::CellsBeyond::worth(sampler, std::int64_t(seeds_.size()));
    const mesh::FieldView field = mesh_->mesh().field("velocity");
    std::vector<Vec3d> ends(seeds_.size());
    const std::size_t chunks = (seeds_.size() + grain - 1) / grain;
    std::vector<advect::Work> works(chunks);
    std::vector<Ends> ends_of(chunks);
    threads.parallel_for(
        std::int64_t(seeds_.size()), grain, [&](std::int64_t begin, std::int64_t end) {
          const auto chunk = std::size_t(begin / grain);
          struct Line : std::vector<Vec3d> {
            void operator()(const advect::State& s) { push_back(s.x); }
          };
          Line line[advect::LaneBatch::lane_count];
          advect::State states[advect::LaneBatch::lane_count];
          const auto begin_line = [&](std::int64_t i, std::size_t slot) -> advect::State& {
            advect::State& p = states[slot] = {};
            p.x = seeds_[std::size_t(i)];
            line[slot].clear();
            return p;
          };
          const auto integrate = [&](auto& v, std::int64_t i, std::size_t slot) {
            return advect::integration(v, settings, times[std::size_t(i)],
                                       std::numeric_limits<double>::infinity(), begin_line(i, slot),
                                       works[chunk], advect::Visitor(line[slot]));
          };
          const auto finish = [&](std::int64_t i, std::size_t slot, insitu_ending ending) {
            ends_of[chunk].left += ending == INSITU_END_LEFT;
            ends_of[chunk].lost += ending != INSITU_END_ALIVE && ending != INSITU_END_LEFT;
            ends[std::size_t(i)] = states[slot].x;
          };
          advect::run_lanes(
              sampler, begin, end,
              [&](std::deque<advect::LaneVelocity>& to) {
                to.emplace_back(sampler, field, nullptr, 0, 0, o_.accuracy).walk_by(beyond.get());
              },
              [&](std::int64_t i, std::size_t slot, advect::LaneVelocity& velocity) {
                velocity.begin(-1);
                return integrate(velocity, i, slot);
              },
              [&](std::int64_t i, std::size_t slot, advect::LaneVelocity&,
                  const advect::Stepping& stepping) { finish(i, slot, stepping.ending()); });
        });
    for (const advect::Work& w : works)
      work += w;
    for (const Ends& e : ends_of) {
      ended.left += e.left;
      ended.lost += e.lost;
    }
    return ends;
  }

  std::vector<Vec3d> reference(const std::vector<double>& times) {
    progress("reference");
    IntegratorSettings exact;
    exact.face_aware = true;
    exact.tolerance = 1e-13;
    exact.max_steps = 1'000'000;
    advect::Work work;
    Ends ended;
    return trace(exact, times, all_, work, ended);
  }

  double error_of(const std::vector<Vec3d>& ends, const std::vector<Vec3d>& truth) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < ends.size(); ++i)
      sum += dot(ends[i] - truth[i], ends[i] - truth[i]);
    return std::sqrt(sum / double(ends.size())) / cell();
  }

  /// size: of a step in cells (rk4, at the flow's mean speed), or the tolerance.
  Row measure(Method method, bool aware, double size) {
    Row row;
    IntegratorSettings settings;
    settings.method = method;
    settings.face_aware = aware;
    settings.max_steps = 1'000'000;
    const char* const names[] = {"euler", "rk4", "bs32", "dopri5"};
    row.name = std::string(names[int(method)]) + (aware ? ", face-aware, " : ", ");
    if (advect::is_adaptive(method)) {
      settings.tolerance = size;
      row.name += format("tolerance %.0e", size);
    } else {
      constexpr double speed = 2.45; // the root of the mean square: sqrt(A^2 + B^2 + C^2)
      settings.step = size * cell() / speed;
      row.name += format("step %.3g cells", size);
    }
    progress(row.name);
    const core::Threads single(1);
    std::vector<Vec3d> ends;
    Series one, all;
    for (int i = 0; i < o_.repetitions; ++i) {
      row.work = {};
      Ends ended, again;
      one.time([&] { ends = trace(settings, times_, single, row.work, ended); });
      row.left = ended.left;
      row.lost = ended.lost;
      advect::Work work;
      all.time([&] { trace(settings, times_, all_, work, again); });
    }
    row.seconds = one.for_ratio(1);
    row.all_seconds = all.median();
    row.error = error_of(ends, truth_);
    row.across = LinesByLength(*mesh_, all_).across(ends, truth_) / cell();
    return row;
  }

  void add(const Row& r) {
    rows_.push_back(r);
    const double steps = double(r.work.steps), evaluations = double(r.work.evaluations);
    text_ += format("%-34s %9.4f %9.4f %9.3f %9.3f %8.2f %9.2e %9.2e %6lld %6lld\n", r.name.c_str(),
                    r.seconds, r.all_seconds, 1e-6 * steps / r.seconds,
                    1e-6 * evaluations / r.seconds, evaluations / steps, r.error, r.across,
                    static_cast<long long>(r.left), static_cast<long long>(r.lost));
    json_["rows"].push_back({{"name", r.name},
                             {"seconds", number(r.seconds)},
                             {"seconds_all_cores", number(r.all_seconds)},
                             {"steps", r.work.steps},
                             {"steps_per_s", number(steps / r.seconds)},
                             {"evaluations", r.work.evaluations},
                             {"error", number(r.error)},
                             {"across", number(r.across)},
                             {"left", r.left},
                             {"lost", r.lost}});
  }

  /// A peer, and the fastest of our rows that errs no more.
  void add(const PeerLines& peer) {
    const double error = LinesByLength(*mesh_, all_).across(peer, seeds_, length) / cell();
    const double seconds = peer.time.for_ratio(1);
    const auto lost = std::count(peer.times.begin(), peer.times.end(), 0.0);
    // All that is told of a peer's error (LinesByLength), so `error` and `across` are one below.
    // The lines' lengths in time may differ from ours by parts of a step.
    double time = 0.0, our_time = 0.0;
    for (std::size_t i = 0; i < seeds_.size(); ++i) {
      time += peer.times[i];
      our_time += times_[i];
    }
    text_ += format("\n%-34s %9.4f %9s %9.3f %9s %8s %9s %9.2e %6s %6lld\n", peer.name.c_str(),
                    seconds, "", 1e-6 * double(peer.steps) / seconds, "", "", "", error, "",
                    static_cast<long long>(lost));
    const Row* best = nullptr;
    for (const Row& r : rows_)
      if (r.across <= error && (!best || r.seconds < best->seconds))
        best = &r;
    const double ratio = best ? seconds / time / (best->seconds / our_time) : 0.0;
    if (best)
      text_ += format("  at an error no larger: %s, %.1f times as fast on one core\n",
                      best->name.c_str(), ratio);
    json_["peers"].push_back({{"name", peer.name},
                              {"seconds", number(seconds)},
                              {"steps", peer.steps},
                              {"steps_per_s", number(double(peer.steps) / seconds)},
                              {"error", number(error)},
                              {"across", number(error)},
                              {"lost", lost},
                              {"ratio_at_equal_error", number(ratio)}});
  }

  const Options& o_;
  Setup setup_;
  core::Threads all_;
  std::unique_ptr<commit::CommittedMesh> mesh_;
  Series neighbours_; ///< finding the table of cells across faces, where numbers do not tell
  std::int64_t neighbour_bytes_ = 0;
  std::vector<double> velocity_;
  std::vector<Vec3d> seeds_;
  std::vector<double> times_;
  std::vector<Vec3d> truth_;
  std::vector<Row> rows_;
  std::string text_;
  Json json_;
};

} // namespace

Output advect(const Options& o) {
  return Bench(o).run();
}

} // namespace insitu::bench
