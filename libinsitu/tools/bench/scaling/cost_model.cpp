#include "scaling/cost_model.h"

#include <algorithm>
#include <cmath>

#include "workload/flow.h"

namespace insitu::bench::scaling {

using math::Vec3d;

namespace {

// The page's first table.
constexpr double box = 48, most_boxes = 64;
constexpr double near_cell = 24 + 1.0 / 8;
constexpr double halo_cell = 57, halo_vertex = 24, value = 8;
constexpr double question = 24, no_answer = 1, owner = 64;
constexpr double hop = 2104;
constexpr double parcel = 8; // its length
constexpr double piece = 32; // of a halo: what stands before a piece's cells
constexpr double field_header = 12;

/// Two messages for each pair of processes that sends one parcel: the length, and the parcel.
Cost exchange(double pairs, double bytes) {
  Cost cost;
  cost.exchanges = 1;
  cost.messages = 2 * pairs;
  cost.bytes = bytes + parcel * pairs;
  return cost;
}

Cost directory(const Layout& layout) {
  const double pairs = double(layout.processes) * (layout.processes - 1);
  return exchange(pairs, pairs * most_boxes * box);
}

/// What the neighbours of all parts have of them.
struct Seams {
  double pairs = 0, cells = 0, vertices = 0;

  explicit Seams(const Layout& layout) {
    for (int rank = 0; rank < layout.processes; ++rank) {
      const Layout::Part part = layout.part(rank);
      const std::array<int, 3> at = layout.place(rank);
      for (int neighbour = 0; neighbour < 27; ++neighbour) {
        const int step[3] = {neighbour % 3 - 1, neighbour / 3 % 3 - 1, neighbour / 9 - 1};
        double lent = 1, corners = 1;
        bool is_there = neighbour != 13;
        for (int a = 0; a < 3; ++a) {
          const int to = at[std::size_t(a)] + step[a];
          is_there = is_there && to >= 0 && to < layout.parts[std::size_t(a)];
          lent *= step[a] ? 1 : part.count(a);
          corners *= step[a] ? 2 : part.count(a) + 1;
        }
        if (!is_there)
          continue;
        pairs += 1;
        cells += lent;
        vertices += corners;
      }
    }
  }
};

} // namespace

Cost& Cost::operator+=(const Cost& b) {
  items += b.items;
  exchanges += b.exchanges;
  messages += b.messages;
  bytes += b.bytes;
  return *this;
}

double halo_cells(const Layout& layout) {
  return Seams(layout).cells;
}

Cost found_halo(const Layout& layout, const VertexFields& fields) {
  const Seams seams(layout);
  Cost cost = directory(layout);
  cost += exchange(seams.pairs, seams.cells * 24);
  cost += exchange(seams.pairs, seams.cells / 8);
  cost += exchange(seams.pairs,
                   seams.pairs * piece + seams.cells * halo_cell + seams.vertices * halo_vertex);
  cost += exchange(seams.pairs, seams.pairs * fields.fields * field_header +
                                    seams.vertices * fields.components * value);
  cost.items = double(layout.cell_count());
  return cost;
}

Cost refreshed_halo(const Layout& layout, const VertexFields& fields) {
  const Seams seams(layout);
  Cost cost = exchange(seams.pairs, seams.vertices * halo_vertex);
  cost += exchange(seams.pairs, seams.pairs * fields.fields * field_header +
                                    seams.vertices * fields.components * value);
  cost.items = double(layout.cell_count());
  return cost;
}

Cost asked_everywhere(const Layout& layout, double points) {
  const double pairs = double(layout.processes) * (layout.processes - 1);
  const double elsewhere = points * (layout.processes - 1) / layout.processes;
  // The jitter makes boxes of both sides reach over the seam.
  double twice = 0;
  for (std::size_t a = 0; a < 3; ++a)
    twice += 2 * layout.jitter * (layout.parts[a] - 1) / layout.cells[a];
  Cost cost = directory(layout);
  cost += exchange(pairs, elsewhere * (1 + twice) * question);
  cost += exchange(pairs, elsewhere * ((1 + twice) * no_answer + owner + value));
  cost.items = points;
  return cost;
}

namespace {

/// How long ago, at most `seconds`, what is at x now came into the box.
double time_within(const Layout& layout, Vec3d x, double seconds) {
  constexpr int steps = 16;
  const Vec3d size = layout.size();
  const double dt = seconds / steps;
  for (int step = 0; step < steps; ++step) {
    x -= dt * workload::abc_flow(x - 0.5 * dt * workload::abc_flow(x));
    for (int a = 0; a < 3; ++a)
      if (x[a] < 0 || x[a] > size[a])
        return (step + 0.5) * dt;
  }
  return seconds;
}

} // namespace

Cost moved_particles(const Layout& layout, double particles, double seconds) {
  // What crosses the faces of the seams, in the time since it came in, from both sides.
  double crossed = 0, face_pairs = 0;
  int cuts = 0;
  for (int a = 0; a < 3; ++a) {
    const auto n = std::size_t(a), b = std::size_t((a + 1) % 3), c = std::size_t((a + 2) % 3);
    const int parts = layout.parts[n];
    cuts += parts > 1;
    face_pairs += 2.0 * (parts - 1) * layout.processes / parts;
    for (int seam = 1; seam < parts; ++seam)
      for (int i = 0; i < layout.cells[b]; ++i)
        for (int j = 0; j < layout.cells[c]; ++j) {
          const auto corner = [&](int u, int w) {
            std::array<int, 3> at{};
            at[n] = int(std::int64_t(layout.cells[n]) * seam / parts);
            at[b] = i + u;
            at[c] = j + w;
            return layout.vertex(at[0], at[1], at[2]);
          };
          const Vec3d p = corner(0, 0), q = corner(1, 0), r = corner(1, 1), s = corner(0, 1);
          const double time = time_within(layout, 0.25 * (p + q + r + s), seconds);
          // The face is bilinear, and may be crossed in both directions.
          for (const double u : {0.25, 0.75})
            for (const double w : {0.25, 0.75}) {
              const Vec3d along = (1 - w) * (q - p) + w * (r - s);
              const Vec3d across = (1 - u) * (s - p) + u * (r - q);
              const Vec3d x = (1 - u) * ((1 - w) * p + w * s) + u * ((1 - w) * q + w * r);
              crossed += 0.25 * std::fabs(dot(workload::abc_flow(x), cross(along, across))) * time;
            }
        }
  }
  const Vec3d size = layout.size();
  const double hops = particles / (size.x * size.y * size.z) * crossed;
  Cost cost = directory(layout);
  for (int round = 0; round < cuts; ++round)
    cost += exchange(face_pairs, hops * hop / cuts);
  cost.items = particles;
  return cost;
}

} // namespace insitu::bench::scaling
