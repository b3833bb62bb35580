#include "api/amr_watch.h"

#include <algorithm>
#include <array>

#include "core/status.h"

namespace insitu::api {

namespace {

constexpr std::int64_t chunk_leaves = 4096;

using Triple = std::array<std::int64_t, 3>;

std::string text(const Triple& index) {
  return "(" + std::to_string(index[0]) + ", " + std::to_string(index[1]) + ", " +
         std::to_string(index[2]) + ")";
}

std::string by(const Triple& extent) {
  return std::to_string(extent[0]) + " x " + std::to_string(extent[1]) + " x " +
         std::to_string(extent[2]);
}

Triple extents(const mesh::ExternalArray& array) {
  const mesh::ItemLayout& l = array.layout;
  const std::int64_t layer = l.extent[0] * l.extent[1];
  return {l.extent[0], l.extent[1], layer > 0 ? l.count / layer : 0};
}

Triple cells(const mesh::AmrPieceView& patch) {
  return {patch.size[0], patch.size[1], patch.size[2]};
}

/// Whether a pointer to where the leaf lies is missing.
bool has_null(const mesh::AmrPieceView& v, std::int64_t leaf) {
  const auto null_at = [](const std::byte* p) { return !mesh::load_as<const std::byte*>(p); };
  return (v.levels_indirect && null_at(v.levels + leaf * v.levels_stride)) ||
         (v.corner_indirect && null_at(v.corner[0] + leaf * v.corner_stride));
}

int depth_of(const mesh::AmrView& view, std::int64_t level) {
  return view.depth_of[view.finest_first ? view.level_count - 1 - level : level];
}

} // namespace

/// As the solver stores it.
std::int64_t AmrWatch::corner(const Piece& piece, const Leaf& leaf, int axis) const {
  const mesh::AmrPieceView& v = piece.view;
  const int shift = v.corner_depth < 0 ? 0 : v.corner_depth - depth_of(view_, leaf.level);
  return std::int64_t(leaf.index[axis]) * (std::int64_t(1) << shift) - v.offset[axis];
}

void AmrWatch::remember(const mesh::Mesh& mesh, const core::Threads& threads) {
  pieces_.clear();
  mesh_ = &mesh;
  if (!mesh.is_adaptive())
    return;
  view_ = mesh.adaptive();
  for (std::int32_t p = 0; p < view_.piece_count - view_.halo_piece_count; ++p) {
    Piece& to = pieces_.emplace_back(*memory_, view_.pieces[p]);
    if (to.view.is_patch) {
      const Triple box = cells(to.view);
      mesh.visit_piece_fields(
          p, [&](const mesh::ExternalArray& array, const std::string& name, mesh::Mesh::ArrayKind) {
            if (extents(array) == box && (box[1] > 1 || box[2] > 1))
              to.fields.push_back(name);
          });
      continue;
    }
    to.leaves.resize_discard(std::size_t(to.view.cell_count));
    threads.parallel_for(to.view.cell_count, 1 << 14, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        const mesh::AmrCell c = view_.cell(to.view, i);
        to.leaves[std::size_t(i)] = {
            {std::int32_t(c.index[0]), std::int32_t(c.index[1]), std::int32_t(c.index[2])},
            std::int32_t(to.view.raw_level(i))};
      }
    });
  }
}

bool AmrWatch::is_elsewhere(const Piece& piece, std::int64_t i) const {
  const Leaf& leaf = piece.leaves[std::size_t(i)];
  if (has_null(piece.view, i) || piece.view.raw_level(i) != leaf.level)
    return true;
  for (int a = 0; a < 3; ++a)
    if (piece.view.raw_corner(i, a) != corner(piece, leaf, a))
      return true;
  return false;
}

void AmrWatch::refuse(std::size_t piece, const std::string& what) const {
  throw core::Error(INSITU_ERROR_ORDER,
                    "mesh '" + mesh_->name() + "', piece " + std::to_string(piece) + ", " + what +
                        ": a regrid that was not announced; after one say INSITU_CHANGED_TOPOLOGY "
                        "by insitu_mesh_changed, then call insitu_mesh_commit");
}

void AmrWatch::check_leaves(std::size_t p, std::int64_t begin, std::int64_t end,
                            const core::Threads* threads) const {
  const Piece& piece = pieces_[p];
  const std::int64_t n = end - begin;
  const std::int64_t bad =
      mesh::first_bad(n, threads, [&](std::int64_t i) { return is_elsewhere(piece, begin + i); });
  if (bad == n)
    return;
  const std::int64_t i = begin + bad;
  const Leaf& leaf = piece.leaves[std::size_t(i)];
  Triple was, is;
  for (int a = 0; a < 3; ++a)
    was[std::size_t(a)] = corner(piece, leaf, a);
  std::string now = "its pointer is null";
  if (!has_null(piece.view, i)) {
    for (int a = 0; a < 3; ++a)
      is[std::size_t(a)] = piece.view.raw_corner(i, a);
    now = "now level " + std::to_string(piece.view.raw_level(i)) + ", corner " + text(is);
  }
  refuse(p, "leaf " + std::to_string(i) + ": was level " + std::to_string(leaf.level) +
                ", corner " + text(was) + ", " + now);
}

void AmrWatch::check_shapes(std::size_t p) const {
  const Piece& piece = pieces_[p];
  const mesh::AmrPieceView& v = piece.view;
  const Triple box = cells(v);
  mesh_->visit_piece_fields(std::int32_t(p), [&](const mesh::ExternalArray& array,
                                                 const std::string& name, mesh::Mesh::ArrayKind) {
    const Triple is = extents(array);
    // An array of one extent says nothing about shapes.
    if (is == box || (is[1] == 1 && is[2] == 1) || array.indirect ||
        std::find(piece.fields.begin(), piece.fields.end(), name) == piece.fields.end())
      return;
    Triple last;
    for (std::size_t a = 0; a < 3; ++a)
      last[a] = v.lower[a] + v.size[a] - 1;
    refuse(p, "patch of cells " + text({v.lower[0], v.lower[1], v.lower[2]}) + " to " + text(last) +
                  ": " + name + " was " + by(box) + " items, now " + by(is));
  });
}

void AmrWatch::expect_unchanged(const core::Threads& threads) const {
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    check_leaves(p, 0, std::int64_t(pieces_[p].leaves.size()), &threads);
    // What has been given since counts from the next commit on.
    if (pieces_[p].view.is_patch && !(mesh_->pending() & INSITU_CHANGED_TOPOLOGY))
      check_shapes(p);
  }
}

void AmrWatch::expect_unchanged_chunk() {
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    Piece& piece = pieces_[p];
    const auto count = std::int64_t(piece.leaves.size());
    const std::int64_t begin = piece.next < count ? piece.next : 0;
    const std::int64_t end = std::min(count, begin + chunk_leaves);
    piece.next = end;
    check_leaves(p, begin, end, nullptr);
  }
}

} // namespace insitu::api
