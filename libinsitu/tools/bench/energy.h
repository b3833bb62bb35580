#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace insitu::bench {

/// Joules drawn so far by a processor (RAPL, all packages) or a card (NVML, device 0), where they
/// can be read.
class EnergyMeter {
public:
  enum class Of { processor, card };
  explicit EnergyMeter(Of of);
  ~EnergyMeter();
  EnergyMeter(const EnergyMeter&) = delete;
  EnergyMeter& operator=(const EnergyMeter&) = delete;

  bool works() const;
  /// Why not, if not.
  const std::string& why() const { return why_; }
  /// Since some moment; differences count. Packages' counters wrap after minutes under load: ask
  /// often.
  double joules();

private:
  struct Source;
  std::unique_ptr<Source> source_;
  std::string why_;
};

} // namespace insitu::bench
