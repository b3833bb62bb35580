#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "parallel/bytes.h"
#include "render/volume/volume.h"

/// What is sent of runs of samples that a process has composited (VolumeMarcher::Run).
namespace insitu::render {

using parallel::ByteReader;
using parallel::ByteWriter;

/// What there is of each run.
struct RunForm {
  bool has_hits = false; ///< several pieces, between hits
  bool is_preintegrated = false;
  bool is_lit = false;
};

/// Bytes of a run of one piece; of how many pieces there are, and of each, where there are hits; of
/// its values at both ends, where it is pre-integrated; and of both gradients, where it is lit too.
constexpr std::int64_t bytes_a_composite = 20, bytes_a_piece_count = 4, bytes_a_hit_count = 4,
                       bytes_of_values = 16, bytes_of_gradients = 48;

/// Writes the runs of rays from the tile's ray `first_ray` on. first: the round's first sample.
void write_runs(const VolumeMarcher::Runs& runs, std::size_t first_ray, std::int64_t first,
                const RunForm& form, ByteWriter& to);

/// The runs of all processes on a tile's rays in a round.
class SentRuns {
public:
  struct Sent : VolumeMarcher::Run {
    int process = -1;
    std::uint32_t first_piece = 0;
  };

  /// rays: how many the tile has.
  void clear(std::size_t rays);
  /// Those of a process, as they were written.
  void add(int process, ByteReader from, std::int64_t first, const RunForm& form);
  /// After all were added.
  void put_in_order();
  /// Of a ray: by depth.
  std::span<const Sent> of(std::size_t ray) const {
    return {sorted_.data() + begin_[ray], sorted_.data() + begin_[ray + 1]};
  }
  std::span<const RayPiece> pieces(const Sent& run) const {
    return {pieces_.data() + run.first_piece, run.pieces};
  }
  /// Whether two processes have the same sample of a ray.
  static bool overlap(std::span<const Sent> runs);

private:
  std::vector<Sent> runs_, sorted_;
  std::vector<std::uint32_t> begin_; ///< by ray, in sorted_
  std::vector<RayPiece> pieces_;
};

} // namespace insitu::render
