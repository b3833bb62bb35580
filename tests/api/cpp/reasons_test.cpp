/// Owners and reasons of points whose place is known exactly.
#include <algorithm>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>

namespace {

/// n^3 hexahedra with jittered vertices, whose coordinates have few digits: so the middles of
/// edges, of (bilinear) faces and of cells are known exactly, and with them owner and reason.
struct KnownPlaces {
  static constexpr int n = 12;
  std::vector<double> vertices, points;
  std::vector<int> ids;
  std::vector<std::int64_t> owners;
  std::vector<insitu::Reason> reasons;

  KnownPlaces() {
    std::uint32_t state = 12345;
    for (int k = 0; k <= n; ++k)
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i)
          for (const int c : {i, j, k}) {
            state = state * 1664525u + 1013904223u;
            vertices.push_back(c + (static_cast<double>(state >> 24) - 128.0) / 1024.0);
          }
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
          for (const auto& [a, b, c] : std::vector<std::array<int, 3>>{{0, 0, 0},
                                                                       {1, 0, 0},
                                                                       {1, 1, 0},
                                                                       {0, 1, 0},
                                                                       {0, 0, 1},
                                                                       {1, 0, 1},
                                                                       {1, 1, 1},
                                                                       {0, 1, 1}})
            ids.push_back(vertex(i + a, j + b, k + c));
    // The span (di, dj, dk) from vertex (i, j, k): a vertex, an edge, a face or a cell.
    for (int span = 0; span < 8; ++span)
      for (int k = 0; k + (span >> 2 & 1) <= n; ++k)
        for (int j = 0; j + (span >> 1 & 1) <= n; ++j)
          for (int i = 0; i + (span & 1) <= n; ++i)
            add_middle({i, j, k}, {span & 1, span >> 1 & 1, span >> 2 & 1});
    for (int q = 0; q < 1000; ++q) {
      points.insert(points.end(), {-1.0 - q, 0.5, 0.5});
      owners.push_back(-1);
      reasons.push_back(insitu::Reason::outside);
    }
  }

private:
  static int vertex(int i, int j, int k) { return i + (n + 1) * (j + (n + 1) * k); }
  void add_middle(const std::array<int, 3>& from, const std::array<int, 3>& span) {
    const int dimension = span[0] + span[1] + span[2];
    double p[3] = {0, 0, 0};
    for (int c = 0; c <= span[2]; ++c)
      for (int b = 0; b <= span[1]; ++b)
        for (int a = 0; a <= span[0]; ++a)
          for (int axis = 0; axis < 3; ++axis)
            p[axis] += vertices[static_cast<std::size_t>(
                           3 * vertex(from[0] + a, from[1] + b, from[2] + c) + axis)] /
                       (1 << dimension);
    points.insert(points.end(), p, p + 3);
    std::int64_t owner = 0; // of the cells around it, the lowest along each axis
    for (const std::size_t axis : {2u, 1u, 0u})
      owner = owner * n + (span[axis] ? from[axis] : std::max(from[axis] - 1, 0));
    owners.push_back(owner);
    constexpr insitu::Reason by_dimension[] = {insitu::Reason::on_vertex, insitu::Reason::on_edge,
                                               insitu::Reason::on_face, insitu::Reason::certified};
    reasons.push_back(by_dimension[dimension]);
  }
};

} // namespace

TEST(Reasons, DoNotDependOnThreads) {
  const KnownPlaces known;
  for (const insitu::Accuracy accuracy : {insitu::Accuracy::standard, insitu::Accuracy::exact}) {
    insitu::Locations first;
    for (const int threads : {1, 2, 4}) {
      insitu::Options options;
      options.threads = threads;
      insitu::Session session(options);
      insitu::Mesh mesh = session.mesh("m");
      mesh.points(known.vertices);
      mesh.hexahedra(known.ids);
      mesh.commit();
      insitu::LocateOptions how;
      how.accuracy = accuracy;
      EXPECT_TRUE(mesh.locate(known.points, how).reasons.empty());
      how.reasons = true;
      const insitu::Locations found = mesh.locate(known.points, how);
      ASSERT_EQ(found.reasons.size(), known.reasons.size());
      std::int64_t expected[INSITU_REASON_COUNT] = {};
      for (std::size_t i = 0; i < found.size(); ++i) {
        ASSERT_EQ(found.cells[i], known.owners[i]) << i;
        // How the library makes sure of an interior point is its own affair.
        const bool same = found.reasons[i] == known.reasons[i] ||
                          (known.reasons[i] == insitu::Reason::certified &&
                           found.reasons[i] == insitu::Reason::exact);
        ASSERT_TRUE(same) << i << ": " << int(found.reasons[i]);
        expected[static_cast<int>(found.reasons[i])] += 2; // located twice
      }
      const insitu::Report report = session.report();
      for (int r = 0; r < INSITU_REASON_COUNT; ++r)
        EXPECT_EQ(report.located_by_reason[r], expected[r]) << r;
      if (threads == 1)
        first = found;
      EXPECT_EQ(found.reasons, first.reasons) << threads << " threads";
    }
  }
}
