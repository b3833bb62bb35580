#include <algorithm>
#include <cmath>

#include "peers/openvkl_device.h"
#include "peers/openvkl_parts.h"

namespace insitu::bench {

namespace {

using math::Vec3d;

class OpenVklPeer : public Peer {
public:
  OpenVklPeer(const workload::Mesh& mesh, const std::vector<double>& field) : mesh_(mesh, field) {}

  const char* name() const override { return "OpenVKL"; }
  bool tells_cells() const override { return false; }
  void build() override { mesh_.build(); }
  void locate(std::span<const Vec3d> points, std::span<std::int64_t> cells,
              std::span<Vec3d>) override {
    run(points, cells, nullptr);
  }
  void sample(std::span<const Vec3d> points, std::span<std::int64_t> cells,
              std::span<double> values) override {
    run(points, cells, values.data());
  }

private:
  void run(std::span<const Vec3d> points, std::span<std::int64_t> cells, double* values) {
    constexpr std::size_t block = 1024; // what is converted stays in the first cache
    vkl_vec3f some[block];
    float found[block];
    for (std::size_t first = 0; first < points.size(); first += block) {
      const std::size_t n = std::min(block, points.size() - first);
      for (std::size_t i = 0; i < n; ++i) {
        const Vec3d& p = points[first + i];
        some[i] = {float(p.x), float(p.y), float(p.z)};
      }
      vklComputeSampleN(passed(mesh_.sampler()), unsigned(n), some, found);
      for (std::size_t i = 0; i < n; ++i) {
        cells[first + i] = std::isnan(found[i]) ? -1 : 0;
        if (values)
          values[first + i] = std::isnan(found[i]) ? 0.0 : double(found[i]);
      }
    }
  }

  OpenVklMesh mesh_;
};

} // namespace

std::unique_ptr<Peer> make_openvkl(const workload::Mesh& mesh, const std::vector<double>& field) {
  return std::make_unique<OpenVklPeer>(mesh, field);
}

} // namespace insitu::bench
