#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "advect/particles.h"
#include "core/context.h"
#include "core/timer.h"
#include "math/vec.h"
#include "output/files/json_text.h"
#include "output/page/run_page.h"
#include "scene/parse/description.h"
#include "scene/run/statistics.h"

namespace insitu::scene {

/// What the page of a run (output/page/run_page.h) says of a cycle: the actions note it here, and
/// the runner ends the cycle. An entry is made of each cycle in which something was due, failed or
/// warned; its seconds are the sums since the entry before. The page is opened with the first
/// entry. A step that comes again has one entry, which tells of all its executions.
///
/// Where another session writes a page to the same folder, this one has none, and a warning says
/// so.
class PageRecord {
public:
  /// What a plot can show; the tables have everything.
  static constexpr std::size_t most_points = 16, most_columns = 12;

  PageRecord(const SceneDescription& scene, const std::string& folder, core::Context& context,
             Statistics& statistics);

  /// A step begins, or comes again.
  void begin_step(bool again);
  /// A file of the frame `name`; kind: what the image shows, such as "color".
  void add_frame(const std::string& name, const std::string& kind, const std::string& path);
  /// values: [point][column], NaN outside. names: of the points, or empty.
  void add_probe(const std::string& name, std::span<const std::string> columns,
                 std::span<const math::Vec3d> points, std::span<const std::string> names,
                 std::span<const double> values);
  void add_tracer(const std::string& name, const advect::Counts& counts);
  void add_failure(const std::string& text) { add_message("error", text); }
  /// What the items need and why (shown if it differs from the one before).
  void add_plan(const std::string& text);

  /// Takes the warnings that the log had since the last call, for the cycle's entry.
  void take_warnings();
  /// Whether the cycle will have an entry, so that what is dear need not be noted in vain.
  bool wanted(bool due) const { return !refused_ && (due || !now_.messages.empty()); }
  /// Whether there was an entry.
  bool begun() const { return now_.begun; }
  /// Makes the cycle's entry. Throws INSITU_ERROR_FILE if the page cannot be written; the entry
  /// then waits for the next. seconds: of all processes since the entry before. began: with the
  /// work on this entry, whose seconds and wall time are the next entry's.
  void end_cycle(std::int64_t cycle, double time, const SecondsOfAll& seconds,
                 const core::Timer& began);
  /// The session closes: the page says so.
  void finish();

private:
  struct Message {
    std::string level, text;
  };
  /// What an entry is made of, so far.
  struct Noted {
    core::Timer since;                         ///< work on the entry before began
    Statistics before;                         ///< then
    std::string frames, probes, tracers, plan; ///< JSON, without brackets
    std::set<std::string> names;               ///< files and probes that it has
    std::vector<Message> messages;
    bool begun = false; ///< there was an entry before
  };
  void add_message(const std::string& level, const std::string& text);
  void add_session(output::JsonText& entry) const;
  std::string make_entry(const SecondsOfAll* seconds, const core::Timer& began);
  void write(std::string entry);

  const std::string file_, folder_;
  std::string files_; ///< JSON: the tables that grow
  core::Context& context_;
  Statistics& statistics_;
  Noted now_;
  std::optional<Noted> last_; ///< of the step's entry, if it has one
  bool replaces_ = false;     ///< the next entry takes that one's place
  std::int64_t cycle_ = 0;
  double time_ = 0;
  std::string last_plan_;
  std::set<std::string> warned_;
  std::set<std::string> described_;  ///< probes, with their columns
  std::vector<std::string> waiting_; ///< entries not written yet
  std::int64_t first_cycle_ = 0;     ///< of the session
  bool refused_ = false;
  std::unique_ptr<output::RunPage> page_;
};

} // namespace insitu::scene
