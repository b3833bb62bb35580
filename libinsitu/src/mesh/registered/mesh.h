#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/archive.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/adaptive.h"
#include "mesh/faces.h"
#include "mesh/registered/adaptive_piece.h"
#include "mesh/registered/blank_values.h"
#include "mesh/registered/earlier_step.h"
#include "mesh/registered/external_array.h"
#include "mesh/registered/flat_piece.h"
#include "mesh/registered/given.h"
#include "mesh/view.h"

namespace insitu::mesh {

/// Trees keep flat cell ids in 32 bits.
constexpr std::int64_t most_cells = 0xffffffff;

/// Cells in place of the solver's own: an adaptive mesh's dual cells, or those of a geodetic mesh
/// with copies of some.
class StandIn {
public:
  virtual ~StandIn() = default;
  virtual const MeshView& view() const = 0;
  /// A field of the solver's on these cells; valid until the next commit.
  virtual FieldView field(const FieldView& own) = 0;
  /// If these are the solver's vertices, which move with it: view(), to which commits add what they
  /// find out. Else null.
  virtual MeshView* solver_view() { return nullptr; }
};

/// Pieces of other processes' cells that touch a mesh's own (commit/halo/halo.h). What they refer
/// to stays as it is until the mesh's next update().
class HaloPieces {
public:
  virtual ~HaloPieces() = default;
  virtual std::span<const PieceView> pieces() const = 0;
  /// The same of an adaptive mesh, whose pieces are leaves; the last `far` do not touch the mesh's.
  virtual std::span<const AmrPieceView> leaves() const { return {}; }
  virtual std::int32_t far_count() const { return 0; }
  /// See AmrView::covered.
  virtual const std::uint64_t* covered() const { return nullptr; }
  /// Of one of these; `no_values` where they were not brought here.
  virtual FieldPieceView values(const std::string& field, std::size_t piece) const = 0;
};

/// The components of a field on a piece whose values nobody reads: as many as a field may have.
extern const std::byte* const no_values[1 << 16];

/// What a solver registered: pieces, fields, ghosts. Holds pointers, never values, but for the
/// earlier step that pathlines need. Registrations may be incomplete until update().
class Mesh {
public:
  Mesh(std::string name, core::Memory& memory);
  Mesh(const Mesh&) = delete;
  Mesh& operator=(const Mesh&) = delete;

  const std::string& name() const { return name_; }

  // Registration; each throws core::Error and then changes nothing.
  void set_points(std::int32_t piece, const insitu_array* arrays, std::int32_t array_count);
  void set_cells(std::int32_t piece, const insitu_cells* cells);
  void set_faces(std::int32_t piece, const insitu_faces* faces); // mesh_faces.cpp
  void set_block(std::int32_t piece, const insitu_block* block);
  void set_field(std::int32_t piece, const std::string& name, insitu_association association,
                 const insitu_array* arrays, std::int32_t array_count);
  void remove_field(const std::string& name);
  /// Items of the field that hold this have no value; adds up (mesh_blanks.cpp).
  void add_blank(const std::string& name, double value);
  /// One byte a vertex, whose bit 2 says that no field on vertices has a value there; null: none.
  void set_hidden_points(std::int32_t piece, const insitu_array* array);
  void set_ghosts(std::int32_t piece, const insitu_array* array,
                  insitu_ghost_convention convention);
  /// One integer a cell or vertex of the piece, which is its number in the mesh of all processes;
  /// null: none (mesh_global_ids.cpp).
  void set_global_ids(std::int32_t piece, insitu_association association,
                      const insitu_array* array);
  // Of an adaptive mesh; the first makes it one (mesh_adaptive.cpp).
  void set_amr(const insitu_amr* amr);
  void set_patch(std::int32_t piece, const insitu_patch* patch);
  void set_leaves(std::int32_t piece, const insitu_leaves* leaves);
  void drop_pieces(std::int32_t first);
  /// Whether vertices of different pieces stay apart though they coincide (MeshView::join_pieces).
  void set_separate_pieces(bool separate);
  /// Whether other processes may have more of the mesh; of adaptive ones (AmrView::is_part).
  void set_is_part(bool is_part) { amr_view_.is_part = is_part; }
  void set_changed(std::uint32_t what) { pending_ |= what; }
  std::uint32_t pending() const { return pending_; }
  void clear_pending() { pending_ = 0; }

  /// Checks that the registrations fit each other and makes the views. Throws core::Error. Passes
  /// over leaves and pointers, when they are due, run on `threads`, or on the caller if null.
  void update(const core::Threads* threads = nullptr);
  /// Whether all coordinates of view() are finite and below this, read or not.
  bool vertices_are_within(double bound, const core::Threads& threads) const;

  // Of a flat mesh, whose cells stand upright in its views (mesh_flat.cpp).
  bool is_flat() const { return view_.is_flat; }
  /// What was found of its cells at the last update() that looked at them.
  const FlatFacts& flat_facts() const { return flat_facts_; }
  /// From the next update() on the plane and the thickness are those of these facts, of which
  /// flat_facts() are a part; null: those of flat_facts().
  void set_whole_flat(const FlatFacts* whole) { whole_flat_ = whole; }
  /// So many of the first coordinate are a full turn, around the Earth; 0: it does not turn. From
  /// the next change of topology on.
  void set_flat_turn(double turn) { flat_turn_ = turn; }
  /// Tells of cells of lower dimension that are left out, of the last update(); "": none are.
  std::string left_out() const;
  /// Has the next update() look at flat cells again, since arrays may have changed unsaid.
  void look_again() { flat_is_stale_ = true; }
  /// Copies made of flat cells.
  void audit_flat(std::vector<insitu_audit_entry>& entries) const;
  /// The number of vertices as the solver counts, without those of a halo.
  std::int64_t solver_vertex_count() const;

  /// Whether a piece has cells that are given by faces.
  bool has_faces() const;
  /// Of a piece, as of the last update(): its faces, or null where cells have shapes.
  const FacesView* faces(std::int32_t piece) const;
  /// What stands in for the cells of such a piece, until others are registered; kept by the caller.
  void set_parts(std::int32_t piece, const PartsView* parts);

  bool is_adaptive() const { return amr_.has_value(); }
  /// The pieces of an adaptive mesh as of the last update(), each checked by itself.
  const AmrView& adaptive() const { return amr_view_; }
  /// Of an adaptive mesh's cell, as the solver numbers levels.
  int level_of(std::int32_t piece, std::int64_t cell) const;
  insitu_reconstruction reconstruction() const { return amr_ ? amr_->reconstruction : INSITU_DUAL; }
  /// Whether an array lies in device memory: then the host reads none of the mesh.
  bool lies_on_device() const;

  /// The views of the last update(): of the stand-in's cells if there is one, and of the solver's
  /// own.
  const MeshView& view() const { return stand_in_ ? stand_in_->view() : view_; }
  const MeshView& own_view() const { return view_; }
  /// From now on view() and field() are the stand-in's; null: the solver's own.
  void set_stand_in(StandIn* stand_in) { stand_in_ = stand_in; }
  bool has_stand_in() const { return stand_in_ != nullptr; }
  /// Adds these pieces to the views, behind the solver's, from the next update() on; null: none.
  void set_halo(const HaloPieces* halo) { halo_ = halo; }
  void set_free_of_folds(bool free) { shown().free_of_folds = free; }
  void set_one_mesh(bool one) { shown().one_mesh = one; }
  void set_covers_once(bool once) { shown().covers_once = once; }

  /// Whether all pieces that have any have global ids, as of the last update().
  bool has_global_ids(insitu_association association) const { return has_global_ids_[association]; }
  /// Of a cell or vertex of own_view(); -1 if there are none. Of a flat mesh's vertices twice the
  /// solver's, and 1 added above the plane.
  std::int64_t global_id(insitu_association association, std::int64_t flat) const;
  /// Empty if the global ids of the cells that own points ascend, from piece to piece and in each;
  /// else where they do not.
  const std::string& global_ids_descend() const { return global_ids_descend_; }

  /// Registers what `from` has, as of its last update(), but for the vertices: those lie at
  /// points[from.own_view().first_vertex[piece] + id], borrowed; null: where `from` has them.
  /// Nothing else is copied but
  /// pointers, and these are taken anew with each call; what changed is up to set_changed(). Not of
  /// adaptive meshes.
  void share(const Mesh& from, const math::Vec3d* points);

  /// Which cells of an adaptive mesh are no leaves: a bit a flat cell, or null; kept by the caller.
  void set_masked(const std::uint64_t* masked);

  /// The field of that name, on view()'s cells and on own_view()'s; throws INSITU_ERROR_FIELD with
  /// the nearest name.
  FieldView field(const std::string& name) const;
  FieldView own_field(const std::string& name) const;
  bool has_field(const std::string& name) const;
  std::vector<std::string> field_names() const;

  /// Keeps copies of the coordinates and of these fields as the earlier step, for pathlines; called
  /// at the end of a step. Of a field that was kept at the end of the step before, too, older steps
  /// stay as far as it asks for them. What was kept is of the same cells: else release it.
  void keep_earlier(const std::vector<KeptField>& fields, const core::Threads& threads);
  /// The bytes that coordinates take in it. Of blocks whose coordinates come from axes, it keeps
  /// these.
  std::int64_t earlier_points_bytes() const;
  void release_earlier();
  /// Before keep_earlier(), so that the current step can be done again: what was kept so far, of
  /// whose fields the mesh has copies meanwhile, and back.
  StepsAside set_earlier_aside();
  void put_earlier_back(StepsAside steps);
  /// What was kept last, which then is kept here no more: the cells become others.
  TakenStep take_earlier(const core::Threads& threads);
  /// What was kept, for a checkpoint, and back: returns false, and changes nothing, if it does not
  /// fit the pieces as they are now (after update()).
  EarlierStep copy_earlier() const;
  bool set_earlier(const EarlierStep& step);
  /// The copy of a field at the step before, if one was kept; valid until the next keep or release.
  std::optional<FieldView> earlier_field(const std::string& name) const;
  /// The same of all steps that were kept, the latest first.
  std::vector<FieldView> earlier_fields(const std::string& name) const;
  /// Shows the kept coordinates in view(), once the solver moved its own and committed, until the
  /// next commit; whether there are any to be shown: not if no vertex moved, unless they are to be
  /// shown even then, since those of other processes moved. The largest displacement is infinite
  /// until it is found.
  bool show_earlier(const core::Threads& threads, bool even_if_still = false);
  void find_displacement(const core::Threads& threads);
  void hide_earlier();

  /// Every registered array, in a fixed order, by the name that the audit gives it.
  enum class ArrayKind { geometry, topology, field };
  using ArrayVisitor =
      core::FunctionRef<void(const ExternalArray&, const std::string& name, ArrayKind)>;
  void visit_arrays(ArrayVisitor visit) const;
  /// The same of one field alone; of none if there is no such field.
  void visit_field_arrays(const std::string& name, ArrayVisitor visit) const;
  /// The same of all fields of one piece.
  void visit_piece_fields(std::int32_t piece, ArrayVisitor visit) const;
  /// What was given, piece by piece and beside the pieces (mesh_given.cpp); valid until something
  /// else is given.
  std::int32_t given_piece_count() const { return std::int32_t(pieces_.size()); }
  GivenPiece given_piece(std::int32_t piece) const;
  GivenMesh given() const;
  /// The copy audit, in the same order.
  std::vector<insitu_audit_entry> audit() const;
  std::int64_t bytes_borrowed() const;

private:
  struct Piece {
    bool has_cells = false, has_points = false, is_block = false;
    GivenCells given;
    PieceView view;
    std::vector<ExternalArray> points;
    ExternalArray connectivity, types, offsets, ghosts, hidden_points, axes[3];
    ExternalArray global_ids[2]; ///< [association]
    std::vector<std::pair<ExternalArray, const char*>>
        face_arrays; ///< those given, and their names
    std::optional<FacesView> faces;
    AmrPiece amr;
    int point_components = 3;
    FlatCells flat_cells; ///< if the cells are flat: what they are
    std::shared_ptr<FlatPiece> flat;
    std::shared_ptr<LeftOutCells> left_out;

    /// What is registered apart from the cells stays, whichever is registered first.
    void set_cells_view(PieceView cells);
  };
  std::int64_t cells_of(std::size_t p) const {
    return amr_ ? amr_pieces_[p].cell_count : pieces_[p].view.cell_count;
  }
  static std::int64_t vertices_of(const Piece& p) {
    return p.is_block ? p.view.vertex_count : p.view.points.layout.count;
  }
  struct FieldPiece {
    std::vector<ExternalArray> arrays;
    std::vector<const std::byte*> components;
    std::vector<std::int64_t> behind; ///< see FieldPieceView
    ItemLayout layout;
    bool is_float32 = false;
    bool pointers_checked = true;
    std::shared_ptr<BlankedValues> blanked; ///< read instead, if not null
    std::shared_ptr<BlankedValues> in_rows; ///< the same, of a flat mesh's vertices

    FieldPieceView view() const {
      return {components.data(), layout, is_float32, behind.empty() ? nullptr : behind.data()};
    }
  };
  struct Field {
    std::string name;
    insitu_association association = INSITU_VERTEX;
    int components = 0;
    std::vector<double> blanks; ///< values that are none
    std::vector<FieldPiece> pieces;
    std::vector<FieldPieceView> views;
  };

  /// view(), unless the stand-in's vertices are its own.
  MeshView& shown() {
    MeshView* const shown = stand_in_ ? stand_in_->solver_view() : nullptr;
    return shown ? *shown : view_;
  }
  void keep_points(const MeshView& now, const core::Threads& threads);
  void keep_axes(const MeshView& now);
  bool axes_stand(const MeshView& now) const;
  bool points_stand(const MeshView& now) const;
  bool kept_fits(const MeshView& now) const;
  void make_earlier_points(const core::Threads& threads);
  /// Cells on lattices, and those of a dual: where they are needs no copy.
  bool has_still_vertices() const {
    return is_adaptive() || (stand_in_ && !stand_in_->solver_view());
  }
  void add_halo();
  void set_views();
  EarlierField& earlier_field_for(const std::string& name, insitu_association association,
                                  int components);
  void make_leaves_views();
  Piece& piece_for(std::int32_t piece);
  const Field* find(const std::string& name) const;
  static void visit_field_piece(const Field& field, std::size_t p, ArrayVisitor visit);
  void check_piece(std::size_t p) const;
  void check_field(const Field& field) const;
  void check_global_ids(const core::Threads* threads);
  void check_global_ids(std::size_t p, insitu_association of, std::int64_t& last,
                        const core::Threads* threads);
  void check_pointers(Field& field, const core::Threads* threads) const;
  /// Counts the ids of faces that lie behind pointers, none of which may be null.
  void count_rings(std::size_t piece);
  void update_fields(const core::Threads* threads);
  bool hides_points(const Field& field, std::size_t p) const;
  bool has_blanks(const Field& field) const;
  void audit_blanks(std::vector<insitu_audit_entry>& entries) const;
  void find_flat_pieces(const core::Threads* threads);
  void update_flat(const core::Threads* threads);
  void add_flat_view(FieldPiece& piece, std::size_t p, int components, FieldPieceView& view,
                     const core::Threads* threads) const;
  void add_view(Field& field, std::size_t p, const core::Threads* threads) const;
  // Adaptive meshes.
  void refuse_if_adaptive(const std::string& name) const;
  const AmrLevels& levels_for(const std::string& name) const;
  void update_adaptive(const core::Threads* threads);

  std::string name_;
  std::uint32_t pending_ = INSITU_CHANGED_ALL;
  bool separate_pieces_ = false;
  bool has_global_ids_[2] = {false, false}; ///< [association]
  std::string global_ids_descend_;
  std::vector<Piece> pieces_;
  std::vector<std::unique_ptr<Field>> fields_;
  // Flat meshes.
  bool has_flat_pieces_ = false, flat_is_stale_ = false;
  FlatFacts flat_facts_;
  const FlatFacts* whole_flat_ = nullptr;
  double flat_turn_ = 0.0;
  FlatSlab slab_;
  // Views.
  std::vector<PieceView> piece_views_;
  std::vector<std::int64_t> first_cell_{0}, first_vertex_{0};
  MeshView view_;
  StandIn* stand_in_ = nullptr;
  const HaloPieces* halo_ = nullptr;
  // Of an adaptive mesh.
  std::optional<AmrLevels> amr_;
  std::vector<AmrPieceView> amr_pieces_;
  AmrView amr_view_;
  std::vector<LeavesView> leaves_views_;
  const std::uint64_t* masked_ = nullptr;
  // The earlier step.
  core::Memory* memory_;
  core::Buffer<math::Vec3d> earlier_points_;
  std::vector<PieceView> earlier_blocks_; ///< in place of points: all pieces, on earlier_axes_
  core::Buffer<double> earlier_axes_;
  std::vector<std::unique_ptr<EarlierField>> earlier_fields_;
};

} // namespace insitu::mesh
