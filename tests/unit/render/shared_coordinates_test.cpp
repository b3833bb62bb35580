// A sample's coordinates hang on its cell and its ray alone, not on what else the process has:
// where coordinates differ in their last bits, so do some colours.
#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>

#include "render/structures/structures.h"
#include "unit/parallel/threaded_world.h"
#include "unit/render/block_mesh.h"
#include "unit/render/parted_mesh.h"

namespace insitu::test {
namespace {

using render::FrameImages;

double wave(const Vec3d& p) {
  return 0.5 + 0.25 * std::sin(9 * p.x + 2 * p.y) + 0.25 * std::cos(7 * p.z - 3 * p.y);
}

/// Some layers of cells of a block, and their field.
class BlockPart {
public:
  /// Cells first to behind - 1 along z of n^3 about [0,1]^3, in uneven planes if rectilinear.
  BlockPart(insitu_block_kind kind, int n, int first, int behind) : first_cell_(first * n * n) {
    if (first == behind)
      return;
    insitu_block block = insitu_block_default();
    block.kind = kind;
    const double origin[3] = {0.013, -0.007, 0.003};
    for (int a = 0; a < 3; ++a) {
      block.vertices[a] = a == 2 ? behind - first + 1 : n + 1;
      const bool uniform = kind == INSITU_BLOCK_UNIFORM;
      for (int i = 0; i <= n; ++i)
        planes_[a].push_back(origin[a] + (i + (uniform ? 0.0 : 0.3 * std::sin(i))) * 0.97 / n);
      if (uniform) {
        block.origin[a] = origin[a];
        block.spacing[a] = 0.97 / n;
        block.first[a] = a == 2 ? first : 0;
      } else {
        block.coordinates[a] = insitu_array_of(planes_[a].data() + (a == 2 ? first : 0),
                                               INSITU_FLOAT64, block.vertices[a], 1);
      }
    }
    for (int k = first; k <= behind; ++k)
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i)
          values_.push_back(wave({planes_[0][std::size_t(i)], planes_[1][std::size_t(j)],
                                  planes_[2][std::size_t(k)]}));
    mesh::Mesh& mesh = committed_.mesh.mesh();
    mesh.set_block(0, &block);
    const insitu_array v =
        insitu_array_of(values_.data(), INSITU_FLOAT64, std::int64_t(values_.size()), 1);
    mesh.set_field(0, "f", INSITU_VERTEX, &v, 1);
    committed_.commit();
  }

  void meet_others(parallel::World& world) {
    committed_.mesh.set_whole_facts(
        render::whole_facts(world, mesh::find_facts(committed_.mesh.mesh().view(), nullptr)));
  }
  render::ScalarField field() const {
    if (values_.empty())
      return {{"f", INSITU_VERTEX, 1, nullptr, false}, -1};
    return {committed_.mesh.mesh().field("f"), -1};
  }
  render::FramePart part(parallel::World& world) const {
    return {world, committed_.mesh.mesh().view().own_cell_count(),
            [this](std::int64_t flat) { return first_cell_ + flat; }};
  }
  query::Sampler sampler() const { return committed_.mesh.own_sampler(); }

  core::Memory& memory() { return committed_.memory; }

private:
  std::int64_t first_cell_;
  std::vector<double> planes_[3], values_;
  fixtures::Committed committed_{1};
};

/// The same of a mesh without a structure.
class CellPart {
public:
  CellPart(const TestMesh& whole, int process, int processes)
      : mesh_(
            whole,
            [=](std::size_t, const Vec3d& p) {
              return std::clamp(int(p.z * processes), 0, processes - 1) == process ? 0 : 1;
            },
            0),
        field_(mesh_.field("f", INSITU_VERTEX, wave)) {}

  void meet_others(parallel::World& world) { mesh_.meet_others(world, false); }
  render::ScalarField field() const { return mesh_.known(field_); }
  render::FramePart part(parallel::World& world) const { return mesh_.part(world); }
  query::Sampler sampler() const { return mesh_.sampler(); }
  core::Memory& memory() { return mesh_.committed.memory; }

private:
  PartedMesh mesh_;
  render::ScalarField field_;
};

render::FrameSettings shaded(const render::ScalarField& field, int pixels) {
  render::FrameSettings s = box_frame(pixels);
  s.volume = render::VolumeSettings{
      field, {render::ColorMap::built_in("viridis"), 0.0, 1.0, {{0, 0.1}, {1, 0.4}}}};
  s.volume->unit_distance = 0.1;
  s.volume->step = 0.01;
  s.volume->shading = true;
  return s;
}

/// make(process, processes): what a process has. How many numbers of the image differ.
template <class Make>
void expect_same(const Make& make, int pixels) {
  std::vector<float> one;
  for (const int processes : {1, 2, 4}) {
    std::vector<float> drawn;
    run_processes(processes, [&](parallel::World& world) {
      auto part = make(world.rank(), processes);
      part.meet_others(world);
      render::Structures structures(part.memory());
      const core::Threads threads(1);
      structures.begin(part.sampler(), 0, 0, threads);
      const render::FrameSettings settings = shaded(part.field(), pixels);
      const FrameImages images =
          processes == 1 ? render::render_frame(part.sampler(), settings, threads, part.memory())
                         : render::render_shared_frame(part.part(world), part.sampler(), settings,
                                                       structures, threads);
      if (world.is_root())
        drawn.assign(images.color.rgba.begin(), images.color.rgba.end());
    });
    if (processes == 1)
      one = drawn;
    ASSERT_EQ(one.size(), drawn.size());
    std::size_t seen = 0, differing = 0;
    for (std::size_t i = 0; i < one.size(); ++i) {
      seen += one[i] > 0;
      differing += std::memcmp(&one[i], &drawn[i], sizeof(float)) != 0;
    }
    EXPECT_GT(seen, one.size() / 8);
    EXPECT_EQ(differing, 0u) << processes << " processes, of " << one.size() << " numbers";
  }
}

/// Bundles whose samples are claimed by cells in one process, and located one by one in another.
TEST(SharedCoordinates, CellsAsFineAsSamples) {
  const TestMesh whole = box_cells(60, Shape::hexahedron, 0.25);
  expect_same([&](int process, int processes) { return CellPart(whole, process, processes); }, 128);
}

/// One process has all the cells that fold.
TEST(SharedCoordinates, SomeCellsFold) {
  for (const double folded : {0.001, 0.3}) {
    TestMesh whole = box_cells(12, Shape::hexahedron, 0.25);
    for (std::size_t c = 0; c < whole.cells.size() / 3; ++c)
      if (core::random_unit(5, c, 0) < folded)
        std::swap(whole.cells[c].vertices[0], whole.cells[c].vertices[6]);
    SCOPED_TRACE(folded);
    expect_same([&](int process, int processes) { return CellPart(whole, process, processes); },
                128);
  }
}

TEST(SharedCoordinates, LayersOfABlock) {
  for (const insitu_block_kind kind : {INSITU_BLOCK_UNIFORM, INSITU_BLOCK_RECTILINEAR}) {
    constexpr int n = 13;
    SCOPED_TRACE(testing::Message() << "kind " << kind);
    expect_same(
        [&](int process, int processes) {
          return BlockPart(kind, n, process * n / processes, (process + 1) * n / processes);
        },
        128);
  }
}

} // namespace
} // namespace insitu::test
