#pragma once

#include <cstdint>

/// Locator methods and where they run; the table is in doc/design/tree.md.
namespace insitu::accel {

enum class Method : std::uint8_t {
  bvh,                  ///< boxes of cells, point traversal
  user_geometry,        ///< cells as user primitives, vanishing ray
  replicated_faces,     ///< inward triangles of each cell, short ray, back faces culled
  shared_faces,         ///< unique faces with the cells on either side, short ray
  shared_bilinear_faces ///< the same; curved quads as bounding tetrahedra, one patch test
};
constexpr int method_count = 5;

enum class Backend : std::uint8_t { cpu, cuda, optix };
constexpr int backend_count = 3;

constexpr const char* name(Method method) {
  constexpr const char* names[] = {"bvh", "user_geometry", "replicated_faces", "shared_faces",
                                   "shared_bilinear_faces"};
  return names[int(method)];
}
constexpr const char* name(Backend backend) {
  constexpr const char* names[] = {"cpu", "cuda", "optix"};
  return names[int(backend)];
}

constexpr bool uses_faces(Method method) {
  return method >= Method::replicated_faces;
}

/// Backends that have the method: ray methods need ray tracing, cuda has `bvh` alone.
constexpr bool has(Backend backend, Method method) {
  return backend == Backend::cpu || (backend == Backend::cuda) == (method == Method::bvh);
}

/// How the tree of `bvh` is built.
enum class Builder : std::uint8_t { automatic, morton, surface_area };

/// No cell (outside the mesh) or no vertex, in 32-bit flat ids.
constexpr std::uint32_t none = 0xffffffffu;

} // namespace insitu::accel
