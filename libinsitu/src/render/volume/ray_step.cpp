#include "render/volume/ray_step.h"

namespace insitu::render {

double mesh_diagonal(const query::Sampler& sampler) {
  return sampler.facts().diagonal();
}

double typical_cell_size(const query::Sampler& sampler) {
  return sampler.facts().cell_size();
}

} // namespace insitu::render
