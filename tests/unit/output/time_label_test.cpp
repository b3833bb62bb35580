// Formats of time labels: what each writes, and which are refused.
#include <clocale>
#include <gtest/gtest.h>

#include "core/status.h"
#include "output/annotate/time_label.h"

namespace insitu::output {
namespace {

std::string label(const char* format, double time, std::int64_t cycle = 120) {
  return TimeLabel(format)(time, cycle);
}

TEST(TimeLabel, WritesTimeAndCycle) {
  EXPECT_EQ(TimeLabel()(0.25, 120), "cycle 120  time 0.25");
  EXPECT_EQ(TimeLabel()(1.0 / 3, 0), "cycle 0  time 0.333333");
  EXPECT_EQ(TimeLabel()(1e-7, -1), "cycle -1  time 1e-07");
  EXPECT_EQ(label("{time:.3f} s", 1.0005), "1.000 s");
  EXPECT_EQ(label("{time:.0f}", 2.5), "2");
  EXPECT_EQ(label("{time:.2e}", 12345.678), "1.23e+04");
  EXPECT_EQ(label("{time:.4g}", 12345.678), "1.235e+04");
  EXPECT_EQ(label("{time:.17g}", 0.1), "0.10000000000000001");
  EXPECT_EQ(label("{time:.1f}", -0.01), "0.0") << "what is rounded to zero has no sign";
  EXPECT_EQ(label("{cycle}/{cycle:6}/{cycle:06}/{cycle:2}", 0), "120/   120/000120/120");
  EXPECT_EQ(label("{cycle:06}", 0, -12), "-00012");
  EXPECT_EQ(label("{{{time}}} {{}}", 2), "{2} {}");
  EXPECT_EQ(label("{time:.3f}", 1e300).size(), 301u + 4u);
  EXPECT_EQ(label("{time:.2f} {time}", HUGE_VAL), "inf inf");
}

TEST(TimeLabel, RefusesWhatIsNoFormat) {
  for (const char* format : {"",
                             "no field",
                             "{{time}}",
                             "{",
                             "}",
                             "{time",
                             "time}",
                             "{time}}",
                             "{}",
                             "{t}",
                             "{Time}",
                             "{time }",
                             "{time:}",
                             "{time:.}",
                             "{time:.3}",
                             "{time:3f}",
                             "{time:.18f}",
                             "{time:.3d}",
                             "{time:.3ff}",
                             "{time:.-1f}",
                             "{time:+.3f}",
                             "{time:.99999999999999f}",
                             "{cycle:}",
                             "{cycle:0}",
                             "{cycle:21}",
                             "{cycle:x}",
                             "{cycle:-3}",
                             "{cycle:.3f}",
                             "{cycle:6d}",
                             "{time:{cycle}}",
                             "%g"})
    EXPECT_THROW(TimeLabel{format}, core::Error) << format;
}

} // namespace
} // namespace insitu::output
