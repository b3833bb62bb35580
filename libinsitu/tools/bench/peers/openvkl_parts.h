#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "peers/peers.h"
#include "render/frame.h"
#include "workload/amr.h"

/// What needs Open VKL; openvkl_absent.cpp stands in where a build goes without it
/// (-DINSITU_BENCH_OPENVKL=ON).
namespace insitu::bench {

/// Why there is nothing by Open VKL.
inline constexpr const char* no_openvkl =
    "this insitu-bench was built without it (-DINSITU_BENCH_OPENVKL=ON)";

/// Open VKL's unstructured volume on one thread, hexahedra by Newton's method (hexIterative),
/// sampled 1024 points a call; float, as it has it. It names no
/// cells and gives no parametric coordinates. Null without Open VKL.
std::unique_ptr<Peer> make_openvkl(const workload::Mesh& mesh, const std::vector<double>& field);

/// Open VKL's AMR volume, over values in float that were made beforehand.
class OpenVklAmr {
public:
  virtual ~OpenVklAmr() = default;
  /// octant: continuous; finest: linear between cells as wide as the finest, whatever the level.
  enum class Method { octant, finest };

  /// Builds anew, on as many threads as it was made for.
  virtual void build() = 0;
  /// Points that its kernels take abreast on this machine.
  virtual int width() const = 0;
  /// Of what it builds, and of the values.
  virtual std::int64_t bytes() const = 0;
  virtual std::int64_t bytes_values() const = 0;
  /// The points of sample(), brought to float.
  virtual void set_points(std::span<const math::Vec3d> points) = 0;
  /// As many points a call as a thread has; NaN outside. The answer lasts until the next one.
  virtual std::span<const float> sample(Method method, const core::Threads& threads) = 0;
};

/// The blocks must outlive it. Null without Open VKL.
std::unique_ptr<OpenVklAmr> make_openvkl_amr(const workload::AmrMesh& blocks, int threads);

/// How a frame is marched by Open VKL.
enum class OpenVklMarch {
  intervals, ///< 4 x 4 rays abreast, through intervals of its iterator, as in its examples
  packets    ///< the same from bounds to bounds, without the iterator
};

/// A frame's volume by Open VKL on one thread: the samples that render::VolumeMarcher takes without
/// skipping, classified as it does.
class OpenVklFrame {
public:
  virtual ~OpenVklFrame() = default;
  /// Builds anew.
  virtual void build() = 0;
  virtual core::Image draw(OpenVklMarch march) = 0;
  /// Of the frame that was drawn last.
  virtual std::int64_t samples() const = 0;
};

/// What it is given must outlive it. Null without Open VKL.
std::unique_ptr<OpenVklFrame> make_openvkl_frame(const workload::Mesh& mesh,
                                                 const std::vector<double>& field,
                                                 const query::Sampler& sampler,
                                                 const render::FrameSettings& settings);

} // namespace insitu::bench
