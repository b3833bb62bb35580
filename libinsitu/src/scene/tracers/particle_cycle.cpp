#include "scene/tracers/particle_cycle.h"

#include <algorithm>
#include <limits>

#include "advect/field/owners.h"
#include "commit/halo/everywhere.h"

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

std::vector<mesh::FieldView> ParticleCycle::fields() const {
  return moved_.fields ? *moved_.fields : moved_.tracer.fields(mesh_);
}

TrackRows ParticleCycle::no_rows() const {
  TrackRows out;
  out.cycle = step_.cycle;
  out.names = moved_.names;
  out.frame = mesh_.reference_frame;
  out.columns = moved_.tracer.field_columns(fields());
  return out;
}

/// A cell that holds the point, as the solver counts cells.
OwnCell ParticleCycle::named_cell(std::int64_t flat, const math::Vec3d& x) const {
  return own_cell(mesh_, flat, x, moved_.world);
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
      out.rows.push_back(track_row(p.ids[i], at.times[k], x, named_cell(at.places[item].cell, x),
                                   INSITU_END_ALIVE));
      items.push_back(item);
    }
  const std::size_t width = out.columns.size();
  out.values.assign(items.size() * width, std::numeric_limits<double>::quiet_NaN());
  std::size_t column = 0;
  for (const mesh::FieldView& field : fields()) {
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

/// Where the particles with these indices are, by their owners; none of those that are outside.
std::vector<query::Location> ParticleCycle::places(const std::vector<std::size_t>& indices) const {
  const advect::Particles& p = particles();
  const query::Sampler sampler = mesh_.sampler();
  const auto beyond =
      advect::CellsBeyond::worth(sampler, std::int64_t(moved_.mesh_moved ? indices.size() : 0));
  query::LocateOptions options;
  options.accuracy = moved_.tracer.accuracy();
  std::vector<query::Location> places(indices.size());
  moved_.tracer.threads().parallel_for(
      std::int64_t(indices.size()), 512, [&](std::int64_t begin, std::int64_t end) {
        for (auto r = std::size_t(begin); r < std::size_t(end); ++r)
          places[r] = advect::owner_of(sampler, beyond.get(), p.cells[indices[r]],
                                       p.positions[indices[r]], options);
      });
  return places;
}

/// Rows of the particles with these indices, as they are.
TrackRows ParticleCycle::make_rows(const std::vector<std::size_t>& indices) const {
  const advect::Particles& p = particles();
  TrackRows out = no_rows();
  const std::vector<mesh::FieldView> recorded = fields();
  std::vector<query::Location> at(indices.size());
  if (!recorded.empty() || moved_.mesh_moved)
    at = places(indices);
  out.values = moved_.tracer.values_at(mesh_, recorded, at);
  for (std::size_t r = 0; r < indices.size(); ++r) {
    const std::size_t i = indices[r];
    const bool is_told = moved_.mesh_moved && at[r] && p.endings[i] == INSITU_END_ALIVE;
    const std::int64_t cell = is_told ? at[r].cell : p.cells[i];
    out.rows.push_back(track_row(p.ids[i], p.times[i], p.positions[i],
                                 named_cell(cell, p.positions[i]), insitu_ending(p.endings[i])));
  }
  add_geodesics(out, [&](std::size_t r, double* to) { geodesics().put(out.rows[r].particle, to); });
  return out;
}

void ParticleCycle::add_values_of_others(const std::vector<std::size_t>& indices, TrackRows& rows,
                                         parallel::World& world) const {
  std::vector<std::string> names;
  std::vector<std::size_t> of; // rows
  std::vector<math::Vec3d> points;
  world.agree_after([&] {
    for (const mesh::FieldView& field : fields())
      names.emplace_back(field.name);
    if (names.empty())
      return;
    std::vector<std::size_t> ended, its_rows;
    for (std::size_t r = 0; r < indices.size(); ++r)
      if (particles().endings[indices[r]] != INSITU_END_ALIVE) {
        ended.push_back(indices[r]);
        its_rows.push_back(r);
      }
    const std::vector<query::Location> at = places(ended);
    for (std::size_t k = 0; k < ended.size(); ++k)
      if (!at[k]) {
        of.push_back(its_rows[k]);
        points.push_back(particles().positions[ended[k]]);
      }
  });
  std::int64_t any = !points.empty();
  world.reduce(std::span(&any, 1), parallel::Reduction::greatest);
  if (!any)
    return;
  query::LocateOptions options;
  options.accuracy = moved_.tracer.accuracy();
  commit::Everywhere all(mesh_, world);
  all.sample(points, names, options, moved_.tracer.threads(),
             [&](std::size_t first, std::span<const commit::OwnerOfAll> owners,
                 std::span<const double> values) {
               const std::size_t width = values.size() / owners.size();
               for (std::size_t k = 0; k < owners.size(); ++k)
                 if (owners[k])
                   std::copy_n(values.begin() + std::ptrdiff_t(k * width), width,
                               rows.values.begin() +
                                   std::ptrdiff_t(of[first + k] * rows.columns.size()));
             });
}

} // namespace insitu::scene
