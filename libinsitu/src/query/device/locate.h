#pragma once

#include <cstdint>
#include <memory>
#include <mutex>

#include "accel/cuda/device_tree.h"
#include "core/parallel.h"
#include "device/device_mesh.h"
#include "query/device/device_locator.h"

namespace insitu::query::on_device {

using accel::cuda::DeviceTree;
using device::DeviceMesh;
using device::StreamHandle;

/// Memory of queries: lists of points for the host, staging. One query at a time uses it; others
/// wait.
class Workspace {
public:
  explicit Workspace(core::Memory& memory);
  ~Workspace();
  struct Impl;
  Impl& impl() { return *impl_; }
  std::int64_t device_bytes() const;

private:
  std::unique_ptr<Impl> impl_;
};

/// Most points of a slice.
constexpr std::uint32_t host_slice = 1u << 20, device_slice = 1u << 22;

/// What a ray method finds for some points in device memory: flat ids or `none`, on the device, in
/// the order of the points. others: cells to look at next, or null.
struct Candidates {
  const std::uint32_t* cells = nullptr;
  const std::uint32_t* others = nullptr;
};
/// Written on the stream. The arrays may be reused for the next slice on the same stream, or once
/// that stream has been waited for.
using CandidatesOf =
    core::FunctionRef<Candidates(const double* points, std::uint32_t count, StreamHandle)>;

/// Answers a query, slice by slice; points and outputs lie on the host or on the device
/// (query.on_device, on query.stream). tree may be null in `fast` with candidates.
///
/// candidates (may be null): a point's candidates are looked at first. In `fast` it is the answer.
/// In `standard` and `exact` it answers alone where it is proven to hold the point strictly inside,
/// on a mesh free of folds (and in `exact` one that covers once); else the tree is asked, below the
/// candidate's id if that is proven. All other points go through the tree.
DeviceCounts locate_points(const DeviceMesh& mesh, const DeviceTree* tree, Workspace& workspace,
                           const core::Threads& threads, const DeviceQuery& query,
                           const CandidatesOf* candidates);

} // namespace insitu::query::on_device
