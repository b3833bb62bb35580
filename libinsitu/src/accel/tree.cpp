#include "accel/tree.h"

#include <algorithm>
#include <atomic>

#include "accel/cell_boxes.h"
#include "accel/embree/builder.h"
#include "core/status.h"

namespace insitu::accel {

namespace {

constexpr std::int64_t grain = 4096;

[[noreturn]] void refuse_cell(const mesh::MeshView& mesh, std::int64_t flat) {
  const std::int32_t piece = mesh.piece_of(flat);
  throw core::Error(INSITU_ERROR_MESH,
                    "piece " + std::to_string(piece) + ", cell " +
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

void Tree::release_scratch() { scratch_.reset(); }

math::Vec3d Tree::bounds_min() const {
  return {origin_.x + bounds_.lower[0], origin_.y + bounds_.lower[1], origin_.z + bounds_.lower[2]};
}

math::Vec3d Tree::bounds_max() const {
  return {origin_.x + bounds_.upper[0], origin_.y + bounds_.upper[1], origin_.z + bounds_.upper[2]};
}

void Tree::build(const mesh::MeshView& mesh, const core::Threads& threads, Builder builder) {
  if (mesh.cell_count() > std::int64_t(std::numeric_limits<std::uint32_t>::max()))
    throw core::Error(INSITU_ERROR_UNSUPPORTED, "a mesh holds at most 4294967295 cells a session, " +
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
  measure_cost(threads);
  built_cost_ = cost_;
}

/// One primitive an owning cell, in the frame of the mesh's first vertex's neighbourhood: the centre
/// of the vertices' box, so that floats resolve the mesh and not its distance from zero.
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
    if (!std::isfinite(origin_[a]))
      origin_[a] = 0.0;

  const CellBoxes boxes(mesh, origin_);
  std::atomic<std::int64_t> bad{none};
  threads.parallel_for(cells, grain, [&](std::int64_t begin, std::int64_t end) {
    RTCBuildPrimitive* out = primitives.data() + start[std::size_t(begin / grain)];
    for (std::int64_t flat = begin; flat < end; ++flat) {
      if (!owns(flat))
        continue;
      const Box b = boxes(flat);
      if (!CellBoxes::is_finite(b))
        lower_to(bad, flat);
      *out++ = {b.lower[0], b.lower[1], b.lower[2], 0,
                b.upper[0], b.upper[1], b.upper[2], std::uint32_t(flat)};
    }
  });
  if (bad != none)
    refuse_cell(mesh, bad);
}

void Tree::flatten(const void* root_pointer, const core::Threads& threads) {
  using embree::BuildInner;
  using embree::BuildLeaf;
  using embree::BuildNode;
  const auto* root = static_cast<const BuildNode*>(root_pointer);

  // A root that is a leaf gets a node above it, so that every tree starts with a node.
  BuildInner above;
  if (root->leaf) {
    above.count = 1;
    above.leaf = false;
    above.child[0] = const_cast<BuildNode*>(root);
    Box all;
    for (const RTCBuildPrimitive& p : scratch_->primitives.span())
      all.extend({{p.lower_x, p.lower_y, p.lower_z}, {p.upper_x, p.upper_y, p.upper_z}});
    above.box[0] = all;
    root = &above;
  }
  const auto* top = static_cast<const BuildInner*>(root);
  for (std::uint32_t c = 0; c < top->count; ++c)
    bounds_.extend(top->box[c]);

  cells_.resize_discard(scratch_->primitives.size());
  std::vector<const BuildInner*> level{top}, next;
  std::vector<std::uint32_t> first_child, first_cell;
  std::uint32_t node_total = 0, cell_total = 0;
  while (!level.empty()) {
    const std::size_t n = level.size();
    levels_.push_back(node_total);
    first_child.resize(n + 1);
    first_cell.resize(n + 1);
    threads.parallel_for(std::int64_t(n), 1024, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        std::uint32_t inner = 0, cells = 0;
        for (std::uint32_t c = 0; c < level[std::size_t(i)]->count; ++c) {
          const BuildNode* child = level[std::size_t(i)]->child[c];
          inner += !child->leaf;
          cells += child->leaf ? child->count : 0;
        }
        first_child[std::size_t(i) + 1] = inner;
        first_cell[std::size_t(i) + 1] = cells;
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
    threads.parallel_for(std::int64_t(n), 1024, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        const auto at = std::size_t(i);
        const BuildInner& from = *level[at];
        Node& node = nodes_[node_total + at];
        node.inner = 0;
        node.first_child = below + first_child[at];
        node.first_cell = first_cell[at];
        std::uint32_t inner = first_child[at], cell = 0;
        for (std::uint32_t c = 0; c < 8; ++c) {
          node.meta[c] = 0;
          if (c >= from.count)
            continue;
          const BuildNode* child = from.child[c];
          if (child->leaf) {
            node.meta[c] = std::uint8_t((cell << 3) | child->count);
            std::copy_n(static_cast<const BuildLeaf*>(child)->cells, child->count,
                        &cells_[first_cell[at] + cell]);
            cell += child->count;
          } else {
            node.inner |= std::uint8_t(1u << c);
            node.meta[c] = 1;
            next[inner++] = static_cast<const BuildInner*>(child);
          }
        }
        encode_boxes(node, from.box);
      }
    });
    cell_total = first_cell[n];
    node_total = below;
    level.swap(next);
  }
  levels_.push_back(node_total);
}

void Tree::refit(const mesh::MeshView& mesh, const core::Threads& threads) {
  if (nodes_.empty())
    return;
  const CellBoxes boxes(mesh, origin_);
  boxes_.resize_discard(nodes_.size());
  std::atomic<std::int64_t> bad{none};
  for (std::size_t l = levels_.size() - 1; l-- > 0;) {
    const std::uint32_t first = levels_[l];
    threads.parallel_for(levels_[l + 1] - first, 512, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        Node& node = nodes_[first + std::size_t(i)];
        Box children[8], all;
        for (int c = 0; c < 8; ++c) {
          if (!node.meta[c])
            continue;
          if (node.is_inner(c))
            children[c] = boxes_[node.child_node(c)];
          else
            for (int k = 0; k < node.child_cell_count(c); ++k) {
              const std::uint32_t cell = cells_[node.child_cells(c) + std::uint32_t(k)];
              const Box b = boxes(cell);
              if (!CellBoxes::is_finite(b))
                lower_to(bad, cell);
              children[c].extend(b);
            }
          all.extend(children[c]);
        }
        encode_boxes(node, children);
        boxes_[first + std::size_t(i)] = all;
      }
    });
    if (bad != none)
      refuse_cell(mesh, bad);
  }
  bounds_ = boxes_[0];
  measure_cost(threads);
}

/// Surface-area sum of all child boxes over the root's: the expected number of boxes that a random
/// ray hits (MacDonald and Booth 1990). Chunks are summed in order, so the value is the same for any
/// thread count.
void Tree::measure_cost(const core::Threads& threads) {
  constexpr std::int64_t chunk = 8192;
  std::vector<double> sums((nodes_.size() + chunk - 1) / chunk, 0.0);
  threads.parallel_for(std::int64_t(nodes_.size()), chunk,
                       [&](std::int64_t begin, std::int64_t end) {
                         double sum = 0.0;
                         for (std::int64_t i = begin; i < end; ++i) {
                           const Node& node = nodes_[std::size_t(i)];
                           for (int c = 0; c < 8; ++c)
                             if (node.meta[c])
                               sum += node.child_box(c).half_area();
                         }
                         sums[std::size_t(begin / chunk)] = sum;
                       });
  double total = 0.0;
  for (const double s : sums)
    total += s;
  const double root = bounds_.half_area();
  cost_ = root > 0.0 ? total / root : 0.0;
}

} // namespace insitu::accel
