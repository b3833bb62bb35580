#include "query/batch/guessed_batches.h"

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <vector>

#include "mesh/one_mesh.h"

namespace insitu::query {

using math::Vec3d;

struct GuessScratch {
  // Every spacing-th point behind the trial's.
  std::vector<Vec3d> points;
  std::vector<Location> anchors;
  std::vector<Reason> reasons;
  std::int64_t guessed[batch_size + (1 << 5)]; ///< a whole spacing more
};

namespace {

GuessScratch& guess_scratch() {
  thread_local std::unique_ptr<GuessScratch> scratch = std::make_unique<GuessScratch>();
  return *scratch;
}

constexpr std::size_t trial = 256; ///< points that the tree answers first
constexpr int least_spacing_log = 2, most_spacing_log = 5;

/// The cells of the 2^log points from one in cell a on; the point behind these is in b. Along a row
/// numbers rise evenly; else a point is in the cell of the nearer one.
void guess_between(std::int64_t a, std::int64_t b, int log, std::int64_t* cells) {
  const int n = 1 << log;
  const std::int64_t rise = b - a;
  const bool evenly = a >= 0 && b >= 0 && (std::abs(rise) < n || (rise & (n - 1)) == 0);
  if (evenly) {
    const std::int64_t scaled = (a << log) + n / 2;
    for (int k = 0; k < n; ++k)
      cells[k] = (scaled + rise * k) >> log;
    return;
  }
  std::fill_n(cells, n / 2, a);
  std::fill_n(cells + n / 2, n / 2, b);
}

/// From how few points the others' cells could have been guessed, at the least expected time: every
/// 2^n-th; n = 0: asking the tree for all takes less.
int best_spacing_log(std::span<const Location> located) {
  // Of a guess, in parts of what the tree takes for a point, in hexahedra, where that is most; and
  // what is worth changing for.
  constexpr double guess_time = 0.6, worth = 0.9;
  const int n = int(located.size());
  double least = worth;
  int best = 0;
  for (int log = least_spacing_log; log <= most_spacing_log; ++log) {
    const int spacing = 1 << log;
    int right = 0, asked = 0;
    for (int at = 0; at + spacing < n; at += spacing) {
      const Location* const from = &located[std::size_t(at)];
      std::int64_t guessed[1 << most_spacing_log];
      guess_between(from[0].cell, from[spacing].cell, log, guessed);
      for (int k = 1; k < spacing; ++k)
        right += guessed[k] >= 0 && guessed[k] == from[k].cell;
      asked += spacing - 1;
    }
    const double anchors = 1.0 / spacing, wrong = 1.0 - double(right) / std::max(asked, 1);
    const double time = anchors + (1.0 - anchors) * (guess_time + wrong);
    if (time < least) {
      least = time;
      best = log;
    }
  }
  return best;
}

} // namespace

GuessedBatches::GuessedBatches(const PointQuery& query, BatchScratch& scratch, BatchLocator& tree,
                               BatchAnswers& answers)
    : query_(query), tree_(tree), s_(guess_scratch()), batch_(query, scratch, tree, answers) {
  const mesh::MeshView& mesh = query.mesh;
  all_own_ = mesh.piece_count == 1 && !mesh.pieces[0].may_not_exist() &&
             mesh.pieces[0].layout != mesh::CellLayout::mixed &&
             mesh.pieces[0].layout != mesh::CellLayout::padded;
}

bool GuessedBatches::may_pay(const PointQuery& query) {
  const mesh::MeshView& mesh = query.mesh;
  const ProofRule proof = query.proof();
  return proof.for_some() && query.options.alpha == 1.0 && proof.may_be_enough() &&
         mesh::is_one(mesh) && mesh.first_single_cell() == 0;
}

/// Guesses at cells that own no point are taken back, those for points for which a proof does not
/// count, and those of which it would not be enough.
void GuessedBatches::check_guesses(std::span<const Vec3d> points) {
  const mesh::MeshView& mesh = query_.mesh;
  const std::size_t n = points.size();
  const auto cells = std::uint64_t(mesh.cell_count());
  for (std::size_t q = 0; q < n; ++q)
    s_.guessed[q] = std::uint64_t(s_.guessed[q]) < cells ? s_.guessed[q] : -1;
  const ProofRule proof = query_.proof();
  if (!proof.for_all())
    for (std::size_t q = 0; q < n; ++q)
      if (!proof.counts_for(points[q]))
        s_.guessed[q] = -1;
  if (!proof.is_enough())
    for (std::size_t q = 0; q < n; ++q)
      if (s_.guessed[q] >= 0 && !proof.is_enough(s_.guessed[q]))
        s_.guessed[q] = -1;
  if (all_own_)
    return;
  for (std::size_t q = 0; q < n; ++q)
    if (const std::int64_t cell = s_.guessed[q]; cell >= 0) {
      const std::int32_t p = mesh.piece_of(cell);
      const std::int64_t local = cell - mesh.first_cell[p];
      if (!mesh.pieces[p].exists(local) || mesh.pieces[p].shape(local) == mesh::Shape::none)
        s_.guessed[q] = -1;
    }
}

/// Of points of which the first is number `from`, a multiple of the spacing, behind the first point
/// with a known cell. Those with one get it as their answer.
void GuessedBatches::guess(std::span<const Vec3d> points, std::size_t from) {
  const std::size_t spacing = std::size_t(1) << spacing_log_;
  for (std::size_t q = 0; q < points.size(); q += spacing) {
    const std::size_t at = (from + q) >> spacing_log_;
    const std::int64_t cell = s_.anchors[at].cell;
    const std::int64_t next = at + 1 < s_.anchors.size()
                                  ? s_.anchors[at + 1].cell
                                  : 2 * cell - s_.anchors[at - 1].cell; // the row goes on
    guess_between(cell, next, spacing_log_, &s_.guessed[q]);
    batch_.answer(q, s_.anchors[at], s_.reasons[at]);
  }
  check_guesses(points);
}

/// Points [begin, end); those behind are asked for.
void GuessedBatches::run_by_tree(std::span<const Vec3d> points, std::size_t begin, std::size_t end,
                                 Put put) {
  while (begin < end) {
    const std::size_t n = std::min<std::size_t>(batch_size, end - begin);
    ask_for_batch(points, begin + n);
    tree_.run(points.subspan(begin, n));
    put(begin, {tree_.locations(), tree_.reasons()});
    begin += n;
  }
}

/// By the tree.
void GuessedBatches::find_anchors(std::span<const Vec3d> points, std::size_t from) {
  s_.points.clear();
  s_.anchors.clear();
  s_.reasons.clear();
  for (; from < points.size(); from += std::size_t(1) << spacing_log_)
    s_.points.push_back(points[from]);
  run_by_tree(s_.points, 0, s_.points.size(), [&](std::size_t, const Answered& found) {
    s_.anchors.insert(s_.anchors.end(), found.locations.begin(), found.locations.end());
    s_.reasons.insert(s_.reasons.end(), found.reasons.begin(), found.reasons.end());
  });
}

void GuessedBatches::run(std::span<const Vec3d> points, std::size_t count, Put put) {
  const std::size_t first = std::min(trial, count);
  run_by_tree(points, 0, first, put);
  const std::size_t left = count - first;
  spacing_log_ = left > trial ? best_spacing_log(tree_.locations()) : 0;
  if (spacing_log_ == 0)
    return run_by_tree(points, first, count, put);
  find_anchors(points.first(count), first);
  for (std::size_t from = first; from < count; from += batch_size) {
    const std::size_t n = std::min<std::size_t>(batch_size, count - from);
    ask_for_batch(points, from + n);
    batch_.begin(points.subspan(from, n));
    guess(points.subspan(from, n), from - first);
    const std::int64_t proven = batch_.certify(s_.guessed, [](QueryId) {});
    proven_ += proven;
    batch_.answer_rest();
    put(from, batch_.answered());
    if (2 * proven < std::int64_t(n)) // another part of the mesh
      return run_by_tree(points, from + n, count, put);
  }
}

} // namespace insitu::query
