#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "advect/effects/effects.h"
#include "advect/field/homes.h"
#include "mesh/box.h"
#include "mesh/view.h"
#include "parallel/bytes.h"
#include "query/directory.h"
#include "query/elsewhere.h"
#include "query/sampler.h"

/// Particles on several processes: the places that they ask for beyond the cells that are here.
namespace insitu::advect {

/// Cells of other processes that hold places for which steps have asked in one interval of time:
/// copies of their vertices and of the fields that particles need, behind the cells of a sampler's
/// mesh. A place that is strictly inside a cell that is here, and answers alone, is in that; each
/// other place is asked for once, and the answer of its owner is then that of sampler(), to the
/// bit: so a step over any number of processes is made by the code of one. Calls that are const are
/// thread-safe; the others are for the thread that called the library, while nobody asks.
class FarCells final : public query::Outlook {
public:
  /// A field at the current step and, latest first, at those before.
  struct InTime {
    mesh::FieldView* now;
    std::vector<mesh::FieldView>* earlier = nullptr;
  };
  /// What processes have to agree on, since one without cells may know less: the greatest number of
  /// each counts.
  static std::vector<std::int64_t> facts(const query::Sampler& here,
                                         std::span<const InTime> fields);

  /// here: of this process's cells, and of those around them; homes: who owns them; others: boxes
  /// of all processes' cells. The fields become those of sampler().
  FarCells(const query::Sampler& here, const Homes& homes, query::Directory others, int rank,
           std::span<const InTime> fields, std::span<const std::int64_t> facts);
  /// Of cells that were gathered from all processes: the sampler's outlook says what is beyond
  /// them, and asks this one until it goes. Who gathered a place has all cells that hold it.
  FarCells(const query::Sampler& here, std::span<const InTime> fields,
           std::span<const std::int64_t> facts);
  ~FarCells() override;
  FarCells(const FarCells&) = delete;
  FarCells& operator=(const FarCells&) = delete;

  /// On the cells that are here and those that came.
  const query::Sampler& sampler() const { return sampler_; }
  /// Who owns all of these.
  const Homes& homes() const { return homes_; }
  bool is_far(std::int64_t cell) const { return cell >= first_; }

  bool is_beyond(const math::Vec3d& point) const override;
  query::Location find(const math::Vec3d& point, double alpha) const override;
  std::optional<math::Vec3d> nearest(const math::Vec3d& point, double reach,
                                     double alpha) const override;
  std::vector<int> ranks_at(const math::Vec3d& point, double reach) const override;

  /// What a process says of a place.
  struct Answer {
    bool holds = false;                 ///< it owns the place: `at` is it
    bool is_near = false;               ///< otherwise: cells of it may lie within near_
    std::optional<math::Vec3d> nearest; ///< within the reach that was asked for
    query::Location at;
  };
  Answer answer(const math::Vec3d& point, double alpha, double reach,
                insitu_accuracy accuracy) const;
  /// Writes a cell with all that is needed of it; and takes what another process wrote, whose id
  /// here is returned. What was taken is there after set_views().
  void tell(std::int64_t cell, insitu_accuracy accuracy, parallel::ByteWriter& to) const;
  std::int64_t take(int rank, parallel::ByteReader& from);
  void set_views();
  /// What all processes together have said.
  void know(const math::Vec3d& point, double alpha, const query::Location& at, bool is_near) {
    known_[{point, alpha, 0.0}] = {at, is_near, std::nullopt};
  }
  void know_nearest(const math::Vec3d& point, double alpha, double reach,
                    const std::optional<math::Vec3d>& nearest) {
    known_[{point, alpha, reach}] = {{}, false, nearest};
  }

private:
  /// A place that was asked for.
  struct Asked {
    math::Vec3d point;
    double alpha, reach;
    bool operator==(const Asked& b) const;
  };
  struct Hash {
    std::size_t operator()(const Asked& asked) const;
  };
  struct Known {
    query::Location at;
    bool is_near;
    std::optional<math::Vec3d> nearest;
  };
  class AllHomes final : public Homes {
  public:
    AllHomes(const FarCells& cells, const Homes* here) : cells_(cells), here_(here) {}
    bool is_own(std::int64_t cell) const override;
    CellName name(std::int64_t cell) const override;
    std::int64_t find(const CellName& name) const override;

  private:
    const FarCells& cells_;
    const Homes* here_; ///< null: nobody asks
  };
  /// The cells on one chart (geo::Pole), as a piece of the view.
  struct Piece {
    std::vector<std::uint8_t> types;
    std::vector<std::int64_t> offsets;
    std::vector<std::int32_t> connectivity;
    std::vector<math::Vec3d> points, earlier;
    std::vector<CellName> names;
  };
  struct Field {
    mesh::FieldView view;
    std::vector<mesh::FieldPieceView> pieces;
    struct Of {
      std::vector<double> values;
      std::vector<const std::byte*> components;
    };
    std::vector<Of> of; ///< [piece that is far]
  };

  /// Cells that answer alone, near each other or not, and their boxes at all times.
  struct Group {
    static constexpr std::size_t size = 32;
    mesh::Box all;
    std::vector<mesh::Box> boxes;
    std::vector<std::int64_t> cells;
  };

  static mesh::Box wider_box(const mesh::Box& box, double by) {
    const math::Vec3d all{by, by, by};
    return {box.low - all, box.high + all};
  }
  query::Location inside(const math::Vec3d& point, double alpha) const;
  void add_alone(std::int64_t id, const Piece& piece, std::size_t first);
  void begin(std::span<const InTime> fields, std::span<const std::int64_t> facts);
  void take_field(mesh::FieldView& field);
  std::size_t first_piece() const { return pieces_.size() - far_.size(); }

  const query::Sampler here_; ///< without an outlook, among images
  query::Sampler sampler_;
  const query::Outlook* beyond_ = nullptr; ///< of cells that were gathered
  const int rank_ = -1;
  const query::Directory directory_;
  double near_ = 0.0; ///< so far from a place cells are looked for that may be nearest to it
  AllHomes homes_;
  std::int64_t first_ = 0; ///< the flat id of the first cell that may come
  bool moves_ = false;     ///< the mesh of any process
  mesh::MeshView view_;
  std::vector<mesh::PieceView> pieces_;
  std::vector<std::int64_t> first_cell_, first_vertex_;
  std::vector<math::Vec3d> earlier_; ///< of all vertices, once a cell has come
  std::vector<Piece> far_;           ///< one; on a chart three
  std::vector<std::unique_ptr<Field>> fields_;
  std::map<std::pair<int, std::int64_t>, std::int64_t> ids_; ///< of cells, by process and id there
  std::map<CellName, std::int64_t> by_name_;
  std::vector<Group> groups_;
  std::unordered_map<Asked, Known, Hash> known_;
};

/// The fields of effects, in an order that all processes have.
void add_fields(std::vector<Drift>& drifts, std::vector<FarCells::InTime>& to);
void add_fields(Effects& effects, std::vector<FarCells::InTime>& to);

} // namespace insitu::advect
