#include "query/nearest/nearest_vertices.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace insitu::query {

using math::Vec3d;

bool NearVertex::is_before(const NearVertex& b) const {
  return std::tie(squared, global, rank, piece, vertex) <
         std::tie(b.squared, b.global, b.rank, b.piece, b.vertex);
}

void NearVertices::take(const NearVertex& vertex) {
  if (!(vertex.squared <= reach()))
    return;
  const auto same = std::find_if(found_.begin(), found_.end(),
                                 [&](const NearVertex& one) { return one.is_same(vertex); });
  if (same != found_.end()) {
    if (!vertex.is_before(*same))
      return;
    found_.erase(same);
  }
  const auto place =
      std::lower_bound(found_.begin(), found_.end(), vertex,
                       [](const NearVertex& a, const NearVertex& b) { return a.is_before(b); });
  found_.insert(place, vertex);
  if (found_.size() > most_)
    found_.pop_back();
}

void NearestVertices::find(const Vec3d& p, NearVertices& found) const {
  const Images images(p, sampler_.chart());
  for (int i = 0; i < images.count; ++i) {
    const Vec3d& image = images.at[i];
    if (!std::isfinite(image.x + image.y + image.z))
      continue;
    visit_near(
        tree_, image, images.metric[i], [&] { return found.reach(); },
        [&](std::int64_t flat) {
          if (!sampler_.owns(flat))
            return;
          const std::int64_t own = own_cell_(flat);
          const std::int32_t piece = own_.piece_of(own);
          const mesh::PieceView& cells = own_.pieces[piece];
          cells.for_each_item_vertex(own - own_.first_cell[piece], [&](std::int64_t id) {
            const std::int64_t vertex = cells.solver_vertex(id);
            Vec3d x = cells.point(id);
            if (own_.is_flat)
              x.z = own_.plane;
            const double squared = images.squared_to(x);
            if (squared <= found.reach())
              found.take({squared, global_id_(own_.first_vertex[piece] + vertex), rank_, piece,
                          vertex, x});
          });
        });
  }
}

} // namespace insitu::query
