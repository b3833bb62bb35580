#include "check_dual.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <unordered_map>

#include "amr/values/leaf_gradient.h"
#include "cells/checks/folds.h"
#include "cells/kernels/kernels.h"
#include "core/random.h"
#include "dual_cell.h"

namespace insitu::test {

namespace {

using math::Vec3d;
using Cell = DualCell;

class Checker {
public:
  Checker(AmrMesh& mesh, const amr::DualMesh& dual, const Expect& expect)
      : dual_(dual), view_(mesh.view()), expect_(expect), leaves_(leaves_of(mesh)) {}

  DualFacts run() {
    read_cells();
    volumes();
    faces();
    gridlets();
    values();
    counts();
    return facts_;
  }

private:
  void fail(const std::string& what) {
    if (facts_.problem.empty())
      facts_.problem = what;
  }

  void read_cells() {
    const mesh::MeshView& view = dual_.view();
    if (view.pieces[1].vertex_count > 0) // volumes of small meshes far from the origin
      near_ = view.pieces[1].point(0);
    for (std::int64_t flat = 0; flat < view.cell_count(); ++flat) {
      mesh::CellVertices g;
      const std::int32_t p = view.piece_of(flat);
      if (!view.pieces[p].owns(flat - view.first_cell[p]))
        continue;
      mesh::gather(view, flat, g);
      Cell c;
      c.shape = g.shape;
      c.count = g.count;
      c.stitching = g.piece == 1;
      c.in_piece = flat - view.first_cell[p];
      for (int v = 0; v < g.count; ++v) {
        c.x[v] = g.x[v] - near_;
        c.vertices[v] = places_.try_emplace(g.x[v], std::int64_t(places_.size())).first->second;
      }
      cells_.push_back(c);
      if (c.stitching)
        check_folds(c, g);
    }
    facts_.cells = std::int64_t(cells_.size());
  }

  void check_folds(const Cell& c, const mesh::CellVertices& g) {
    // Positive Jacobians in every cell and faces that match in pairs, and on the boundary lie in
    // it, make the cover single: the cells' maps, put together, are a local homeomorphism from the
    // complex of cells to the domain that is proper over the boundary, so every point has the same
    // number of preimages, and the volumes say that it is one.
    if (!expect_.no_folds)
      return;
    if (cells::jacobian_changes_sign(c.shape, g.x))
      fail("a stitching cell folds");
    if (!(volume(c) > 0.0))
      fail("a stitching cell is inside out");
  }

  void volumes() {
    for (const Cell& c : cells_)
      facts_.volume += volume(c);
    for (const Leaf& l : leaves_)
      facts_.leaves += view_.lattice.width(0, l.depth) * view_.lattice.width(1, l.depth) *
                       view_.lattice.width(2, l.depth);
  }

  void faces() {
    std::map<FaceKey, FaceUse> uses;
    for (const Cell& c : cells_) {
      const cells::FaceTable table = cells::face_table(c.shape);
      for (int f = 0; f < table.face_count; ++f) {
        FaceKey key;
        FaceUse use;
        const int turn = face_key(c, table.faces[f], key, use.x);
        if (turn == 0)
          continue;
        FaceUse& all = uses.try_emplace(key, use).first->second;
        ++all.count;
        all.turn += turn;
      }
    }
    for (const auto& [key, use] : uses) {
      if (use.count > 2 || (use.count == 2 && use.turn != 0))
        fail("a face of " + std::to_string(use.count) + " cells, turns add up to " +
             std::to_string(use.turn));
      if (use.count != 1)
        continue;
      ++facts_.unmatched;
      facts_.enclosed += use.turn * flux(use.x, key.count);
      if (expect_.conforming && !on_boundary(use.x, key.count))
        fail("an unmatched face inside the domain");
    }
    const double scale = 1e-12 * std::max(facts_.leaves, 1e-300);
    if (std::abs(facts_.volume - facts_.enclosed) > scale)
      fail("cells of volume " + std::to_string(facts_.volume) + " inside faces that enclose " +
           std::to_string(facts_.enclosed));
    if (expect_.covers_leaves && std::abs(facts_.volume - facts_.leaves) > scale)
      fail("cells of volume " + std::to_string(facts_.volume) + " in leaves of " +
           std::to_string(facts_.leaves));
  }

  /// A face in one plane of the lattice with leaves on one side of it only, at its middle.
  bool on_boundary(const Vec3d* x, int count) const {
    Vec3d middle{0, 0, 0};
    for (int v = 0; v < count; ++v)
      middle += (1.0 / count) * x[v];
    for (int a = 0; a < 3; ++a) {
      bool flat = true;
      for (int v = 1; v < count; ++v)
        flat &= x[v][a] == x[0][a];
      if (!flat)
        continue;
      // Off the leaves' own faces along the other axes, which the middle may lie on.
      const double h = 1e-5 * view_.lattice.width(a, view_.finest_depth());
      Vec3d low = near_ + middle, high = low;
      low[a] -= h;
      high[a] += h;
      for (int b = 0; b < 3; ++b)
        if (b != a) {
          const double nudge = 1e-6 * view_.lattice.width(b, view_.finest_depth());
          low[b] += nudge;
          high[b] += nudge;
        }
      if (bool(dual_.leaves().find(low)) != bool(dual_.leaves().find(high)))
        return true;
    }
    return false;
  }

  /// Gridlets are shrunk to fit their cells, and only vertices that none of these has are empty.
  void gridlets() {
    const mesh::GridletsView& all = *dual_.view().pieces[0].gridlets;
    std::set<std::uint32_t> leaves;
    for (const Leaf& l : leaves_)
      leaves.insert(l.id);
    for (std::int64_t n = 0; n < all.count; ++n) {
      const mesh::Gridlet& g = all.gridlets[n];
      int low[3] = {8, 8, 8}, high[3] = {-1, -1, -1};
      std::set<std::int64_t> used;
      for (std::int64_t cell = n << mesh::Gridlet::cell_bits;
           cell < (n + 1) << mesh::Gridlet::cell_bits; ++cell) {
        if (!all.is_full(cell))
          continue;
        for (int a = 0; a < 3; ++a) {
          const int at = int(cell >> (3 * a)) & 7;
          low[a] = std::min(low[a], at);
          high[a] = std::max(high[a], at);
        }
        std::int64_t ids[8];
        all.vertex_ids(cell, ids);
        used.insert(ids, ids + 8);
      }
      for (int a = 0; a < 3; ++a)
        if (low[a] != 0 || high[a] + 1 != int(g.size[a]))
          fail("a gridlet does not fit its cells");
      for (std::int64_t v = g.first; v < std::int64_t(g.first) + g.vertex_count(); ++v) {
        const bool empty = all.leaves[v] == mesh::GridletsView::no_leaf;
        if (empty && used.count(v) != 0)
          fail("an empty vertex of a full cell");
        else if (!empty && leaves.count(all.leaves[v]) == 0)
          fail("a gridlet's vertex of no leaf");
      }
    }
  }

  double linear(const Vec3d& p) const { return 0.7 - 1.3 * p.x + 2.1 * p.y + 0.4 * p.z; }

  /// At centres the leaves' values; a linear field is reproduced where all vertices are centres.
  void values() {
    std::unordered_map<std::uint32_t, Vec3d> centre;
    std::unordered_map<std::uint32_t, int> depth;
    for (const Leaf& l : leaves_) {
      depth[l.id] = l.depth;
      Vec3d& c = centre[l.id];
      for (int a = 0; a < 3; ++a)
        c[a] = view_.lattice.centre(a, l.depth, l.index[std::size_t(a)]);
    }
    const mesh::GridletsView& gridlets = *dual_.view().pieces[0].gridlets;
    const mesh::PieceView& piece = dual_.view().pieces[1];
    for (const Cell& c : cells_) {
      std::int64_t ids[8];
      double f[8];
      bool all_centres = true;
      dual_.view().pieces[c.stitching].vertex_ids(c.in_piece, ids);
      for (int v = 0; v < c.count; ++v) {
        if (!c.stitching) {
          const auto at = centre.find(gridlets.leaves[ids[v]]);
          if (at == centre.end() || !(at->second == gridlets.point(ids[v])))
            fail("a gridlet's vertex is not its leaf's centre");
          meet(c.vertices[v], rough(gridlets.leaves[ids[v]], amr::no_ghost));
          continue;
        }
        const amr::DualMesh::Terms t = dual_.terms(ids[v]);
        const Vec3d x = piece.point(ids[v]);
        f[v] = 0.0;
        double weights = 0.0, any = 0.0;
        for (int n = 0; n < t.count; ++n) {
          const double w = t.weights ? t.weights[n] : 1.0;
          const auto at = centre.find(t.leaves[n]);
          if (at == centre.end()) {
            fail("a term of no leaf");
            return;
          }
          Vec3d from = at->second;
          if (t.ghosts && t.ghosts[n] != amr::no_ghost) {
            const int axis = t.ghosts[n] >> 1;
            from[axis] += (t.ghosts[n] & 1 ? 1 : -1) * view_.lattice.width(axis, depth[at->first]);
            if (dual_.leaves().find(from))
              fail("a ghost cell is read where a leaf is");
          }
          f[v] += w * linear(from);
          any += w * rough(t.leaves[n], t.ghosts ? t.ghosts[n] : amr::no_ghost);
          weights += w;
        }
        meet(c.vertices[v], any);
        if (std::abs(weights - 1.0) > 1e-9)
          fail("weights add up to " + std::to_string(weights));
        const bool inside = is_inside(x);
        all_centres &= inside || expect_.ghosts;
        if ((inside || expect_.ghosts) && t.weights && expect_.linear &&
            std::abs(f[v] - linear(x)) > 1e-9)
          fail("a virtual leaf or a vertex on the boundary does not meet a linear field");
        if (inside && t.weights == nullptr && !(centre.at(t.leaves[0]) == x))
          fail("a vertex is not its leaf's centre");
      }
      if (c.stitching && all_centres && expect_.linear)
        check_linear(c, f, piece, ids);
    }
  }

  /// Numbers that leaves and ghost cells have nothing in common by.
  static double rough(std::uint32_t leaf, std::uint8_t ghost) {
    return core::random_unit(11, leaf, ghost);
  }
  /// Where cells meet a vertex has one value, whatever the leaves': with faces that match in pairs
  /// the interpolant then has no jump anywhere.
  void meet(std::int64_t place, double value) {
    const double there = value_at_.try_emplace(place, value).first->second;
    if (expect_.conforming && std::abs(there - value) > 1e-12)
      fail("a vertex of two values, " + std::to_string(there) + " and " + std::to_string(value));
  }

  /// Not on the boundary: leaves lie on all sides.
  bool is_inside(const Vec3d& x) const {
    for (int o = 0; o < 8; ++o) {
      Vec3d p = x;
      for (int a = 0; a < 3; ++a)
        p[a] += (o >> a & 1 ? 1e-6 : -1e-6) * view_.lattice.width(a, view_.finest_depth());
      if (!dual_.leaves().find(p))
        return false;
    }
    return true;
  }

  void check_linear(const Cell& c, const double* f, const mesh::PieceView& piece,
                    const std::int64_t* ids) {
    Vec3d x[8];
    for (int v = 0; v < c.count; ++v)
      x[v] = piece.point(ids[v]);
    Vec3d r = {core::random_unit(7, std::uint64_t(c.in_piece), 0) / 3,
               core::random_unit(7, std::uint64_t(c.in_piece), 1) / 3,
               core::random_unit(7, std::uint64_t(c.in_piece), 2) / 3};
    double n[8], value = 0.0;
    cells::shape_functions(c.shape, r, n);
    for (int v = 0; v < c.count; ++v)
      value += n[v] * f[v];
    if (std::abs(value - linear(cells::map_to_physical(c.shape, x, r))) > 1e-9)
      fail("a linear field is not reproduced");
  }

  void counts() {
    const amr::DualCounts& n = dual_.counts();
    std::int64_t cubes = 0, stitching = 0;
    for (const Cell& c : cells_)
      ++(c.stitching ? stitching : cubes);
    if (n.cubes != cubes || n.stitching() != stitching ||
        n.leaves != std::int64_t(leaves_.size()) || n.leaves + n.masked != view_.cell_count() ||
        n.scalars != dual_.view().pieces[0].vertex_count)
      fail("counts do not agree with the cells");
    if (expect_.no_folds && n.still_folded != 0)
      fail("still folded: " + std::to_string(n.still_folded));
  }

  const amr::DualMesh& dual_;
  const mesh::AmrView& view_;
  Expect expect_;
  std::vector<Leaf> leaves_;
  std::vector<Cell> cells_;
  std::map<Vec3d, std::int64_t, PointLess> places_;
  std::unordered_map<std::int64_t, double> value_at_; ///< of places
  DualFacts facts_;
  Vec3d near_{0, 0, 0};
};

} // namespace

DualFacts check_dual(AmrMesh& mesh, const amr::DualMesh& dual, const Expect& expect) {
  return Checker(mesh, dual, expect).run();
}

} // namespace insitu::test
