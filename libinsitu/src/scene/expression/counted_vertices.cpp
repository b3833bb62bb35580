#include "scene/expression/counted_vertices.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <tuple>

#include "mesh/box.h"
#include "mesh/piece_borders.h"

namespace insitu::scene {

namespace {

/// A vertex that may have copies, as it is told to the process that compares them.
struct Copy {
  std::int64_t key[3]; ///< the global id and zeros, or the coordinates' bits
  std::int64_t owner;  ///< the lowest owning cell: its global id, or its flat id
  std::int32_t piece;
  std::int32_t process;

  auto place() const { return std::tie(key[0], key[1], key[2]); }
};

std::uint64_t hash_of(const Copy& copy) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const std::int64_t k : copy.key) {
    hash = (hash ^ std::uint64_t(k)) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
  }
  return hash;
}

/// Which of these copies count, in their order. by_ids: the vertices are known by global ids;
/// cells_by_ids: the owners are global ids.
std::vector<std::uint8_t> choose(std::span<const Copy> copies, bool by_ids, bool cells_by_ids) {
  std::vector<std::size_t> order(copies.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    const Copy &a = copies[i], &b = copies[j];
    return std::tuple(a.place(), a.process, a.piece, i) <
           std::tuple(b.place(), b.process, b.piece, j);
  });
  std::vector<std::uint8_t> counts(copies.size(), 1);
  for (auto first = order.begin(); first != order.end();) {
    const auto last = std::find_if(first, order.end(), [&](std::size_t i) {
      return copies[i].place() != copies[*first].place();
    });
    const Copy* lowest = nullptr;
    for (auto at = first; at != last;) {
      const Copy& copy = copies[*at];
      const auto next = std::find_if(at, last, [&](std::size_t i) {
        return copies[i].process != copy.process || copies[i].piece != copy.piece;
      });
      if (next - at > 1 && !by_ids) { // a crack: all of them count
        at = next;
        continue;
      }
      for (; at != next; ++at) {
        counts[*at] = 0;
        if (!lowest || (cells_by_ids && copies[*at].owner < lowest->owner))
          lowest = &copies[*at];
      }
    }
    if (lowest)
      counts[std::size_t(lowest - copies.data())] = 1;
    first = last;
  }
  return counts;
}

} // namespace

/// One search, whose steps are called in their order by all processes.
class CountedVertices::Finder {
public:
  Finder(const mesh::Mesh& mesh, parallel::World& world, const core::Threads& threads)
      : mesh_(mesh), view_(mesh.own_view()), world_(world), threads_(threads) {}

  std::vector<std::vector<bool>> find(bool ids_of_vertices, bool ids_of_cells) {
    by_ids_ = ids_of_vertices;
    cells_by_ids_ = ids_of_cells;
    world_.agree_after([&] { find_used(); });
    std::vector<double> boxes(std::size_t(world_.size()) * 6);
    world_.agree_after([&] {
      // The lows are negated, so that one reduction brings the boxes of all processes.
      std::fill(boxes.begin(), boxes.end(), -std::numeric_limits<double>::infinity());
      for (int axis = 0; axis < 3 && any_; ++axis) {
        boxes[std::size_t(world_.rank() * 6 + axis)] = -box_.low[axis];
        boxes[std::size_t(world_.rank() * 6 + 3 + axis)] = box_.high[axis];
      }
    });
    if (world_.size() > 1)
      world_.reduce(std::span(boxes), parallel::Reduction::greatest);
    std::vector<parallel::Parcel> out;
    world_.agree_after([&] {
      find_copies(boxes);
      out = to_those_who_compare();
    });
    if (world_.size() == 1 && vertices_.empty())
      return std::move(counted_);
    const std::vector<parallel::Parcel> in = world_.exchange(out);
    std::vector<parallel::Parcel> answers;
    world_.agree_after([&] { answers = compare(in); });
    const std::vector<parallel::Parcel> told = world_.exchange(answers);
    world_.agree_after([&] { take(told); });
    return std::move(counted_);
  }

private:
  /// The vertices that owning cells use, and the lowest cell of each.
  void find_used() {
    counted_.resize(std::size_t(view_.piece_count));
    lowest_.resize(counted_.size());
    for (std::int32_t p = 0; p < view_.piece_count; ++p) {
      const mesh::PieceView& piece = view_.pieces[p];
      if (!piece.shares_vertices())
        continue;
      std::vector<std::int64_t>& lowest = lowest_[std::size_t(p)];
      lowest.assign(std::size_t(piece.vertex_count), -1);
      for (std::int64_t c = piece.cell_count; c-- > 0;)
        if (piece.owns(c))
          piece.for_each_item_vertex(
              c, [&](std::int64_t v) { lowest[std::size_t(v)] = view_.first_cell[p] + c; });
      for (std::int64_t v = 0; v < piece.vertex_count; ++v)
        if (lowest[std::size_t(v)] < 0)
          forget(p, v);
        else if (world_.size() > 1)
          extend(piece.point(v));
    }
  }

  void forget(std::int32_t piece, std::int64_t vertex) {
    std::vector<bool>& counted = counted_[std::size_t(piece)];
    if (counted.empty())
      counted.assign(std::size_t(view_.pieces[piece].vertex_count), true);
    counted[std::size_t(vertex)] = false;
  }

  void extend(const math::Vec3d& x) {
    if (!any_)
      box_ = {x, x};
    box_.extend({x, x});
    any_ = true;
  }

  /// The vertices that may have copies: in the boxes of other pieces, or of other processes.
  void find_copies(std::span<const double> boxes) {
    if (!by_ids_ && !view_.join_pieces && view_.piece_count > 0)
      return;
    if (view_.piece_count > 1)
      vertices_ = mesh::find_among_others(view_, mesh::Boxes::touch, false, threads_).vertices;
    std::vector<mesh::Box> others;
    for (int r = 0; r < world_.size(); ++r) {
      const double* const of = boxes.data() + r * 6;
      const mesh::Box box{{-of[0], -of[1], -of[2]}, {of[3], of[4], of[5]}};
      if (r != world_.rank() && box.low.x <= box.high.x)
        others.push_back(box);
    }
    for (std::int32_t p = 0; p < view_.piece_count && !others.empty(); ++p)
      for (std::int64_t v = 0; v < std::int64_t(lowest_[std::size_t(p)].size()); ++v) {
        const math::Vec3d x = view_.pieces[p].point(v);
        if (std::any_of(others.begin(), others.end(), [&](const auto& o) { return o.holds(x); }))
          vertices_.push_back(view_.first_vertex[p] + v);
      }
    std::sort(vertices_.begin(), vertices_.end());
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
    std::erase_if(vertices_, [&](std::int64_t flat) {
      const std::int32_t p = mesh::piece_of_vertex(view_, flat);
      const std::vector<std::int64_t>& lowest = lowest_[std::size_t(p)];
      return lowest.empty() || lowest[std::size_t(flat - view_.first_vertex[p])] < 0;
    });
  }

  Copy copy_of(std::int64_t flat) const {
    const std::int32_t p = mesh::piece_of_vertex(view_, flat);
    const std::int64_t v = flat - view_.first_vertex[p];
    const std::int64_t cell = lowest_[std::size_t(p)][std::size_t(v)];
    Copy copy{};
    if (by_ids_) {
      copy.key[0] = mesh_.global_id(INSITU_VERTEX, flat);
    } else {
      const math::Vec3d x = view_.pieces[p].point(v);
      for (int axis = 0; axis < 3; ++axis)
        copy.key[axis] = std::bit_cast<std::int64_t>(x[axis] + 0.0); // -0 is 0
    }
    copy.owner = cells_by_ids_ ? mesh_.global_id(INSITU_CELL, cell) : cell;
    copy.piece = p;
    copy.process = world_.rank();
    return copy;
  }

  /// Copies of one vertex come to one process.
  std::vector<parallel::Parcel> to_those_who_compare() {
    std::vector<std::vector<Copy>> copies(std::size_t(world_.size()));
    sent_.resize(copies.size());
    for (const std::int64_t flat : vertices_) {
      const Copy copy = copy_of(flat);
      const std::size_t to = hash_of(copy) % copies.size();
      copies[to].push_back(copy);
      sent_[to].push_back(flat);
    }
    return parallel::parcels_of(copies);
  }

  /// The answers to those who sent copies, a byte for each.
  std::vector<parallel::Parcel> compare(const std::vector<parallel::Parcel>& in) const {
    std::vector<Copy> copies;
    for (const parallel::Parcel& p : in)
      for (const auto& copy : parallel::items_of<Copy>(p.bytes))
        copies.push_back(copy);
    const std::vector<std::uint8_t> counts = choose(copies, by_ids_, cells_by_ids_);
    std::vector<parallel::Parcel> answers;
    auto at = counts.begin();
    for (const parallel::Parcel& p : in) {
      const auto end = at + std::ptrdiff_t(p.bytes.size() / sizeof(Copy));
      answers.push_back({p.rank, parallel::bytes_of(std::vector<std::uint8_t>(at, end))});
      at = end;
    }
    return answers;
  }

  void take(const std::vector<parallel::Parcel>& told) {
    for (const parallel::Parcel& p : told)
      for (std::size_t i = 0; i < p.bytes.size(); ++i)
        if (p.bytes[i] == std::byte(0)) {
          const std::int64_t flat = sent_[std::size_t(p.rank)][i];
          const std::int32_t piece = mesh::piece_of_vertex(view_, flat);
          forget(piece, flat - view_.first_vertex[piece]);
        }
  }

  const mesh::Mesh& mesh_;
  const mesh::MeshView& view_;
  parallel::World& world_;
  const core::Threads& threads_;
  bool by_ids_ = false, cells_by_ids_ = false;
  std::vector<std::vector<bool>> counted_;
  std::vector<std::vector<std::int64_t>> lowest_; ///< [piece][vertex] flat cells, -1: none
  mesh::Box box_{};                               ///< of the used vertices, if any
  bool any_ = false;
  std::vector<std::int64_t> vertices_;          ///< flat, ascending: those with copies, maybe
  std::vector<std::vector<std::int64_t>> sent_; ///< [process] of them
};

void CountedVertices::update(const commit::CommittedMesh& mesh, parallel::World& world,
                             const core::Threads& threads) {
  const bool has_cells = mesh.mesh().own_view().own_cell_count() > 0;
  const auto lacks = [&](insitu_association of) {
    return has_cells && !mesh.mesh().has_global_ids(of);
  };
  const bool moved = geometry_ != mesh.geometry_version();
  std::int64_t here[] = {!found_ || mesh_ != mesh.id() || topology_ != mesh.topology_version(),
                         moved, lacks(INSITU_VERTEX), lacks(INSITU_CELL)};
  world.reduce(here, parallel::Reduction::greatest);
  if (!here[0] && !(here[1] && here[2]))
    return;
  found_ = false;
  counted_ = Finder(mesh.mesh(), world, threads).find(!here[2], !here[3]);
  mesh_ = mesh.id();
  topology_ = mesh.topology_version();
  geometry_ = mesh.geometry_version();
  found_ = true;
}

} // namespace insitu::scene
