#include "energy.h"

#include <dlfcn.h>
#include <filesystem>
#include <fstream>
#include <vector>

namespace insitu::bench {

struct EnergyMeter::Source {
  virtual ~Source() = default;
  virtual double joules() = 0;
};

namespace {

namespace fs = std::filesystem;

/// A number from a one-line file of /sys; -1 if it cannot be read.
std::int64_t read_number(const fs::path& file) {
  std::ifstream in(file);
  std::int64_t value = -1;
  return in >> value ? value : -1;
}

/// Intel's and AMD's running average power limit counters, in microjoules, through the powercap
/// files: most kernels let root alone read them, and virtual machines have none.
struct Rapl {
  struct Package {
    fs::path energy;
    std::int64_t range, last;
  };
  std::vector<Package> packages;
  double sum = 0.0;

  std::string open() {
    const fs::path root = "/sys/class/powercap";
    std::error_code error;
    bool seen = false;
    for (const auto& entry : fs::directory_iterator(root, error)) {
      const std::string name = entry.path().filename();
      if (name.rfind("intel-rapl:", 0) != 0 || name.find(':', 11) != std::string::npos)
        continue; // a part of a package, or something else
      seen = true;
      Package p{entry.path() / "energy_uj", read_number(entry.path() / "max_energy_range_uj"), 0};
      p.last = read_number(p.energy);
      if (p.last >= 0)
        packages.push_back(p);
    }
    return !packages.empty() ? ""
           : seen            ? "RAPL's counters (/sys/class/powercap) may not be read by this user"
                             : "the kernel shows no RAPL counters (/sys/class/powercap)";
  }

  double joules() {
    for (Package& p : packages) {
      const std::int64_t now = read_number(p.energy);
      if (now < 0)
        continue;
      sum += 1e-6 * double(now >= p.last ? now - p.last : now - p.last + p.range);
      p.last = now;
    }
    return sum;
  }
};

/// NVIDIA's management library, found at run time: the few calls needed, as its header declares
/// them.
struct Nvml {
  void* library = nullptr;
  void* device = nullptr;
  int (*shutdown)() = nullptr;
  int (*total_energy)(void*, unsigned long long*) = nullptr;

  ~Nvml() {
    if (shutdown)
      shutdown();
    if (library)
      dlclose(library);
  }

  std::string open() {
    library = dlopen("libnvidia-ml.so.1", RTLD_NOW);
    if (!library)
      return "libnvidia-ml.so.1 is not here";
    const auto init = reinterpret_cast<int (*)()>(dlsym(library, "nvmlInit_v2"));
    const auto get = reinterpret_cast<int (*)(unsigned, void**)>(
        dlsym(library, "nvmlDeviceGetHandleByIndex_v2"));
    total_energy = reinterpret_cast<int (*)(void*, unsigned long long*)>(
        dlsym(library, "nvmlDeviceGetTotalEnergyConsumption"));
    if (!init || !get || !total_energy || init() != 0)
      return "NVML does not start";
    shutdown = reinterpret_cast<int (*)()>(dlsym(library, "nvmlShutdown"));
    unsigned long long millijoules = 0;
    if (get(0, &device) != 0 || total_energy(device, &millijoules) != 0)
      return "NVML: this card does not tell its energy";
    return "";
  }

  double joules() {
    unsigned long long millijoules = 0;
    return total_energy(device, &millijoules) == 0 ? 1e-3 * double(millijoules) : 0.0;
  }
};

template <class Counter, class Base>
struct From : Base {
  Counter counter;
  double joules() override { return counter.joules(); }
};
} // namespace

EnergyMeter::EnergyMeter(Of of) {
  const auto open = [&]<class Counter>() {
    auto source = std::make_unique<From<Counter, Source>>();
    why_ = source->counter.open();
    if (why_.empty())
      source_ = std::move(source);
  };
  if (of == Of::processor)
    open.operator()<Rapl>();
  else
    open.operator()<Nvml>();
}

EnergyMeter::~EnergyMeter() = default;

bool EnergyMeter::works() const {
  return source_ != nullptr;
}

double EnergyMeter::joules() {
  return source_ ? source_->joules() : 0.0;
}

} // namespace insitu::bench
