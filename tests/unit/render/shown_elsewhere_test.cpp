#include <gtest/gtest.h>

#include "render/processes/shown_elsewhere.h"
#include "unit/render/render_mesh.h"

namespace insitu::test {
namespace {

using render::Macrocells;
using render::Majorants;

/// Of many processes, of which one is here; the others show what it shows, or nothing.
class ManyProcesses final : public parallel::World {
public:
  ManyProcesses(int size, bool others_show) : size_(size), others_show_(others_show) {}
  int rank() const override { return 0; }
  int size() const override { return size_; }
  int on_this_node() const override { return 1; }

private:
  void do_reduce(std::span<std::int64_t> values, parallel::Reduction) override {
    for (std::int64_t& v : values)
      v = std::int64_t(std::uint64_t(v) * std::uint64_t(others_show_ ? size_ : 1));
  }
  void do_broadcast(std::span<std::byte>, int) override {}
  void swap_numbers(std::span<const std::int64_t>, std::span<std::int64_t>) override {}
  void transfer(std::span<const Outgoing>, std::span<const Incoming>) override {}

  int size_;
  bool others_show_;
};

/// Each part counts the processes that show something there, and no count runs over into the next
/// part's.
TEST(ShownElsewhere, CountsAnyNumberOfProcesses) {
  RenderMesh mesh(3, Shape::hexahedron, 0.0); // the unit cube
  const auto field = mesh.field("f", INSITU_VERTEX, [](const Vec3d&) { return 0.5; });
  const query::Sampler sampler = mesh.sampler();
  const Macrocells cells(sampler, field, mesh.committed.threads, mesh.committed.memory, 8);
  const Majorants nothing(cells, {render::ColorMap::built_in("viridis"), 0, 1, {{0, 0}}},
                          mesh.committed.threads, mesh.committed.memory);
  // The cube fills the middle of the part with these numbers, which is two wide.
  for (const int part : {0, 1, 3, 31})
    for (const int processes : {2, 32768, 65535, 65536, 65537, 1 << 20})
      for (const bool others_show : {false, true}) {
        const double low = -0.5 - 2.0 * part;
        render::ShownElsewhere elsewhere({{low, low, low}, {low + 64, low + 64, low + 64}},
                                         processes);
        ManyProcesses world(processes, others_show);
        elsewhere.note(sampler.tree(), nullptr, 0.1);
        elsewhere.exchange(world);
        const auto with = elsewhere.with(nothing, mesh.committed.memory);
        const std::int64_t count = with->grid().count();
        std::int64_t shown = 0;
        for (std::int64_t m = 0; m < count; ++m)
          shown += with->opacity(m) > 0;
        EXPECT_EQ(shown, others_show ? count : 0) << processes << " processes, part " << part;
      }
}

} // namespace
} // namespace insitu::test
