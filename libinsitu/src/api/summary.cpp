#include "advect/particles.h"
#include "api/session.h"
#include "output/files/atomic_file.h"
#include "output/files/json_text.h"

namespace insitu::api {

namespace {

constexpr const char* reason_names[INSITU_REASON_COUNT] = {"outside", "certified", "exact",
                                                           "on_face", "on_edge",   "on_vertex"};

} // namespace

void Session::write_summary(const std::string& path, double solver_seconds) {
  const insitu_report r = report();
  output::JsonText json = output::JsonText::spaced();
  const auto add = [&](const char* key, auto value) { json.line().key(key).value(value); };
  const auto open = [&](const char* key) { json.line().key(key).open('{'); };
  json.open('{');
  add("executions", r.executions);
  const double library = r.commit_s + r.query_s + r.advect_s + r.render_s + r.output_s;
  open("seconds");
  add("commit", r.commit_s);
  add("query", r.query_s);
  add("advect", r.advect_s);
  add("render", r.render_s);
  add("render_ranges", r.ranges_s);
  add("render_classify", r.classify_s);
  add("output", r.output_s);
  add("library", library);
  if (solver_seconds >= 0.0) {
    add("solver", solver_seconds);
    add("library_share",
        library + solver_seconds > 0.0 ? library / (library + solver_seconds) : 0.0);
  }
  json.close();
  open("commits");
  add("keep", r.keeps);
  add("refit", r.refits);
  add("rebuild", r.rebuilds);
  json.close();
  // Of the refits those that commits put off, and what became of them when the tree was asked.
  commit::FitsDone fits;
  for (const auto& m : meshes_)
    fits += m->mesh.fits_done();
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
  // Of all meshes, by ray methods and devices (insitu_locator_info).
  insitu_locator_info sum = insitu_locator_info_default();
  for (const auto& m : meshes_) {
    const insitu_locator_info info = m->mesh.locators().info(m->mesh.standing_tree());
    sum.kept += info.kept;
    sum.by_neighbour += info.by_neighbour;
    sum.by_tree += info.by_tree;
    sum.settled_on_host += info.settled_on_host;
  }
  open("located_by_locators");
  add("kept", sum.kept);
  add("by_neighbour", sum.by_neighbour);
  add("by_tree", sum.by_tree);
  add("settled_on_host", sum.settled_on_host);
  json.close();
  add("frames", r.frames);
  add("probe_rows", r.probe_rows);
  add("files", r.files);
  add("failures", r.failures);
  json.close();
  locks_.take(path);
  output::AtomicFile file(path);
  file.write(json.text() + "\n");
  file.commit();
}

} // namespace insitu::api
