#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace insitu::output {

/// The index of a series of files over time, rewritten atomically at every `add`, so a viewer can
/// open it while the simulation runs: VTK's `.pvd`, or ParaView's JSON of any other ending
/// (`.series`).
class FileSeries {
public:
  /// With `resume` the entries that an earlier run wrote there are kept; an index that was not
  /// written by this class is an error (core::Error, INSITU_ERROR_FILE) then, else it is replaced.
  /// backward: time descends from one to the next.
  explicit FileSeries(std::string path, bool resume = false, bool backward = false);

  /// `file` is relative to the index. Entries of an earlier run at this time or beyond it, those of
  /// this run at this time, and one of the same name, go: a run that restarted writes them again.
  void add(double time, const std::string& file);

  const std::vector<std::pair<double, std::string>>& entries() const { return entries_; }

private:
  struct Form;
  static const Form& form_of(const std::string& path);

  std::string path_;
  std::vector<std::pair<double, std::string>> entries_;
  std::size_t resumed_ = 0; ///< of entries_, the first ones: an earlier run's
  bool backward_;
};

} // namespace insitu::output
