#include <cmath>

#include "advect/particles.h"
#include "api/session.h"
#include "output/files/atomic_file.h"
#include "output/files/csv.h"

namespace insitu::api {

namespace {

constexpr const char* reason_names[INSITU_REASON_COUNT] = {"outside", "certified", "exact",
                                                           "on_face", "on_edge",   "on_vertex"};

/// A JSON object, written line by line.
class JsonObject {
public:
  explicit JsonObject(int depth) : indent_(std::size_t(depth) * 2, ' ') {}
  void add(const char* key, double value) {
    std::string number;
    if (std::isfinite(value)) // JSON has no other numbers
      output::append_number(number, value);
    raw(key, number.empty() ? "null" : number);
  }
  void add(const char* key, std::int64_t value) { raw(key, std::to_string(value)); }
  void raw(const char* key, const std::string& value) {
    text_ += (text_.empty() ? "" : ",\n") + indent_ + "\"" + key + "\": " + value;
  }
  std::string text() const {
    return "{\n" + text_ + "\n" + indent_.substr(0, indent_.size() - 2) + "}";
  }

private:
  std::string indent_, text_;
};

} // namespace

void Session::write_summary(const std::string& path, double solver_seconds) {
  const insitu_report r = report();
  JsonObject json(1), seconds(2), commits(2), bytes(2), purposes(3), particles(2), reasons(2),
      locators(2);
  json.add("executions", r.executions);
  const double library = r.commit_s + r.query_s + r.advect_s + r.render_s + r.output_s;
  seconds.add("commit", r.commit_s);
  seconds.add("query", r.query_s);
  seconds.add("advect", r.advect_s);
  seconds.add("render", r.render_s);
  seconds.add("render_ranges", r.ranges_s);
  seconds.add("render_classify", r.classify_s);
  seconds.add("output", r.output_s);
  seconds.add("library", library);
  if (solver_seconds >= 0.0) {
    seconds.add("solver", solver_seconds);
    seconds.add("library_share",
                library + solver_seconds > 0.0 ? library / (library + solver_seconds) : 0.0);
  }
  json.raw("seconds", seconds.text());
  commits.add("keep", r.keeps);
  commits.add("refit", r.refits);
  commits.add("rebuild", r.rebuilds);
  json.raw("commits", commits.text());
  bytes.add("borrowed", r.bytes_borrowed);
  bytes.add("held", r.bytes_held);
  bytes.add("peak", r.bytes_peak);
  for (int p = 0; p < INSITU_MEMORY_COUNT; ++p)
    purposes.add(core::purpose_name(insitu_purpose(p)), r.bytes_by_purpose[p]);
  bytes.raw("held_by_purpose", purposes.text());
  json.raw("bytes", bytes.text());
  particles.add("seeded", r.particles_seeded);
  for (int e = 0; e < INSITU_END_COUNT; ++e)
    particles.add(advect::ending_name(insitu_ending(e)), r.particles[e]);
  json.raw("particles", particles.text());
  json.add("points_located", r.points_located);
  json.add("points_outside", r.points_outside);
  for (int k = 0; k < INSITU_REASON_COUNT; ++k)
    reasons.add(reason_names[k], r.located_by_reason[k]);
  json.raw("located_by_reason", reasons.text());
  // Of all meshes, by ray methods and devices (insitu_locator_info).
  insitu_locator_info sum = insitu_locator_info_default();
  for (const auto& m : meshes_) {
    const insitu_locator_info info = m->mesh.locators().info(m->mesh.tree());
    sum.kept += info.kept;
    sum.by_neighbour += info.by_neighbour;
    sum.by_tree += info.by_tree;
    sum.settled_on_host += info.settled_on_host;
  }
  locators.add("kept", sum.kept);
  locators.add("by_neighbour", sum.by_neighbour);
  locators.add("by_tree", sum.by_tree);
  locators.add("settled_on_host", sum.settled_on_host);
  json.raw("located_by_locators", locators.text());
  json.add("frames", r.frames);
  json.add("probe_rows", r.probe_rows);
  json.add("files", r.files);
  json.add("failures", r.failures);
  locks_.take(path);
  output::AtomicFile file(path);
  file.write(json.text() + "\n");
  file.commit();
}

} // namespace insitu::api
