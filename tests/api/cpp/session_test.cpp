/// Sessions of insitu.hpp. Compiled as C++17 and as C++20.

#include <algorithm>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>

#include "two.h"

static insitu::Mesh mesh_of(Two& two, insitu::Session& session) {
  insitu::Mesh mesh = session.mesh("m");
  mesh.points(two.xyz);
  mesh.hexahedra(two.ids);
  mesh.vertex_field("p", two.pressure);
  return mesh;
}

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
  insitu::Mesh mesh = mesh_of(two, session);
  EXPECT_FALSE(session.execute(0, 0.0));
  EXPECT_TRUE(std::any_of(messages.begin(), messages.end(), [](const std::string& m) {
    return m.find("absent") != std::string::npos;
  }));
  EXPECT_EQ(session.report().failures, 1);
  EXPECT_EQ(session.report().executions, 1);
}

TEST(WrapperSession, AnswersOfProbesAreKept) {
  insitu::Options options;
  options.scene_text = "insitu: 1\nprobes:\n"
                       "  - {name: often, points: [[0.5, 0.5, 0.5], [9, 9, 9]], fields: [p]}\n"
                       "  - {name: once, every: 10, points: [[1.5, 0.5, 0.5]], fields: [p]}\n";
  options.output = testing::TempDir() + "insitu_answers";
  insitu::Session session(options);
  Two two;
  insitu::Mesh mesh = mesh_of(two, session);
  EXPECT_TRUE(session.execute(0, 0.0));
  ASSERT_EQ(session.answers().size(), 2u);
  EXPECT_EQ(session.answers()[0].answered, 0); // nobody asked to keep them
  session.keep_answers();
  EXPECT_TRUE(session.execute(1, 0.5));
  std::vector<insitu::ProbeAnswers> answers = session.answers();
  EXPECT_STREQ(answers[0].name, "often");
  EXPECT_EQ(answers[0].cycle, 1);
  EXPECT_EQ(answers[0].time, 0.5);
  ASSERT_EQ(answers[0].point_count, 2);
  EXPECT_EQ(answers[0].points[3], 9.0);
  EXPECT_EQ(answers[0].inside[0], 1);
  EXPECT_EQ(answers[0].inside[1], 0);
  const std::vector<double> middle{0.5, 0.5, 0.5};
  EXPECT_EQ(answers[0].values[0], mesh.sample("p", middle)(0));
  EXPECT_NE(answers[0].values[1], answers[0].values[1]); // NaN
  EXPECT_EQ(answers[1].answered, 0);                     // not due since
  EXPECT_TRUE(session.execute(10, 5.0));
  answers = session.answers();
  EXPECT_EQ(answers[0].cycle, 10);
  EXPECT_EQ(answers[1].cycle, 10);
  EXPECT_TRUE(session.execute(11, 5.5));
  EXPECT_EQ(session.answers()[1].cycle, 10); // the last of its own
  session.keep_answers(false);
  EXPECT_EQ(session.answers()[0].answered, 0);

  std::int32_t count = 0;
  insitu_probe_answers none = insitu_probe_answers_default();
  EXPECT_EQ(insitu_session_answers(session.handle(), 2, &none, &count), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(count, 2);
  EXPECT_EQ(insitu_session_answers(session.handle(), 0, &none, nullptr), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(insitu_session_keep_answers(session.handle(), 2), INSITU_ERROR_ARGUMENT);
  none.size = 3;
  EXPECT_EQ(insitu_session_answers(session.handle(), 0, &none, &count), INSITU_ERROR_ARGUMENT);
  insitu::Session without{insitu::Options()};
  EXPECT_TRUE(without.answers().empty());
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
