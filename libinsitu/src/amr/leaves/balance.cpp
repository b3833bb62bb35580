#include "amr/leaves/balance.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "core/status.h"
#include "parallel/parcels.h"

namespace insitu::amr {

namespace {

/// A cell to split, and the real leaf that it is or lies in.
struct Split {
  std::int64_t index[3];
  std::uint32_t leaf;
  int leaf_depth;
};
using Splits = std::vector<Split>; ///< of one depth

void normalize(Splits& splits) {
  std::sort(splits.begin(), splits.end(),
            [](const Split& a, const Split& b) { return comes_before(a.index, b.index); });
  splits.erase(std::unique(splits.begin(), splits.end(),
                           [](const Split& a, const Split& b) {
                             return std::equal(a.index, a.index + 3, b.index);
                           }),
               splits.end());
}

bool holds(const Splits& splits, const std::int64_t* index) {
  const auto at = std::lower_bound(
      splits.begin(), splits.end(), index,
      [](const Split& a, const std::int64_t* b) { return comes_before(a.index, b); });
  return at != splits.end() && std::equal(index, index + 3, at->index);
}

/// The leaf at a place of a depth or above it; nothing where it is refined and outside.
std::uint32_t leaf_at(const BrickStore& store, int depth, const std::int64_t* index,
                      int* leaf_depth) {
  int up = 0;
  std::uint32_t leaf = store.at(depth, index);
  if (leaf == BrickStore::nothing)
    leaf = store.above(depth, index, &up);
  *leaf_depth = depth - up;
  return BrickStore::is_leaf(leaf) ? leaf : BrickStore::nothing;
}

/// A split cell has to be there, and its children need neighbours of its depth at least: asks for
/// the splits above that make them, of eight cells.
void ask_around(const BrickStore& store, int depth, const Split& split, Splits& above) {
  for (int o = 0; o < 8; ++o) {
    Split s;
    for (int a = 0; a < 3; ++a)
      s.index[a] = (split.index[a] + (o >> a & 1 ? 1 : -1)) >> 1;
    s.leaf = leaf_at(store, depth - 1, s.index, &s.leaf_depth);
    if (s.leaf != BrickStore::nothing)
      above.push_back(s);
  }
}

mesh::AmrCell cell(int depth, const std::int64_t* index) {
  return {depth, {index[0], index[1], index[2]}};
}

/// Adds what splits ask for, from the finest depth on.
void close(const BrickStore& store, std::vector<Splits>& splits) {
  for (int d = store.depth_count() - 1; d >= 0; --d) {
    Splits& own = splits[std::size_t(d)];
    normalize(own);
    if (d > 0)
      for (const Split& s : own)
        ask_around(store, d, s, splits[std::size_t(d - 1)]);
  }
}

/// A split as processes tell each other.
struct ToldSplit {
  std::int32_t depth, index[3];
};

/// Of the splits in leaves that count, tells each process those that are its business.
class SplitMail {
public:
  explicit SplitMail(const SharedLeaves& shared) : shared_(shared) {}

  /// whose(split, tell): calls tell(rank).
  template <class Whose>
  void write(const std::vector<Splits>& splits, Whose&& whose) {
    to_.assign(std::size_t(shared_.world.size()), {});
    for (std::size_t d = 0; d < splits.size(); ++d)
      for (const Split& s : splits[d])
        whose(s, int(d), [&](int rank) {
          to_[std::size_t(rank)].push_back(
              {std::int32_t(d),
               {std::int32_t(s.index[0]), std::int32_t(s.index[1]), std::int32_t(s.index[2])}});
        });
    parcels_ = parallel::parcels_of(to_);
  }
  void exchange() { parcels_ = shared_.world.exchange(parcels_); }
  /// Adds those that came and are not there; returns how many.
  std::int64_t add(const BrickStore& store, std::vector<Splits>& splits) const {
    std::vector<Splits> more(splits.size());
    for (const parallel::Parcel& p : parcels_)
      for (const ToldSplit& told : parallel::items_of<ToldSplit>(p.bytes)) {
        Split s{{told.index[0], told.index[1], told.index[2]}, BrickStore::nothing, 0};
        if (told.depth < 0 || std::size_t(told.depth) >= splits.size())
          continue; // of a leaf that is none here
        s.leaf = leaf_at(store, told.depth, s.index, &s.leaf_depth);
        if (s.leaf != BrickStore::nothing && !holds(splits[std::size_t(told.depth)], s.index))
          more[std::size_t(told.depth)].push_back(s);
      }
    std::int64_t count = 0;
    for (std::size_t d = 0; d < splits.size(); ++d) {
      normalize(more[d]);
      count += std::int64_t(more[d].size());
      splits[d].insert(splits[d].end(), more[d].begin(), more[d].end());
      normalize(splits[d]);
    }
    return count;
  }

private:
  const SharedLeaves& shared_;
  std::vector<std::vector<ToldSplit>> to_;
  std::vector<parallel::Parcel> parcels_;
};

/// What a split asks for lies in leaves that touch its own; who has that one knows them all.
void close_over_all(const BrickStore& store, const SharedLeaves& shared,
                    std::vector<Splits>& splits) {
  SplitMail mail(shared);
  std::vector<Splits> told(splits.size());
  for (std::int64_t more = 1; more > 0;) {
    shared.world.agree_after([&] {
      close(store, splits);
      mail.write(splits, [&](const Split& s, int depth, auto&& tell) {
        if (!shared.is_own(s.leaf) && !holds(told[std::size_t(depth)], s.index))
          tell(shared.rank_of(s.leaf));
      });
      told = splits;
    });
    mail.exchange();
    shared.world.agree_after([&] { more = mail.add(store, splits); });
    more = sum_over(&shared, more);
  }
  shared.world.agree_after([&] {
    mail.write(splits, [&](const Split& s, int, auto&& tell) {
      if (shared.is_own(s.leaf))
        shared.for_borrowers(s.leaf, tell);
    });
  });
  mail.exchange();
  shared.world.agree_after([&] { (void)mail.add(store, splits); });
}

} // namespace

VirtualLeaves balance(const BrickStore& store, const std::vector<SteepCorner>& corners,
                      std::int64_t first_id, const SharedLeaves* shared) {
  std::vector<Splits> splits(std::size_t(store.depth_count()) + 1);
  for (const SteepCorner& c : corners)
    for (int o = 0; o < 8; ++o) {
      if ((c.octants >> o & 1) == 0)
        continue;
      // The cell two depths above has to be split, whatever real leaf it is in.
      const int depth = c.depth - 2;
      Split s;
      for (int a = 0; a < 3; ++a)
        s.index[a] = (c.index[a] - 1 + (o >> a & 1)) >> 2;
      s.leaf = leaf_at(store, depth, s.index, &s.leaf_depth);
      splits[std::size_t(depth)].push_back(s);
    }
  if (shared)
    close_over_all(store, *shared, splits);
  else
    close(store, splits);
  VirtualLeaves made;
  made.first = first_id;
  std::size_t count = 0;
  for (const Splits& s : splits)
    count += s.size();
  made.split.reserve(count);
  made.leaves.reserve(8 * count);
  for (int d = 0; d < store.depth_count(); ++d)
    for (const Split& s : splits[std::size_t(d)]) {
      made.split.push_back(cell(d, s.index));
      const int up = d - s.leaf_depth;
      const std::int64_t real[3] = {s.index[0] >> up, s.index[1] >> up, s.index[2] >> up};
      for (int o = 0; o < 8; ++o) {
        const std::int64_t child[3] = {2 * s.index[0] + (o & 1), 2 * s.index[1] + (o >> 1 & 1),
                                       2 * s.index[2] + (o >> 2)};
        if (!holds(splits[std::size_t(d + 1)], child))
          made.leaves.push_back({cell(d + 1, child), cell(s.leaf_depth, real), s.leaf});
      }
    }
  if (first_id + std::int64_t(made.leaves.size()) > std::int64_t(BrickStore::most_leaves))
    throw core::Error(INSITU_ERROR_MESH,
                      "an adaptive mesh of " + std::to_string(first_id) +
                          " cells, whose dual mesh needs " + std::to_string(made.leaves.size()) +
                          " more; at most " + std::to_string(BrickStore::most_leaves) +
                          " can be told apart");
  return made;
}

void overlay(const BrickStore& store, const VirtualLeaves& leaves, BrickStore& copy,
             const core::Threads& threads) {
  BrickKeys keys;
  for (int d = 0; d < store.depth_count(); ++d)
    for (std::int64_t b = store.first_brick(d); b < store.first_brick(d + 1); ++b)
      keys[std::size_t(d)].push_back(store.key(b));
  for (const mesh::AmrCell& c : leaves.split) {
    const std::int64_t child[3] = {2 * c.index[0], 2 * c.index[1], 2 * c.index[2]};
    keys[std::size_t(c.depth + 1)].push_back(BrickStore::key_of(child));
  }
  for (std::vector<BrickKey>& k : keys)
    normalize(k);
  copy.create(keys, threads);
  threads.parallel_for(store.brick_count(), 64, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t b = begin; b < end; ++b)
      std::memcpy(copy.entries(copy.find(store.depth_of(b), store.key(b))), store.entries(b),
                  BrickStore::brick_entries * sizeof(std::uint32_t));
  });
  const auto entry = [&](const mesh::AmrCell& c) -> std::uint32_t& {
    return copy.entries(
        copy.find(c.depth, BrickStore::key_of(c.index)))[BrickStore::entry_of(c.index)];
  };
  for (const mesh::AmrCell& c : leaves.split)
    entry(c) = BrickStore::refined;
  for (std::size_t n = 0; n < leaves.leaves.size(); ++n)
    entry(leaves.leaves[n].cell) = std::uint32_t(leaves.first + std::int64_t(n));
}

} // namespace insitu::amr
