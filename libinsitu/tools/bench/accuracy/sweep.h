#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "measure.h"

namespace insitu::bench::accuracy {

/// One choice as it was measured.
struct Setting {
  std::string
      group; ///< settings of one group answer the same question and are held against each other
  std::string name;
  double error = 0.0; ///< of the reference, in the sweep's unit; 0: none found
  double work = 0.0;  ///< counted, in the sweep's unit; 0: not counted
  Series time;        ///< of the whole piece of work
  double items = 1.0; ///< queries, frames, ... that `time` was spent on
  bool is_default = false;
  std::vector<double> more; ///< [Sweep::more_labels]; NaN: not measured
  bool is_peer = false;     ///< another program's: no setting of ours
  /// What answered is another setting's method, which stands in: no front is this one's.
  bool is_stand_in = false;

  double seconds() const { return time.for_ratio(1) / items; }
  double least_seconds() const { return time.cpu_min() / items; }
  double most_seconds() const { return time.cpu_max() / items; }
};

/// A choice that trades accuracy for time, measured against a reference.
struct Sweep {
  std::string key; ///< of its files
  std::string title;
  std::string swept;     ///< what was varied, on what
  std::string reference; ///< what errors are measured against, and why it may be trusted
  std::string error_label, work_label, time_label; ///< with units
  std::vector<std::string> more_labels;
  std::vector<Setting> settings;
  /// Labels of error and of time by group, where groups have their own; so have their charts.
  std::map<std::string, std::pair<std::string, std::string>> axes;
  std::string advice; ///< a sentence with its numbers, made from the settings
  std::vector<std::string> notes;

  std::vector<std::string> groups() const; ///< in the order of appearance
  /// Those of a group; peers left out unless asked for.
  std::vector<const Setting*> of(const std::string& group, bool peers = false) const;
  const Setting* find(const std::string& group, const std::string& name) const;
  const Setting* default_of(const std::string& group) const;
};

using Cost = std::function<double(const Setting&)>;
/// Counted work, and seconds an item.
double work(const Setting& s);
double seconds(const Setting& s);

/// What a setting's name begins with, up to a comma: "bvh" of "bvh, exact".
std::string method_of(const std::string& name);

/// The settings of a group that no other beats: none has less error at no more cost.
std::vector<const Setting*> front(const Sweep& sweep, const std::string& group, const Cost& cost);

/// A setting's cost over the least cost among those of its group whose error is at most 1 % above
/// its: 1 on the front. 0 if its cost is not known.
double over_front(const Sweep& sweep, const Setting& setting, const Cost& cost);
/// The same of a group's default; 0 if there is none.
double default_over_front(const Sweep& sweep, const std::string& group, const Cost& cost);

/// A setting of ours, or a method with all its settings, that wins nowhere: in every group
/// something as accurate takes less time by more than a tenth, and by more than repetitions spread.
struct Loser {
  std::string name;
  bool is_method = false;
  double at_best = 0.0; ///< its time over that of a front, the least of all groups
};
std::vector<Loser> losers(const Sweep& sweep);
/// Sentences with the methods, then the settings, that win nowhere; or that none does.
std::string say_losers(const Sweep& sweep);

/// One row a setting.
std::string csv(const Sweep& sweep);
/// Error against seconds, a chart a group; fronts drawn, defaults marked.
std::string plot(const Sweep& sweep);

} // namespace insitu::bench::accuracy
