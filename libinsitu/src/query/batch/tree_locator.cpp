#include "query/batch/tree_locator.h"

#include <algorithm>
#include <memory>

#include "query/batch/guessed_batches.h"

namespace insitu::query {

using math::Vec3d;

namespace {

class TreeBatches : public Batches {
public:
  explicit TreeBatches(BatchLocator& tree) : tree_(tree) {}
  Answered run(std::span<const Vec3d> points) override {
    tree_.run(points);
    return {tree_.locations(), tree_.reasons()};
  }

private:
  BatchLocator& tree_;
};

class GuessedTreeBatches final : public TreeBatches {
public:
  GuessedTreeBatches(const PointQuery& query, BatchLocator& tree)
      : TreeBatches(tree), guesses_(query, batch_scratch(), tree, batch_answers()) {}
  void run_grain(std::span<const Vec3d> points, std::size_t count, Put put) override {
    guesses_.run(points, count, put);
  }

private:
  GuessedBatches guesses_;
};

} // namespace

BatchScratch& batch_scratch() {
  thread_local std::unique_ptr<BatchScratch> scratch = std::make_unique<BatchScratch>();
  return *scratch;
}

BatchAnswers& batch_answers() {
  thread_local std::unique_ptr<BatchAnswers> answers = std::make_unique<BatchAnswers>();
  return *answers;
}

void Batches::run_grain(std::span<const Vec3d> points, std::size_t count, Put put) {
  for (std::size_t first = 0; first < count; first += batch_size) {
    const std::size_t n = std::min<std::size_t>(batch_size, count - first);
    ask_for_batch(points, first + n);
    put(first, run(points.subspan(first, n)));
  }
}

void TreeLocator::with_batches(const PointQuery& query, Ask ask) const {
  BatchLocator tree(query, batch_scratch());
  if (GuessedBatches::may_pay(query)) {
    GuessedTreeBatches batches(query, tree);
    ask(batches);
  } else {
    TreeBatches batches(tree);
    ask(batches);
  }
}

const TreeLocator& TreeLocator::plain() {
  static const TreeLocator locator;
  return locator;
}

} // namespace insitu::query
