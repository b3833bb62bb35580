#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "query/sampler.h"
#include "render/camera/ray_state.h"
#include "render/color/preintegration.h"
#include "render/color/transfer_function.h"
#include "render/light.h"
#include "render/structures/scalar_field.h"
#include "render/surface/shade.h"
#include "render/volume/culling.h"
#include "render/volume/macrocells.h"
#include "render/volume/ray_step.h"
#include "render/volume/step_levels.h"

namespace insitu::query {
struct LatticeRay;
struct ValueSample;
} // namespace insitu::query

namespace insitu::render {

class Structures;

/// A field drawn as a medium that emits and absorbs.
struct VolumeSettings {
  ScalarField field;
  TransferFunction function;
  /// The distance between samples along a ray: step_factor times typical_cell_size(), or `step`
  /// itself where it is given.
  double step_factor = 0.5;
  std::optional<double> step = std::nullopt;
  /// Length of ray over which the function's opacities hold; 0: a hundredth of the mesh's diagonal.
  double unit_distance = 0;
  insitu_accuracy accuracy = INSITU_STANDARD; ///< of locating the samples
  /// Nothing is looked for where the macrocells say that nothing shows. The image is the same.
  bool skip_empty = true;
  /// With Culling::always, samples are located in a tree of the gridlets and stitching cells that
  /// the function shows anything of. The image stays the same, except that a sample on a face of a
  /// primitive that was left out takes its value from the cell beyond the face, which differs by
  /// rounding. Meshes without such primitives are drawn without culling, and so are frames with
  /// `preintegrated`, because integrals between samples need values that do not show too.
  Culling culling = Culling::never;
  /// Between two samples the function is integrated over all values between theirs, instead of
  /// being asked at the samples alone. Vertex fields only: a cell field has but one value in a
  /// cell.
  bool preintegrated = false;
  /// Colours are lit by the field's gradient, as Lighting says of surfaces.
  bool shading = false;
  /// The step varies from macrocell to macrocell so that the error of the opacity and of the colour
  /// stays below this (see StepLevels); the step above is where it starts from.
  std::optional<double> tolerance = std::nullopt;
  /// Samples of a ray that are located at once (Rathke et al. 2015, section 7.2), at most
  /// query::RayBundleLocator::most_depth; 0: 16. It changes the time alone, and how many are
  /// located in vain behind the sample that hides the rest, but for rounding. Not with a tolerance.
  int sample_group = 0;
};

/// Throws core::Error: INSITU_ERROR_FIELD unless the field has the component, INSITU_ERROR_ARGUMENT
/// for what does not go together.
void check(const VolumeSettings& settings);
/// The distance between samples, but for a tolerance. Throws core::Error (INSITU_ERROR_ARGUMENT)
/// for one too short to be counted.
double ray_step(const query::Sampler& sampler, const VolumeSettings& settings);
/// As given, or a hundredth of the mesh's diagonal.
double unit_distance_of(const query::Sampler& sampler, const VolumeSettings& settings);

struct VolumeCounts {
  std::int64_t samples = 0;   ///< located
  std::int64_t skipped = 0;   ///< of the lattice, in macrocells that nothing shows of
  std::int64_t lit = 0;       ///< by the field's gradient
  std::int64_t integrals = 0; ///< stretches between two samples
  std::int64_t shadow_rays = 0;

  VolumeCounts& operator+=(const VolumeCounts& b) {
    samples += b.samples;
    skipped += b.skipped;
    lit += b.lit;
    integrals += b.integrals;
    shadow_rays += b.shadow_rays;
    return *this;
  }
};

/// What a frame's volume needs of the structures that frames share. Null where it needs none.
struct VolumeStructures {
  const Majorants* majorants = nullptr;       ///< to skip what is empty
  const query::CulledCells* culled = nullptr; ///< where samples are looked for; null: everywhere
  const Macrocells* macrocells = nullptr;     ///< with cells' sizes, for a tolerance
  core::CountedAllocator<char> counted = {};  ///< of the marcher's own tables
};
/// rays: of the frame. whole: of a mesh that is spread over processes, the level_grid() of all of
/// it, on which macrocells then are those of the sampler's cells alone; null: the sampler's mesh is
/// whole.
VolumeStructures volume_structures(const query::Sampler& sampler, const VolumeSettings& settings,
                                   std::int64_t rays, Structures& structures,
                                   const MacrocellGrid* whole = nullptr);
/// Whether macrocells are made for skipping: if the samples that macrocells are likely to save, by
/// a look at some cells, are more than the cells that have to be read once. In a culled frame a
/// sample where nothing shows costs little, so ten times as many have to be saved.
bool skipping_pays(const query::Sampler& sampler, const VolumeSettings& settings, std::int64_t rays,
                   bool culled = false);

/// Marches rays through a volume. Sample i of a ray lies at (i + 1/2) * step and stands for the
/// distances from i * step to (i + 1) * step, whatever the mesh; the first and the last in the
/// mesh's bounds, or in what clips leave, stand for all up to there; a ray that is within for less
/// than that takes one sample in the middle. Nothing is gathered outside of cells. With a tolerance
/// samples stand for 3^level steps, and lie in the middle all the same.
class VolumeMarcher {
  struct Gathered;

public:
  /// The structures must outlive it. clipped: the rays' `stays` say what is left of them.
  VolumeMarcher(const query::Sampler& sampler, const VolumeSettings& settings,
                const VolumeStructures& structures = {}, const Lighting& lighting = {},
                bool clipped = false);

  /// Surfaces that cast shadows on what `shading` lights; they must outlive this. None: no rays
  /// are sent.
  void set_surfaces(const SceneSurfaces* surfaces);

  /// With a tolerance, of the finest samples.
  double step() const { return step_; }
  /// Macrocells where the tolerance is not held; see StepLevels.
  std::int64_t unheld() const { return levels_ ? levels_->unheld() : 0; }

  /// Sets the ray's samples: those within the tree's bounds, up to its first opaque hit.
  void start(RayState& ray) const;

  /// Gathers the samples of all rays, and those of their hits that lie before each ray's last
  /// sample, in depth order. row: so many rays are a row of neighbouring pixels, one row after the
  /// other; it changes the time alone.
  VolumeCounts march(std::span<RayState> rays, int row = 0) const;

  // Where a mesh is spread over processes (render/processes), one of them gathers a ray and all
  // claim samples of it.

  /// Rays start and end where the whole mesh of sampler.facts() does, though cells may be few here,
  /// or none. Locations that are gathered then hold, in place of coordinates, the field's gradient,
  /// or the light that falls there if that hangs on the place.
  void take_part();
  bool is_lit() const { return shader_.has_value(); }
  bool has_levels() const { return levels_.has_value(); }
  /// Whether there are lights that hang on a sample's place: points, and those with shadows.
  bool is_lit_by_place() const { return shader_ && shader_->asks_place(); }
  /// Whose rays are to be followed; null: there are none.
  const Shader* light_shader() const {
    return shader_ && shader_->sends_rays() ? &*shader_ : nullptr;
  }
  /// The point that is lit by a gradient there; none: it has no side to be lit from.
  static std::optional<SurfacePoint> lit_point(const Ray& view, const math::Vec3d& gradient,
                                               const math::Vec3d& place);
  /// The light there, if no ray is sent; 1 where there is no point.
  math::Vec3d light_without_rays(const std::optional<SurfacePoint>& at) const;
  /// Samples of a ray that are located at once: stretches begin at multiples of it.
  int group() const { return sample_group_ > 0 ? sample_group_ : 16; }

  /// The samples of some rays that cells of this process claim.
  struct Claims {
    std::vector<std::uint32_t> wanted;       ///< by ray; bit k: sample first + k is claimed
    std::vector<query::ValueSample> samples; ///< at place()
    std::vector<math::Vec3d> gradients;      ///< the same, if colours are lit; otherwise empty
    std::vector<math::Vec3d> places;         ///< the same, if is_lit_by_place()
    std::vector<std::uint8_t> levels;        ///< the same, with a tolerance: of the steps
    std::size_t rays = 0;
    int group = 1;
    std::size_t place(std::size_t ray, int k) const {
      return (std::size_t(k / group) * rays + ray) * std::size_t(group) + std::size_t(k % group);
    }
  };
  /// Leaves those samples of a ray that was started which cells of this process may hold.
  void keep_near(RayState& ray) const;
  /// Claims samples [first, first + depth), depth at most 32 and both multiples of group(), as far
  /// as keep_near() left them and something may show. With a tolerance sample i is the one whose
  /// stretch begins at the base step i. rays: at most
  /// query::RayBundleLocator::most_rays; lattice: the same; row as for march(). open: the rays that
  /// have not ended, ascending; those that end are taken out. Flat cells below own_cells are of
  /// this process.
  void claim(std::span<RayState> rays, std::span<const query::LatticeRay> lattice, int row,
             std::int64_t first, int depth, std::int64_t own_cells,
             std::vector<std::uint16_t>& open, Claims& claims, VolumeCounts& counts) const;
  /// The same of the sample of each thin ray: sample 0.
  void claim_thin(std::span<RayState> rays, std::int64_t own_cells, Claims& claims,
                  VolumeCounts& counts) const;

  /// What rays have in the making between stretches that they gather.
  class Progress {
  public:
    explicit Progress(std::size_t rays);
    Progress(Progress&&) noexcept;
    ~Progress();
    /// Remembers what a ray has, until the next one is kept, or puts it back.
    void keep(std::size_t ray);
    void put_back(std::size_t ray);

  private:
    friend class VolumeMarcher;
    std::vector<Gathered> last_; ///< by ray, and what is kept
  };
  /// Gathers those of samples [first, first + 32) of ray r whose bit is set in `wanted`, at
  /// locations if colours are lit, of levels with a tolerance. Stretches come in order, and those
  /// without samples need not.
  void gather(RayState& ray, Progress& progress, std::size_t r, std::int64_t first,
              std::uint32_t wanted, const query::ValueSample* samples,
              const query::Location* locations, const std::uint8_t* levels) const;
  /// Which of these samples gather() will light, and maybe some more: a bit each.
  std::uint32_t lit_samples(const RayState& ray, const Progress& progress, std::size_t r,
                            std::int64_t first, std::uint32_t wanted,
                            const query::ValueSample* samples, const std::uint8_t* levels) const;
  /// The same of a thin ray's sample.
  void gather_thin(RayState& ray, double value, const query::Location& at) const;
  /// After the last stretch.
  void finish(std::span<RayState> rays, Progress& progress) const;

  // Or each process composites the samples in its own cells, and one blends what all have made.

  /// A sample at which other samples of a pre-integrated volume may go on.
  struct RunEnd {
    double value = 0;
    math::Vec3d lit; ///< the field's gradient, or its light, as take_part() says
  };
  /// Consecutive samples of a ray in cells of one process.
  struct Run {
    std::uint16_t ray = 0;
    std::int64_t begin = -1, last = -1; ///< samples
    std::uint32_t pieces = 0;           ///< these are in Runs::pieces, run by run
    RunEnd at_begin, at_last;           ///< if is_preintegrated()
  };
  struct Runs {
    std::vector<Run> runs;
    std::vector<RayPiece> pieces;
  };
  bool is_preintegrated() const { return preintegration_.has_value(); }
  /// As claim(), but of any depth: adds what the samples make, in runs of which those of a ray are
  /// in order. A pre-integrated run goes from its first sample to its last, and what is before and
  /// behind these is missing. The rays' hits alone are cut in, and are told apart by no colour.
  void composite(std::span<RayState> rays, std::span<const query::LatticeRay> lattice, int row,
                 std::int64_t first, int depth, std::int64_t own_cells,
                 std::vector<std::uint16_t>& open, Runs& to, VolumeCounts& counts) const;
  /// Gathers a run of ray r, as gather() gathers samples.
  void gather(RayState& ray, Progress& progress, std::size_t r, const Run& run,
              std::span<const RayPiece> pieces) const;

private:
  struct Planned;
  struct Scratch;
  static Scratch& scratch();

  std::uint32_t advance(RayState& ray, std::int64_t first, int depth, std::int64_t& skipped) const;
  bool ask(std::span<RayState> rays, std::int64_t first, std::span<const std::uint16_t> open,
           Scratch& s, VolumeCounts& counts) const;
  bool is_claimed(std::int64_t cell, std::int64_t own_cells) const {
    return cell >= 0 && cell < own_cells && (!has_foreign_ || sampler_.mesh().is_own(cell));
  }
  /// Whether samples that do not show count: for the integrals between them and others, or because
  /// the lowest of several cells that hold a sample, each with a value of its own, is the one that
  /// is drawn.
  bool claims_all() const { return preintegration_ || field_.field.association == INSITU_CELL; }
  /// Whether a value may show.
  bool may_show(double value) const { return !(value < shown_low_ || value > shown_high_); }
  bool shows(double value) const { return classifiers_[0](value).alpha > 0; }
  void add_to_run(RayState& ray, Run& run, Gathered& last, std::int64_t first,
                  std::uint32_t claimed, const query::ValueSample* samples,
                  const query::Location* locations) const;
  void end_run(RayState& ray, Run& run, Runs& to) const;
  void march_bundle(std::span<RayState> rays, int row, VolumeCounts& counts) const;
  bool is_plain() const { return !preintegration_ && !shader_ && !clipped_ && !levels_; }
  void gather_stretch(RayState& ray, Gathered& last, std::int64_t first, std::uint32_t wanted,
                      const query::ValueSample* samples, const query::Location* locations,
                      const std::uint8_t* levels = nullptr) const;
  void gather_plainly(RayState& ray, std::int64_t first, std::uint32_t wanted,
                      const query::ValueSample* samples) const;
  void locate_thin(std::span<const RayState> rays) const;
  std::int64_t march_thin(std::span<RayState> rays) const;
  void march_levels(std::span<RayState> rays, VolumeCounts& counts) const;
  void plan(RayState& ray, std::size_t most, std::int64_t upto, Scratch& s,
            VolumeCounts& counts) const;
  void claim_levels(std::span<RayState> rays, std::int64_t first, int depth, std::int64_t own_cells,
                    std::span<const std::uint16_t> open, Claims& claims,
                    VolumeCounts& counts) const;
  double longest_step() const {
    return step_ * double(StepLevels::stride(int(classifiers_.size()) - 1));
  }
  double middle(std::int64_t begin, int level) const;
  Stretch stretch(const RayState& ray, std::int64_t begin, std::int64_t stride) const;
  void add_sample(RayState& ray, const Stretch& stretch, const query::Location& at,
                  int level) const;
  void add_value(RayState& ray, const Stretch& stretch, double value, const query::Location& at,
                 int level) const;
  math::Vec3d gradient(const query::Location& at) const;
  math::Vec3d place(const query::Location& at) const;
  void light(RayState& ray, const query::Location& at, Color& color) const;
  void gather(RayState& ray, Gathered& last, std::int64_t index, double value,
              const query::Location& at, int level = 0) const;
  void finish(RayState& ray, Gathered& last) const;
  void add(RayState& ray, const Stretch& stretch, const ColorSample& sample,
           std::int64_t cell) const;

  query::Sampler sampler_;
  query::Sampler located_; ///< the same, or among what is not culled, where places are
  ScalarField field_;
  TransferFunction function_;
  query::LocateOptions options_;
  double step_, unit_distance_;
  int sample_group_;
  bool clipped_;
  bool takes_part_ = false;    ///< see take_part()
  double shown_low_ = -HUGE_VAL, shown_high_ = HUGE_VAL;
  bool has_foreign_ = false;   ///< whether other processes own cells of this one's own pieces
  const Majorants* majorants_; ///< null: nothing to skip
  std::optional<Shader> shader_;
  Lighting lighting_;
  const SceneSurfaces* surfaces_ = nullptr;
  std::optional<StepLevels> levels_;
  std::vector<Classifier> classifiers_; ///< by level
  std::optional<Preintegration> preintegration_;
  math::Vec3d low_, high_;             ///< nothing is outside of these
  math::Vec3d inner_low_, inner_high_; ///< and the mesh reaches up to these
};

} // namespace insitu::render
