#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace insitu::bench {

/// Wall-clock and processor seconds of one measured piece of work, repetition by repetition. On a
/// shared machine the processor's time tells more.
class Series {
public:
  template <class Work>
  void time(Work&& work) {
    const Clock before;
    work();
    add(before);
  }
  /// Seconds that were added up elsewhere, as another repetition.
  void add(double seconds) {
    wall_.push_back(seconds);
    cpu_.push_back(seconds);
  }
  /// Repetition by repetition.
  Series plus(const Series& other) const;
  bool empty() const { return wall_.empty(); }
  double min() const { return at(wall_, 0.0); }
  double median() const { return at(wall_, 0.5); }
  double max() const { return at(wall_, 1.0); }
  double cpu_min() const { return at(cpu_, 0.0); }
  double cpu_median() const { return at(cpu_, 0.5); }
  double cpu_max() const { return at(cpu_, 1.0); }
  double cpu_sum() const;

  /// The median's part in a ratio: of processor time on one thread, which others on the machine
  /// change least; of wall-clock time on several.
  double for_ratio(int threads) const { return threads == 1 ? cpu_median() : median(); }

private:
  struct Clock {
    Clock();
    double wall, cpu;
  };
  void add(const Clock& before);
  static double at(std::vector<double> values, double quantile);
  std::vector<double> wall_, cpu_;
};

/// The power of x that y goes with, by least squares over the logarithms; x, y: above 0, as many.
double power_of(const std::vector<double>& x, const std::vector<double>& y);

/// Bytes the C library has handed out (to a peer; libinsitu counts its own). 0 if unknown.
std::int64_t heap_bytes();
/// Starts a new peak of resident memory; returns what is resident now.
std::int64_t start_resident_peak();
std::int64_t resident_peak();

/// Throws std::runtime_error naming the option if the file cannot be written.
void write_file(const std::string& option, const std::string& file, const std::string& text);

/// One line that overwrites itself on standard error, if that is a terminal.
void progress(const std::string& text);

} // namespace insitu::bench
