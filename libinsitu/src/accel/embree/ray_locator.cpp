#include "accel/ray_locator.h"

#include "accel/embree/cell_rays.h"
#include "accel/embree/face_rays.h"
#include "core/status.h"

namespace insitu::accel {

std::unique_ptr<RayLocator> make_embree_locator(Method method, core::Memory& memory,
                                                std::int64_t group) {
  if (method == Method::bvh)
    throw core::Error(INSITU_ERROR_INTERNAL, "the bvh method traces no rays");
  if (method == Method::user_geometry)
    return std::make_unique<embree::CellRays>(memory, group);
  return std::make_unique<embree::FaceRays>(method, memory, group);
}

} // namespace insitu::accel
