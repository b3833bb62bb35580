#include "query/locators.h"

#include <algorithm>
#include <cstring>

#include "mesh/registered/mesh.h"
#include "query/batch/device_calls.h"
#include "query/batch/ray_method.h"

namespace insitu::query {

using accel::Backend;
using accel::Method;

void Locators::decide(bool on_device, const std::string& mesh_name, const core::Log& log) {
  const LocatorPick pick = pick_locator(choice_, on_device);
  if (!pick.fallback.empty() && pick.fallback != said_) {
    said_ = pick.fallback;
    log.warning("mesh '" + mesh_name + "', " + pick.fallback);
  }
  pending_ = pending_ || pick.method != pick_.method || pick.backend != pick_.backend;
  pick_ = pick;
}

void Locators::make_faces(HostView host, const core::Threads& threads) {
  if (pick_.method != Method::bvh)
    faces_.build(host(), threads);
  else
    faces_ = accel::MeshFaces(*memory_);
}

void Locators::commit(const mesh::Mesh& mesh, HostView host, std::uint32_t what,
                      const core::Threads& threads) {
  const bool anew = pending_ || (what & INSITU_CHANGED_TOPOLOGY);
  const bool rebuild = anew || (what & rebuild_due);
  const bool refit = !rebuild && (what & INSITU_CHANGED_GEOMETRY);
  if (pending_) {
    chosen_.reset();
    rays_.reset();
    device_.reset();
  }
  pending_ = true; // until done: what fails leaves nothing that answers
  const bool on_cpu = pick_.backend == Backend::cpu;
  const bool by_rays = pick_.method != Method::bvh;
  if (!on_cpu) {
    if (!device_)
      device_ = make_device_locator(pick_.backend, pick_.method, *memory_);
    if (!chosen_)
      chosen_ = std::make_unique<DeviceCalls>(*device_,
                                              [this](const DeviceCounts& counts) { note(counts); });
    device_->commit(mesh, host, anew ? std::uint32_t(INSITU_CHANGED_ALL) : what, &faces_, threads);
  } else if (by_rays) {
    if (!rays_)
      rays_ = accel::make_embree_locator(pick_.method, *memory_);
    if (!chosen_)
      chosen_ = std::make_unique<RayMethod>(*rays_, ray_counts_);
    if (rebuild)
      rays_->build(mesh.view(), &faces_, threads);
    else if (refit)
      rays_->refit(mesh.view(), threads);
  }
  if (rays_ || device_) {
    upkeep_.builds += rebuild;
    upkeep_.refits += refit;
  }
  pending_ = false;
}

void Locators::note(const DeviceCounts& counts) const {
  ray_counts_.kept += counts.candidates_kept;
  ray_counts_.by_tree += counts.by_tree;
  settled_on_host_ += counts.settled_on_host;
}

insitu_locator_info Locators::info(const accel::Tree& tree) const {
  insitu_locator_info info = insitu_locator_info_default();
  info.method = insitu_method(INSITU_METHOD_BVH + int(pick_.method));
  info.backend = insitu_backend(INSITU_BACKEND_CPU + int(pick_.backend));
  std::strncpy(info.reason, pick_.reason.c_str(), sizeof info.reason - 1);
  info.primitives = tree.cell_count();
  info.bytes = info.bytes_peak = tree.bytes();
  if (rays_) {
    const accel::RayLocatorReport r = rays_->report();
    info.primitives = r.primitives;
    info.bytes += r.bytes + faces_.bytes();
    info.bytes_peak += r.peak_bytes + faces_.bytes();
  }
  if (device_) {
    const DeviceReport r = device_->report();
    info.primitives = r.primitives;
    info.bytes += r.bytes;
    info.bytes_peak += std::max(r.peak_bytes, r.bytes);
    info.bytes_copied = r.bytes_copied;
  }
  info.kept = ray_counts_.kept;
  info.by_neighbour = ray_counts_.by_neighbour;
  info.by_tree = ray_counts_.by_tree;
  info.settled_on_host = settled_on_host_;
  return info;
}

} // namespace insitu::query
