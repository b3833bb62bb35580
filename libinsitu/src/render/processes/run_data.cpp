#include "render/processes/run_data.h"

#include <algorithm>

namespace insitu::render {

namespace {

struct RunHead {
  std::uint16_t ray;
  std::uint8_t begin, last; ///< from the round's first sample on
};
struct RunPaint {
  Color color;
  float alpha;
};
static_assert(sizeof(RunHead) + sizeof(RunPaint) == std::size_t(bytes_a_composite));

} // namespace

void write_runs(const VolumeMarcher::Runs& runs, std::size_t first_ray, std::int64_t first,
                const RunForm& form, ByteWriter& to) {
  const RayPiece* piece = runs.pieces.data();
  for (const VolumeMarcher::Run& run : runs.runs) {
    to.value(RunHead{std::uint16_t(first_ray + run.ray), std::uint8_t(run.begin - first),
                     std::uint8_t(run.last - first)});
    if (form.has_hits)
      to.value(run.pieces);
    else if (run.pieces == 0)
      to.value(RunPaint{{}, 0});
    for (std::uint32_t p = 0; p < run.pieces; ++p, ++piece) {
      to.value(RunPaint{piece->color, piece->alpha});
      if (form.has_hits)
        to.value(piece->hits);
    }
    if (!form.is_preintegrated)
      continue;
    to.value(run.at_begin.value);
    to.value(run.at_last.value);
    if (form.is_lit) {
      to.value(run.at_begin.lit);
      to.value(run.at_last.lit);
    }
  }
}

void SentRuns::clear(std::size_t rays) {
  runs_.clear();
  pieces_.clear();
  begin_.assign(rays + 1, 0);
}

void SentRuns::add(int process, ByteReader from, std::int64_t first, const RunForm& form) {
  while (!from.at_end()) {
    Sent& run = runs_.emplace_back();
    const auto head = from.value<RunHead>();
    run.ray = head.ray;
    run.begin = first + head.begin;
    run.last = first + head.last;
    run.process = process;
    run.first_piece = std::uint32_t(pieces_.size());
    run.pieces = form.has_hits ? from.value<std::uint32_t>() : 1;
    for (std::uint32_t p = 0; p < run.pieces; ++p) {
      const auto paint = from.value<RunPaint>();
      const std::uint32_t hits = form.has_hits ? from.value<std::uint32_t>() : 0;
      pieces_.push_back({hits, paint.alpha, paint.color});
    }
    if (form.is_preintegrated) {
      run.at_begin.value = from.value<double>();
      run.at_last.value = from.value<double>();
      if (form.is_lit) {
        run.at_begin.lit = from.value<math::Vec3d>();
        run.at_last.lit = from.value<math::Vec3d>();
      }
    }
    ++begin_[std::size_t(run.ray) + 1];
  }
}

void SentRuns::put_in_order() {
  for (std::size_t r = 1; r < begin_.size(); ++r)
    begin_[r] += begin_[r - 1];
  sorted_.resize(runs_.size());
  for (std::size_t i = runs_.size(); i-- > 0;) // begin_[ray + 1] is where the ray's next one ends
    sorted_[--begin_[std::size_t(runs_[i].ray) + 1]] = runs_[i];
  // Now begin_[ray + 1] is where the ray begins.
  begin_.erase(begin_.begin());
  begin_.push_back(std::uint32_t(runs_.size()));
  const auto is_before = [](const Sent& a, const Sent& b) { return a.begin < b.begin; };
  for (std::size_t r = 0; r + 1 < begin_.size(); ++r)
    std::sort(sorted_.begin() + begin_[r], sorted_.begin() + begin_[r + 1], is_before);
}

bool SentRuns::overlap(std::span<const Sent> runs) {
  std::int64_t last = -1;
  for (const Sent& run : runs) {
    if (run.begin <= last)
      return true;
    last = std::max(last, run.last);
  }
  return false;
}

} // namespace insitu::render
