// A run whose steps are held: they answer as they did when they were live.
#pragma once

#include <functional>
#include <regex>
#include <sstream>

#include "arrays.h"

namespace records {

/// Does the run of a test of records once more, holds all its steps, lets the solver's arrays go,
/// and shows the steps: records, frames, streamlines and rows of probes are those of the live
/// steps, to the byte, and no tree is built.
class HeldRun {
public:
  using Give = std::function<void(insitu_session, int step, Arrays&)>;

  HeldRun(const Replay& in, std::string scene) : in_(in) {
    const std::string record = "record: {every: 1}";
    scene.replace(scene.find(record), record.size(),
                  "hold: {steps: " + std::to_string(steps) + "}");
    in_.put("held.yaml", scene);
    const std::string file = in_.path("held.yaml"), out = in_.path("held");
    insitu_session_options options = insitu_session_options_default();
    options.scene = file.c_str();
    options.output = out.c_str();
    options.log = [](insitu_log_level, const char* message, void* run) {
      static_cast<HeldRun*>(run)->log_ += std::string(message) + "\n";
    };
    options.log_user = this;
    check(insitu_session_open(&options, &session_));
  }

  /// builds: of trees, in a run without held steps.
  void run(const Give& give, std::int64_t builds) {
    {
      Arrays arrays;
      for (int step = 0; step < steps; ++step) {
        give(session_, step, arrays);
        check(insitu_session_execute(session_, 10 * step, 0.1 * step));
        check(insitu_session_record(session_, record("live", step).c_str()));
      }
    } // the arrays are gone
    const insitu_report before = report();
    EXPECT_EQ(before.rebuilds, builds); // holding copies trees
    for (const int step : {2, 0, 3, 1, 1}) {
      check(insitu_session_show(session_, 10 * step));
      check(insitu_session_execute(session_, shown + 10 * step, 0.1 * step));
      check(insitu_session_record(session_, record("shown", step).c_str()));
      EXPECT_TRUE(contents(record("shown", step)) == contents(record("live", step))) << step;
    }
    const insitu_report after = report();
    EXPECT_EQ(after.rebuilds, before.rebuilds);
    EXPECT_EQ(after.failures, before.failures) << log_;
    EXPECT_GT(after.bytes_by_purpose[INSITU_MEMORY_HELD], 0);
    check(insitu_session_close(&session_));
    compare_files();
    compare_rows();
  }

private:
  static constexpr int steps = 4, shown = 1000; ///< the latter: added to the cycles of shown steps

  std::string record(const std::string& of, int step) const {
    return in_.path(of + "_" + std::to_string(step) + ".hdf");
  }
  insitu_report report() const {
    insitu_report r = insitu_report_default();
    check(insitu_session_report(session_, &r));
    return r;
  }
  /// Those that are named by cycles.
  void compare_files() const {
    const Files files = files_of(in_.folder / "held");
    const std::regex of_cycle("(.*)_([0-9]{6})(\\..*)");
    int compared = 0;
    for (const auto& [name, bytes] : files) {
      std::smatch parts;
      if (!std::regex_match(name, parts, of_cycle) || std::stoi(parts[2]) < shown)
        continue;
      char cycle[16];
      std::snprintf(cycle, sizeof cycle, "%06d", std::stoi(parts[2]) - shown);
      const auto live = files.find(parts[1].str() + "_" + cycle + parts[3].str());
      ASSERT_TRUE(live != files.end()) << name;
      EXPECT_TRUE(live->second == bytes) << name;
      ++compared;
    }
    EXPECT_GE(compared, steps);
  }
  /// The rows of probes, whose first column is the cycle, and the next one the time.
  void compare_rows() const {
    int tables = 0;
    for (const auto& [name, text] : files_of(in_.folder / "held"))
      if (text.substr(0, 11) == "cycle,time," && text.find(",ending") == std::string::npos &&
          name != "data.csv") { // which names files
        SCOPED_TRACE(name);
        compare_rows(text);
        ++tables;
      }
    EXPECT_GT(tables, 0);
  }
  static void compare_rows(const std::string& text) {
    std::map<int, std::vector<std::string>> rows;
    std::istringstream table(text);
    std::string line;
    std::getline(table, line);
    while (std::getline(table, line))
      rows[std::stoi(line)].push_back(line.substr(line.find(',')));
    for (int step = 0; step < steps; ++step) {
      std::vector<std::string> twice = rows[10 * step];
      EXPECT_FALSE(twice.empty());
      if (step == 1) // which was shown again
        twice.insert(twice.end(), rows[10].begin(), rows[10].end());
      EXPECT_EQ(rows[shown + 10 * step], twice) << step;
    }
  }

  const Replay& in_;
  std::string log_;
  insitu_session session_ = nullptr;
};

} // namespace records
