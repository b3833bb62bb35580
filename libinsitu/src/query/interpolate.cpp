#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "cells/kernels/kernels.h"
#include "query/batch/query_boxes.h"
#include "query/chart_image.h"
#include "query/lattice/gridlet_query.h"
#include "query/lattice/gridlet_values.h"
#include "query/lattice/stitching_values.h"
#include "query/sampler.h"

/// The functions of Sampler that give values at locations; other files have those that find
/// locations.
namespace insitu::query {

using math::Vec3d;

namespace {

/// Tells the pieces of cells, of which most lie in the piece of the cell before.
class PieceOfCells {
public:
  explicit PieceOfCells(const mesh::MeshView& mesh) : mesh_(mesh) {}

  std::int32_t operator()(std::int64_t cell) {
    if (cell < begin_ || cell >= end_) {
      piece_ = mesh_.piece_of(cell);
      begin_ = mesh_.first_cell[piece_];
      end_ = mesh_.first_cell[piece_ + 1];
    }
    return piece_;
  }

private:
  const mesh::MeshView& mesh_;
  std::int32_t piece_ = 0;
  std::int64_t begin_ = 0, end_ = 0;
};

/// Loads one component of a cell field, at cells of which most lie in the piece of the cell before.
class CellValues {
public:
  CellValues(const mesh::MeshView& mesh, const mesh::FieldView& field)
      : mesh_(mesh), field_(field) {}

  double operator()(std::int64_t cell) {
    if (cell < begin_ || cell >= end_)
      go_to(cell);
    return linear_ ? mesh::load_real(data_ + (cell - begin_) * stride_, is_float32_)
                   : field_.pieces[piece_].load(cell - begin_, 0);
  }

private:
  void go_to(std::int64_t cell) {
    piece_ = mesh_.piece_of(cell);
    begin_ = mesh_.first_cell[piece_];
    end_ = mesh_.first_cell[piece_ + 1];
    const mesh::FieldPieceView& from = field_.pieces[piece_];
    linear_ = from.layout.linear;
    is_float32_ = from.is_float32;
    data_ = from.component[0];
    stride_ = from.layout.stride[0];
  }

  const mesh::MeshView& mesh_;
  const mesh::FieldView& field_;
  std::int32_t piece_ = 0;
  std::int64_t begin_ = 0, end_ = 0;
  bool linear_ = false, is_float32_ = false;
  const std::byte* data_ = nullptr;
  std::int64_t stride_ = 0;
};

/// Interpolates a field with blank vertices on a face that has none: the vertices off the face,
/// whose weights are 0, take no part, so that their NaN does not spread.
double beside_blanks(const mesh::FieldPieceView& from, int c, const double* weight,
                     const std::int64_t* ids, int n) {
  double sum = 0.0;
  for (int v = 0; v < n; ++v)
    if (weight[v] != 0.0)
      sum += weight[v] * from.load(ids[v], c);
  return sum;
}

} // namespace

void Sampler::interpolate(const mesh::FieldView& field, const Location& at, double* values) const {
  interpolate(std::span(&field, 1), at, values);
}

void Sampler::interpolate(std::span<const mesh::FieldView> fields, const Location& at,
                          double* values) const {
  interpolate_to(fields, mesh_->piece_of(at.cell), at, [&](std::size_t f) {
    return std::exchange(values, values + fields[f].components);
  });
}

void Sampler::interpolate(std::span<const mesh::FieldView> fields, const Answered& answered,
                          std::size_t first, double* const* values) const {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const std::span<const Location> at = answered.locations;
  PieceOfCells piece(*mesh_);
  const auto put = [&](auto some) {
    for (std::size_t k = 0; k < at.size(); ++k) {
      const std::size_t i = first + answered.item(k);
      if (at[k]) {
        interpolate_to(some, piece(at[k].cell), at[k], [&](std::size_t f) {
          return values[f] + i * std::size_t(some[f].components);
        });
        continue;
      }
      for (std::size_t f = 0; f < some.size(); ++f) {
        const auto components = std::size_t(some[f].components);
        std::fill_n(values[f] + i * components, components, nan);
      }
    }
  };
  // Interpolates one field of the dual mesh of an adaptive mesh, where most locations lie in
  // gridlets. First the stitching cells among one_by_one are prefetched: the ids of their vertices,
  // then the values there. Then runs of locations that lie in gridlets are interpolated together,
  // and all others one by one.
  const auto put_one = [&](auto in_gridlets, const auto& in_stitching) {
    const std::int64_t end = mesh_->first_cell[1];
    const auto components = std::size_t(fields[0].components);
    double in_turn[64];                     // values of a run, which go to their items after it
    std::int64_t stitching[batch_size + 1]; // stitching cells, counted without a branch: the loop
                                            // writes one item more than it keeps
    std::size_t count = 0;
    for (const std::uint16_t k : answered.one_by_one) {
      stitching[count] = at[k].cell - end;
      count += std::size_t(at[k].cell >= end);
    }
    for (const std::int64_t cell : std::span(stitching, count))
      in_stitching.ask_for_ids(cell);
    for (const std::int64_t cell : std::span(stitching, count))
      in_stitching.ask_for_values(cell);
    for (std::size_t k = 0; k < at.size(); ++k) {
      double* const to = values[0] + (first + answered.item(k)) * components;
      if (std::uint64_t(at[k].cell) < std::uint64_t(end)) {
        const std::size_t most =
            answered.order ? std::min(std::size(in_turn), at.size() - k) : at.size() - k;
        const std::size_t ahead =
            in_gridlets.ahead(end, at.subspan(k, most), answered.order ? in_turn : to);
        for (std::size_t i = 0; i < ahead && answered.order; ++i)
          values[0][first + answered.item(k + i)] = in_turn[i];
        if (ahead > 0)
          k += ahead - 1;
        else
          in_gridlets.at(at[k].cell, at[k].parametric, to);
      } else if (at[k]) {
        in_stitching.at(at[k].cell - end, at[k].parametric, to);
      } else {
        std::fill_n(to, components, nan);
      }
    }
  };
  // Loads a cell field of one component, of which a location needs little but its place.
  const auto put_own = [&] {
    CellValues value(*mesh_, fields[0]);
    for (std::size_t k = 0; k < at.size(); ++k)
      values[0][first + answered.item(k)] = at[k] ? value(at[k].cell) : nan;
  };
  const mesh::GridletsView* const gridlets = gridlets_of(*mesh_);
  if (fields.size() == 1 && fields[0].association == INSITU_CELL && fields[0].components == 1)
    put_own();
  else if (fields.size() == 1 && gridlets && fields[0].pieces[0].is_float32)
    put_one(GridletValues<float>(*gridlets, fields[0]),
            StitchingValues<float>(*mesh_, fields[0], 1));
  else if (fields.size() == 1 && gridlets)
    put_one(GridletValues<double>(*gridlets, fields[0]),
            StitchingValues<double>(*mesh_, fields[0], 1));
  else if (fields.size() == 1)
    put(fields.first<1>());
  else
    put(fields);
}

bool Sampler::takes_coordinates(std::span<const mesh::FieldView> fields) const {
  return std::any_of(fields.begin(), fields.end(), [&](const mesh::FieldView& field) {
    return field.association != INSITU_CELL || (chart_ && mesh_->is_vector(field)); // it is turned
  });
}

/// Interpolates the fields at one location, which lies in `piece`. values_of(f) tells where the
/// values of field f go.
template <class Fields, class ValuesOf>
inline void Sampler::interpolate_to(const Fields& fields, std::int32_t piece, const Location& at,
                                    ValuesOf&& values_of) const {
  const mesh::PieceView& cells_of = mesh_->pieces[piece];
  const std::int64_t cell = at.cell - mesh_->first_cell[piece];
  if (cells_of.gridlets) {
    for (std::size_t f = 0; f < fields.size(); ++f)
      if (fields[f].pieces[0].is_float32)
        GridletValues<float>(*cells_of.gridlets, fields[f]).at(cell, at.parametric, values_of(f));
      else
        GridletValues<double>(*cells_of.gridlets, fields[f]).at(cell, at.parametric, values_of(f));
    return;
  }
  double weight[8];
  std::int64_t ids[8];
  int n = 0;
  const bool turned = chart_ && cells_of.pole != 0;
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const mesh::FieldView& field = fields[f];
    const mesh::FieldPieceView& from = field.pieces[piece];
    double* values = values_of(f);
    const bool turns = turned && mesh_->is_vector(field);
    if (n == 0 && (turns || field.association != INSITU_CELL)) {
      n = cells_of.vertex_ids(cell, ids);
      const mesh::Shape shape = cells_of.layout == mesh::CellLayout::padded
                                    ? cells_of.padded_shape(n)
                                    : cells_of.shape(cell);
      cells::shape_functions(shape, at.parametric, weight);
    }
    if (field.association == INSITU_CELL) {
      for (int c = 0; c < field.components; ++c)
        values[c] = from.load(cell, c);
      if (turns)
        to_true_axes(cells_of, {weight, std::size_t(n)}, ids, values);
      continue;
    }
    for (int c = 0; c < field.components; ++c) {
      double sum = weight[0] * from.load(ids[0], c);
      for (int v = 1; v < n; ++v)
        sum += weight[v] * from.load(ids[v], c);
      values[c] = field.has_blanks && sum != sum ? beside_blanks(from, c, weight, ids, n) : sum;
    }
    if (turns)
      to_true_axes(cells_of, {weight, std::size_t(n)}, ids, values);
  }
}

void Sampler::to_true_axes(const mesh::PieceView& cells, std::span<const double> weights,
                           const std::int64_t* ids, double* vector) const {
  const auto pole = geo::Pole(cells.pole);
  Vec3d p;
  for (std::size_t v = 0; v < weights.size(); ++v)
    p += weights[v] * cells.point(ids[v]);
  p.x -= chart_->offset(pole);
  const geo::ChartPlace at = geo::place_of(chart_->units, pole, p);
  const geo::EastNorth axes = geo::east_north(at.normal);
  const Vec3d v = vector[0] * at.east + vector[1] * at.north;
  vector[0] = dot(v, axes.east);
  vector[1] = dot(v, axes.north);
}

Vec3d Sampler::gradient(const mesh::FieldView& field, int component, const Location& at,
                        double alpha) const {
  if (field.association == INSITU_CELL)
    return {};
  mesh::CellVertices cell;
  mesh::gather(*mesh_, at.cell, cell, alpha);
  double f[8];
  for (int v = 0; v < cell.count; ++v)
    f[v] = field.pieces[cell.piece].load(cell.ids[v], component);
  Vec3d slope = cells::gradient(cell.shape, cell.x, f, at.parametric);
  if (mesh_->is_flat)
    slope.z = 0.0;
  return slope;
}

} // namespace insitu::query
