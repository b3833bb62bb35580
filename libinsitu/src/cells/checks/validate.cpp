#include "cells/checks/validate.h"

#include <bit>
#include <cmath>
#include <vector>

#include "cells/checks/folds.h"

namespace insitu::cells {

namespace {

using math::Vec3d;
using mesh::CellLayout;
using mesh::from_base;
using mesh::MeshView;
using mesh::PieceView;
using mesh::Shape;

constexpr std::int64_t grain = 4096;

/// What one chunk of cells showed; chunks are joined in order.
struct Findings {
  insitu_validation counts = insitu_validation_default();
  std::vector<std::string> lines;
  void add(std::string line) {
    if (lines.size() < 4)
      lines.push_back(std::move(line));
  }
};

/// Counts what the geometry of a block of cells shows.
void count_kinds(Shape shape, CellBlock& block, insitu_validation& counts) {
  const CellKinds kinds = kinds_of(shape, block);
  counts.folded_cells += std::popcount(kinds.folded);
  counts.inverted_cells += std::popcount(kinds.inverted);
  counts.zero_volume_cells += std::popcount(kinds.flat);
  counts.collapsed_cells += std::popcount(kinds.collapsed);
}

/// One chunk of a piece's cells.
class ChunkValidator {
public:
  ChunkValidator(const PieceView& piece, const std::string& name) : p_(piece), name_(name) {}

  void cell(std::int64_t cell, Findings& f) {
    if (!p_.exists(cell)) { // never read by any kernel, so it may hold garbage
      ++f.counts.ghost_cells;
      return;
    }
    if (!structure_is_sound(cell, f))
      return;
    std::int64_t ids[8];
    const Shape shape = p_.shape(cell);
    const int n = p_.vertex_ids(cell, ids);
    for (int v = 0; v < n; ++v)
      if (ids[v] < 0 || ids[v] >= p_.vertex_count) {
        ++f.counts.index_errors;
        const std::int64_t given = from_base(ids[v], -p_.index_base);
        f.add(at(cell) + "vertex " + std::to_string(v) + " has id " + std::to_string(given) + ", " +
              std::to_string(p_.index_base) + " to " +
              std::to_string(p_.vertex_count - 1 + p_.index_base) + " expected");
        return;
      }
    Vec3d x[8];
    p_.cell_points(cell, ids, n, x);
    bool finite = true;
    for (int v = 0; v < n; ++v)
      finite &= std::isfinite(x[v].x) & std::isfinite(x[v].y) & std::isfinite(x[v].z);
    if (!finite)
      return refuse_coordinates(cell, n, ids, x, f);
    if (shape != shape_ || block_.count == CellBlock::size)
      flush(f);
    shape_ = shape;
    block_.set(n, block_.count++, x);
  }

  /// Looks at the geometry of the cells that wait for it.
  void flush(Findings& f) {
    count_kinds(shape_, block_, f.counts);
    block_.count = 0;
  }

private:
  std::string at(std::int64_t cell) const {
    return name_ + ", cell " + std::to_string(cell) + ": ";
  }

  /// The shape is known and the ids lie within connectivity.
  bool structure_is_sound(std::int64_t cell, Findings& f) const {
    const auto refuse = [&](const std::string& what) {
      ++f.counts.shape_errors;
      f.add(at(cell) + what);
      return false;
    };
    if (p_.layout == CellLayout::mixed) {
      const int type = mesh::load_as<std::uint8_t>(p_.types + cell * p_.types_stride);
      if (!mesh::is_shape(type))
        return refuse("type " + std::to_string(type) + ", 10 to 14 expected");
      const std::int64_t given = p_.offsets.load(cell), start = from_base(given, p_.index_base);
      const int n = mesh::vertex_count(Shape(type));
      if (start < 0 || start > p_.connectivity.count - n)
        return refuse("its " + std::to_string(n) + " ids start at " + std::to_string(given) +
                      " of " + std::to_string(p_.connectivity.count) + " in connectivity");
      // With an offset more than cells (or the next cell's start), the count is checked as well.
      if (cell + 1 < p_.offsets.count) {
        const std::int64_t ids = from_base(p_.offsets.load(cell + 1), given);
        if (ids != n)
          return refuse(std::to_string(ids) + " ids between its offsets, " + std::to_string(n) +
                        " expected for a " + mesh::shape_name(Shape(type)));
      }
    } else if (p_.layout == CellLayout::padded) {
      int n = 0;
      while (n < 8 && from_base(p_.padded_id(cell, n), p_.index_base) >= 0)
        ++n;
      if (n != 4 && n != 5 && n != 6 && n != 8)
        return refuse(std::to_string(n) + " ids before the padding, 4, 5, 6 or 8 expected");
      for (int v = n; v < 8; ++v)
        if (p_.padded_id(cell, v) != -1)
          return refuse("place " + std::to_string(v) + " holds " +
                        std::to_string(p_.padded_id(cell, v)) + ", -1 expected after its " +
                        std::to_string(n) + " ids");
    }
    return true;
  }

  void refuse_coordinates(std::int64_t cell, int n, const std::int64_t* ids, const Vec3d* x,
                          Findings& f) const {
    for (int v = 0; v < n; ++v)
      for (int a = 0; a < 3; ++a)
        if (!std::isfinite(x[v][a])) {
          ++f.counts.coordinate_errors;
          f.add(at(cell) + "vertex id " + std::to_string(ids[v] + p_.index_base) + ": coordinate " +
                "xyz"[a] + " is " + (std::isnan(x[v][a]) ? "NaN" : "infinite"));
          return;
        }
  }

  const PieceView& p_;
  const std::string& name_;
  Shape shape_ = Shape::none;
  CellBlock block_{}; ///< cells of shape_
};

} // namespace

void join(insitu_validation& to, const insitu_validation& from) {
  to.cells += from.cells;
  to.index_errors += from.index_errors;
  to.shape_errors += from.shape_errors;
  to.coordinate_errors += from.coordinate_errors;
  to.inverted_cells += from.inverted_cells;
  to.zero_volume_cells += from.zero_volume_cells;
  to.folded_cells += from.folded_cells;
  to.collapsed_cells += from.collapsed_cells;
  to.ghost_cells += from.ghost_cells;
}

Validation validate(const std::string& mesh_name, const MeshView& mesh,
                    const core::Threads& threads, std::int32_t first) {
  Validation out;
  out.counts = insitu_validation_default();
  std::size_t lines = 0;
  for (std::int32_t p = first; p < mesh.piece_count; ++p) {
    const PieceView& piece = mesh.pieces[p];
    const std::string name = "mesh '" + mesh_name + "', piece " + std::to_string(p);
    std::vector<Findings> chunks(std::size_t((piece.cell_count + grain - 1) / grain));
    threads.parallel_for(piece.cell_count, grain, [&](std::int64_t begin, std::int64_t end) {
      Findings& f = chunks[std::size_t(begin / grain)];
      f.counts.cells = end - begin;
      ChunkValidator validator(piece, name);
      for (std::int64_t cell = begin; cell < end; ++cell)
        validator.cell(cell, f);
      validator.flush(f);
    });
    for (const Findings& f : chunks) {
      join(out.counts, f.counts);
      for (const std::string& line : f.lines)
        if (lines++ < 4)
          out.findings += (out.findings.empty() ? "" : "\n") + line;
    }
  }
  const insitu_validation& c = out.counts;
  const std::int64_t errors = c.index_errors + c.shape_errors + c.coordinate_errors;
  if (errors > std::int64_t(lines < 4 ? lines : 4))
    out.findings += "\n(" + std::to_string(errors) + " cells with errors in all)";
  if (c.inverted_cells + c.zero_volume_cells + c.folded_cells + c.collapsed_cells > 0)
    out.warning = "mesh '" + mesh_name + "': of " + std::to_string(c.cells) + " cells " +
                  std::to_string(c.inverted_cells) + " are inverted, " +
                  std::to_string(c.zero_volume_cells) + " have no volume, " +
                  std::to_string(c.folded_cells) + " are folded, " +
                  std::to_string(c.collapsed_cells) + " have coincident vertices";
  return out;
}

} // namespace insitu::cells
