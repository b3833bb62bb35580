#include "accel/tree.h"

#include <algorithm>
#include <atomic>

#include "accel/cell_boxes.h"
#include "accel/embree/builder.h"
#include "accel/fit.h"
#include "core/status.h"

namespace insitu::accel {

namespace {

constexpr std::int64_t grain = 4096;     ///< cells a task
constexpr std::int64_t node_grain = 512; ///< nodes a task

[[noreturn]] void refuse_cell(const mesh::MeshView& mesh, std::int64_t flat) {
  const std::int32_t piece = mesh.piece_of(flat);
  throw core::Error(INSITU_ERROR_MESH, "piece " + std::to_string(piece) + ", cell " +
                                           std::to_string(flat - mesh.first_cell[piece]) +
                                           ": a vertex coordinate is not finite or beyond 1e37");
}

/// Keeps the lowest of the offending cells, so that the message does not depend on threads.
void lower_to(std::atomic<std::int64_t>& first, std::int64_t cell) {
  std::int64_t now = first.load();
  while (cell < now && !first.compare_exchange_weak(now, cell)) {
  }
}

constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();

} // namespace

struct Tree::Scratch {
  explicit Scratch(core::Memory& memory)
      : device(memory), bvh(rtcNewBVH(device.handle())), primitives(memory, INSITU_MEMORY_BUILD) {}
  ~Scratch() { rtcReleaseBVH(bvh); }
  embree::Device device;
  RTCBVH bvh;
  core::Buffer<RTCBuildPrimitive> primitives;
};

Tree::Tree(core::Memory& memory)
    : memory_(&memory), nodes_(memory, INSITU_MEMORY_TREE), cells_(memory, INSITU_MEMORY_TREE),
      boxes_(memory, INSITU_MEMORY_BUILD) {}

Tree::~Tree() = default;

void Tree::release_scratch() {
  scratch_.reset();
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
  levels_.clear();
  bounds_ = Box{};
  if (!scratch_)
    scratch_ = std::make_unique<Scratch>(*memory_);
  gather_primitives(mesh, threads);
  const std::size_t count = scratch_->primitives.size();
  if (count == 0)
    return;
  threads.run([&] {
    const embree::BuildNode* root =
        embree::build(scratch_->device, scratch_->bvh, scratch_->primitives.data(), count,
                      builder != Builder::surface_area);
    flatten(root, threads);
  });
  built_cost_ = cost_;
}

/// One primitive an owning cell, in the frame of the mesh's first vertex's neighbourhood: the
/// centre of the vertices' box, so that floats resolve the mesh and not its distance from zero.
void Tree::gather_primitives(const mesh::MeshView& mesh, const core::Threads& threads) {
  const std::int64_t cells = mesh.cell_count();
  core::Buffer<RTCBuildPrimitive>& primitives = scratch_->primitives;
  const std::int64_t chunks = (cells + grain - 1) / grain;
  std::vector<std::int64_t> start(std::size_t(chunks) + 1, 0);
  std::vector<math::Vec3d> low(start.size()), high(start.size());
  const auto owns = [&](std::int64_t flat) {
    const std::int32_t p = mesh.piece_count == 1 ? 0 : mesh.piece_of(flat);
    return mesh.pieces[p].owns(flat - mesh.first_cell[p]);
  };

  // The local frame's origin: the middle of one vertex of each owning cell is middle enough.
  threads.parallel_for(cells, grain, [&](std::int64_t begin, std::int64_t end) {
    const auto chunk = std::size_t(begin / grain);
    std::int64_t n = 0;
    math::Vec3d lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};
    for (std::int64_t flat = begin; flat < end; ++flat) {
      if (!owns(flat))
        continue;
      ++n;
      const std::int32_t p = mesh.piece_count == 1 ? 0 : mesh.piece_of(flat);
      std::int64_t ids[8];
      mesh.pieces[p].vertex_ids(flat - mesh.first_cell[p], ids);
      const math::Vec3d x = mesh.pieces[p].point(ids[0]);
      for (int a = 0; a < 3; ++a) {
        if (!(std::fabs(x[a]) <= 1e37)) // refused below; it must not move the frame off the others
          continue;
        lo[a] = std::min(lo[a], x[a]);
        hi[a] = std::max(hi[a], x[a]);
      }
    }
    start[chunk + 1] = n;
    low[chunk] = lo;
    high[chunk] = hi;
  });
  math::Vec3d lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};
  for (std::size_t c = 0; c < std::size_t(chunks); ++c) {
    start[c + 1] += start[c];
    for (int a = 0; a < 3; ++a) {
      lo[a] = std::min(lo[a], low[c][a]);
      hi[a] = std::max(hi[a], high[c][a]);
    }
  }
  const std::int64_t owners = chunks ? start[std::size_t(chunks)] : 0;
  primitives.resize_discard(std::size_t(owners));
  if (owners == 0)
    return;
  origin_ = {0.5 * lo.x + 0.5 * hi.x, 0.5 * lo.y + 0.5 * hi.y, 0.5 * lo.z + 0.5 * hi.z};
  for (int a = 0; a < 3; ++a)
    if (lo[a] > hi[a])
      origin_[a] = 0.0;

  const CellBoxes boxes(mesh, origin_);
  std::atomic<std::int64_t> bad{none};
  threads.parallel_for(cells, grain, [&](std::int64_t begin, std::int64_t end) {
    constexpr std::uint32_t few = 128;
    std::uint32_t ids[few];
    Box cell_boxes[few];
    RTCBuildPrimitive* out = primitives.data() + start[std::size_t(begin / grain)];
    for (std::int64_t flat = begin; flat < end;) {
      std::uint32_t n = 0;
      for (; flat < end && n < few; ++flat)
        if (owns(flat))
          ids[n++] = std::uint32_t(flat);
      const std::int64_t refused = boxes.compute(ids, n, cell_boxes);
      if (refused >= 0)
        lower_to(bad, refused);
      for (std::uint32_t i = 0; i < n; ++i) {
        const Box& b = cell_boxes[i];
        *out++ = {b.lower[0], b.lower[1], b.lower[2], 0,
                  b.upper[0], b.upper[1], b.upper[2], ids[i]};
      }
    }
  });
  if (bad != none)
    refuse_cell(mesh, bad);
}

void Tree::flatten(const void* root_pointer, const core::Threads& threads) {
  using embree::BuildNode;
  const auto* root = static_cast<const BuildNode*>(root_pointer);
  for (std::uint32_t c = 0; c < root->count; ++c)
    bounds_.extend(root->box[c]);

  cells_.resize_discard(scratch_->primitives.size());
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
    for (std::size_t i = 0; i < n; ++i) {
      first_child[i + 1] += first_child[i];
      first_cell[i + 1] += first_cell[i];
    }
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
  if (nodes_.empty())
    return;
  const CellBoxes boxes(mesh, origin_);
  boxes_.resize_discard(nodes_.size());
  std::vector<double> areas;
  std::atomic<std::int64_t> bad{none};
  for (std::size_t l = levels_.size() - 1; l-- > 0;) {
    const std::uint32_t first = levels_[l], n = levels_[l + 1] - first;
    const std::size_t first_area = areas.size();
    areas.resize(first_area + (n + node_grain - 1) / node_grain);
    threads.parallel_for(n, node_grain, [&](std::int64_t begin, std::int64_t end) {
      // A few nodes at a time: the boxes of their cells, which are adjacent, then theirs.
      constexpr std::uint32_t few = 32;
      Box cells[few * 8 * most_leaf_cells];
      double area = 0.0;
      const std::uint32_t stop = first + std::uint32_t(end);
      for (std::uint32_t i = first + std::uint32_t(begin); i < stop; i += few) {
        const std::uint32_t j = std::min(i + few, stop);
        const std::uint32_t slot = nodes_[i].first_cell;
        const std::uint32_t slot_end =
            j < nodes_.size() ? nodes_[j].first_cell : std::uint32_t(cells_.size());
        const std::int64_t refused = boxes.compute(&cells_[slot], slot_end - slot, cells);
        if (refused >= 0)
          lower_to(bad, refused);
        area += fit_nodes(nodes_.data(), i, j, cells, slot, boxes_.data());
      }
      areas[first_area + std::size_t(begin / node_grain)] = area;
    });
    if (bad != none)
      refuse_cell(mesh, bad);
  }
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
