#pragma once

#include <string>

#include "core/archive.h"
#include "output/files/checkpoint.h"
#include "parallel/world.h"

namespace insitu::scene {

/// Gives all processes what the root reads of a file. Collective, each item; throws
/// parallel::AgreedError.
class SharedReader final : public core::Archive {
public:
  /// at_root: null on other processes.
  SharedReader(parallel::World& world, output::CheckpointReader* at_root)
      : world_(world), at_root_(at_root) {}
  bool restores() const override { return true; }

private:
  void bytes(const char* name, std::size_t item_bytes, std::size_t count,
             core::FunctionRef<void*(std::size_t)> place) override;

  parallel::World& world_;
  output::CheckpointReader* at_root_;
};

} // namespace insitu::scene
