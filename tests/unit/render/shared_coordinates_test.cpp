// A sample's coordinates hang on its cell and its ray alone, not on what else the process has:
// where coordinates differ in their last bits, so do some colours.
#include "unit/render/shared_frames.h"

namespace insitu::test {
namespace {

/// Some layers of cells of a block, and their field.
class BlockPart {
public:
  /// Cells first to behind - 1 along z of n^3 about [0,1]^3, in uneven planes if rectilinear.
  BlockPart(insitu_block_kind kind, int n, int first, int behind)
      : committed(1), first_(first), behind_(behind), n_(n) {
    if (first == behind)
      return;
    insitu_block block = insitu_block_default();
    block.kind = kind;
    const bool uniform = kind == INSITU_BLOCK_UNIFORM;
    for (int a = 0; a < 3; ++a) {
      block.vertices[a] = a == 2 ? behind - first + 1 : n + 1;
      const double origin = 0.013 - 0.01 * a;
      for (int i = 0; i <= n; ++i)
        planes_[a].push_back(origin + (i + (uniform ? 0.0 : 0.3 * std::sin(i))) * 0.97 / n);
      if (uniform) {
        block.origin[a] = origin;
        block.spacing[a] = 0.97 / n;
        block.first[a] = a == 2 ? first : 0;
      } else {
        block.coordinates[a] = insitu_array_of(planes_[a].data() + (a == 2 ? first : 0),
                                               INSITU_FLOAT64, block.vertices[a], 1);
      }
    }
    committed.mesh.mesh().set_block(0, &block);
    committed.commit();
  }

  /// Of vertices.
  render::ScalarField field(const char* name, insitu_association,
                            const std::function<double(const Vec3d&)>& f) {
    if (first_ == behind_)
      return {{name, INSITU_VERTEX, 1, nullptr, false}, -1};
    std::vector<double>& values = values_.emplace_back();
    for (int k = first_; k <= behind_; ++k)
      for (int j = 0; j <= n_; ++j)
        for (int i = 0; i <= n_; ++i)
          values.push_back(f({planes_[0][std::size_t(i)], planes_[1][std::size_t(j)],
                              planes_[2][std::size_t(k)]}));
    const insitu_array v =
        insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(values.size()), 1);
    committed.mesh.mesh().set_field(0, name, INSITU_VERTEX, &v, 1);
    committed.commit(INSITU_CHANGED_FIELDS);
    return {committed.mesh.mesh().field(name), -1};
  }
  void meet_others(parallel::World& world, bool /*with_halo*/) {
    committed.mesh.set_whole_facts(
        render::whole_facts(world, mesh::find_facts(committed.mesh.mesh().view(), nullptr)));
  }
  render::ScalarField known(const render::ScalarField& field) const {
    if (first_ == behind_)
      return field;
    return {committed.mesh.mesh().field(field.field.name), -1};
  }
  render::FramePart part(parallel::World& world) const {
    return {world, committed.mesh.mesh().view().own_cell_count(),
            [this](std::int64_t flat) { return std::int64_t(first_) * n_ * n_ + flat; }};
  }
  query::Sampler sampler() const { return committed.mesh.own_sampler(); }

  fixtures::Committed committed;

private:
  int first_, behind_, n_;
  std::vector<double> planes_[3];
  std::list<std::vector<double>> values_;
};

FrameSettings shaded(const ScalarField& field) {
  FrameSettings s = box_frame(128);
  s.volume = soft(field);
  s.volume->function = {render::ColorMap::built_in("viridis"), 0.0, 1.0, {{0, 0.1}, {1, 0.4}}};
  s.volume->step = 0.01;
  s.volume->shading = true;
  return s;
}
const Show show = [](const ScalarField& f, const ScalarField&) { return shaded(f); };

void expect_same_of(const TestMesh& whole) {
  const Drawn one = on_one(whole, show);
  for (const int processes : {2, 4})
    expect_equal(one, on_several(whole, show, processes, partitions()[0]));
}

/// Bundles whose samples are claimed by cells in one process, and located one by one in another.
TEST(SharedCoordinates, CellsAsFineAsSamples) {
  expect_same_of(box_cells(60, Shape::hexahedron, 0.25));
}

/// One process has all the cells that fold: few, which are known, or many.
TEST(SharedCoordinates, SomeCellsFold) {
  for (const double folded : {0.001, 0.3}) {
    TestMesh whole = box_cells(12, Shape::hexahedron, 0.25);
    for (std::size_t c = 0; c < whole.cells.size(); ++c)
      if (middle_of(whole, whole.cells[c]).x < 0.3 && core::random_unit(5, c, 0) < folded)
        std::swap(whole.cells[c].vertices[0], whole.cells[c].vertices[6]);
    SCOPED_TRACE(folded);
    expect_same_of(whole);
  }
}

TEST(SharedCoordinates, LayersOfABlock) {
  for (const insitu_block_kind kind : {INSITU_BLOCK_UNIFORM, INSITU_BLOCK_RECTILINEAR}) {
    constexpr int n = 13;
    SCOPED_TRACE(testing::Message() << "kind " << kind);
    BlockPart whole(kind, n, 0, n);
    const Drawn one = drawn_of(whole, show);
    for (const int processes : {2, 4})
      expect_equal(one, drawn_on(
                            processes,
                            [&](int rank) {
                              return BlockPart(kind, n, rank * n / processes,
                                               (rank + 1) * n / processes);
                            },
                            show));
  }
}

} // namespace
} // namespace insitu::test
