#include "accel/tree/tree.h"

#include <algorithm>
#include <numeric>

#include "accel/embree/builder.h"
#include "accel/morton/topology.h"
#include "accel/tree/cell_boxes.h"
#include "accel/tree/fit.h"
#include "accel/tree/owners.h"
#include "accel/tree/subtrees.h"
#include "core/status.h"

namespace insitu::accel {

namespace {

constexpr std::int64_t node_grain = 512; ///< nodes a task

} // namespace

struct Tree::Embree {
  explicit Embree(core::Memory& memory)
      : device(memory), bvh(rtcNewBVH(device.handle())), primitives(memory, INSITU_MEMORY_BUILD) {}
  ~Embree() { rtcReleaseBVH(bvh); }
  embree::Device device;
  RTCBVH bvh;
  core::Buffer<RTCBuildPrimitive> primitives;
};

struct Tree::Morton {
  explicit Morton(core::Memory& memory)
      : boxes(memory, INSITU_MEMORY_BUILD), order(memory, INSITU_MEMORY_BUILD),
        scratch(memory, INSITU_MEMORY_BUILD), flat_ids(memory, INSITU_MEMORY_BUILD) {}
  core::Buffer<Box> boxes; ///< by flat id, or by rank
  core::Buffer<morton::Coded> order, scratch;
  core::Buffer<std::uint32_t> flat_ids; ///< by rank, where boxes are
};

Tree::Tree(core::Memory& memory)
    : memory_(&memory), nodes_(memory, INSITU_MEMORY_TREE), cells_(memory, INSITU_MEMORY_TREE),
      boxes_(memory, INSITU_MEMORY_BUILD) {}

Tree::~Tree() = default;
Tree::Tree(Tree&&) noexcept = default;

namespace {

/// Writes nothing where none is marked: others may read that while a fit that was put off runs.
void forget(OddSlots& odd) {
  if (!odd.empty())
    odd = {};
}

} // namespace

Tree Tree::take() {
  Tree taken(std::move(*this));
  embree_ = std::move(taken.embree_);
  morton_ = std::move(taken.morton_);
  odd_ = {};
  bounds_ = Box{};
  cost_ = built_cost_ = 0.0;
  return taken;
}

void Tree::copy(const Tree& from) {
  nodes_.resize_discard(from.nodes_.size());
  std::copy(from.nodes_.begin(), from.nodes_.end(), nodes_.begin());
  cells_.resize_discard(from.cells_.size());
  std::copy(from.cells_.begin(), from.cells_.end(), cells_.begin());
  levels_ = from.levels_;
  odd_ = {};
  origin_ = from.origin_;
  bounds_ = from.bounds_;
  builder_ = from.builder_;
  cost_ = from.cost_;
  built_cost_ = from.built_cost_;
}

void Tree::release_scratch() {
  embree_.reset();
  morton_.reset();
}

math::Vec3d Tree::bounds_min() const {
  return {origin_.x + bounds_.lower[0], origin_.y + bounds_.lower[1], origin_.z + bounds_.lower[2]};
}

math::Vec3d Tree::bounds_max() const {
  return {origin_.x + bounds_.upper[0], origin_.y + bounds_.upper[1], origin_.z + bounds_.upper[2]};
}

void Tree::build(const mesh::MeshView& mesh, const core::Threads& threads, Builder builder) {
  if (mesh.cell_count() > std::int64_t(std::numeric_limits<std::uint32_t>::max()))
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      "a mesh holds at most 4294967295 cells a session, " +
                          std::to_string(mesh.cell_count()) + " given");
  nodes_.resize_discard(0);
  cells_.resize_discard(0);
  forget(odd_);
  levels_.clear();
  bounds_ = Box{};
  const Owners owners(mesh, threads);
  origin_ = owners.origin();
  if (owners.count() == 0)
    return;
  builder_ = builder == Builder::surface_area ? builder : Builder::morton;
  if (builder_ == Builder::surface_area)
    build_by_surface_area(owners, threads);
  else
    build_in_morton_order(mesh, owners, threads);
  built_cost_ = cost_;
}

void Tree::build_by_surface_area(const Owners& owners, const core::Threads& threads) {
  morton_.reset();
  if (!embree_)
    embree_ = std::make_unique<Embree>(*memory_);
  core::Buffer<RTCBuildPrimitive>& primitives = embree_->primitives;
  primitives.resize_discard(std::size_t(owners.count()));
  owners.for_boxes(threads, nullptr,
                   [&](std::int64_t, std::int64_t rank, const std::uint32_t* ids, const Box* boxes,
                       std::uint32_t n) {
                     for (std::uint32_t i = 0; i < n; ++i) {
                       const Box& b = boxes[i];
                       primitives[std::size_t(rank) + i] = {b.lower[0], b.lower[1], b.lower[2],
                                                            0,          b.upper[0], b.upper[1],
                                                            b.upper[2], ids[i]};
                     }
                   });
  threads.run([&] {
    flatten(embree::build(embree_->device, embree_->bvh, primitives.data(), primitives.size()),
            threads);
  });
}

void Tree::build_in_morton_order(const mesh::MeshView& mesh, const Owners& owners,
                                 const core::Threads& threads) {
  embree_.reset();
  if (!morton_)
    morton_ = std::make_unique<Morton>(*memory_);
  const std::int64_t n = owners.count();
  core::Buffer<Box>& boxes = morton_->boxes;
  // Boxes lie by flat id; where half of these and more stand for nothing, by rank, which takes less
  // memory, and ids are set last.
  const bool by_rank = n < mesh.cell_count() / 2;
  core::Buffer<std::uint32_t>& flat_ids = morton_->flat_ids;
  flat_ids.resize_discard(by_rank ? std::size_t(n) : 0);
  boxes.resize_discard(std::size_t(by_rank ? n : mesh.cell_count()));
  morton_->order.resize_discard(std::size_t(n));
  morton_->scratch.resize_discard(std::size_t(n));

  std::vector<morton::Centres> centres(std::size_t(owners.chunks()));
  owners.for_boxes(threads, by_rank ? nullptr : boxes.data(),
                   [&](std::int64_t chunk, std::int64_t rank, const std::uint32_t* ids,
                       const Box* some, std::uint32_t count) {
                     centres[std::size_t(chunk)].add(morton::Centres(some, count));
                     const auto first = std::size_t(rank);
                     for (std::uint32_t i = 0; i < count; ++i)
                       morton_->order[first + i].id = by_rank ? std::uint32_t(first) + i : ids[i];
                     if (by_rank) {
                       std::copy_n(some, count, &boxes[first]);
                       std::copy_n(ids, count, &flat_ids[first]);
                     }
                   });
  morton::Centres all;
  for (const morton::Centres& c : centres) // in order of chunks: sums do not depend on threads
    all.add(c);
  morton::Coded* order = morton_->order.data();
  morton::order(order, morton_->scratch.data(), n, boxes.data(), all, threads);
  morton::make_nodes(order, morton_->scratch.data(), std::uint32_t(n), boxes.data(), threads,
                     nodes_, cells_, levels_);
  fit_bottom_up(threads, [&](std::uint32_t begin, std::uint32_t end, std::uint32_t slot) {
    return fit_nodes(nodes_.data(), begin, end, boxes.data(), &cells_[slot], boxes_.data());
  });
  if (by_rank)
    for (std::uint32_t& cell : cells_)
      cell = flat_ids[cell];
}

void Tree::flatten(const void* root_pointer, const core::Threads& threads) {
  using embree::BuildNode;
  const auto* root = static_cast<const BuildNode*>(root_pointer);
  for (std::uint32_t c = 0; c < root->count; ++c)
    bounds_.extend(root->box[c]);

  cells_.resize_discard(embree_->primitives.size());
  std::vector<const BuildNode*> level{root}, next;
  std::vector<std::uint32_t> first_child, first_cell;
  std::vector<double> areas;
  std::uint32_t node_total = 0, cell_total = 0;
  while (!level.empty()) {
    const std::size_t n = level.size();
    levels_.push_back(node_total);
    first_child.resize(n + 1);
    first_cell.resize(n + 1);
    threads.parallel_for(std::int64_t(n), node_grain, [&](std::int64_t begin, std::int64_t end) {
      for (auto i = std::size_t(begin); i < std::size_t(end); ++i) {
        const BuildNode& from = *level[i];
        const std::uint32_t cells =
            from.bottom ? from.count : std::uint32_t(std::popcount(from.single));
        first_child[i + 1] = from.count - cells;
        first_cell[i + 1] = cells;
      }
    });
    first_child[0] = 0;
    first_cell[0] = cell_total;
    std::partial_sum(first_child.begin(), first_child.end(), first_child.begin());
    std::partial_sum(first_cell.begin(), first_cell.end(), first_cell.begin());
    const std::uint32_t below = node_total + std::uint32_t(n);
    next.resize(first_child[n]);
    nodes_.resize(below);
    const std::size_t first_area = areas.size();
    areas.resize(first_area + (n + node_grain - 1) / node_grain);
    threads.parallel_for(std::int64_t(n), node_grain, [&](std::int64_t begin, std::int64_t end) {
      double area = 0.0;
      for (auto i = std::size_t(begin); i < std::size_t(end); ++i) {
        const BuildNode& from = *level[i];
        Node& node = nodes_[node_total + i];
        node.inner = 0;
        node.first_child = below + first_child[i];
        node.first_cell = first_cell[i];
        std::uint32_t inner = first_child[i], cell = 0;
        for (std::uint32_t c = 0; c < 8; ++c) {
          node.meta[c] = 0;
          if (c >= from.count)
            continue;
          if (from.bottom || ((from.single >> c) & 1)) {
            node.meta[c] = std::uint8_t((cell << 3) | 1);
            cells_[first_cell[i] + cell++] = from.bottom ? from.cell[c] : from.child[c]->cell[0];
          } else {
            node.inner |= std::uint8_t(1u << c);
            node.meta[c] = 1;
            next[inner++] = from.child[c];
          }
        }
        area += double(encode_node(node, from.box));
      }
      areas[first_area + std::size_t(begin / node_grain)] = area;
    });
    cell_total = first_cell[n];
    node_total = below;
    level.swap(next);
  }
  levels_.push_back(node_total);
  set_cost(areas);
}

void Tree::refit(const mesh::MeshView& mesh, const core::Threads& threads) {
  forget(odd_);
  if (nodes_.empty())
    return;
  const CellBoxes boxes(mesh, origin_);
  RefusedCells refused;
  fit_bottom_up(threads, [&](std::uint32_t begin, std::uint32_t end, std::uint32_t slot) {
    // A few nodes at a time: the boxes of their cells, which are adjacent, then theirs.
    constexpr std::uint32_t few = 64;
    Box cells[few * 8 * most_leaf_cells];
    double area = 0.0;
    const auto first_slot = [&](std::uint32_t node) {
      return node < nodes_.size() ? nodes_[node].first_cell : std::uint32_t(cells_.size());
    };
    const std::uint32_t last_slot = first_slot(end);
    for (std::uint32_t next = begin; begin < end; begin = next) {
      next = std::min(begin + few, end);
      const std::uint32_t slot_end = first_slot(next);
      for (const auto* line = reinterpret_cast<const std::byte*>(&nodes_[begin]);
           line < reinterpret_cast<const std::byte*>(&nodes_[next - 1] + 1); line += 64)
        __builtin_prefetch(line, 1); // fitted once their cells' boxes are there
      refused.note(boxes.compute(&cells_[slot], slot_end - slot, last_slot - slot_end, cells));
      slot = slot_end;
      area += fit_nodes(nodes_.data(), begin, next, cells, nullptr, boxes_.data());
    }
    return area;
  });
  refused.check(mesh);
}

template <class Fit>
void Tree::fit_bottom_up(const core::Threads& threads, Fit&& fit) {
  boxes_.resize_discard(nodes_.size());
  const Subtrees subtrees(nodes_.data(), levels_);
  std::vector<double> areas(subtrees.parts(), 0.0);
  subtrees.bottom_up(threads, [&](std::size_t part, std::uint32_t begin, std::uint32_t end) {
    areas[part] += fit(begin, end, nodes_[begin].first_cell);
  });
  bounds_ = boxes_[0];
  set_cost(areas);
}

/// Surface-area sum of all child boxes over the root's: the expected number of boxes that a random
/// ray hits (MacDonald and Booth 1990). Chunks are summed in order, so the value is the same for
/// any thread count.
void Tree::set_cost(const std::vector<double>& areas) {
  double total = 0.0;
  for (const double area : areas)
    total += area;
  const double root = bounds_.half_area();
  const double cost = total / root;
  cost_ = std::isfinite(cost) ? cost : 0.0; // areas that no float holds: unknown
}

} // namespace insitu::accel
