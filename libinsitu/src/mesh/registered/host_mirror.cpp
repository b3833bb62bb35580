#include "mesh/registered/host_mirror.h"

#include "core/status.h"

namespace insitu::mesh {

HostMirror::HostMirror(const Mesh& mesh, Copy copy) : view_(mesh.view()) {
  mesh.visit_arrays([&](const ExternalArray& array, const std::string&, Mesh::ArrayKind kind) {
    const ExternalArray::Range range = array.range();
    if (kind == Mesh::ArrayKind::field || range.begin == range.end)
      return;
    auto copied = std::make_unique<Range>();
    copied->of = range;
    if (array.memory == INSITU_DEVICE) {
      copied->bytes.resize(range.end - range.begin);
      copy(copied->bytes.data(), reinterpret_cast<const std::byte*>(range.begin),
           copied->bytes.size());
    }
    ranges_.push_back(std::move(copied));
  });
  pieces_.assign(view_.pieces, view_.pieces + view_.piece_count);
  for (PieceView& piece : pieces_)
    for_each_array(piece, [&](const std::byte*& p, std::int64_t count, const char*) {
      if (!p || count == 0)
        return;
      const auto address = reinterpret_cast<std::uintptr_t>(p);
      for (const auto& range : ranges_)
        if (address >= range->of.begin && address < range->of.end) {
          if (!range->bytes.empty())
            p = range->bytes.data() + (address - range->of.begin);
          return;
        }
    });
  view_.pieces = pieces_.data();
}

} // namespace insitu::mesh
