#pragma once

#include <cstdio>
#include <initializer_list>
#include <map>
#include <string>

#include "part_session.h"

namespace insitu::test {

constexpr int shown_from = 100; ///< added to the cycles of steps that are shown

/// Shows steps that are held and executes them, on all processes; no tree is built.
inline void show_again(api::Session& session, std::initializer_list<int> cycles) {
  const std::int64_t builds = session.report().rebuilds;
  for (const int cycle : cycles) {
    session.show(cycle);
    EXPECT_EQ(session.execute(shown_from + cycle, 0.25 * cycle), "");
  }
  session.show(INSITU_LIVE);
  EXPECT_EQ(session.report().rebuilds, builds);
}

/// The files of steps that were shown are those of the live ones. Returns how many there are.
inline int expect_shown_as_live(const std::map<std::string, std::string>& files) {
  int count = 0;
  for (const auto& [name, bytes] : files) {
    const auto at = name.rfind("_0001");
    if (at == std::string::npos)
      continue;
    std::string live = name;
    live.replace(at, 5, "_0000");
    const auto found = files.find(live);
    EXPECT_TRUE(found != files.end() && found->second == bytes) << name;
    ++count;
  }
  return count;
}

} // namespace insitu::test
