#include "scene/tracers/particle_cycle.h"

#include <algorithm>
#include <limits>

namespace insitu::scene {

const TrackRows& ParticleCycle::rows_at(std::size_t k) {
  if (known_time_ != k) {
    rows_at_ = make_rows_at(k);
    known_time_ = k;
  }
  return rows_at_;
}

const TrackRows& ParticleCycle::rows(const std::vector<std::size_t>& indices) {
  if (!known_ || *known_ != indices) {
    rows_ = make_rows(indices);
    known_ = indices;
  }
  return rows_;
}

TrackRows ParticleCycle::no_rows() const {
  TrackRows out;
  out.cycle = step_.cycle;
  out.pieces = names_pieces(mesh_.mesh());
  out.frame = mesh_.reference_frame;
  out.columns = moved_.tracer.field_columns(moved_.tracer.fields(mesh_));
  return out;
}

/// Further columns after those of the fields; put(r, out): of row r.
template <class Put>
void ParticleCycle::add_geodesics(TrackRows& out, Put&& put) const {
  const std::size_t fields = out.columns.size(), width = fields + geodesics().columns().size();
  if (width == fields)
    return;
  for (const TrackGeodesic column : geodesics().columns())
    out.columns.emplace_back(geodesic_name(column));
  std::vector<double> values(out.rows.size() * width);
  for (std::size_t r = 0; r < out.rows.size(); ++r) {
    std::copy_n(out.values.data() + r * fields, fields, values.data() + r * width);
    put(r, values.data() + r * width + fields);
  }
  out.values = std::move(values);
}

/// Rows of the particles at one of the tracer's times; fields are interpolated as the velocity is.
TrackRows ParticleCycle::make_rows_at(std::size_t k) const {
  const advect::Particles& p = particles();
  const advect::Snapshots& at = snapshots();
  TrackRows out = no_rows();
  std::vector<std::size_t> items;
  for (std::size_t i = 0; i < at.particles; ++i)
    if (const std::size_t item = at.item(k, i); at.present[item]) {
      const math::Vec3d& x = at.positions[item];
      out.rows.push_back(track_row(p.ids[i], at.times[k], x,
                                   own_cell(mesh_, at.places[item].cell, x), INSITU_END_ALIVE));
      items.push_back(item);
    }
  const std::size_t width = out.columns.size();
  out.values.assign(items.size() * width, std::numeric_limits<double>::quiet_NaN());
  std::size_t column = 0;
  for (const mesh::FieldView& field : moved_.tracer.fields(mesh_)) {
    const FieldBetween between(mesh_, field, moved_.interval, moved_.tracer.accuracy(),
                               at.times[k]);
    const auto n = std::size_t(field.components);
    moved_.tracer.threads().parallel_for(
        std::int64_t(items.size()), 512, [&](std::int64_t begin, std::int64_t end) {
          std::vector<double> u(n);
          for (auto r = std::size_t(begin); r < std::size_t(end); ++r)
            between.put(out.rows[r].position, at.places[items[r]], u.data(),
                        out.values.data() + r * width + column);
        });
    column += n;
  }
  add_geodesics(out, [&](std::size_t r, double* to) { geodesics().put_snapshot(items[r], to); });
  return out;
}

/// Rows of the particles with these indices, as they are.
TrackRows ParticleCycle::make_rows(const std::vector<std::size_t>& indices) const {
  const advect::Particles& p = particles();
  std::vector<math::Vec3d> points;
  std::vector<std::int64_t> cells;
  for (const std::size_t i : indices) {
    points.push_back(p.positions[i]);
    cells.push_back(p.cells[i]);
  }
  TrackRows out = no_rows();
  out.values = moved_.tracer.sample(mesh_, moved_.tracer.fields(mesh_), points, cells);
  for (std::size_t r = 0; r < indices.size(); ++r) {
    const std::size_t i = indices[r];
    out.rows.push_back(track_row(p.ids[i], p.times[i], points[r],
                                 own_cell(mesh_, cells[r], points[r]),
                                 insitu_ending(p.endings[i])));
  }
  add_geodesics(out, [&](std::size_t r, double* to) { geodesics().put(out.rows[r].particle, to); });
  return out;
}

} // namespace insitu::scene
