#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/camera/camera.h"
#include "render/clip.h"
#include "render/surface/isosurface.h"

namespace insitu::render {

/// Finds the hits of a screen tile's rays with all isosurfaces, cell by cell: the cells that hold a
/// value come nearest first, and each is solved for all pixels that it covers at once
/// (render/surface/tiles/patches.h). Where a proof is wanting - on silhouettes, on faces of cells,
/// in folded cells - the search by the ray (CellRoots, exact) takes cell and pixel. So the hits are
/// those of that search. One object is scratch of one thread.
class IsosurfaceTile {
public:
  static constexpr int side = 64;

  IsosurfaceTile();
  ~IsosurfaceTile();

  /// Pixels [x0, x1) x [y0, y1), at most side x side.
  void trace(const IsosurfaceTracer& surfaces, const RayGenerator& rays,
             const std::vector<Clip>& clips, int x0, int y0, int x1, int y1, SurfaceCounts& counts);
  /// Appends a pixel's hits in depth order, up to and including the first opaque one, without
  /// colours, as IsosurfaceTracer::trace does.
  void hits(int x, int y, std::vector<SurfaceHit>& out);
  /// Appends them as cells have them; see IsosurfaceTracer::collect. Gradients are there if hits
  /// are lit.
  void raw_hits(int x, int y, std::vector<SurfaceHit>& out);

private:
  struct Work;
  std::unique_ptr<Work> work_;
};

} // namespace insitu::render
