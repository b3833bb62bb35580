#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string_view>

#include "accuracy/sweeps.h"
#include "cells/exact/contain_exact.h"
#include "commands.h"
#include "report/format.h"
#include "peers/peers.h"
#include "setup.h"
#include "workload/queries.h"

namespace insitu::bench::accuracy {

namespace {

using math::Vec3d;

struct Case {
  std::string name;
  workload::Kind kind;
  double jitter;
  bool twisted;
};

/// Turned about the box's axis, so that the outermost cells are sheared by about their width.
void twist(workload::Mesh& mesh) {
  for (std::size_t v = 0; v < mesh.points.size(); v += 3) {
    double* p = &mesh.points[v];
    const double a = 1.2 * p[2], x = p[0] - 0.5, y = p[1] - 0.5;
    p[0] = 0.5 + std::cos(a) * x - std::sin(a) * y;
    p[1] = 0.5 + std::sin(a) * x + std::cos(a) * y;
  }
}

/// Random points, then a tenth as many on faces, on edges and on vertices.
std::vector<Vec3d> points_on(const workload::Mesh& mesh, std::int64_t count) {
  using workload::Pattern;
  std::vector<Vec3d> out = workload::make_queries(mesh, Pattern::random, count).points;
  for (const Pattern p : {Pattern::faces, Pattern::edges, Pattern::vertices}) {
    const auto more = workload::make_queries(mesh, p, count / 10);
    out.insert(out.end(), more.points.begin(), more.points.end());
  }
  return out;
}

void keep_quiet(insitu_log_level, const char*, void*) {}

/// Whether the cell holds the point, by exact arithmetic.
bool holds(const workload::Mesh& mesh, std::int64_t cell, const Vec3d& p) {
  Vec3d x[8];
  mesh.gather(cell, x);
  return cells::holds(cells::contain_exact(mesh.shape(cell), x, p).where);
}

/// By brute force, the lowest cell that holds p, -1 for none.
std::int64_t owner(const workload::Mesh& mesh, const Vec3d& p) {
  for (std::int64_t c = 0; c < mesh.cell_count(); ++c) {
    Vec3d x[8];
    const int n = mesh.gather(c, x);
    bool near = true;
    for (int a = 0; a < 3 && near; ++a) {
      double low = x[0][a], high = x[0][a];
      for (int i = 1; i < n; ++i) {
        low = std::min(low, x[i][a]);
        high = std::max(high, x[i][a]);
      }
      near = p[a] >= low && p[a] <= high;
    }
    if (near && cells::holds(cells::contain_exact(mesh.shape(c), x, p).where))
      return c;
  }
  return -1;
}

class Locating {
public:
  Locating(const Case& c, const Extent& extent) : case_(c), extent_(extent), setup_(options()) {
    if (c.twisted) {
      twist(setup_.mesh);
      setup_.update_field();
    }
    setup_.context.log =
        core::Log(INSITU_LOG_ERROR, keep_quiet, nullptr); // folds are what is asked for
    random_count_ = extent.quick ? 4000 : 100'000;
    points_ = points_on(setup_.mesh, random_count_);
    mesh_ = setup_.register_mesh();
    mesh_->set_locator({accel::Method::bvh, accel::Backend::cpu});
    setup_.commit(*mesh_);
    truth_ = located(INSITU_EXACT);
  }

  /// How many of some points the reference has otherwise than brute force.
  int reference_is_off() const {
    int off = 0;
    const std::size_t stride = std::max<std::size_t>(1, points_.size() / 500);
    for (std::size_t i = 0; i < points_.size(); i += stride)
      off += owner(setup_.mesh, points_[i]) != truth_[i].cell;
    return off;
  }

  /// A method's accuracies, their repetitions in turns, so that ratios of them tell.
  std::vector<Setting> measure(accel::Method method) {
    mesh_->set_locator({method, accel::Backend::cpu});
    mesh_->mesh().set_changed(INSITU_CHANGED_TOPOLOGY);
    setup_.commit(*mesh_);
    mesh_->look_for_folds(setup_.context.threads);
    struct Run {
      insitu_accuracy accuracy;
      int rounds = 0; ///< of a repetition: about 10 ms, long enough for a ratio
      std::vector<query::Location> found = {};
      Series time = {};
    };
    std::vector<Run> runs = {{INSITU_STANDARD}, {INSITU_EXACT}};
    if (method != accel::Method::bvh) // whose fast is standard
      runs.insert(runs.begin(), Run{INSITU_FAST});
    for (Run& run : runs) {
      Series first;
      first.time([&] { run.found = located(run.accuracy); });
      run.rounds = std::clamp(int(0.01 / (first.cpu_median() + 1e-6)), 1, 100);
    }
    const query::Sampler sampler = mesh_->sampler();
    for (int i = 0; i < extent_.repetitions; ++i)
      for (Run& run : runs)
        run.time.time([&] {
          for (int k = 0; k < run.rounds; ++k)
            sampler.locate(setup_.context.threads, points_, run.found, {run.accuracy, 1.0});
        });
    std::vector<Setting> out;
    for (const Run& run : runs) {
      Setting s = held_against_truth(run.found);
      constexpr const char* names[] = {"fast", "standard", "exact"};
      s.name = std::string(accel::name(method)) + ", " + names[int(run.accuracy)];
      s.time = run.time;
      s.items = double(points_.size()) * run.rounds;
      s.is_default = method == accel::Method::bvh && run.accuracy == INSITU_STANDARD;
      // No certificate proves anything where cells may fold, so the tree answers.
      s.is_stand_in = method != accel::Method::bvh && run.accuracy != INSITU_FAST &&
                      !mesh_->mesh().view().free_of_folds;
      if (method == accel::Method::bvh) {
        const Work w = count_work(mesh_->tree(), points_);
        s.work = w.nodes + w.candidates;
      }
      out.push_back(std::move(s));
    }
    return out;
  }

  /// VTK's and Open VKL, where they are there.
  std::vector<Setting> measure_peers() {
    std::vector<Setting> out;
    std::vector<std::int64_t> cells(points_.size());
    std::vector<double> values(points_.size());
    const std::string_view wanted[] = {"vtkStaticCellLocator", "vtkProbeFilter", "OpenVKL"};
    for (const auto& peer : make_peers(setup_.mesh, setup_.field)) {
      if (std::find(std::begin(wanted), std::end(wanted), peer->name()) == std::end(wanted))
        continue;
      peer->build();
      Setting s;
      s.group = case_.name;
      s.name = peer->name();
      s.is_peer = true;
      s.items = double(points_.size());
      for (int i = 0; i < extent_.repetitions; ++i)
        s.time.time([&] { peer->sample(points_, cells, values); });
      std::int64_t wrong[2] = {0, 0}, not_lowest = 0;
      double worst = 0.0;
      for (std::size_t i = 0; i < points_.size(); ++i) {
        const bool lost = cells[i] < 0 && truth_[i];
        const bool other = peer->tells_cells() && cells[i] >= 0 && cells[i] != truth_[i].cell;
        const bool sound = other && holds(setup_.mesh, cells[i], points_[i]);
        wrong[i >= std::size_t(random_count_)] += lost || (other && !sound);
        not_lowest += sound;
        if (cells[i] >= 0)
          worst = std::max(worst, std::fabs(values[i] - workload::field(points_[i])));
      }
      s.error = double(wrong[0]) / double(random_count_);
      s.more = {double(wrong[1]) / (s.items - double(random_count_)),
                peer->tells_cells() ? double(not_lowest) / s.items : std::nan(""), worst};
      out.push_back(std::move(s));
    }
    return out;
  }

private:
  Setting held_against_truth(const std::vector<query::Location>& found) const {
    const auto count = double(points_.size());
    const query::Sampler sampler = mesh_->sampler();
    const mesh::FieldView field = mesh_->mesh().field("f");
    std::int64_t wrong[2] = {0, 0}, not_lowest = 0; // wrong: of random points, of those on features
    double worst = 0.0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (found[i].cell != truth_[i].cell) {
        const bool sound = found[i] && holds(setup_.mesh, found[i].cell, points_[i]);
        (sound ? not_lowest : wrong[i >= std::size_t(random_count_)]) += 1;
      }
      if (!found[i])
        continue;
      double value = 0.0;
      sampler.interpolate(field, found[i], &value);
      worst = std::max(worst, std::fabs(value - workload::field(points_[i])));
    }
    Setting s;
    s.group = case_.name;
    s.error = double(wrong[0]) / double(random_count_);
    s.more = {double(wrong[1]) / (count - double(random_count_)), double(not_lowest) / count,
              worst};
    return s;
  }

  Options options() const {
    Options o;
    o.kind = case_.kind;
    o.jitter = case_.jitter;
    o.cells = {extent_.quick ? 6000 : 200'000};
    return o;
  }
  std::vector<query::Location> located(insitu_accuracy accuracy) {
    std::vector<query::Location> out(points_.size());
    mesh_->sampler().locate(setup_.context.threads, points_, out, {accuracy, 1.0});
    return out;
  }

  Case case_;
  Extent extent_;
  Setup setup_;
  std::unique_ptr<commit::CommittedMesh> mesh_;
  std::int64_t random_count_ = 0;
  std::vector<Vec3d> points_;
  std::vector<query::Location> truth_;
};

std::string advise(const Sweep& s) {
  // How much more exact takes than standard, and the worst that anything else does.
  double least = HUGE_VAL, most = 0.0, worst = 0.0, worst_ratio = 0.0;
  const Setting* worst_of = nullptr;
  for (const std::string& group : s.groups()) {
    const Setting *standard = s.find(group, "bvh, standard"), *exact = s.find(group, "bvh, exact");
    const double ratio = exact->seconds() / standard->seconds();
    least = std::min(least, ratio);
    most = std::max(most, ratio);
    for (const Setting* other : s.of(group))
      if (other->error > worst) {
        worst = other->error;
        worst_of = other;
        worst_ratio = other->seconds() / standard->seconds();
      }
  }
  std::string out = format(
      "Leave it at bvh in standard: where cells do not overlap it names the same cells as exact, "
      "which takes %.2f to %.2f times its time. ",
      least, most);
  if (worst_of)
    out += format("In fast a wrong cell or none is named for up to %.2g %% of random points (",
                  100 * worst) +
           worst_of->name + ", " + worst_of->group +
           format("), for %.1f times the time on this processor.", worst_ratio);
  else
    out += "No setting named a wrong cell.";
  double slowest = 0.0, fastest = HUGE_VAL;
  for (const std::string& group : s.groups())
    if (const Setting* vtk = s.find(group, "vtkStaticCellLocator")) {
      const double ratio = vtk->seconds() / s.find(group, "bvh, standard")->seconds();
      fastest = std::min(fastest, ratio);
      slowest = std::max(slowest, ratio);
    }
  if (slowest > 0.0)
    out += format(" vtkStaticCellLocator takes %.1f to %.1f times the time of bvh in standard.",
                  fastest, slowest);
  return out;
}

} // namespace

Sweep sweep_locate(const Extent& extent) {
  using workload::Kind;
  Sweep s;
  s.key = "locate";
  s.title = "Locating points";
  s.swept =
      "Locator accuracy (fast, standard, exact) and method, on hexahedra with jitters from 0 to "
      "0.3 and "
      "twisted ones, tetrahedra, wedges and pyramids; random points and points on faces, edges "
      "and vertices.";
  s.error_label = "random points in a wrong cell or lost, of all";
  s.work_label = "tree nodes and candidate cells a point (bvh)";
  s.time_label = "seconds a point, one core";
  s.more_labels = {"points on faces, edges, vertices in a wrong cell or lost, of these",
                   "points in a cell that holds them but is not the lowest, of all",
                   "largest error of the value"};
  const Case cases[] = {{"hexahedra, jitter 0", Kind::hexahedra, 0.0, false},
                        {"hexahedra, jitter 0.1", Kind::hexahedra, 0.1, false},
                        {"hexahedra, jitter 0.2", Kind::hexahedra, 0.2, false},
                        {"hexahedra, jitter 0.3", Kind::hexahedra, 0.3, false},
                        {"hexahedra, twisted", Kind::hexahedra, 0.1, true},
                        {"tetrahedra, jitter 0.2", Kind::tetrahedra, 0.2, false},
                        {"wedges, jitter 0.2", Kind::wedges, 0.2, false},
                        {"pyramids, jitter 0.2", Kind::pyramids, 0.2, false}};
  int off = 0;
  for (const Case& c : cases) {
    progress("locate: " + c.name);
    Locating at(c, extent);
    off += at.reference_is_off();
    for (int m = 0; m < accel::method_count; ++m)
      for (Setting& one : at.measure(accel::Method(m)))
        s.settings.push_back(std::move(one));
    for (Setting& peer : at.measure_peers())
      s.settings.push_back(std::move(peer));
  }
  s.reference = format(
      "The lowest cell that holds the point by exact arithmetic; of 500 points a case, all cells "
      "asked one by one, %d differ.",
      off);
  s.advice = advise(s);
  s.notes = {"Methods by rays are there for ray-tracing hardware; on a processor their work is not "
             "counted in "
             "nodes, so they are on no front of counted work.",
             "fast differs from standard for the methods by rays alone. Where cells may fold "
             "(jitter 0.3), bvh answers for them in standard and exact, so those have no part in "
             "the front there.",
             "Peers locate and interpolate; vtkProbeFilter tells only whether a point was found."};
  return s;
}

} // namespace insitu::bench::accuracy
