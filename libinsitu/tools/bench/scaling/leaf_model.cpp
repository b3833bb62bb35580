/// What leaves at seams cost: doc/design/scale.md.
#include <algorithm>
#include <set>

#include "scaling/leaves.h"

namespace insitu::bench::scaling {

namespace {

// The page's first table.
constexpr double box = 48, most_boxes = 64;
constexpr double told_leaf = 48, asked_leaf = 8, asked_piece = 16, value = 8, field_header = 12;
constexpr double gridlet = 20;

/// All leaves of the box, by places of the finer level.
class Leaves {
public:
  explicit Leaves(const LeafLayout& layout) : layout_(layout) {
    for (std::size_t a = 0; a < 3; ++a)
      places_[a] = 2 * layout.coarse.cells[a];
    at_.assign(std::size_t(places_[0]) * std::size_t(places_[1]) * std::size_t(places_[2]), -1);
    for (int rank = 0; rank < layout.coarse.processes; ++rank)
      layout.for_leaves(rank, [&](int level, const std::array<int, 3>& corner) {
        const int width = level ? 1 : 2;
        const Leaf leaf{rank, level, {corner[0] * width, corner[1] * width, corner[2] * width}};
        for (int n = 0; n < width * width * width; ++n)
          at_[place(leaf.low[0] + n % width, leaf.low[1] + n / width % width,
                    leaf.low[2] + n / width / width)] = int(leaves_.size());
        leaves_.push_back(leaf);
      });
  }
  struct Leaf {
    int rank, level, low[3]; ///< low: its first place
  };
  const std::vector<Leaf>& all() const { return leaves_; }
  const std::array<int, 3>& places() const { return places_; }
  const std::array<int, 3>& cells() const { return layout_.coarse.cells; }
  int at(int i, int j, int k) const { return at_[place(i, j, k)]; }

  /// Calls f(another leaf), perhaps more than once.
  template <class F>
  void for_touching(int id, F&& f) const {
    const Leaf& leaf = leaves_[std::size_t(id)];
    int low[3], end[3];
    for (int a = 0; a < 3; ++a) {
      low[a] = std::max(leaf.low[a] - 1, 0);
      end[a] = std::min(leaf.low[a] + (leaf.level ? 2 : 3), places_[std::size_t(a)]);
    }
    for (int k = low[2]; k < end[2]; ++k)
      for (int j = low[1]; j < end[1]; ++j)
        for (int i = low[0]; i < end[0]; ++i)
          if (const int other = at(i, j, k); other != id)
            f(other);
  }

private:
  std::size_t place(int i, int j, int k) const {
    return std::size_t(i) +
           std::size_t(places_[0]) * (std::size_t(j) + std::size_t(places_[1]) * std::size_t(k));
  }
  const LeafLayout& layout_;
  std::array<int, 3> places_{};
  std::vector<int> at_;
  std::vector<Leaf> leaves_;
};

/// What one process has of others, and what was told for it.
struct Around {
  std::set<int> near, far;
  double asked_pairs = 0, told = 0; ///< of the second and the third layer

  Around(const Leaves& leaves, int rank, int processes) {
    for (int id = 0; id < int(leaves.all().size()); ++id)
      if (leaves.all()[std::size_t(id)].rank == rank)
        leaves.for_touching(id, [&](int other) {
          if (leaves.all()[std::size_t(other)].rank != rank)
            near.insert(other);
        });
    std::set<int> frontier = near;
    for (int layer = 1; layer < 3; ++layer) {
      std::set<int> found;
      for (int owner = 0; owner < processes; ++owner) {
        std::set<int> answer;
        double asked = 0;
        for (const int id : frontier)
          if (leaves.all()[std::size_t(id)].rank == owner) {
            asked += 1;
            leaves.for_touching(id, [&](int other) { answer.insert(other); });
          }
        asked_pairs += asked > 0;
        told += asked + double(answer.size());
        found.merge(answer);
      }
      frontier.clear();
      for (const int id : found)
        if (leaves.all()[std::size_t(id)].rank != rank && !near.contains(id) && !far.contains(id))
          frontier.insert(id);
      far.insert(frontier.begin(), frontier.end());
    }
  }
  /// The processes that leaves are of.
  static std::set<int> owners(const Leaves& leaves, const std::set<int>& of) {
    std::set<int> ranks;
    for (const int id : of)
      ranks.insert(leaves.all()[std::size_t(id)].rank);
    return ranks;
  }
};

/// The bricks of 8^3 places of each level in which a process has cubes.
double gridlets_of(const Leaves& leaves, int rank, const Around& around) {
  std::set<std::array<int, 4>> bricks;
  for (int level = 0; level < 2; ++level) {
    const int width = level ? 1 : 2;
    const auto leaf_at = [&](int i, int j, int k) {
      const int id = leaves.at(width * i, width * j, width * k);
      return leaves.all()[std::size_t(id)].level == level ? id : -1;
    };
    std::array<int, 3> count{};
    for (std::size_t a = 0; a < 3; ++a)
      count[a] = (level ? leaves.places() : leaves.cells())[a] - 1;
    for (int k = 0; k < count[2]; ++k)
      for (int j = 0; j < count[1]; ++j)
        for (int i = 0; i < count[0]; ++i) {
          bool is_cube = true, exists = false;
          for (int n = 0; n < 8 && is_cube; ++n) {
            const int id = leaf_at(i + (n & 1), j + (n >> 1 & 1), k + (n >> 2));
            is_cube = id >= 0;
            exists |=
                is_cube && (leaves.all()[std::size_t(id)].rank == rank || around.near.contains(id));
          }
          if (is_cube && exists)
            bricks.insert({level, i >> 3, j >> 3, k >> 3});
        }
  }
  return double(bricks.size());
}

/// Two messages for each pair of processes that sends one parcel: the length, and the parcel.
Cost exchange(double pairs, double bytes) {
  return {0, 1, 2 * pairs, bytes + 8 * pairs};
}

} // namespace

LeafCosts cost_of_leaves(const LeafLayout& layout) {
  const int processes = layout.coarse.processes;
  const Leaves leaves(layout);
  LeafCosts costs;
  costs.found.items = costs.refreshed.items = double(leaves.all().size());
  if (processes == 1)
    return costs;
  const double all_pairs = double(processes) * (processes - 1);
  double near_pairs = 0, near = 0, asked_pairs = 0, told = 0, pairs = 0, pieces = 0, gridlets = 0;
  for (int rank = 0; rank < processes; ++rank) {
    const Around around(leaves, rank, processes);
    std::set<int> owners = Around::owners(leaves, around.near);
    near_pairs += double(owners.size());
    pieces += double(owners.size());
    near += double(around.near.size());
    asked_pairs += around.asked_pairs;
    told += around.told;
    std::set<int> of_far = Around::owners(leaves, around.far);
    pieces += double(of_far.size());
    owners.merge(of_far);
    pairs += double(owners.size());
    costs.halo_leaves += double(around.near.size() + around.far.size());
    gridlets += gridlets_of(leaves, rank, around);
  }
  // Boxes; leaves that touch; places beyond the domain, of which nobody is asked, twice; two
  // layers, asked for and told; which leaves are lent; gridlets to who puts them together, and
  // back; values.
  costs.found += exchange(all_pairs, all_pairs * most_boxes * box);
  costs.found += exchange(near_pairs, near * told_leaf);
  costs.found += exchange(2 * asked_pairs, told * told_leaf);
  costs.found += exchange(pairs, pieces * asked_piece + costs.halo_leaves * asked_leaf);
  const double elsewhere = double(processes - 1) / processes;
  costs.found += exchange(2 * all_pairs, 2 * elsewhere * gridlets * gridlet);
  costs.found.exchanges += 2 + 3 + 1;
  costs.refreshed += exchange(pairs, pieces * field_header + costs.halo_leaves * value);
  costs.found +=
      Cost{0, costs.refreshed.exchanges, costs.refreshed.messages, costs.refreshed.bytes};
  return costs;
}

} // namespace insitu::bench::scaling
