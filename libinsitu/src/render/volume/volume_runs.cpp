#include <algorithm>
#include <bit>

#include "render/volume/scalar_values.h"
#include "render/volume/volume.h"
#include "render/volume/volume_scratch.h"

/// A volume's rays where the mesh is spread over processes, composited in runs where the cells are.
namespace insitu::render {

void VolumeMarcher::composite(std::span<RayState> rays, std::span<const query::LatticeRay> lattice,
                              int row, std::int64_t first, int depth, std::int64_t own_cells,
                              std::vector<std::uint16_t>& open, Runs& to,
                              VolumeCounts& counts) const {
  Scratch& s = scratch();
  std::optional<query::RayBundleLocator> locator;
  const ScalarValues values(field_, sampler_.mesh());
  s.open_runs.assign(rays.size(), {});
  s.last.assign(preintegration_ ? rays.size() : 1, {});
  for (std::int64_t from = first; from < first + depth; from += group()) {
    if (!ask(rays, from, open, s, counts))
      continue;
    if (!locator) {
      locator.emplace(located_, options_);
      locator->set_rays(lattice, row, step_);
      s.samples.resize(rays.size() * std::size_t(group()));
      s.locations.resize(shader_ ? s.samples.size() : 0);
    }
    locator->locate(from, group(), s.wanted, values, s.samples, s.locations);
    for (const std::uint32_t r : s.active) {
      RayState& ray = rays[r];
      Run& run = s.open_runs[r];
      const std::size_t at = r * std::size_t(group());
      std::uint32_t claimed = 0;
      for (std::uint32_t rest = s.wanted[r]; rest; rest &= rest - 1) {
        const int k = std::countr_zero(rest);
        claimed |= std::uint32_t(is_claimed(s.samples[at + std::size_t(k)].cell, own_cells)) << k;
      }
      while (claimed && !ray.is_saturated()) {
        const int k = std::countr_zero(claimed), count = std::countr_one(claimed >> k);
        const std::uint32_t together =
            claimed & std::uint32_t((std::uint64_t(1) << (k + count)) - 1);
        claimed &= ~together;
        if (run.begin >= 0 && from + k != run.last + 1)
          end_run(ray, run, to);
        run.ray = std::uint16_t(r);
        add_to_run(ray, run, s.last[preintegration_ ? r : 0], from, together, &s.samples[at],
                   shader_ ? &s.locations[at] : nullptr);
      }
      if (ray.is_saturated()) // the rest is hidden, whatever other processes have
        ray.next = ray.end;
    }
  }
  for (const std::uint16_t r : open) {
    RayState& ray = rays[r];
    if (s.open_runs[r].begin >= 0)
      end_run(ray, s.open_runs[r], to);
    counts.lit += ray.lit;
    counts.integrals += ray.integrals;
    ray.lit = ray.integrals = 0;
  }
  std::erase_if(open, [&](std::uint16_t r) {
    return rays[r].next >= rays[r].end || rays[r].end <= first + depth;
  });
}

/// claimed: of consecutive samples, the first of which begins the run or goes on with it.
void VolumeMarcher::add_to_run(RayState& ray, Run& run, Gathered& last, std::int64_t first,
                               std::uint32_t claimed, const query::ValueSample* samples,
                               const query::Location* locations) const {
  query::Location lit[32];
  if (shader_)
    for (std::uint32_t rest = claimed; rest; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      if (!preintegration_ && !shows(samples[k].value))
        continue;
      lit[k] = {samples[k].cell, gradient(locations[k])};
      if (is_lit_by_place())
        lit[k].parametric =
            light_without_rays(lit_point(ray.ray, lit[k].parametric, place(locations[k])));
    }
  const int k = std::countr_zero(claimed), end = 32 - std::countl_zero(claimed);
  if (run.begin < 0) {
    run.begin = first + k;
    ray.in_pieces = true;
    if (preintegration_) { // what is before it hangs on what others have there
      run.at_begin = {samples[k].value, lit[k].parametric};
      last = {first + k,
              preintegration_->place(samples[k].value, last.place),
              {samples[k].cell, lit[k].parametric}};
      claimed &= claimed - 1;
    }
  }
  run.last = first + end - 1;
  if (preintegration_)
    run.at_last = {samples[end - 1].value, lit[end - 1].parametric};
  gather_stretch(ray, last, first, claimed, samples, shader_ ? lit : nullptr);
}

void VolumeMarcher::end_run(RayState& ray, Run& run, Runs& to) const {
  ray.end_piece();
  run.pieces = std::uint32_t(ray.pieces.size());
  if (run.pieces > 0 || claims_all()) {
    to.pieces.insert(to.pieces.end(), ray.pieces.begin(), ray.pieces.end());
    to.runs.push_back(run);
  }
  ray.pieces.clear();
  run = {};
}

void VolumeMarcher::gather(RayState& ray, Progress& progress, std::size_t r, const Run& run,
                           std::span<const RayPiece> pieces) const {
  Gathered& last = progress.last_[r];
  if (preintegration_)
    gather(ray, last, run.begin, run.at_begin.value, {0, run.at_begin.lit});
  for (const RayPiece& piece : pieces) {
    while (ray.next_hit < piece.hits && !ray.is_saturated())
      ray.blend_next_hit();
    if (ray.is_saturated())
      return;
    ray.blend(piece);
  }
  if (preintegration_)
    last = {run.last, preintegration_->place(run.at_last.value, last.place), {0, run.at_last.lit}};
}

} // namespace insitu::render
