// Structured blocks whose arrays are sections of larger ones, beside packed arrays.
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <unistd.h>

#include "commands.h"
#include "commands/c_session.h"
#include "core/random.h"
#include "report/format.h"
#include "report/json.h"

namespace insitu::bench {

namespace {

/// A scalar on the vertices of a block, or one component of a vector, in an array with `margin`
/// more items on each side along each axis, as a solver's ghost layers are.
class Section {
public:
  Section(int vertices, int margin)
      : n_(vertices), margin_(margin), across_(vertices + 2 * margin) {
    values_.assign(std::size_t(across_) * across_ * across_, std::nan(""));
  }
  double& at(int i, int j, int k) {
    return values_[std::size_t(i + margin_) +
                   std::size_t(across_) * (std::size_t(j + margin_) +
                                           std::size_t(across_) * std::size_t(k + margin_))];
  }
  insitu_array array() {
    insitu_array a = insitu_array_of(&at(0, 0, 0), INSITU_FLOAT64, std::int64_t(n_) * n_ * n_, 1);
    if (margin_ == 0)
      return a;
    std::int64_t stride = sizeof(double);
    for (int axis = 0; axis < 3; ++axis) {
      a.extent[axis] = n_;
      a.stride[axis] = stride;
      stride *= across_;
    }
    return a;
  }

private:
  int n_, margin_, across_;
  std::vector<double> values_;
};

/// A curvilinear block with a scalar and a velocity, and the session that it is given to.
class Block {
public:
  Block(const Options& o, int vertices, int margin, const std::filesystem::path& folder)
      : n_(vertices), sections_(7, Section(vertices, margin)) {
    const double h = 1.0 / (n_ - 1);
    for_each_vertex([&](int i, int j, int k, std::uint64_t vertex) {
      const int at[3] = {i, j, k};
      double x[3];
      for (int a = 0; a < 3; ++a) {
        const bool inner = at[a] > 0 && at[a] < n_ - 1;
        x[a] = h *
               (at[a] + (inner ? o.jitter * (2 * core::random_unit(1, vertex, std::uint64_t(a)) - 1)
                               : 0.0));
        sections_[std::size_t(a)].at(i, j, k) = x[a];
      }
      sections_[3].at(i, j, k) = x[0] + 2 * x[1] + 3 * x[2];
      sections_[4].at(i, j, k) = 0.5 - x[1];
      sections_[5].at(i, j, k) = x[0] - 0.5;
      sections_[6].at(i, j, k) = 0.1 * std::sin(6 * x[0]);
    });
    const std::string scene =
        format("insitu: 1\npage: false\ntracers:\n"
               "  - {name: t, velocity: u, seeds: {box: {min: [0.2, 0.2, 0.2], max: [0.8, 0.8, "
               "0.8], counts: "
               "[20, 20, 10]}}, integrator: {method: rk4, step: 0.002}}\nframes:\n"
               "  - {name: f, size: [%d, %d], volume: {field: s, opacity: [[0, 0], [6, 0.2]]}}\n",
               o.size, o.size);
    session_.emplace(o.threads, scene.c_str(), folder.string().c_str());
    check(insitu_session_mesh(session_->handle, "bench", &mesh_));
    std::array<insitu_array, 7> arrays;
    for (std::size_t s = 0; s < 7; ++s)
      arrays[s] = sections_[s].array();
    check(insitu_mesh_points(mesh_, 0, arrays.data(), 3));
    insitu_block block = insitu_block_default();
    for (std::int64_t& count : block.vertices)
      count = n_;
    check(insitu_mesh_block(mesh_, 0, &block));
    check(insitu_mesh_field(mesh_, 0, "s", INSITU_VERTEX, &arrays[3], 1));
    check(insitu_mesh_field(mesh_, 0, "u", INSITU_VERTEX, &arrays[4], 3));
    check(insitu_mesh_commit(mesh_, nullptr));
  }

  void commit(std::uint32_t changed) {
    check(insitu_mesh_changed(mesh_, changed));
    check(insitu_mesh_commit(mesh_, nullptr));
    check(insitu_mesh_complete(mesh_, nullptr));
  }
  /// Moves the inner vertices a little, there and back in turns.
  void wobble() {
    sign_ = -sign_;
    for_each_vertex([&](int i, int j, int k, std::uint64_t) {
      if (i > 0 && i < n_ - 1)
        sections_[0].at(i, j, k) += sign_ * 1e-3 / n_;
    });
  }
  void sample(const insitu_array& points, std::vector<double>& values, bool with_values) {
    insitu_sample_args args = insitu_sample_args_default();
    args.locate.points = &points;
    std::vector<std::int64_t> cells(std::size_t(points.count));
    args.locate.cells = cells.data();
    const char* const name = "s";
    double* const to = values.data();
    args.fields = &name;
    args.field_count = with_values ? 1 : 0;
    args.values = &to;
    check(insitu_mesh_sample(mesh_, &args));
  }
  /// A cycle of the scene; returns the seconds of tracers and frames.
  std::array<double, 2> execute() {
    insitu_report before = insitu_report_default(), after = before;
    check(insitu_session_report(session_->handle, &before));
    check(insitu_session_execute(session_->handle, cycle_, double(cycle_) * 0.01));
    ++cycle_;
    check(insitu_session_report(session_->handle, &after));
    return {after.advect_s - before.advect_s, after.render_s - before.render_s};
  }

private:
  template <class Visit>
  void for_each_vertex(Visit&& visit) {
    std::uint64_t vertex = 0;
    for (int k = 0; k < n_; ++k)
      for (int j = 0; j < n_; ++j)
        for (int i = 0; i < n_; ++i)
          visit(i, j, k, vertex++);
  }

  int n_;
  std::vector<Section> sections_; ///< x, y, z, s, u
  std::optional<Session> session_;
  insitu_mesh mesh_ = {};
  double sign_ = 1.0;
  std::int64_t cycle_ = 0;
};

struct Row {
  const char* name;
  Series packed, sections;
};

} // namespace

Output sections(const Options& o) {
  const int vertices = 1 + std::max(1, int(std::lround(std::cbrt(double(o.cells.at(0))))));
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / format("insitu_sections_%d", int(getpid()));
  Block packed(o, vertices, 0, folder / "packed"), padded(o, vertices, 2, folder / "sections");
  const std::int64_t n = o.points > 0 ? o.points : 1'000'000;
  std::vector<double> xyz, values(std::size_t(n), 0.0), others = values;
  for (std::uint64_t i = 0; i < std::uint64_t(3 * n); ++i)
    xyz.push_back(core::random_unit(2, i, 0));
  const insitu_array points = insitu_array_of(xyz.data(), INSITU_FLOAT64, n, 3);
  Row rows[] = {{"commit of other cells", {}, {}},
                {"commit of moved vertices", {}, {}},
                {"points located", {}, {}},
                {"points located and sampled", {}, {}},
                {"particles", {}, {}},
                {"a volume's frame", {}, {}}};
  for (int r = 0; r <= o.repetitions; ++r) {
    progress("repetition " + std::to_string(r) + " of " + std::to_string(o.repetitions));
    for (const bool first : {r % 2 == 0, r % 2 != 0}) { // in turns
      Block& block = first ? packed : padded;
      const auto series = [&](Row& row) -> Series& {
        static Series warm; // the first repetition touches pages
        return r == 0 ? warm : first ? row.packed : row.sections;
      };
      block.wobble();
      series(rows[0]).time([&] { block.commit(INSITU_CHANGED_TOPOLOGY); });
      block.wobble();
      series(rows[1]).time([&] { block.commit(INSITU_CHANGED_GEOMETRY); });
      std::vector<double>& to = first ? values : others;
      series(rows[2]).time([&] { block.sample(points, to, false); });
      series(rows[3]).time([&] { block.sample(points, to, true); });
      const std::array<double, 2> seconds = block.execute();
      series(rows[4]).add(seconds[0]);
      series(rows[5]).add(seconds[1]);
    }
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);

  Output out;
  const bool same = values == others;
  out.exit_code = same ? 0 : 1;
  out.text = format("insitu-bench sections: a curvilinear block of %d^3 cells, %d thread%s; arrays "
                    "with two layers more on each side\n\n%-28s %12s %12s %8s\n",
                    vertices - 1, o.threads, o.threads == 1 ? "" : "s", "", "packed, s",
                    "sections, s", "ratio");
  Json table = Json::array();
  for (const Row& row : rows) {
    const double a = row.packed.for_ratio(o.threads), b = row.sections.for_ratio(o.threads);
    out.text += format("%-28s %12.4f %12.4f %8.2f\n", row.name, a, b, b / a);
    table.push_back(Json{{"work", row.name},
                         {"packed_s", number(a)},
                         {"sections_s", number(b)},
                         {"ratio", number(b / a)}});
  }
  out.text += same ? "\nThe samples are the same to the bit.\n" : "\nThe samples DIFFER.\n";
  out.json = json_text(Json{{"cells", o.cells.at(0)},
                            {"threads", o.threads},
                            {"same_samples", same},
                            {"rows", std::move(table)}});
  return out;
}

} // namespace insitu::bench
