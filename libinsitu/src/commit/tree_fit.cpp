#include "commit/tree_fit.h"

#include "core/timer.h"

namespace insitu::commit {

void TreeFit::put_off(int threads) {
  tree_.mark_odd(mesh_.view(), {}, core::Threads(1)); // which cells are odd is not known any more
  threads_ = threads;
  ++done_.put_off;
  set_due(true);
}

void TreeFit::put_off_build(int threads) {
  (void)tree_.take();
  lacks_tree_ = true;
  threads_ = threads;
  ++done_.put_off;
  set_due(true);
}

void TreeFit::forget() {
  lacks_tree_ = false;
  set_due(false);
}

void TreeFit::build(const core::Threads& threads) const {
  const accel::Builder builder = policy_.builder();
  lacks_tree_ = true; // until built: a build that fails leaves no tree
  const core::Timer timer;
  tree_.build(mesh_.view(), threads, builder);
  lacks_tree_ = false;
  policy_.built(builder, timer.seconds(), tree_.cell_count(), tree_.cost());
  ++done_.rebuilds;
  action_ = INSITU_REBUILD;
}

void TreeFit::do_it() const {
  const core::Threads threads(threads_);
  const core::Timer timer;
  if (!lacks_tree_) {
    tree_.refit(mesh_.view(), threads);
    ++done_.refits;
    action_ = INSITU_REFIT;
  }
  if (lacks_tree_ || policy_.rebuild_is_due(tree_.cost_ratio()))
    build(threads);
  if (!odd_.ids.empty())
    tree_.mark_odd(mesh_.view(), odd_.ids, threads);
  done_.seconds += timer.seconds();
}

} // namespace insitu::commit
