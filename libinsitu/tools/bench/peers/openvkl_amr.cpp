#include <algorithm>
#include <limits>

#include "measure.h"
#include "peers/openvkl_device.h"
#include "peers/openvkl_parts.h"

namespace insitu::bench {

namespace {

class Amr : public OpenVklAmr {
public:
  Amr(const workload::AmrMesh& blocks, int threads)
      : values_(blocks.values.begin(), blocks.values.end()),
        cells_a_block_(std::size_t(blocks.cells_a_block())) {
    openvkl_device(threads);
    for (int level = 0; level < blocks.level_count; ++level)
      widths_.push_back(float(blocks.width(level)));
    for (const workload::AmrMesh::Block& b : blocks.blocks) {
      const int x = int(b.lower[0]), y = int(b.lower[1]), z = int(b.lower[2]);
      const int last = blocks.side - 1; // its upper bounds are cells inside
      bounds_.push_back({{x, y, z}, {x + last, y + last, z + last}});
      levels_.push_back(b.level);
    }
  }

  void build() override {
    sampler_[0].reset();
    sampler_[1].reset();
    volume_.reset();
    data_.clear();
    const std::int64_t before = heap_bytes();
    volume_ = OpenVkl<VKLVolume>(vklNewVolume(openvkl_device(), "amr"));
    std::vector<VKLData> data;
    for (std::size_t b = 0; b < bounds_.size(); ++b) {
      data_.emplace_back(vklNewData(openvkl_device(), cells_a_block_, VKL_FLOAT,
                                    values_.data() + b * cells_a_block_, VKL_DATA_SHARED_BUFFER,
                                    0));
      data.push_back(*data_.back());
    }
    OpenVkl<VKLData> all(
        vklNewData(openvkl_device(), data.size(), VKL_DATA, data.data(), VKL_DATA_DEFAULT, 0));
    vklSetData(*volume_, "block.data", *all);
    set_shared(*volume_, "block.bounds", bounds_, VKL_BOX3I);
    set_shared(*volume_, "block.level", levels_, VKL_INT);
    set_shared(*volume_, "cellWidth", widths_, VKL_FLOAT);
    vklSetFloat(*volume_, "background", std::numeric_limits<float>::quiet_NaN());
    vklCommit(*volume_);
    for (const Method method : {Method::octant, Method::finest}) {
      auto& sampler = sampler_[int(method)];
      sampler = OpenVkl<VKLSampler>(vklNewSampler(*volume_));
      vklSetInt(*sampler, "method", method == Method::octant ? VKL_AMR_OCTANT : VKL_AMR_FINEST);
      vklCommit(*sampler);
    }
    throw_openvkl_error();
    bytes_ = heap_bytes() - before;
  }
  int width() const override { return vklGetNativeSIMDWidth(openvkl_device()); }
  std::int64_t bytes() const override { return bytes_; }
  std::int64_t bytes_values() const override {
    return std::int64_t(values_.size() * sizeof(float));
  }

  void set_points(std::span<const math::Vec3d> points) override {
    points_.clear();
    for (const math::Vec3d& p : points)
      points_.push_back({float(p.x), float(p.y), float(p.z)});
    answers_.assign(points.size(), 0.0f); // touches pages
  }
  std::span<const float> sample(Method method, const core::Threads& threads) override {
    auto& sampler = *sampler_[int(method)];
    const auto n = std::int64_t(points_.size());
    const std::int64_t grain = threads.count() == 1 ? std::max<std::int64_t>(1, n) : 65536;
    threads.parallel_for(n, grain, [&](std::int64_t begin, std::int64_t end) {
      vklComputeSampleN(passed(sampler), unsigned(end - begin), points_.data() + begin,
                        answers_.data() + begin);
    });
    return answers_;
  }

private:
  struct Bounds {
    int lower[3], upper[3];
  };
  std::vector<float> values_, widths_;
  std::size_t cells_a_block_;
  std::vector<Bounds> bounds_;
  std::vector<int> levels_;
  std::vector<OpenVkl<VKLData>> data_;
  OpenVkl<VKLVolume> volume_;
  OpenVkl<VKLSampler> sampler_[2];
  std::vector<vkl_vec3f> points_;
  std::vector<float> answers_;
  std::int64_t bytes_ = 0;
};

} // namespace

std::unique_ptr<OpenVklAmr> make_openvkl_amr(const workload::AmrMesh& blocks, int threads) {
  return std::make_unique<Amr>(blocks, threads);
}

} // namespace insitu::bench
