#include "commands/effect_prices.h"

#include <algorithm>
#include <cmath>

#include "output/files/csv.h"
#include "report/svg_axis.h"

namespace insitu::bench {

std::string csv(const std::vector<EffectPrice>& prices, int threads) {
  std::string out = "of,effect,seconds without,seconds with,time over bare,least,most,bytes added,"
                    "evaluations without,evaluations with\n";
  for (const EffectPrice& p : prices) {
    output::append_text(out, p.kind);
    out += ",";
    output::append_text(out, p.effect);
    out += format(",%.6g,%.6g,%.6g,%.6g,%.6g,%lld", p.bare.for_ratio(threads),
                  p.with.for_ratio(threads), p.ratio(threads), p.least_ratio(threads),
                  p.most_ratio(threads), static_cast<long long>(p.bytes_added));
    out += p.evaluations > 0 ? format(",%lld,%lld\n", static_cast<long long>(p.evaluations_bare),
                                      static_cast<long long>(p.evaluations))
                             : ",,\n";
  }
  return out;
}

std::string plot(const std::vector<EffectPrice>& prices, int threads) {
  using namespace drawing;
  constexpr double width = 760.0, left = 250.0, right = 90.0, top = 30.0, line = 18.0, gap = 26.0;
  double least = 1.0, most = 1.0;
  std::vector<std::string> kinds; // in the order of appearance
  for (const EffectPrice& p : prices) {
    for (const double ratio : {p.least_ratio(threads), p.ratio(threads), p.most_ratio(threads)})
      if (ratio > 0.0 && std::isfinite(ratio)) {
        least = std::min(least, ratio);
        most = std::max(most, ratio);
      }
    if (std::find(kinds.begin(), kinds.end(), p.kind) == kinds.end())
      kinds.push_back(p.kind);
  }
  Axis x{0, 1, left, width - right};
  x.fit(least, most);
  const double bottom = top + line * double(prices.size()) + gap * double(kinds.size());
  std::string out;
  for (int e = x.low; e <= x.high; ++e)
    for (int digit = 1; digit <= (e < x.high ? 9 : 1); ++digit) {
      const double at = x.at(digit * std::pow(10.0, e));
      out += format("<path d=\"M%.1f %.1fV%.1f\" stroke=\"%s\"/>\n", at, top, bottom,
                    digit > 1 ? "#f0f0f0"
                    : e == 0  ? "#444"
                              : "#ccc"); // 1: as without
      if (digit == 1)
        out += text(at, bottom + 17.0, "middle", e == -1 ? "0.1" : power(e));
    }
  out += text(0.5 * (x.from + x.to), bottom + 37.0, "middle", "time over that without the effect");
  double y = top;
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    y += gap;
    out += text(left - 10.0, y - 6.0, "end", escaped(kinds[k]), " font-weight=\"bold\"");
    for (const EffectPrice& p : prices) {
      if (p.kind != kinds[k])
        continue;
      const double ratio = p.ratio(threads), middle = y + 4.0;
      out += text(left - 10.0, y + 8.0, "end", escaped(p.effect));
      if (ratio > 0.0 && std::isfinite(ratio)) {
        const char* colour = colours[k % std::size(colours)];
        out += format("<path d=\"M%.1f %.1fH%.1f\" stroke=\"%s\" stroke-width=\"6\" "
                      "opacity=\"0.35\"/>\n",
                      x.at(1.0), middle, x.at(ratio), colour);
        out += format("<path d=\"M%.1f %.1fH%.1f\" stroke=\"%s\" stroke-width=\"2\"/>\n",
                      x.at(p.least_ratio(threads)), middle, x.at(p.most_ratio(threads)), colour);
        out += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\" fill=\"%s\"/>\n", x.at(ratio),
                      middle, colour);
        out +=
            text(width - right + 8.0, y + 8.0, "start",
                 ratio < 10.0 ? format("%+.0f %%", std::round(100.0 * (ratio - 1.0)) + 0.0) // no -0
                              : format("%.0f times", ratio));
      }
      y += line;
    }
  }
  return image(width, bottom + 46.0, out);
}

} // namespace insitu::bench
