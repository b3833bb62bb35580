#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "advect/exits.h"
#include "advect/field/journey.h"
#include "advect/particles.h"
#include "core/parallel.h"

namespace insitu::advect {

/// A particle between two of its steps, or before its first place is found, wherever it is.
struct OnTheWay {
  bool is_marked = false;   ///< false: it begins its way through the interval
  bool stays = false;       ///< its next step is made here though its cell is another process's
  bool stays_here = false;  ///< so it was, when it was taken back
  bool is_new_step = false; ///< another one than was tried before
  std::int32_t hops = 0;    ///< so often it went from process to process in this interval
  std::int32_t tries = 0;   ///< so often its next step was taken back for a place elsewhere
  WayMark mark;             ///< if is_marked

  /// How the particle goes on from where its journey here was marked last, or taken back.
  OnTheWay after(const Journey& journey) const;
};

/// A particle on its way from one process to another, as bytes: cells by their names.
struct Traveller {
  Particles::Record particle;
  OnTheWay way;
  CellName cell;                 ///< of the particle's record
  std::array<CellName, 12> kept; ///< of the mark, in the order of for_each_cell()
  bool is_home = false;          ///< its way through the interval is over
  bool has_left = false;         ///< and where it left is to be told
  LeftAt left;

  /// As it leaves; the ids of cells are this process's. name_of(id): of any of them.
  void name_cells(core::FunctionRef<CellName(std::int64_t)> name_of);
  /// As it arrives in the process of this rank: the ids of cells are those here, -1 for a cell that
  /// does not exist here. Throws INSITU_ERROR_INTERNAL for a cell that this process owns and has
  /// not.
  void find_cells(const Homes& homes, int rank);
};
static_assert(std::is_trivially_copyable_v<Traveller>);

/// What a process asks of another one about a place.
struct Question {
  math::Vec3d point;
  double alpha, reach; ///< as of query::Elsewhere
  CellName cell;       ///< of the particle that asks, if it may go there, or none
  std::int64_t number; ///< of the asker
  std::uint8_t before; ///< among the cells of the step before a change of cells
  std::uint8_t goes;   ///< the particle may make its step there
  std::uint8_t padding[6] = {};
};
struct Answer {
  std::int64_t number;
  math::Vec3d parametric; ///< in the cell that holds the place
  math::Vec3d nearest;
  std::uint8_t holds;   ///< this process owns the cell that owns the place
  std::uint8_t goes;    ///< the particle's step is made here; else the cell follows
  std::uint8_t is_near; ///< nobody here holds it, but the nearest place that was asked for is here,
                        ///< or may be
  std::uint8_t padding[5] = {};
};

} // namespace insitu::advect
