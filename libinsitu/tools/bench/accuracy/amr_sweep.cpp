#include <algorithm>
#include <cmath>

#include "accuracy/images.h"
#include "accuracy/sweeps.h"
#include "adaptive_meshes.h"
#include "commands.h"
#include "report/format.h"
#include "peers/openvkl_parts.h"
#include "render/frame.h"
#include "workload/amr.h"

namespace insitu::bench::accuracy {

namespace {

using math::Vec3d;

/// Of a field from 0 to 1. Rays in float take a neighbour for points within 1e-5 of a face, whose
/// value there is the same but for less than this.
constexpr double another_value = 1e-4;

/// Smooth, with its steepest part on the sphere that the mesh is refined about; from 0 to 1.
double field(const Vec3d& p) {
  const Vec3d d = p - Vec3d{128, 128, 128};
  return 0.5 + 0.5 * std::tanh((90.0 - std::sqrt(dot(d, d))) / 16.0);
}

class Adaptive {
public:
  explicit Adaptive(const Extent& extent)
      : extent_(extent), context_(1, core::Log()),
        blocks_(workload::make_amr(extent.quick ? 8000 : 500'000)),
        leaves_(workload::leaves_of(blocks_)),
        points_(workload::random_amr_points(extent.quick ? 20'000 : 500'000)) {
    for (std::size_t i = 0; i < leaves_.levels.size(); ++i) {
      Vec3d p;
      for (int a = 0; a < 3; ++a)
        p[a] = (leaves_.corners[3 * i + std::size_t(a)] + 0.5) * blocks_.width(leaves_.levels[i]);
      leaves_.values[i] = field(p);
    }
  }

  std::unique_ptr<commit::CommittedMesh> make(insitu_reconstruction reconstruction) {
    auto out = register_leaves(leaves_, blocks_.spacing, blocks_.level_count, reconstruction,
                               context_.memory);
    out->commit(context_.threads, context_.log, context_.memory, true);
    return out;
  }

  /// The dual's cells, cubes as hexahedra, by a method of the papers.
  std::unique_ptr<commit::CommittedMesh> make_by_faces(const PlainDual& dual,
                                                       accel::Method method) {
    auto out = register_plain(dual, context_.memory);
    out->set_locator({method, accel::Backend::cpu});
    out->commit(context_.threads, context_.log, context_.memory, true);
    return out;
  }

  core::Context& context() { return context_; }
  std::int64_t leaf_count() const { return std::int64_t(leaves_.levels.size()); }

  /// Of samples at random points.
  Setting measure_values(const std::string& name, const commit::CommittedMesh& mesh,
                         std::int64_t bytes, insitu_accuracy accuracy) {
    query::LocateOptions options;
    options.accuracy = accuracy;
    Setting s;
    s.group = "values";
    s.name = name;
    s.items = double(points_.size());
    Answers answers(points_.size());
    for (int i = -1; i < extent_.repetitions; ++i) {
      Series cold;
      (i < 0 ? cold : s.time).time([&] {
        sample(context_.threads, mesh, points_, answers, options);
      });
    }
    note_errors(std::span<const double>(answers.values), s, double(bytes));
    Series cells;
    std::vector<query::Location> at(points_.size());
    options.coordinates = false;
    for (int i = 0; i < extent_.repetitions; ++i)
      cells.time([&] { mesh.sampler().locate(context_.threads, points_, at, options); });
    s.more[4] = cells.for_ratio(1) / s.items;
    if (of_dual_.empty())
      of_dual_ = answers.values;
    s.more[5] = 0.0;
    for (std::size_t i = 0; i < points_.size(); ++i)
      s.more[5] += !(std::fabs(answers.values[i] - of_dual_[i]) <= another_value);
    return s;
  }

  /// Open VKL's AMR volume of the same blocks, if it is there.
  std::vector<Setting> peers() {
    std::size_t at = 0;
    for (const workload::AmrMesh::Block& b : blocks_.blocks)
      for (std::int64_t c = 0; c < blocks_.cells_a_block(); ++c)
        blocks_.values[at++] = field(blocks_.centre(b, c));
    const auto peer = make_openvkl_amr(blocks_, 1);
    if (!peer)
      return {};
    peer->build();
    peer->set_points(points_);
    std::vector<Setting> out;
    for (const auto method : {OpenVklAmr::Method::octant, OpenVklAmr::Method::finest}) {
      Setting s;
      s.group = "values";
      s.name = method == OpenVklAmr::Method::octant ? "OpenVKL octant" : "OpenVKL finest";
      s.items = double(points_.size());
      s.is_peer = true;
      std::span<const float> values;
      for (int i = 0; i < extent_.repetitions; ++i)
        s.time.time([&] { values = peer->sample(method, context_.threads); });
      note_errors(values, s, double(peer->bytes() + peer->bytes_values()));
      out.push_back(std::move(s));
    }
    return out;
  }

  render::FrameSettings frame(const commit::CommittedMesh& mesh, insitu_accuracy accuracy) const {
    render::FrameSettings s;
    s.width = s.height = extent_.quick ? 64 : 192;
    s.camera = render::Camera::around({0, 0, 0}, {256, 256, 256}, 30, 20);
    s.background = {0, 0, 0};
    s.volume = render::VolumeSettings{
        {mesh.mesh().field("f"), 0},
        {render::ColorMap::built_in("viridis"), 0.0, 1.0, {{0.3, 0.0}, {1.0, 0.05}}}};
    s.volume->unit_distance = 4.0;
    s.volume->step = 1.0;
    s.volume->accuracy = accuracy;
    return s;
  }
  core::Image draw(const commit::CommittedMesh& mesh, insitu_accuracy accuracy = INSITU_STANDARD,
                   render::FrameStatistics* statistics = nullptr) {
    return render::render_frame(mesh.sampler(), frame(mesh, accuracy), context_.threads,
                                context_.memory, statistics)
        .color;
  }

  Setting measure_image(const std::string& name, const commit::CommittedMesh& mesh,
                        std::int64_t bytes, insitu_accuracy accuracy, const core::Image& truth) {
    Setting s;
    s.group = "images";
    s.name = name;
    render::FrameStatistics statistics;
    core::Image image;
    for (int i = 0; i < extent_.repetitions; ++i)
      s.time.time([&] { image = draw(mesh, accuracy, &statistics); });
    s.error = dissimilarity(image, truth);
    s.more = {std::nan(""), rms_error(image, truth), double(bytes), std::nan(""), std::nan(""),
              std::nan("")};
    s.work = double(statistics.samples);
    return s;
  }

  /// The field itself on even cells as fine as the finest leaves or finer, and of half the width,
  /// extrapolated (Richardson): trilinear interpolation errs by the square of the width.
  core::Image converged() {
    const int n = extent_.quick ? 64 : 128;
    const core::Image wide = on_even_cells(n), narrow = on_even_cells(2 * n);
    core::Image out = narrow;
    for (std::size_t i = 0; i < out.rgba.size(); ++i)
      out.rgba[i] = float((4.0 * double(narrow.rgba[i]) - double(wide.rgba[i])) / 3.0);
    return out;
  }

private:
  template <class T>
  void note_errors(std::span<const T> values, Setting& s, double bytes) const {
    double sum = 0.0, worst = 0.0;
    std::int64_t lost = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (std::isnan(values[i])) {
        ++lost;
        continue;
      }
      const double e = std::fabs(double(values[i]) - field(points_[i]));
      sum += e * e;
      worst = std::max(worst, e);
    }
    s.error = std::sqrt(sum / (s.items - double(lost)));
    s.more = {worst, std::nan(""), bytes, double(lost), std::nan(""), std::nan("")};
  }

  core::Image on_even_cells(int n) {
    std::vector<double> values;
    for (int k = 0; k <= n; ++k)
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i)
          values.push_back(field({256.0 * i / n, 256.0 * j / n, 256.0 * k / n}));
    commit::CommittedMesh mesh("even", context_.memory);
    insitu_block block = insitu_block_default();
    block.kind = INSITU_BLOCK_UNIFORM;
    for (int a = 0; a < 3; ++a) {
      block.vertices[a] = n + 1;
      block.spacing[a] = 256.0 / n;
    }
    mesh.mesh().set_block(0, &block);
    const insitu_array v =
        insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(values.size()), 1);
    mesh.mesh().set_field(0, "f", INSITU_VERTEX, &v, 1);
    mesh.commit(context_.threads, context_.log, context_.memory, true);
    return draw(mesh);
  }

  Extent extent_;
  core::Context context_;
  workload::AmrMesh blocks_;
  workload::AmrLeaves leaves_;
  std::vector<Vec3d> points_;
  std::vector<double> of_dual_; ///< values, of the first mesh that is measured
};

} // namespace

Sweep sweep_amr(const Extent& extent) {
  Sweep s;
  s.key = "amr";
  s.title = "Adaptive meshes";
  Adaptive adaptive(extent);
  s.swept =
      "Reconstruction of " + grouped(adaptive.leaf_count()) +
      " octree leaves in three levels: the dual mesh with gridlets and curved stitching cells, and "
      "`nearest`, the cell's own value.";
  s.reference =
      std::string("The smooth field itself, whose values the leaves have at their centres; "
                  "for images, the same on even meshes of ") +
      (extent.quick ? "half and a quarter of the finest leaves' width"
                    : "the finest leaves' width and of half") +
      ", extrapolated.";
  s.error_label = "error (values: root mean square, of 1; images: 1 - structural similarity)";
  s.work_label = "samples located";
  s.time_label = "seconds a sample, seconds a frame; one core";
  s.axes = {
      {"values", {"error of the value, root mean square, of 1", "seconds a sample, one core"}},
      {"images", {"1 - structural similarity", "seconds a frame, one core"}}};
  s.more_labels = {"largest error",
                   "root mean square of linear colours",
                   "bytes of the structures",
                   "points in no cell",
                   "seconds a point for its cell alone, one core",
                   "values that differ from the dual mesh's by more than 1e-4"};
  const core::Image truth = adaptive.converged();
  const auto add = [&](const std::string& name, insitu_accuracy accuracy, double arrays,
                       const auto& make) {
    progress("amr: " + name);
    const std::int64_t before = adaptive.context().memory.current();
    const std::unique_ptr<commit::CommittedMesh> mesh = make();
    (void)mesh->mesh().field("f");
    const auto bytes = std::int64_t(arrays) + adaptive.context().memory.current() - before;
    s.settings.push_back(adaptive.measure_values(name, *mesh, bytes, accuracy));
    s.settings.push_back(adaptive.measure_image(name, *mesh, bytes, accuracy, truth));
  };
  PlainDual cells;
  add("dual mesh", INSITU_STANDARD, 0, [&] {
    auto mesh = adaptive.make(INSITU_DUAL);
    cells = welded(plain_dual(*mesh));
    return mesh;
  });
  for (Setting& one : s.settings)
    one.is_default = true;
  add("nearest", INSITU_STANDARD, 0, [&] { return adaptive.make(INSITU_NEAREST); });
  for (const bool curved : {false, true})
    add(curved ? "curved faces by rays" : "planar faces by rays", INSITU_FAST,
        double(cells.bytes() + cells.bytes_values()), [&] {
          return adaptive.make_by_faces(cells, curved ? accel::Method::shared_bilinear_faces
                                                      : accel::Method::shared_faces);
        });
  for (Setting& peer : adaptive.peers())
    s.settings.push_back(std::move(peer));
  const Setting *dual = s.find("values", "dual mesh"), *nearest = s.find("values", "nearest");
  const Setting *dual_image = s.find("images", "dual mesh"),
                *nearest_image = s.find("images", "nearest");
  const double bytes = (dual->more[2] - nearest->more[2]) / double(adaptive.leaf_count());
  s.advice =
      format("The dual mesh has %.1f times less error in values than `nearest` and its images "
             "are %.1f times less dissimilar, for %.2f times the time a sample, %.2f times "
             "the time a frame and %.0f bytes a leaf %s.",
             nearest->error / dual->error, nearest_image->error / dual_image->error,
             dual->seconds() / nearest->seconds(), dual_image->seconds() / nearest_image->seconds(),
             std::fabs(bytes), bytes < 0.0 ? "less" : "more");
  s.advice += format(" Root mean square errors of the images are %.2g (dual) and %.2g",
                     dual_image->more[1], nearest_image->more[1]);
  s.advice += nearest_image->more[1] <= dual_image->more[1]
                  ? ": where only integrals along rays count, `nearest` is as good."
                  : ".";
  for (const Setting* one : s.of("values", true))
    if (one->is_peer)
      s.advice +=
          format(" %s takes %.2f times the dual mesh's time a sample, for %.2f times its "
                 "error.",
                 one->name.c_str(), one->seconds() / dual->seconds(), one->error / dual->error);
  const Setting *planar = s.find("values", "planar faces by rays"),
                *curved = s.find("values", "curved faces by rays"),
                *planar_image = s.find("images", "planar faces by rays");
  s.advice += format(" By rays on the dual mesh's cells as hexahedra and so on, planar faces tell "
                     "the cell of a point in %.2f times the time of curved ones, but %.2g %% of "
                     "values are others then, with %.2f times the error over all; its images are "
                     "%.1f times as dissimilar as the dual mesh's. (Values take %.2f times the "
                     "time: where a point lies outside of the cell that it is given, Newton's "
                     "method does not settle and coordinates are sought anew.)",
                     planar->more[4] / curved->more[4], 100 * planar->more[5] / planar->items,
                     planar->error / curved->error, planar_image->error / dual_image->error,
                     planar->seconds() / curved->seconds());
  return s;
}

} // namespace insitu::bench::accuracy
