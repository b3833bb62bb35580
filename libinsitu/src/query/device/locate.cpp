#include "query/device/locate.h"

#include <algorithm>
#include <cstring>

#include "core/status.h"
#include "query/device/settle.h"

namespace insitu::query::on_device {

Workspace::Workspace(core::Memory& memory) : impl_(std::make_unique<Impl>(memory)) {}
Workspace::~Workspace() = default;

std::int64_t Workspace::device_bytes() const {
  std::int64_t sum = impl_->pair_data.bytes() + impl_->decided.bytes() + impl_->parametric.bytes();
  for (int k = 0; k < 2; ++k)
    sum += impl_->lists[k].bytes() + impl_->staging[k].device.bytes();
  return sum;
}

namespace {

/// Host memory to pinned or back, by all threads.
void copy_in_parallel(const core::Threads& threads, void* to, const void* from, std::size_t bytes) {
  threads.parallel_for(std::int64_t(bytes), 1 << 20, [&](std::int64_t begin, std::int64_t end) {
    std::memcpy(static_cast<std::byte*>(to) + begin, static_cast<const std::byte*>(from) + begin,
                std::size_t(end - begin));
  });
}

/// Queues the locating of a slice, and the counts of what is left to do.
void start(const InFlight& slice, insitu_accuracy accuracy) {
  if (accuracy == INSITU_FAST)
    return launch_locate_fast(slice.arguments, slice.stream);
  const std::size_t bytes = Lists::counter_count * sizeof(std::uint32_t);
  device::fill(slice.lists->counters.data(), 0, bytes, slice.stream, "locating points");
  launch_locate(slice.arguments, slice.stream);
  copy_to_host(slice.lists->counted.data(), slice.lists->counters.data(), bytes, slice.stream);
}

/// One query of at most most_fields fields.
class Locate {
public:
  Locate(const DeviceMesh& mesh, const DeviceTree* tree, Workspace::Impl& work,
         const core::Threads& threads, const DeviceQuery& query, const CandidatesOf* candidates)
      : work_(work), threads_(threads), query_(query), candidates_(candidates) {
    const mesh::MeshView& view = mesh.host_view();
    common_.in.mesh = mesh.in_kernels();
    if (tree)
      common_.in.tree = tree->view();
    common_.in.alone = view.free_of_folds && (query.accuracy != INSITU_EXACT || view.covers_once);
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
  void set_candidates(LocateArguments& a, StreamHandle stream) const {
    const Candidates found = (*candidates_)(a.points, a.count, stream);
    a.candidates = found.cells;
    a.others = found.others;
  }
  void settle(InFlight& slice) {
    if (query_.accuracy != INSITU_FAST)
      settle_slice(work_, threads_, slice, counts_);
  }

  void run_on_device() {
    for (std::int64_t first = 0; first < query_.count; first += device_slice) {
      InFlight slice{common_, static_cast<StreamHandle>(query_.stream), nullptr};
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
    device::wait(slice.stream, "copying answers");
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

} // namespace insitu::query::on_device
