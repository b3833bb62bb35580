/** @file mesh.hpp
 *  The meshes of a session, for insitu.hpp, which includes this file. */
#ifndef INSITU_MESH_HPP
#define INSITU_MESH_HPP

#include <algorithm>

#include "insitu/piece.hpp"
#include "insitu/types.hpp"

namespace insitu {

/** A mesh of a session: its piece 0, further pieces, and queries. A Mesh is cheap to copy; all
 *  copies, and all that Session::mesh() returns for one name, are the same mesh, which the session
 *  owns. Once the session is closed, each call throws INSITU_ERROR_HANDLE. */
class Mesh : public Piece {
public:
  /** Makes a Mesh of no session, until another Mesh is assigned to it. */
  Mesh() : Piece(nullptr, 0) {}

  /** Returns piece p. Pieces are numbered from 0 without gaps, in the order of their first use. */
  Piece piece(int p) const { return Piece(state(), p); }

  /** Makes the mesh an adaptive one, of patches or leaves. The first call comes before the mesh's
   *  first piece; a later call changes the lattice or the reconstruction. */
  void adaptive(const AmrLevels& levels) {
    insitu_amr a = insitu_amr_default();
    std::copy(levels.origin.begin(), levels.origin.end(), a.origin);
    std::copy(levels.spacing.begin(), levels.spacing.end(), a.spacing);
    a.level_count =
        levels.ratios.empty() ? levels.count : static_cast<int>(levels.ratios.size()) + 1;
    a.ratios = levels.ratios.empty() ? nullptr : levels.ratios.data();
    a.finest_first = levels.finest_first ? 1 : 0;
    a.reconstruction = static_cast<insitu_reconstruction>(levels.reconstruction);
    a.dimensions = levels.dimensions;
    detail::check(insitu_mesh_amr(handle(), &a));
  }
  /** Returns what the last regrid of an adaptive mesh made. Throws INSITU_ERROR_ORDER before its
   *  commit. */
  AmrInfo amr_info() const {
    AmrInfo info = insitu_amr_info_default();
    detail::check(insitu_mesh_amr_info(handle(), &info));
    return info;
  }
  /** Returns the levels of the cells of an adaptive mesh that points lie in, as the solver numbers
   *  levels; -1 outside. cell_base: that of the answers (LocateOptions). */
  std::vector<std::int32_t> cell_levels(const Locations& at, std::int64_t cell_base = 0) const {
    std::vector<std::int32_t> levels(at.cells.size());
    detail::check(insitu_mesh_cell_levels(handle(), static_cast<std::int64_t>(levels.size()),
                                          at.cells.data(), at.pieces.data(), cell_base,
                                          levels.data()));
    return levels;
  }
  /** Says whether pieces stand for themselves (insitu_mesh_separate_pieces). */
  void separate_pieces(bool separate = true) {
    detail::check(insitu_mesh_separate_pieces(handle(), separate));
  }
  /** Drops the pieces from `first` on, since a regrid may leave fewer patches. */
  void drop_pieces(int first) { detail::check(insitu_mesh_drop_pieces(handle(), first)); }

  /** Tells the library what changed since the last commit; calls add up. Calls that give new arrays
   *  and cells imply it. */
  void changed(Change what) { detail::check(insitu_mesh_changed(handle(), what)); }
  /** Says that the arrays cannot be given, and why: until accept() commits throw
   *  INSITU_ERROR_MESH with this message, on all processes (insitu_mesh_refuse). */
  void refuse(const std::string& message) {
    detail::check(insitu_mesh_refuse(handle(), message.c_str()));
  }
  void accept() { detail::check(insitu_mesh_refuse(handle(), nullptr)); }
  /** Says that items of the field that hold this value have no value (insitu_mesh_field_blank). */
  void field_blank(const std::string& name, double value) {
    detail::check(insitu_mesh_field_blank(handle(), name.c_str(), value));
  }
  void remove_field(const std::string& name) {
    detail::check(insitu_mesh_remove_field(handle(), name.c_str()));
  }
  /** Sets the frame of the mesh's coordinates, which is cartesian at first. */
  void frame(const Frame& frame) { detail::check(insitu_mesh_frame(handle(), &frame.get())); }

  /** Chooses the locator, in place of the scene's choice; the next commit makes it. Throws
   *  INSITU_ERROR_UNSUPPORTED if an explicit choice cannot be had here. */
  void locator(Method method, Backend backend = Backend::automatic) {
    insitu_locator l = insitu_locator_default();
    l.method = static_cast<insitu_method>(method);
    l.backend = static_cast<insitu_backend>(backend);
    detail::check(insitu_mesh_locator(handle(), &l));
  }
  /** Returns what answers queries since the last commit, why, and how it decided points. Throws
   *  INSITU_ERROR_ORDER before the first commit. */
  LocatorInfo locator_info() const {
    LocatorInfo info = insitu_locator_info_default();
    detail::check(insitu_mesh_locator_info(handle(), &info));
    return info;
  }

  /** Brings the structures up to date, and reports what was done, how long it took, and what it
   *  allocated. Session::execute commits by itself. Throws INSITU_ERROR_MESH if validation refuses
   *  the mesh, INSITU_ERROR_FIELD if a field does not fit. */
  CommitReport commit() {
    CommitReport report = insitu_commit_report_default();
    detail::check(insitu_mesh_commit(handle(), &report));
    return report;
  }
  /** Does now what the last commit has put off until a query needs it, and reports what that was.
   *  Throws INSITU_ERROR_ORDER if the mesh is not committed. */
  CommitReport complete() {
    CommitReport report = insitu_commit_report_default();
    detail::check(insitu_mesh_complete(handle(), &report));
    return report;
  }
  /** Validates the arrays as they are now. A mesh that a commit would refuse makes no exception
   *  here. */
  Validation validate() {
    Validation v{insitu_validation_default(), true, {}};
    const insitu_status status = insitu_mesh_validate(handle(), &v.counts);
    if (status != INSITU_OK && status != INSITU_ERROR_MESH)
      detail::check(status);
    v.accepted = status == INSITU_OK;
    if (!v.accepted)
      v.findings = insitu_last_message();
    return v;
  }
  /** Returns the copy audit: each array, the pointer that the library reads, and whether the memory
   *  is the caller's own. */
  std::vector<AuditEntry> audit() const {
    std::int32_t count = 0;
    detail::check(insitu_mesh_audit(handle(), nullptr, &count));
    std::vector<AuditEntry> entries(static_cast<std::size_t>(count));
    if (count > 0)
      detail::check(insitu_mesh_audit(handle(), entries.data(), &count));
    return entries;
  }

  /** Finds the cell that owns each point, after a commit: the lowest (piece, cell) of the closed
   *  cells that hold the point (insitu_accuracy tells where Accuracy::standard may differ), and
   *  never a ghost cell. NaN and infinite points are outside. */
  Locations locate(const Points& points, const LocateOptions& options = {}) const {
    Locations out;
    insitu_locate_args args{};
    take_memory(options, [&] { args = locate_args(points, options, out); });
    detail::check(insitu_mesh_locate(handle(), &args));
    return out;
  }
  /** Locates points, and interpolates a field: vertex fields by the cell's shape functions, cell
   *  fields by the owner's value. Points that are outside get NaN. */
  Samples sample(const std::string& field, const Points& points,
                 const LocateOptions& options = {}) const {
    Samples out;
    out.components = components_of(field, options);
    insitu_locate_args args{};
    take_memory(options, [&] {
      out.values.resize(points.size() * static_cast<std::size_t>(out.components));
      args = locate_args(points, options, out);
    });
    const char* name = field.c_str();
    double* values = out.values.data();
    sample_into(1, &name, &values, args);
    return out;
  }
  /** Does as sample() for several fields, and locates points once. */
  FieldSamples sample_fields(const std::vector<std::string>& names, const Points& points,
                             const LocateOptions& options = {}) const {
    FieldSamples out;
    std::vector<const char*> c_names;
    std::vector<double*> values;
    insitu_locate_args args{};
    take_memory(options, [&] {
      out.values.reserve(names.size());
      for (const std::string& name : names) {
        const int n = components_of(name, options);
        out.values.push_back(
            {name, n, std::vector<double>(points.size() * static_cast<std::size_t>(n))});
        c_names.push_back(name.c_str());
        values.push_back(out.values.back().values.data());
      }
      args = locate_args(points, options, out);
    });
    sample_into(names.size(), c_names.data(), values.data(), args);
    return out;
  }
  /** Samples a field at one point in the mesh's frame, and allocates nothing. The call fills
   *  values, which has one item a component of the field (NaN outside), and returns whether the
   *  point is inside. */
  bool sample_point(const std::string& field, const std::array<double, 3>& point,
                    View<double> values) const {
    const int n = field_info(field).components;
    if (values.size() != static_cast<std::size_t>(n))
      detail::refuse("values", detail::text(static_cast<std::int64_t>(values.size())) +
                                   " given, field '" + field + "' has " + detail::text(n) +
                                   " components");
    std::int32_t found = 0;
    detail::check(
        insitu_mesh_sample_point(handle(), field.c_str(), point.data(), values.data(), &found));
    return found != 0;
  }
  /** Finds the vertices nearest to each point, `most` of them (insitu_mesh_nearest_vertices), with
   *  the frame, greatest distance and scope of the options. */
  NearestVertices nearest_vertices(const Points& points, int most = 1,
                                   const LocateOptions& options = {}) const {
    NearestVertices out;
    out.most = static_cast<std::size_t>(std::max(most, 0));
    take_memory(options, [&] {
      const std::size_t n = points.size() * out.most;
      out.vertices.resize(n);
      out.pieces.resize(n);
      out.ranks.resize(n);
      out.global_vertices.resize(n);
      out.distances.resize(n);
      out.places.resize(3 * n);
    });
    insitu_vertices_args args = insitu_vertices_args_default();
    args.points = points.arrays();
    args.point_arrays = points.array_count();
    args.nearest = most;
    args.frame = options.frame ? &options.frame->get() : nullptr;
    args.greatest_distance = options.greatest_distance;
    args.scope = options.everywhere ? INSITU_SCOPE_EVERYWHERE : INSITU_SCOPE_LOCAL;
    args.vertices = out.vertices.data();
    args.pieces = out.pieces.data();
    args.ranks = out.ranks.data();
    args.global_vertices = out.global_vertices.data();
    args.distances = out.distances.data();
    args.places = out.places.data();
    detail::check(insitu_mesh_nearest_vertices(handle(), &args));
    return out;
  }
  FieldInfo field_info(const std::string& name) const {
    std::int32_t components = 0;
    insitu_association association = INSITU_VERTEX;
    detail::check(insitu_mesh_field_info(handle(), name.c_str(), &components, &association));
    return {components, static_cast<Association>(association)};
  }

  /** Returns the handle for calls of insitu.h; it belongs to the session. */
  using Piece::handle;

private:
  friend class Session;

  explicit Mesh(std::shared_ptr<detail::MeshState> state) : Piece(std::move(state), 0) {}

  /** Of a query everywhere 0 for a field that is not here: the others must not wait for a process
   *  that throws, and a query of points at which it cannot take values fails on all alike. */
  int components_of(const std::string& field, const LocateOptions& options) const {
    if (!options.everywhere)
      return field_info(field).components;
    std::int32_t components = 0;
    insitu_association association = INSITU_VERTEX;
    return insitu_mesh_field_info(handle(), field.c_str(), &components, &association) == INSITU_OK
               ? components
               : 0;
  }

  /** Takes the memory of answers. A process that lacks it tells the others of a query everywhere,
   *  which then fails on all alike. */
  template <class Take>
  void take_memory(const LocateOptions& options, Take&& take) const {
    try {
      take();
    } catch (const std::bad_alloc&) {
      if (!options.everywhere)
        throw;
      insitu_locate_args args = insitu_locate_args_default();
      args.scope = INSITU_SCOPE_EVERYWHERE;
      args.point_arrays = INSITU_LACKS_MEMORY;
      detail::check(insitu_mesh_locate(handle(), &args));
      throw; // in a session that asks nobody
    }
  }
  static insitu_locate_args locate_args(const Points& points, const LocateOptions& options,
                                        Locations& out) {
    const std::size_t n = points.size();
    out.found.resize(n);
    out.cells.resize(n);
    out.pieces.resize(n);
    out.parametric.resize(3 * n);
    insitu_locate_args args = insitu_locate_args_default();
    args.points = points.arrays();
    args.point_arrays = points.array_count();
    args.frame = options.frame ? &options.frame->get() : nullptr;
    args.accuracy = static_cast<insitu_accuracy>(options.accuracy);
    args.cell_base = options.cell_base;
    args.cells = out.cells.data();
    args.pieces = out.pieces.data();
    args.parametric = out.parametric.data();
    args.found = out.found.data();
    if (options.reasons) {
      out.reasons.resize(n);
      args.reasons = reinterpret_cast<std::uint8_t*>(out.reasons.data());
    }
    if (options.nearest) {
      out.distances.resize(n);
      out.nearest.resize(3 * n);
      args.outside = INSITU_OUTSIDE_NEAREST;
      args.greatest_distance = options.greatest_distance;
      args.distances = out.distances.data();
      args.nearest = out.nearest.data();
    }
    if (options.everywhere) {
      out.ranks.resize(n);
      out.global_cells.resize(n);
      args.scope = INSITU_SCOPE_EVERYWHERE;
      args.ranks = out.ranks.data();
      args.global_cells = out.global_cells.data();
    }
    return args;
  }
  void sample_into(std::size_t number, const char* const* names, double* const* values,
                   const insitu_locate_args& locate) const {
    insitu_sample_args args = insitu_sample_args_default();
    args.locate = locate;
    args.fields = names;
    args.field_count = static_cast<std::int32_t>(number);
    args.values = values;
    detail::check(insitu_mesh_sample(handle(), &args));
  }
};

} // namespace insitu

#endif // INSITU_MESH_HPP
