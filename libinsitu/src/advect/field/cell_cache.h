#pragma once

#include <cstdint>
#include <utility>

#include "advect/field/cells_beyond.h"
#include "advect/field/kept_cell.h"
#include "query/proof.h"

namespace insitu::advect {

/// How a kept cell holds a point.
enum class Held : std::uint8_t {
  no,
  inside,      ///< proven
  on_boundary, ///< on one of its faces, or beside it by what rounding makes of coordinates
};

/// Where a kept cell was found to hold a point.
struct PlaceInCell {
  std::int64_t cell = -1; ///< or -1: no kept cell did
  math::Vec3d x;
  double alpha = 1.0; ///< of the geometry
  math::Vec3d r;
  double margin = 0.0, error = 0.0; ///< see cells::InverseMap

  bool is_inside() const { return margin > error; }
  bool is_of(const math::Vec3d& point, const Moment& moment) const {
    return cell >= 0 && x == point && alpha == moment.geometry_alpha();
  }
};

/// The cells of a particle that are kept with all that is asked of them: the last two that held its
/// points or were tried, by turns, and its own cell, for a particle that is confined to one. A
/// point that is proven to be in a kept cell, or in one that is guessed from where the point lies
/// in a kept one, does without the sampler. The counts of points are told to the sampler in the
/// end.
class CellCache {
public:
  /// Of the moment's mesh and fields. The sampler must outlive the object.
  explicit CellCache(const Moment& moment);
  ~CellCache() {
    sampler_->count_certified(proven_);
    sampler_->count_on_faces(on_boundary_);
    sampler_->count_unguided(unguided_);
  }
  CellCache(const CellCache&) = delete;
  CellCache& operator=(const CellCache&) = delete;

  /// The cells in which points are looked for that the last cell does not hold; or null. It must
  /// outlive the object. Where cells overlap, another one may answer.
  void walk_by(const CellsBeyond* beyond) {
    if (by_places_)
      return; // places are as good a guide
    beyond_ = beyond && beyond->knows() ? beyond : nullptr;
    lacks_guide_ = serves() && beyond && beyond->lacks_neighbours();
  }
  /// From now on a point of a mesh that moves may be on the boundary of the cell that it is looked
  /// for in, to rounding, and that cell answers, for what is the same in all cells there.
  void take_boundaries(const Moment& moment) {
    takes_boundaries_ =
        moment.moves() && !moment.is_by_cell() && serves() && moment.accuracy() != INSITU_EXACT;
  }
  bool takes_boundaries() const { return takes_boundaries_; }
  /// Begins with a new particle: what is kept of another one's way must not decide where cells
  /// overlap.
  void begin() {
    for (KeptCell& k : cells_)
      k.forget();
  }

  /// The cells that are kept, by flat ids or -1; what is kept of them follows from the mesh.
  struct Kept {
    std::int64_t cells[2], own;
    std::int32_t last;
  };
  Kept keep() const { return {{kept_[0]->cell, kept_[1]->cell}, own_->cell, last_}; }
  void go_on_from(const Kept& kept, const Moment& moment);

  /// Whether proofs count for some points of the mesh; if not, no cell is kept.
  bool serves() const { return sound_ || proof_.for_some(); }
  /// Whether a proof counts for this point, of a cell that answers alone. None does in an adaptive
  /// mesh's dual that is found by places: these tell the coordinates of a point in a cell, which
  /// Newton's method finds to rounding alone, and the last digits must not hang on where the
  /// particle came from, which other processes do not know.
  bool counts_for(const math::Vec3d& x) const {
    return !by_places_ && (sound_ || proof_.counts_for(x));
  }
  /// Whether a cell answers alone for what it is proven to hold.
  bool answers_alone(KeptCell& k, const Moment& moment) const {
    if (!sound_)
      return true;
    if (k.sound == query::SoundCells::Known::unknown)
      find_sound(k, moment);
    return k.sound == query::SoundCells::Known::sound;
  }
  /// How a kept cell holds a point of which an inverse map found this.
  Held held(KeptCell& k, const Moment& moment, double margin, double error) {
    constexpr double rounding =
        1e-9; // so near to a face coordinates are put on it (put_on_nearest)
    const bool inside = margin > error;
    if ((inside ||
         (takes_boundaries_ && error < rounding && cells::is_on_boundary(margin, error))) &&
        answers_alone(k, moment))
      return inside ? Held::inside : Held::on_boundary;
    return Held::no;
  }
  /// Where that is asked a cell at a time, or null.
  const query::SoundCells* sound_cells() const { return sound_; }
  bool can_keep(std::int64_t cell) const;

  const KeptCell& own() const { return *own_; }
  /// The own cell, moved to a moment.
  KeptCell& own(const Moment& moment) {
    own_->move_to(moment);
    return *own_;
  }
  /// The kept cell that answered last.
  const KeptCell& last() const { return *kept_[last_]; }
  KeptCell& last(const Moment& moment) {
    kept_[last_]->move_to(moment);
    return *kept_[last_];
  }

  /// Finds the kept cell that holds x, and calls found(cell, inverse map, how). False, and it is
  /// not called: the sampler has to be asked. hint: the last cell of a particle whose first point
  /// this is, or -1.
  template <class Found>
  [[gnu::always_inline]] bool prove(const math::Vec3d& x, std::int64_t hint, const Moment& moment,
                                    const Found& found) {
    int walked = 0;
    const std::int64_t first = first_guess(hint);
    KeptCell* k = first >= 0 ? &beside(first, moment) : first_to_try(x);
    while (k) {
      k->move_to(moment);
      const auto map = cells::inverse_map(k->vertices.shape, k->vertices.x, x);
      if (const Held how = held(*k, moment, map.margin, map.error); how != Held::no) {
        answered(*k, how);
        found(*k, map, how);
        return true;
      }
      found_outside(map.converged, map.r);
      const std::int64_t next = next_guess(*k, walked);
      k = next >= 0 ? &beside(next, moment) : other_to_try(*k, x);
    }
    return false;
  }

  // The parts of prove(), for many particles at a time. The kept cells that may hold a point are
  // tried one after the other: the last, and one that is guessed from where the point lies in it,
  // or the other whose box holds it.

  /// Before a new particle's first point: its last cell, or -1.
  std::int64_t first_guess(std::int64_t hint) const {
    return kept_[last_]->cell < 0 && hint >= 0 && may_own(hint) ? hint : -1;
  }
  /// The kept cell that is tried first, or null.
  KeptCell* first_to_try(const math::Vec3d& x) const {
    KeptCell* const last = kept_[last_];
    if (beyond_ && beyond_->knows_most() ? last->cell >= 0 : last->may_hold(x))
      return last;
    return kept_[last_ ^ 1]->may_hold(x) ? kept_[last_ ^ 1] : nullptr;
  }
  /// A cell to go on to from one beyond whose faces a point was just found, or -1.
  std::int64_t next_guess(const KeptCell& tried, int& walked) const {
    if (!beyond_ || !outside_known_ || walked++ == beyond_->most_guesses())
      return -1;
    const std::int64_t cell = next_cell(tried, outside_, 0.0);
    return cell == kept_[last_]->cell ? -1 : cell;
  }
  /// The kept cell that is tried when nothing is guessed, or null.
  KeptCell* other_to_try(const KeptCell& tried, const math::Vec3d& x) const {
    KeptCell* const other = kept_[last_ ^ 1];
    return &tried != other && other->may_hold(x) ? other : nullptr;
  }
  void answered(const KeptCell& k, Held how) {
    count(how);
    last_ = &k == kept_[last_] ? last_ : last_ ^ 1;
  }
  void found_outside(bool converged, const math::Vec3d& r) {
    outside_known_ = converged;
    outside_ = r;
  }

  /// This cell, kept beside the last one.
  KeptCell& beside(std::int64_t cell, const Moment& moment) {
    KeptCell& k = *kept_[last_ ^ 1];
    if (k.cell != cell)
      load(k, cell, moment);
    return k;
  }
  /// This cell, which has answered, as the last one.
  const KeptCell& keep(std::int64_t cell, const Moment& moment);
  /// Makes this cell the own one; what was the own cell may be kept.
  KeptCell& take_own(std::int64_t cell, const Moment& moment);
  /// The own cell is kept as the one that answered last, and no own one any more.
  void give_back_own() {
    std::swap(own_, kept_[last_]);
    if (kept_[last_ ^ 1]->cell == kept_[last_]->cell)
      kept_[last_ ^ 1]->forget();
    own_->forget();
  }
  /// Asks for what open() reads of a cell, and opens the cell that will be kept next, if it is not
  /// kept.
  void foresee(std::int64_t cell) const;
  void expect(std::int64_t cell, const Moment& moment) {
    if (serves() && kept_[0]->cell != cell && kept_[1]->cell != cell && can_keep(cell))
      open(*kept_[last_ ^ 1], cell, moment);
  }

  /// The guess at the cell across the face of the own cell on which the point with coordinates r
  /// lies, for a point x beyond that face; or -1.
  std::int64_t across(const math::Vec3d& r, const math::Vec3d& x) const {
    return beyond_ && counts_for(x) ? next_cell(*own_, r, 1e-6) : -1;
  }
  /// The own cell, or else that which is guessed from where x lies in it, if one of them holds x;
  /// or none.
  query::Location near_own(const math::Vec3d& x, const Moment& moment);
  /// Whether x, at coordinates r on the boundary of this cell, is in the mesh, as far as cells that
  /// share vertices tell.
  bool closes(KeptCell& k, const Moment& moment, const math::Vec3d& r, double error);
  /// Whether the own cell or a kept one holds x at a moment.
  bool hold(const math::Vec3d& x, const Moment& moment);

  void count(Held how) { ++(how == Held::inside ? proven_ : on_boundary_); }
  /// The sampler is asked for a point that a neighbour of this cell might have held.
  void note_unguided(const KeptCell& from) { unguided_ += lacks_guide_ && from.cell >= 0; }

private:
  std::int64_t next_cell(const KeptCell& from, const math::Vec3d& r, double near) const;
  bool may_own(std::int64_t cell) const;
  void find_sound(KeptCell& k, const Moment& moment) const;
  void open(KeptCell& k, std::int64_t cell, const Moment& moment) const;
  void load(KeptCell& k, std::int64_t cell, const Moment& moment) const;

  const query::Sampler* sampler_;
  bool by_places_;                 ///< see counts_for()
  query::ProofRule proof_;         ///< of all coordinates between the steps
  const query::SoundCells* sound_; ///< instead, or null
  const CellsBeyond* beyond_ = nullptr;
  bool takes_boundaries_ = false;
  bool lacks_guide_ = false; ///< the guesses tell little, and a table would be better
  bool outside_known_ = false;
  math::Vec3d outside_;          ///< coordinates in the cell that was tried last
  std::int64_t proven_ = 0;      ///< points located without the sampler
  std::int64_t on_boundary_ = 0; ///< the same, on boundaries
  std::int64_t unguided_ = 0;    ///< points for which the sampler was asked for want of a guide
  KeptCell cells_[3];
  KeptCell* kept_[2] = {&cells_[0], &cells_[1]};
  KeptCell* own_ = &cells_[2];
  int last_ = 0; ///< of kept_, that which answered last
};

} // namespace insitu::advect
