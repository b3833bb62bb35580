#include "compare/exr_compare.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <map>

#include "core/status.h"

namespace insitu::compare {

namespace {

struct Channels {
  int width = 0, height = 0;
  std::map<std::string, std::vector<double>> values; ///< doubles hold all that 32 bits do
};

template <class T>
std::vector<double> read_channel(Imf::InputFile& file, const char* name, Imf::PixelType type) {
  const auto window = file.header().dataWindow();
  const auto width = std::size_t(window.max.x - window.min.x + 1);
  std::vector<T> values(width * std::size_t(window.max.y - window.min.y + 1));
  // The library counts from the pixel (0, 0), wherever the window begins.
  char* const base =
      reinterpret_cast<char*>(values.data()) -
      std::ptrdiff_t(sizeof(T)) * (window.min.x + std::ptrdiff_t(width) * window.min.y);
  Imf::FrameBuffer buffer;
  buffer.insert(name, Imf::Slice(type, base, sizeof(T), sizeof(T) * width));
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  return {values.begin(), values.end()};
}

Channels read_channels(const std::string& path) {
  try {
    Imf::InputFile file(path.c_str(), 0);
    const auto window = file.header().dataWindow();
    Channels out{window.max.x - window.min.x + 1, window.max.y - window.min.y + 1, {}};
    const Imf::ChannelList& list = file.header().channels();
    for (auto it = list.begin(); it != list.end(); ++it) {
      if (it.channel().xSampling != 1 || it.channel().ySampling != 1)
        throw core::Error(INSITU_ERROR_FILE, "channel '" + std::string(it.name()) +
                                                 "' has not a value for each pixel");
      out.values[it.name()] = it.channel().type == Imf::UINT
                                  ? read_channel<std::uint32_t>(file, it.name(), Imf::UINT)
                                  : read_channel<float>(file, it.name(), Imf::FLOAT);
    }
    return out;
  } catch (const std::exception& e) {
    throw core::Error(INSITU_ERROR_FILE, "cannot read '" + path + "': " + e.what());
  }
}

class Comparison {
public:
  Comparison(const Channels& a, const Channels& b, const ExrOptions& options)
      : a_(a), b_(b), options_(options) {}

  Verdict run() {
    if (a_.width != b_.width || a_.height != b_.height) {
      verdict_.differ("sizes: " + size_text(a_) + " -> " + size_text(b_) + " pixels");
      return verdict_;
    }
    std::size_t compared = 0;
    for (const auto& [name, values] : a_.values)
      if (is_ignored(name)) {
      } else if (const auto other = b_.values.find(name); other == b_.values.end()) {
        verdict_.differ("channel '" + name + "' is missing in the second file");
      } else {
        compare(name, values, other->second);
        ++compared;
      }
    for (const auto& [name, values] : b_.values)
      if (!is_ignored(name) && !a_.values.contains(name))
        verdict_.differ("channel '" + name + "' is missing in the first file");
    if (verdict_.lines.empty())
      verdict_.lines.push_back("same: " + count_text(compared, "channel") + " of " + size_text(a_));
    return verdict_;
  }

private:
  static std::string size_text(const Channels& c) {
    return std::to_string(c.width) + " x " + std::to_string(c.height);
  }
  bool is_ignored(const std::string& name) const {
    return std::find(options_.ignored.begin(), options_.ignored.end(), name) !=
           options_.ignored.end();
  }
  Tolerance tolerance_of(const std::string& name) const {
    for (const NamedTolerance& named : options_.channels)
      if (named.name == name)
        return named.tolerance;
    return options_.tolerance;
  }

  void compare(const std::string& name, const std::vector<double>& a,
               const std::vector<double>& b) {
    const Tolerance tolerance = tolerance_of(name);
    std::size_t moved = 0, worst = 0;
    double most = -1;
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (same_number(a[i], b[i], tolerance))
        continue;
      ++moved;
      if (const double by = excess(a[i], b[i], tolerance); by > most) {
        most = by;
        worst = i;
      }
    }
    if (moved == 0)
      return;
    const auto width = std::size_t(a_.width);
    const std::string line = "channel '" + name + "': " + count_text(moved, "pixel") + " of " +
                             std::to_string(a.size()) + " moved, most (" +
                             std::to_string(worst % width) + ", " + std::to_string(worst / width) +
                             "): " + change_text(a[worst], b[worst]);
    if (double(moved) > options_.max_share * double(a.size()))
      verdict_.differ(line);
    else
      verdict_.lines.push_back("same within tolerance: " + line);
  }

  const Channels &a_, &b_;
  const ExrOptions& options_;
  Verdict verdict_;
};

} // namespace

Verdict compare_exr(const std::string& a, const std::string& b, const ExrOptions& options) {
  const Channels in_a = read_channels(a), in_b = read_channels(b);
  return Comparison(in_a, in_b, options).run();
}

} // namespace insitu::compare
