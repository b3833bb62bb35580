#include "render/volume/ray_step.h"

#include "accel/tree/tree.h"
#include "query/chart_image.h"

namespace insitu::render {

double mesh_diagonal(const query::Sampler& sampler) {
  return sampler.facts().diagonal();
}

mesh::Box outer_bounds(const query::Sampler& sampler) {
  mesh::Box box{sampler.tree().bounds_min(), sampler.tree().bounds_max()};
  if (sampler.chart())
    sampler.chart()->cut(box);
  return box;
}

double typical_cell_size(const query::Sampler& sampler) {
  return sampler.facts().cell_size();
}

} // namespace insitu::render
