#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "catalyst/loader/tree.h"

namespace insitu_replay {

/// The arrays of a run's dumps, each where it was in the call before: a solver that writes its
/// fields and coordinates anew does so in place, and the session tells by the places what stays.
class DumpArrays {
public:
  /// Copies the leaves of a call's tree to their places. Returns false if some still need the
  /// dump's own bytes, as they are not packed. process: whose tree it is.
  bool take(insitu::catalyst::Tree& tree, std::size_t process);
  /// After a call: arrays that were replaced by others of another size are given no more.
  void forget_replaced() { replaced_.clear(); }

private:
  struct Array {
    insitu::catalyst::Tree::TypeId type;
    std::int64_t count;
    std::vector<char> bytes;
  };
  bool take(insitu::catalyst::Tree& tree, const std::string& path);

  std::map<std::string, Array> arrays_; ///< by their paths
  std::vector<Array> replaced_;
};

} // namespace insitu_replay
