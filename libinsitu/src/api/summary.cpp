#include <array>
#include <cmath>

#include "advect/particles.h"
#include "api/session.h"
#include "output/files/atomic_file.h"
#include "output/files/json_text.h"

namespace insitu::api {

namespace {

constexpr const char* reason_names[INSITU_REASON_COUNT] = {"outside", "certified", "exact",
                                                           "on_face", "on_edge",   "on_vertex"};

/// Adds up integers over all processes, in one reduction; they are read again in their order.
class Sums {
public:
  template <class... Integers>
  void add(Integers&... integers) {
    (values_.push_back(&integers), ...);
  }
  void over(parallel::World& world) {
    std::vector<std::int64_t> sums;
    for (const std::int64_t* v : values_)
      sums.push_back(*v);
    world.reduce(sums, parallel::Reduction::sum);
    for (std::size_t i = 0; i < sums.size(); ++i)
      *values_[i] = sums[i];
  }

private:
  std::vector<std::int64_t*> values_;
};

void add_seconds(output::JsonText& json, const char* key, const scene::Seconds& seconds) {
  constexpr const char* names[] = {"commit", "query", "advect", "render", "output"};
  json.line().key(key).open('{');
  for (std::size_t i = 0; i < seconds.size(); ++i)
    json.line().key(names[i]).value(seconds[i]);
  json.close();
}

/// Numbers that each process has, over all processes.
struct Spread {
  enum Number { threads, halo_cells, halo_bytes, messages_sent, bytes_sent, work_ns, count };
  static constexpr const char* names[] = {"threads",       "halo_cells", "halo_bytes",
                                          "messages_sent", "bytes_sent", "work_seconds"};
  std::array<std::int64_t, count> least{}, sum{}, greatest{};

  explicit Spread(const std::array<std::int64_t, count>& mine)
      : least(mine), sum(mine), greatest(mine) {}
  void over(parallel::World& world) {
    world.reduce(least, parallel::Reduction::least);
    world.reduce(sum, parallel::Reduction::sum);
    world.reduce(greatest, parallel::Reduction::greatest);
  }
  void write(output::JsonText& json, int processes) const {
    json.line().key("of_processes").open('{');
    for (std::size_t i = 0; i < count; ++i) {
      const double mean = double(sum[i]) / processes;
      json.line().key(names[i]).open('{');
      if (i == work_ns) {
        json.line().key("least").value(1e-9 * double(least[i]));
        json.line().key("mean").value(1e-9 * mean);
        json.line().key("greatest").value(1e-9 * double(greatest[i]));
        json.line().key("greatest_over_mean").value(mean > 0 ? double(greatest[i]) / mean : 1.0);
      } else {
        json.line().key("least").value(least[i]);
        json.line().key("mean").value(mean);
        json.line().key("greatest").value(greatest[i]);
      }
      json.close();
    }
    json.close();
  }
};

/// What a session did, of all processes.
struct Totals {
  insitu_report report = insitu_report_default();
  commit::FitsDone fits; ///< the refits that commits put off, and what became of them
  insitu_locator_info located = insitu_locator_info_default(); ///< by ray methods and devices
  scene::SecondsOfAll seconds;

  /// Counts become sums over all processes. Executions and failures, which all have alike, stay.
  void add_up(parallel::World& world) {
    insitu_report& r = report;
    Sums sums;
    sums.add(r.keeps, r.refits, r.rebuilds, fits.put_off, fits.refits, fits.rebuilds,
             r.bytes_borrowed, r.bytes_held, r.bytes_peak, r.particles_seeded, r.points_located,
             r.points_outside, r.frames, r.probe_rows, r.files, located.kept, located.by_neighbour,
             located.by_tree, located.settled_on_host);
    for (int p = 0; p < INSITU_MEMORY_COUNT; ++p)
      sums.add(r.bytes_by_purpose[p]);
    for (int e = 0; e < INSITU_END_COUNT; ++e)
      sums.add(r.particles[e]);
    for (int k = 0; k < INSITU_REASON_COUNT; ++k)
      sums.add(r.located_by_reason[k]);
    sums.over(world);
  }
};

std::string text_of(const Totals& totals, const Spread& spread, double solver_seconds) {
  const scene::SecondsOfAll& seconds = totals.seconds;
  const insitu_report& r = totals.report;
  const commit::FitsDone& fits = totals.fits;
  const insitu_locator_info& located = totals.located;
  output::JsonText json = output::JsonText::spaced();
  const auto add = [&](const char* key, auto value) { json.line().key(key).value(value); };
  const auto open = [&](const char* key) { json.line().key(key).open('{'); };
  json.open('{');
  if (seconds.processes > 1)
    add("processes", seconds.processes);
  add("executions", r.executions);
  const auto& [commit_s, query_s, advect_s, render_s, output_s] = seconds.mean;
  const double library = commit_s + query_s + advect_s + render_s + output_s;
  open("seconds");
  add("commit", commit_s);
  add("query", query_s);
  add("advect", advect_s);
  add("render", render_s);
  add("render_ranges", r.ranges_s);
  add("render_classify", r.classify_s);
  add("output", output_s);
  add("library", library);
  if (solver_seconds >= 0.0) {
    add("solver", solver_seconds);
    add("library_share",
        library + solver_seconds > 0.0 ? library / (library + solver_seconds) : 0.0);
  }
  json.close();
  if (seconds.processes > 1) {
    add_seconds(json, "seconds_of_least", seconds.least);
    add_seconds(json, "seconds_of_greatest", seconds.greatest);
    spread.write(json, seconds.processes);
  }
  open("commits");
  add("keep", r.keeps);
  add("refit", r.refits);
  add("rebuild", r.rebuilds);
  json.close();
  open("fits_put_off");
  add("count", fits.put_off);
  add("refit", fits.refits);
  add("rebuild", fits.rebuilds);
  add("seconds", fits.seconds);
  json.close();
  open("bytes");
  add("borrowed", r.bytes_borrowed);
  add("held", r.bytes_held);
  add("peak", r.bytes_peak);
  open("held_by_purpose");
  for (int p = 0; p < INSITU_MEMORY_COUNT; ++p)
    add(core::purpose_name(insitu_purpose(p)), r.bytes_by_purpose[p]);
  json.close().close();
  open("particles");
  add("seeded", r.particles_seeded);
  for (int e = 0; e < INSITU_END_COUNT; ++e)
    add(advect::ending_name(insitu_ending(e)), r.particles[e]);
  json.close();
  add("points_located", r.points_located);
  add("points_outside", r.points_outside);
  open("located_by_reason");
  for (int k = 0; k < INSITU_REASON_COUNT; ++k)
    add(reason_names[k], r.located_by_reason[k]);
  json.close();
  open("located_by_locators");
  add("kept", located.kept);
  add("by_neighbour", located.by_neighbour);
  add("by_tree", located.by_tree);
  add("settled_on_host", located.settled_on_host);
  json.close();
  add("frames", r.frames);
  add("probe_rows", r.probe_rows);
  add("files", r.files);
  add("failures", r.failures);
  json.close();
  return json.text() + "\n";
}

} // namespace

/// Seconds are those of the mean process; with several there are the least and the greatest
/// besides, and of halos, messages and work the same.
void Session::write_summary(const std::string& path, double solver_seconds) {
  meet("summary");
  parallel::World& world = processes_.world();
  Totals totals;
  world.agree_after([&] {
    totals.report = report();
    for (const auto& m : meshes_) {
      totals.fits += m->mesh.fits_done();
      const insitu_locator_info info = m->mesh.locators().info(m->mesh.standing_tree());
      totals.located.kept += info.kept;
      totals.located.by_neighbour += info.by_neighbour;
      totals.located.by_tree += info.by_tree;
      totals.located.settled_on_host += info.settled_on_host;
    }
  });
  const insitu_report& mine = totals.report; // before they are added up
  Spread spread({context_.threads.count(), mine.halo_cells,
                 mine.bytes_by_purpose[INSITU_MEMORY_HALO], mine.messages_sent, mine.bytes_sent,
                 std::llround(1e9 * statistics_.work_s)});
  spread.over(world);
  totals.add_up(world);
  totals.seconds = scene::seconds_of_all(scene::seconds_of(statistics_), world);
  world.agree_after([&] {
    if (!world.is_root())
      return;
    locks_.take(path);
    output::AtomicFile file(path);
    file.write(text_of(totals, spread, solver_seconds));
    file.commit();
  });
}

} // namespace insitu::api
