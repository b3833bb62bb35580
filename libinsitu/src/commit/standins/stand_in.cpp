#include "commit/standins/stand_in.h"

#include "commit/standins/adaptive.h"
#include "commit/standins/geodetic.h"
#include "commit/standins/polyhedral.h"
#include "core/status.h"

namespace insitu::commit {

std::unique_ptr<StandIn> make_stand_in(const mesh::Mesh& mesh, const insitu_frame& frame,
                                       core::Memory& memory) {
  const bool geodetic = frame.kind == INSITU_FRAME_GEODETIC;
  if (mesh.is_adaptive() && geodetic)
    throw core::Error(INSITU_ERROR_UNSUPPORTED, "mesh '" + mesh.name() +
                                                    "' is geodetic: adaptive meshes are not "
                                                    "located in longitude and latitude; give it "
                                                    "in local or UTM metres");
  if (mesh.has_faces() && geodetic)
    throw core::Error(INSITU_ERROR_UNSUPPORTED, "mesh '" + mesh.name() +
                                                    "' is geodetic: cells given by faces are not "
                                                    "located in longitude and latitude; give it "
                                                    "in local or UTM metres");
  if (mesh.is_adaptive())
    return std::make_unique<Adaptive>(memory);
  if (mesh.has_faces())
    return std::make_unique<Polyhedral>(memory);
  if (geodetic)
    return std::make_unique<Geodetic>(memory);
  return nullptr;
}

} // namespace insitu::commit
