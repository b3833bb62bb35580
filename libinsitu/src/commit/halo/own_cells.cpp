#include "commit/halo/own_cells.h"

#include <algorithm>
#include <limits>

#include "accel/tree/owners.h"
#include "mesh/registered/earlier_parts.h"
#include "query/directory.h"

namespace insitu::commit {

namespace {

constexpr std::int64_t cells_a_task = 16384;
constexpr std::size_t sample = 4096; ///< of cells, of which groups get alike many

bool boxes_meet(const accel::Box& a, const accel::Box& b) {
  bool yes = true;
  for (int axis = 0; axis < 3; ++axis)
    yes &= a.lower[axis] <= b.upper[axis] && b.lower[axis] <= a.upper[axis];
  return yes;
}

std::array<float, 3> size_of(const accel::Box& box) {
  std::array<float, 3> size;
  for (std::size_t a = 0; a < 3; ++a)
    size[a] = box.upper[a] - box.lower[a];
  return size;
}

std::array<float, 3> middle_of(const accel::Box& box) {
  std::array<float, 3> middle;
  for (std::size_t a = 0; a < 3; ++a)
    middle[a] = 0.5f * box.lower[a] + 0.5f * box.upper[a];
  return middle;
}

} // namespace

OwnCells::OwnCells(const mesh::MeshView& view, core::Memory& memory, const core::Threads& threads)
    : memory_(&memory), view_(mesh::own_part(view)), boxes_(memory, INSITU_MEMORY_HALO),
      cells_(memory, INSITU_MEMORY_HALO), group_(memory, INSITU_MEMORY_HALO) {
  static_assert(groups == query::Directory::most_boxes);
  const accel::Owners owners(view_, threads);
  origin_ = owners.origin();
  const auto n = std::size_t(owners.count());
  boxes_.resize_discard(n);
  cells_.resize_discard(n);
  group_.resize_discard(n);
  owners.for_boxes(threads, nullptr,
                   [&](std::int64_t, std::int64_t rank, const std::uint32_t* ids,
                       const accel::Box* some, std::uint32_t count) {
                     std::copy_n(some, count, &boxes_[std::size_t(rank)]);
                     std::copy_n(ids, count, &cells_[std::size_t(rank)]);
                   });
  set_planes();
  const std::size_t chunks = (n + cells_a_task - 1) / cells_a_task;
  struct Group {
    accel::Box around;
    std::array<float, 3> largest{};
    void add(const Group& other) {
      around.extend(other.around);
      for (std::size_t a = 0; a < 3; ++a)
        largest[a] = std::max(largest[a], other.largest[a]);
    }
  };
  std::vector<std::array<Group, groups>> found(chunks);
  threads.parallel_for(std::int64_t(n), cells_a_task, [&](std::int64_t begin, std::int64_t end) {
    std::array<Group, groups>& of = found[std::size_t(begin / cells_a_task)];
    for (auto i = std::size_t(begin); i < std::size_t(end); ++i) {
      group_[i] = std::uint8_t(group_of(boxes_[i]));
      of[group_[i]].add({boxes_[i], size_of(boxes_[i])});
    }
  });
  for (std::size_t g = 0; g < groups; ++g) {
    Group whole;
    for (const auto& of : found)
      whole.add(of[g]);
    around_[g] = whole.around;
    largest_[g] = whole.largest;
  }
}

/// By the middles of some cells.
void OwnCells::set_planes() {
  std::vector<std::array<float, 3>> middles;
  for (std::size_t i = 0; i < boxes_.size(); i += std::max<std::size_t>(1, boxes_.size() / sample))
    middles.push_back(middle_of(boxes_[i]));
  halve(1, middles);
}

void OwnCells::halve(std::size_t plane, std::span<std::array<float, 3>> middles) {
  if (plane >= groups || middles.empty())
    return;
  accel::Box around;
  for (const std::array<float, 3>& x : middles)
    around.extend({{x[0], x[1], x[2]}, {x[0], x[1], x[2]}});
  std::size_t widest = 0;
  for (std::size_t a = 1; a < 3; ++a)
    if (around.upper[a] - around.lower[a] > around.upper[widest] - around.lower[widest])
      widest = a;
  const std::size_t half = middles.size() / 2;
  std::nth_element(middles.begin(), middles.begin() + std::ptrdiff_t(half), middles.end(),
                   [&](const auto& x, const auto& y) { return x[widest] < y[widest]; });
  planes_[plane] = {int(widest), middles[half][widest]};
  halve(2 * plane, middles.first(half));
  halve(2 * plane + 1, middles.subspan(half));
}

int OwnCells::group_of(const accel::Box& box) const {
  const std::array<float, 3> middle = middle_of(box);
  int at = 1;
  for (int level = 0; level < levels; ++level) {
    const Plane& plane = planes_[std::size_t(at)];
    at = 2 * at + int(middle[std::size_t(plane.axis)] >= plane.at);
  }
  return at - groups;
}

std::vector<mesh::Box> OwnCells::boxes(const SeamReach& reach) const {
  std::vector<mesh::Box> boxes;
  for (std::size_t g = 0; g < groups; ++g)
    if (around_[g].lower[0] <= around_[g].upper[0])
      boxes.push_back(reach.widened(query::in_mesh(around_[g], origin_),
                                    {largest_[g][0], largest_[g][1], largest_[g][2]}));
  return boxes;
}

accel::Tree OwnCells::tree_of_those_in(std::span<const mesh::Box> boxes,
                                       const core::Threads& threads) const {
  std::array<std::vector<accel::Box>, groups> wanted; // of each group
  for (const mesh::Box& box : boxes) {
    const accel::Box local = query::in_tree(box, origin_);
    for (std::size_t g = 0; g < groups; ++g)
      if (boxes_meet(around_[g], local))
        wanted[g].push_back(local);
  }
  core::Buffer<std::uint8_t> left_out(*memory_, INSITU_MEMORY_HALO); // by flat id
  left_out.resize_discard(std::size_t(view_.cell_count()));
  std::ranges::fill(left_out.span(), std::uint8_t(1));
  threads.parallel_for(
      std::int64_t(cells_.size()), cells_a_task, [&](std::int64_t begin, std::int64_t end) {
        for (auto i = std::size_t(begin); i < std::size_t(end); ++i)
          left_out[cells_[i]] = std::ranges::none_of(
              wanted[group_[i]], [&](const accel::Box& box) { return boxes_meet(boxes_[i], box); });
      });
  std::vector<mesh::PieceView> pieces(view_.pieces, view_.pieces + view_.piece_count);
  mesh::MeshView some = view_;
  some.pieces = pieces.data();
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    pieces[p].ghosts = reinterpret_cast<const std::byte*>(left_out.data() + view_.first_cell[p]);
    pieces[p].ghost_layout = {pieces[p].cell_count, {}, {1, 0, 0}, true};
    pieces[p].ghost_mask = 1;
  }
  accel::Tree tree(*memory_);
  tree.build(some, threads, accel::Builder::morton);
  tree.release_scratch();
  return tree;
}

} // namespace insitu::commit
