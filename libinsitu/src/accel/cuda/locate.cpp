#include "accel/cuda/locate.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "accel/cuda/locate_kernels.h"
#include "cells/robust_inverse.h"
#include "core/status.h"

namespace insitu::accel::cuda {

namespace {

constexpr std::uint32_t pair_room = 1u << 20;  ///< undecided pairs of a round
constexpr std::uint32_t pair_slice = 1u << 15; ///< of them at a time on the host
constexpr std::int64_t pair_grain = 64;

void copy_to_host(void* to, const void* from, std::size_t bytes, cudaStream_t stream) {
  check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream), "copying answers");
}
void copy_to_device(void* to, const void* from, std::size_t bytes, cudaStream_t stream) {
  check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, stream), "copying points");
}

/// Host memory to pinned or back, by all threads.
void copy_in_parallel(const core::Threads& threads, void* to, const void* from, std::size_t bytes) {
  threads.parallel_for(std::int64_t(bytes), 1 << 20, [&](std::int64_t begin, std::int64_t end) {
    std::memcpy(static_cast<std::byte*>(to) + begin, static_cast<const std::byte*>(from) + begin,
                std::size_t(end - begin));
  });
}

/// Lists of one slice in flight.
struct SliceLists {
  explicit SliceLists(core::Memory& memory)
      : counters(memory), open(memory), pairs(memory),
        left(memory), again{DeviceBuffer<std::uint32_t>(memory),
                            DeviceBuffer<std::uint32_t>(memory)},
        hard(memory), counted(memory) {}
  void make_room(std::uint32_t points) {
    counters.resize_discard(Lists::counter_count);
    counted.resize_discard(Lists::counter_count);
    open.resize_discard(points);
    pairs.resize_discard(pair_room);
    left.resize_discard(pair_room);
    again[0].resize_discard(points);
    again[1].resize_discard(points);
    hard.resize_discard(points);
  }
  Lists view(int round) const {
    Lists lists;
    lists.counters = counters.data();
    lists.open_points = open.data();
    lists.pairs = pairs.data();
    lists.left_pairs = left.data();
    lists.pair_room = pair_room;
    lists.again_points = again[round % 2].data();
    lists.hard_points = hard.data();
    return lists;
  }
  std::int64_t bytes() const {
    return counters.bytes() + open.bytes() + pairs.bytes() + left.bytes() + again[0].bytes() +
           again[1].bytes() + hard.bytes();
  }
  DeviceBuffer<std::uint32_t> counters;
  DeviceBuffer<OpenPoint> open;
  DeviceBuffer<OpenPair> pairs, left;
  DeviceBuffer<std::uint32_t> again[2];
  DeviceBuffer<OwnedPoint> hard;
  PinnedBuffer<std::uint32_t> counted;
};

/// Points and answers of one slice on their way between host and device.
struct Staging {
  explicit Staging(core::Memory& memory) : host(memory), device(memory) {}
  PinnedBuffer<std::byte> host;
  DeviceBuffer<std::byte> device;
};

} // namespace

struct Workspace::Impl {
  explicit Impl(core::Memory& memory)
      : lists{SliceLists(memory), SliceLists(memory)}, staging{Staging(memory), Staging(memory)},
        pair_data(memory), pair_host(memory), decided(memory), decided_host(memory),
        parametric(memory), parametric_host(memory) {}

  std::mutex mutex;
  Stream streams[2];
  SliceLists lists[2];
  Staging staging[2];
  DeviceBuffer<PairData> pair_data;
  PinnedBuffer<PairData> pair_host;
  DeviceBuffer<cells::Reason> decided;
  PinnedBuffer<cells::Reason> decided_host;
  DeviceBuffer<math::Vec3d> parametric;
  PinnedBuffer<math::Vec3d> parametric_host;
};

Workspace::Workspace(core::Memory& memory) : impl_(std::make_unique<Impl>(memory)) {}
Workspace::~Workspace() = default;

std::int64_t Workspace::device_bytes() const {
  std::int64_t sum = impl_->pair_data.bytes() + impl_->decided.bytes() + impl_->parametric.bytes();
  for (int k = 0; k < 2; ++k)
    sum += impl_->lists[k].bytes() + impl_->staging[k].device.bytes();
  return sum;
}

namespace {

/// A slice that has been queued.
struct InFlight {
  LocateArguments arguments;
  cudaStream_t stream;
  SliceLists* lists;
};

/// Queues the locating of a slice, and the counts of what is left to do.
void start(const InFlight& slice, insitu_accuracy accuracy) {
  if (accuracy == INSITU_FAST)
    return launch_locate_fast(slice.arguments, slice.stream);
  const std::size_t bytes = Lists::counter_count * sizeof(std::uint32_t);
  check(cudaMemsetAsync(slice.lists->counters.data(), 0, bytes, slice.stream), "locating points");
  launch_locate(slice.arguments, slice.stream);
  copy_to_host(slice.lists->counted.data(), slice.lists->counters.data(), bytes, slice.stream);
}

/// What the device leaves to the host.
class Settler {
public:
  Settler(Workspace::Impl& work, const core::Threads& threads, InFlight& slice)
      : work_(work), threads_(threads), slice_(slice), stream_(slice.stream) {}

  void run(DeviceCounts& counts) {
    wait();
    counts.candidates_kept += counted(Lists::kept);
    counts.by_tree += slice_.arguments.candidates ? counted(Lists::asked) : slice_.arguments.count;
    for (int round = 1; counted(Lists::open) > 0; ++round) {
      counts.settled_on_host += settle_open();
      const std::uint32_t again = counted(Lists::again);
      if (again == 0)
        break;
      // Once more, with the list of pairs empty. The first of them have room.
      slice_.arguments.subset = slice_.arguments.lists.again_points;
      slice_.arguments.count = again;
      slice_.arguments.lists = slice_.lists->view(round);
      const std::size_t bytes = Lists::hard * sizeof(std::uint32_t); // but those of hard points
      check(cudaMemsetAsync(slice_.lists->counters.data(), 0, bytes, stream_), "locating points");
      launch_locate(slice_.arguments, stream_);
      read_counters();
    }
    settle_hard();
  }

private:
  std::uint32_t counted(Lists::Counter c) const { return slice_.lists->counted[c]; }
  void wait() { check(cudaStreamSynchronize(stream_), "locating points"); }
  void read_counters() {
    copy_to_host(slice_.lists->counted.data(), slice_.lists->counters.data(),
                 Lists::counter_count * sizeof(std::uint32_t), stream_);
    wait();
  }
  /// Brings the vertices of some pairs to the host: of open ones or hard ones.
  template <class Launch>
  const PairData* fetch(Launch launch, std::uint32_t first, std::uint32_t n) {
    work_.pair_data.resize_discard(pair_slice);
    work_.pair_host.resize_discard(pair_slice);
    launch(slice_.arguments, first, n, work_.pair_data.data(), stream_);
    copy_to_host(work_.pair_host.data(), work_.pair_data.data(), n * sizeof(PairData), stream_);
    wait();
    return work_.pair_host.data();
  }

  /// Decides the open points' pairs, exactly; the lowest id that holds a point is its owner.
  /// Returns how many points needed the host.
  std::int64_t settle_open() {
    const std::uint32_t points = counted(Lists::open), again = counted(Lists::again);
    const std::uint32_t pairs = std::min(counted(Lists::pair), pair_room);
    launch_decide_pairs(slice_.arguments, pairs, stream_);
    read_counters();
    const std::int64_t settled = settle_left(counted(Lists::left), points);
    launch_finish(slice_.arguments, points, stream_);
    read_counters(); // hard points may have come
    slice_.lists->counted[Lists::again] = again;
    return settled;
  }

  /// The pairs that the device cannot decide, by exact arithmetic.
  std::int64_t settle_left(std::uint32_t pairs, std::uint32_t points) {
    if (pairs == 0)
      return 0;
    std::vector<OpenPair> left(pairs);
    copy_to_host(left.data(), slice_.lists->left.data(), pairs * sizeof(OpenPair), stream_);
    work_.decided.resize_discard(pair_slice);
    work_.decided_host.resize_discard(pair_slice);
    for (std::uint32_t first = 0; first < pairs; first += pair_slice) {
      const std::uint32_t n = std::min(pair_slice, pairs - first);
      const PairData* data = fetch(launch_gather_left, first, n);
      threads_.parallel_for(n, pair_grain, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t k = begin; k < end; ++k)
          work_.decided_host[std::size_t(k)] = cells::decide(data[k].shape, data[k].x, data[k].p);
      });
      copy_to_device(work_.decided.data(), work_.decided_host.data(), n, stream_);
      launch_take_decided(slice_.arguments, first, n, work_.decided.data(), stream_);
    }
    wait();
    std::vector<bool> seen(points, false);
    std::int64_t settled = 0;
    for (const OpenPair& pair : left) {
      settled += !seen[pair.open];
      seen[pair.open] = true;
    }
    return settled;
  }

  /// Parametric coordinates that Newton's method did not find.
  void settle_hard() {
    const std::uint32_t total = counted(Lists::hard);
    for (std::uint32_t first = 0; first < total; first += pair_slice) {
      const std::uint32_t n = std::min(pair_slice, total - first);
      const PairData* data = fetch(launch_gather_hard, first, n);
      work_.parametric_host.resize_discard(pair_slice);
      work_.parametric.resize_discard(pair_slice);
      threads_.parallel_for(n, pair_grain, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t k = begin; k < end; ++k)
          work_.parametric_host[std::size_t(k)] =
              cells::robust_inverse(data[k].shape, data[k].x, data[k].p);
      });
      copy_to_device(work_.parametric.data(), work_.parametric_host.data(), n * sizeof(math::Vec3d),
                     stream_);
      launch_finish_at(slice_.arguments, slice_.lists->hard.data() + first, work_.parametric.data(),
                       n, stream_);
      wait();
    }
  }

  Workspace::Impl& work_;
  const core::Threads& threads_;
  InFlight& slice_;
  cudaStream_t stream_;
};

} // namespace

mesh::Shape only_shape(const mesh::MeshView& mesh) {
  if (mesh.piece_count != 1 || (mesh.pieces[0].layout != mesh::CellLayout::uniform &&
                                mesh.pieces[0].layout != mesh::CellLayout::block))
    return mesh::Shape::none;
  const mesh::Shape shape = mesh.pieces[0].uniform_shape;
  return shape == mesh::Shape::tetrahedron || shape == mesh::Shape::hexahedron ? shape
                                                                               : mesh::Shape::none;
}

namespace {

/// One query of at most most_fields fields.
class Locate {
public:
  Locate(const DeviceMesh& mesh, const DeviceTree* tree, Workspace::Impl& work,
         const core::Threads& threads, const DeviceQuery& query, const CandidatesOf* candidates)
      : work_(work), threads_(threads), query_(query), candidates_(candidates) {
    const mesh::MeshView& view = mesh.host_view();
    common_.mesh = mesh.view();
    common_.shape = only_shape(view);
    if (view.piece_count > 0)
      common_.piece = view.pieces[0];
    if (tree)
      common_.tree = tree->view();
    common_.alone = view.free_of_folds && (query.accuracy != INSITU_EXACT || view.covers_once);
    common_.out.field_count = int(query.fields.size());
    common_.out.needs_map = query.parametric != nullptr;
    for (const mesh::FieldView& field : query.fields)
      common_.out.needs_map |= field.association == INSITU_VERTEX;
    common_.out.fields = mesh.fields(query.fields, work.streams[0].get());
  }

  DeviceCounts run() {
    query_.on_device ? run_on_device() : run_from_host();
    return counts_;
  }

private:
  /// points: of the slice; outputs are set.
  void launch(InFlight& slice, int place) {
    slice.lists = &work_.lists[place];
    LocateArguments& a = slice.arguments;
    if (candidates_)
      set_candidates(a, slice.stream);
    if (query_.accuracy != INSITU_FAST) {
      slice.lists->make_room(a.count);
      a.lists = slice.lists->view(0);
    }
    start(slice, query_.accuracy);
  }
  void set_candidates(LocateArguments& a, cudaStream_t stream) const {
    const Candidates found = (*candidates_)(a.points, a.count, stream);
    a.candidates = found.cells;
    a.others = found.others;
  }
  void settle(InFlight& slice) {
    if (query_.accuracy != INSITU_FAST)
      return Settler(work_, threads_, slice).run(counts_);
    (candidates_ ? counts_.candidates_kept : counts_.by_tree) += slice.arguments.count;
  }

  void run_on_device() {
    for (std::int64_t first = 0; first < query_.count; first += device_slice) {
      InFlight slice{common_, static_cast<cudaStream_t>(query_.stream), nullptr};
      LocateArguments& a = slice.arguments;
      a.points = query_.points + 3 * first;
      a.count = std::uint32_t(std::min<std::int64_t>(device_slice, query_.count - first));
      a.out.cells = query_.cells ? query_.cells + first : nullptr;
      a.out.parametric = query_.parametric ? query_.parametric + 3 * first : nullptr;
      a.out.reasons = query_.reasons ? query_.reasons + first : nullptr;
      for (std::size_t f = 0; f < query_.fields.size(); ++f)
        a.out.values[f] = query_.values[f] + first * query_.fields[f].components;
      launch(slice, 0);
      settle(slice);
    }
  }

  /// Two slices at a time, each on a stream of its own: one is computed while the other's answers
  /// come back. Rays' candidates have one array, so their slices take turns.
  void run_from_host() {
    InFlight slices[2];
    std::uint32_t counts[2];
    std::int64_t firsts[2];
    int waiting = -1;
    int next = 0;
    for (std::int64_t first = 0; first < query_.count; first += host_slice) {
      const int k = next;
      firsts[k] = first;
      counts[k] = std::uint32_t(std::min<std::int64_t>(host_slice, query_.count - first));
      send(slices[k], k, first, counts[k]);
      if (waiting >= 0)
        receive(slices[waiting], waiting, firsts[waiting], counts[waiting]);
      waiting = k;
      if (candidates_) {
        receive(slices[k], k, first, counts[k]);
        waiting = -1;
      } else {
        next = 1 - k;
      }
    }
    if (waiting >= 0)
      receive(slices[waiting], waiting, firsts[waiting], counts[waiting]);
  }

  template <class F>
  void for_outputs(std::int64_t first, std::uint32_t n, F&& f) const {
    std::size_t offset = std::size_t(n) * 3 * sizeof(double);
    const auto one = [&](auto* array, std::size_t components, std::size_t which) {
      if (!array)
        return;
      const std::size_t item = components * sizeof *array;
      f(array + first * std::int64_t(components), offset, item * n, which);
      offset += (item * n + 15) / 16 * 16;
    };
    one(query_.cells, 1, 0);
    one(query_.parametric, 3, 1);
    for (std::size_t k = 0; k < query_.fields.size(); ++k)
      one(query_.values[k], std::size_t(query_.fields[k].components), 3 + k);
    one(query_.reasons, 1, 2);
  }

  void send(InFlight& slice, int place, std::int64_t first, std::uint32_t n) {
    slice = {common_, work_.streams[place].get(), nullptr};
    Staging& staging = work_.staging[place];
    LocateArguments& a = slice.arguments;
    const std::size_t points = std::size_t(n) * 3 * sizeof(double);
    std::size_t bytes = points;
    for_outputs(first, n, [&](void*, std::size_t offset, std::size_t size, std::size_t) {
      bytes = (offset + size + 15) / 16 * 16;
    });
    staging.host.resize_discard(bytes);
    staging.device.resize_discard(bytes);
    copy_in_parallel(threads_, staging.host.data(), query_.points + 3 * first, points);
    copy_to_device(staging.device.data(), staging.host.data(), points, slice.stream);
    a.points = reinterpret_cast<const double*>(staging.device.data());
    a.count = n;
    for_outputs(first, n, [&](void*, std::size_t offset, std::size_t, std::size_t which) {
      std::byte* p = staging.device.data() + offset;
      if (which == 0)
        a.out.cells = reinterpret_cast<std::int64_t*>(p);
      else if (which == 1)
        a.out.parametric = reinterpret_cast<double*>(p);
      else if (which == 2)
        a.out.reasons = reinterpret_cast<std::uint8_t*>(p);
      else
        a.out.values[which - 3] = reinterpret_cast<double*>(p);
    });
    launch(slice, place);
  }

  void receive(InFlight& slice, int place, std::int64_t first, std::uint32_t n) {
    settle(slice);
    Staging& staging = work_.staging[place];
    std::size_t begin = std::size_t(n) * 3 * sizeof(double), end = begin;
    for_outputs(first, n, [&](void*, std::size_t offset, std::size_t size, std::size_t) {
      end = offset + size;
    });
    if (end > begin)
      copy_to_host(staging.host.data() + begin, staging.device.data() + begin, end - begin,
                   slice.stream);
    check(cudaStreamSynchronize(slice.stream), "copying answers");
    for_outputs(first, n, [&](void* to, std::size_t offset, std::size_t size, std::size_t) {
      copy_in_parallel(threads_, to, staging.host.data() + offset, size);
    });
  }

  Workspace::Impl& work_;
  const core::Threads& threads_;
  const DeviceQuery& query_;
  const CandidatesOf* candidates_;
  LocateArguments common_;
  DeviceCounts counts_;
};

} // namespace

DeviceCounts locate_points(const DeviceMesh& mesh, const DeviceTree* tree, Workspace& workspace,
                           const core::Threads& threads, const DeviceQuery& query,
                           const CandidatesOf* candidates) {
  const std::scoped_lock lock(workspace.impl().mutex);
  DeviceCounts counts;
  const std::size_t fields = query.fields.size();
  for (std::size_t first = 0; first == 0 || first < fields; first += most_fields) {
    DeviceQuery part = query;
    part.fields = query.fields.subspan(first, std::min<std::size_t>(most_fields, fields - first));
    part.values = fields > 0 ? query.values + first : nullptr;
    if (first > 0) {
      part.cells = nullptr;
      part.parametric = nullptr;
      part.reasons = nullptr;
    }
    const DeviceCounts one = Locate(mesh, tree, workspace.impl(), threads, part, candidates).run();
    if (first == 0)
      counts = one;
  }
  return counts;
}

void advance_tracers(const DeviceMesh& mesh, const DeviceTree& tree, const DeviceTracers& tracers) {
  if (tracers.velocity.components != 3)
    throw core::Error(INSITU_ERROR_FIELD, std::string("field '") + tracers.velocity.name +
                                              "': " + std::to_string(tracers.velocity.components) +
                                              " components; a velocity has 3");
  const auto stream = static_cast<cudaStream_t>(tracers.stream);
  LocateArguments a;
  const mesh::MeshView& view = mesh.host_view();
  a.mesh = mesh.view();
  a.shape = only_shape(view);
  if (view.piece_count > 0)
    a.piece = view.pieces[0];
  a.tree = tree.view();
  a.alone = view.free_of_folds;
  a.out.fields = mesh.fields(std::span(&tracers.velocity, 1), stream);
  launch_advance(a, tracers, stream);
}

} // namespace insitu::accel::cuda
