/// Sessions of insitu.hpp. Compiled as C++17 and as C++20.

#include <algorithm>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>

#include "two.h"

TEST(WrapperSession, TheLogReachesTheFunction) {
  std::vector<std::string> messages;
  insitu::Options options;
  options.log_level = insitu::LogLevel::debug;
  options.log = [&](insitu::LogLevel, const char* message) {
    messages.emplace_back(message);
    throw std::runtime_error("dropped");
  };
  // A field that is not there: the probe fails, is logged and skipped.
  options.scene_text = "insitu: 1\nprobes:\n  - {name: q, points: [[0, 0, 0]], fields: [absent]}\n";
  options.output = testing::TempDir() + "insitu_wrapper";
  insitu::Session session(options);
  Two two;
  insitu::Mesh mesh = session.mesh("m");
  mesh.points(two.xyz);
  mesh.hexahedra(two.ids);
  mesh.vertex_field("p", two.pressure);
  EXPECT_FALSE(session.execute(0, 0.0));
  EXPECT_TRUE(std::any_of(messages.begin(), messages.end(), [](const std::string& m) {
    return m.find("absent") != std::string::npos;
  }));
  EXPECT_EQ(session.report().failures, 1);
  EXPECT_EQ(session.report().executions, 1);
}

TEST(WrapperSession, Version) {
  EXPECT_EQ(insitu::version(),
            (std::array<int, 3>{INSITU_VERSION_MAJOR, INSITU_VERSION_MINOR, INSITU_VERSION_PATCH}));
}

#if __cplusplus >= 202002L
TEST(WrapperSession, DesignatedInitialisersAndSpans) {
  insitu::Session session({.output = "out", .threads = 1});
  insitu::Mesh mesh = session.mesh("m");
  Two two;
  mesh.points(std::span<const double>(two.xyz));
  mesh.hexahedra(std::span<int>(two.ids));
  mesh.vertex_field("p", std::span<double>(two.pressure));
  EXPECT_EQ(mesh.commit().cells, 2);
}
#endif

TEST(WrapperSession, AWarningTellsWhereGlobalIdsDoNotAscend) {
  std::vector<std::string> messages;
  insitu::Options options;
  options.log = [&](insitu::LogLevel, const char* message) { messages.emplace_back(message); };
  insitu::Session session(options);
  Two two;
  insitu::Mesh mesh = session.mesh("m");
  mesh.points(two.xyz);
  mesh.hexahedra(two.ids);
  const std::vector<int> ids{7, 3};
  mesh.global_ids(insitu::Association::cell, ids);
  mesh.commit();
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_NE(messages[0].find("mesh 'm', piece 0, global ids of cells do not ascend at cell 1"),
            std::string::npos)
      << messages[0];
  mesh.changed(insitu::fields | insitu::geometry);
  mesh.commit();
  EXPECT_EQ(messages.size(), 1u); // told once
}
