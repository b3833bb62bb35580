!> libinsitu for Fortran 2008: in-situ queries, tracers and frames for a running simulation.
!!
!!     use insitu
!!     type(insitu_session) :: session
!!     type(insitu_mesh) :: mesh
!!     call session%open(scene='scene.yaml', ierr=ierr)
!!     call session%mesh('ocean', mesh, ierr)
!!     call mesh%points(x, y, z, ierr)
!!     call mesh%wedges(connectivity, ierr)
!!     call mesh%cell_field('temperature', t(:, 2:nlevels + 1), ierr)
!!     do cycle = 1, last
!!       call step(dt)
!!       call mesh%changed(insitu_fields)
!!       call session%execute(cycle, time, ierr)
!!     end do
!!     call session%close(ierr)
!!
!! - ierr, the last of the arguments that a caller must give, is 0 (insitu_ok) or one of
!!   insitu_error_*; session%message() then names the argument and the numbers. Options follow ierr,
!!   by keyword.
!! - Arrays are external: the library keeps their address and reads them in place from the commit
!!   on. Each array needs the target attribute (the compiler says so if it is missing). The library
!!   takes sections as they are, padded columns, ghost levels, strides and reversed ones, and copies
!!   nothing. A procedure of your own between solver and module takes arrays as assumed-shape
!!   (a(:,:,:)) or pointer dummies with target: for an explicit-shape or contiguous dummy the
!!   compiler makes a temporary copy of a section and frees it when the procedure ends, and the
!!   address that the library kept leads to garbage. With INSITU_CHECKED=1 in the environment a
!!   commit reports memory that is gone, and memory whose values changed although the solver said
!!   nothing. A pointer gives one component of an array of records (p => cell%t): gfortran 12 passes
!!   a wrong address for cell%t itself.
!! - The library reads query points during the call alone; any array or expression will do.
!! - With vector=.true. the first dimension of the array holds the components of one item. Without
!!   it an array of any rank is a scalar field, its items in Fortran's order.
!! - Cells, vertices and pieces count from 1; 0 is "outside". Cells are in VTK's point order.
module insitu
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_int, c_int32_t, c_int64_t, c_loc, &
      c_f_pointer, c_int8_t, c_null_ptr, c_ptr, c_sizeof
  use, intrinsic :: iso_fortran_env, only: int32, int64, int8, real64
  use insitu_arrays, only: view_of_bytes
  use insitu_c
  use insitu_core, only: keep_message, message_length, not_open, piece_index
  use insitu_int64, only: below => mesh_of_integers
  use insitu_text, only: from_c, to_c
  implicit none
  private

  public :: &
      insitu_ok, insitu_error_argument, insitu_error_handle, insitu_error_busy, insitu_error_order, &
      insitu_error_mesh, insitu_error_field, insitu_error_scene, insitu_error_file, &
      insitu_error_memory, insitu_error_unsupported, insitu_error_conversion, insitu_error_action, &
      insitu_error_internal, &
      insitu_triangle, insitu_pixel, insitu_quad, &
      insitu_tetrahedron, insitu_voxel, insitu_hexahedron, insitu_wedge, insitu_pyramid, &
      insitu_fast, insitu_standard, insitu_exact, &
      insitu_nothing, insitu_fields, insitu_geometry, insitu_topology, insitu_all, &
      insitu_log_error, insitu_log_warning, insitu_log_info, insitu_log_debug, &
      insitu_ghosts_vtk, insitu_ghosts_ascent, insitu_dual, insitu_nearest, &
      insitu_keep, insitu_refit, insitu_rebuild, &
      insitu_method_auto, insitu_method_bvh, insitu_method_user_geometry, &
      insitu_method_replicated_faces, insitu_method_shared_faces, &
      insitu_method_shared_bilinear_faces, &
      insitu_backend_auto, insitu_backend_cpu, insitu_backend_cuda, insitu_backend_optix, &
      insitu_builder_none, insitu_builder_morton, insitu_builder_surface_area, &
      insitu_reason_outside, insitu_reason_certified, insitu_reason_exact, &
      insitu_reason_on_face, insitu_reason_on_edge, insitu_reason_on_vertex, &
      insitu_end_alive, insitu_end_left, insitu_end_stagnated, insitu_end_expired, &
      insitu_end_step_limit, insitu_end_seed_outside, insitu_end_not_finite, insitu_end_killed, &
      insitu_end_stopped, insitu_end_removed, insitu_end_step_too_small, insitu_end_hole, &
      insitu_end_hidden, insitu_end_blank, insitu_end_partition, &
      insitu_memory_tree, insitu_memory_build, insitu_memory_ranges, insitu_memory_earlier, &
      insitu_memory_query, insitu_memory_tracer, insitu_memory_frame, insitu_memory_converted, &
      insitu_memory_embree, insitu_memory_device, insitu_memory_amr, insitu_memory_gathered, &
      insitu_memory_geocentric, insitu_memory_chart, insitu_memory_neighbours, insitu_memory_blank, &
      insitu_memory_halo, insitu_memory_polyhedra, insitu_memory_flat, insitu_memory_held, &
      insitu_commit_report, insitu_validation, insitu_report, insitu_amr_info, &
      insitu_status_name, insitu_version

  !> One array of a mesh, as the copy audit reports it.
  type, public :: insitu_audit_entry
    character(len=64) :: name = ''       !< name as in C, such as 'piece 0 points x'
    integer(int64) :: bytes = 0          !< bytes of the array's items
    logical :: borrowed = .false.        !< whether the library reads the solver's memory in place
    character(len=64) :: reason = ''     !< why the array was converted, if it was
    type(c_ptr) :: address = c_null_ptr  !< the address that the library reads
  end type insitu_audit_entry

  !> What answers a mesh's queries since the last commit, and how it decided points.
  type, public :: insitu_locator_info
    integer :: method = insitu_method_auto    !< insitu_method_*
    integer :: backend = insitu_backend_auto  !< insitu_backend_*
    character(len=128) :: reason = ''         !< why this method and backend, in words
    integer(int64) :: primitives = 0          !< number of cells, or of triangles of the face
                                              !< methods
    integer(int64) :: bytes = 0, bytes_peak = 0, bytes_copied = 0
    integer(int64) :: kept = 0, by_neighbour = 0, by_tree = 0, settled_on_host = 0
  end type insitu_locator_info

  !> A mesh of a session, which owns it. The mesh lives as long as the session does; copies of this
  !! variable are the same mesh.
  type, extends(below), public :: insitu_mesh
  contains
    procedure :: uniform_block
    procedure :: flat_uniform_block
    procedure :: adaptive
    procedure :: patch
    procedure :: drop_pieces
    procedure :: separate_pieces
    procedure :: amr_info
    procedure :: cell_levels
    procedure :: remove_field
    procedure :: field_blank
    procedure :: hidden_points
    procedure :: ghosts
    procedure :: changed
    procedure :: commit
    procedure :: complete
    procedure :: validate
    procedure :: audit
    procedure :: sample_point
    procedure :: locator => choose_locator
    procedure :: locator_info
  end type insitu_mesh

  type, public :: insitu_session
    private
    type(c_ptr) :: handle = c_null_ptr
    !> The message of the last failed call of the session and its meshes. The memory is kept for
    !! good, since meshes point to it.
    character(len=message_length), pointer :: text => null()
    integer :: failed = insitu_ok  !< ierr of the last open, which close answers once more
  contains
    procedure :: open => session_open
    procedure :: close => session_close
    procedure :: mesh => session_mesh
    procedure :: execute_int32
    procedure :: execute_int64
    generic :: execute => execute_int32, execute_int64
    procedure :: report => session_report
    procedure :: plan => session_plan
    procedure :: checkpoint => session_checkpoint
    procedure :: restart => session_restart
    procedure :: record => session_record
    procedure :: hold => session_hold
    procedure :: held => session_held
    procedure :: show_int32
    procedure :: show_int64
    generic :: show => show_int32, show_int64
    procedure :: show_live
    procedure :: keep_answers
    procedure :: answers => session_answers
    procedure :: write_summary
    procedure :: message
  end type insitu_session

contains

  function insitu_status_name(status) result(name)
    integer, intent(in) :: status
    character(len=:), allocatable :: name
    name = from_c(c_status_name(int(status, c_int)))
  end function insitu_status_name

  !> Returns the version of the library that is running, such as '0.2.0'.
  function insitu_version() result(text)
    character(len=:), allocatable :: text
    character(len=40) :: buffer
    integer(c_int) :: numbers(3)

    text = ''
    if (c_version(numbers(1), numbers(2), numbers(3)) /= insitu_ok) return
    write (buffer, '(i0, 2(".", i0))') numbers
    text = trim(buffer)
  end function insitu_version

  include 'insitu_session.inc'

  !> Makes the piece an implicit block of vertices(1) x vertices(2) x vertices(3) vertices. first: the numbers of its
  !! first vertex, counted from 0 at the origin.
  subroutine uniform_block(self, vertices, origin, spacing, ierr, piece, first)
    class(insitu_mesh), intent(in) :: self
    integer, intent(in) :: vertices(3)
    real(real64), intent(in) :: origin(3), spacing(3)
    integer, intent(out) :: ierr
    integer, intent(in), optional :: piece
    integer(int64), intent(in), optional :: first(3)
    type(c_block) :: block

    if (present(first)) block%first = first
    block%kind = insitu_block_uniform
    block%vertices = vertices
    block%origin = origin
    block%spacing = spacing
    call self%give_block(block, ierr, piece)
  end subroutine uniform_block

  !> The same of a flat mesh: vertices(1) x vertices(2) vertices.
  subroutine flat_uniform_block(self, vertices, origin, spacing, ierr, piece, first)
    class(insitu_mesh), intent(in) :: self
    integer, intent(in) :: vertices(2)
    real(real64), intent(in) :: origin(2), spacing(2)
    integer, intent(out) :: ierr
    integer, intent(in), optional :: piece
    integer(int64), intent(in), optional :: first(2)
    type(c_block) :: block

    if (present(first)) block%first(1:2) = first
    block%kind = insitu_block_uniform
    block%dimensions = 2
    block%vertices = [vertices(1), vertices(2), 1]
    block%origin(1:2) = origin
    block%spacing(1:2) = spacing
    call self%give_block(block, ierr, piece)
  end subroutine flat_uniform_block

  subroutine remove_field(self, name, ierr)
    class(insitu_mesh), intent(in) :: self
    character(len=*), intent(in) :: name
    integer, intent(out) :: ierr
    call self%finish(c_mesh_remove_field(self%handle, to_c(name)), ierr)
  end subroutine remove_field

  !> Gives the ghosts, one number a cell; convention: insitu_ghosts_vtk (default) or
  !! insitu_ghosts_ascent. The library keeps the array's address, so bits must not be a temporary
  !! (head of the module).
  subroutine ghosts(self, bits, ierr, convention, piece)
    class(insitu_mesh), intent(in) :: self
    integer(int8), pointer, intent(in) :: bits(:)
    integer, intent(out) :: ierr
    integer, intent(in), optional :: convention, piece
    integer(c_int) :: rule

    rule = insitu_ghosts_vtk
    if (present(convention)) rule = int(convention, c_int)
    call self%finish(c_mesh_ghosts(self%handle, piece_index(piece), view_of_bytes(bits), rule), ierr)
  end subroutine ghosts

  !> Says what the solver changed in place: insitu_fields, insitu_geometry, insitu_topology, or
  !! several joined by ior. Without ierr, a failure shows at the next commit.
  subroutine changed(self, what, ierr)
    class(insitu_mesh), intent(in) :: self
    integer, intent(in) :: what
    integer, intent(out), optional :: ierr
    integer :: status

    call self%finish(c_mesh_changed(self%handle, int(what, c_int32_t)), status)
    if (present(ierr)) ierr = status
  end subroutine changed

  subroutine commit(self, ierr, report)
    class(insitu_mesh), intent(in) :: self
    integer, intent(out) :: ierr
    type(insitu_commit_report), intent(out), optional :: report
    type(insitu_commit_report) :: result

    result%size = c_sizeof(result)
    call self%finish(c_mesh_commit(self%handle, result), ierr)
    if (present(report)) report = result
  end subroutine commit

  !> Does now what the last commit has put off until a query needs it.
  subroutine complete(self, ierr, report)
    class(insitu_mesh), intent(in) :: self
    integer, intent(out) :: ierr
    type(insitu_commit_report), intent(out), optional :: report
    type(insitu_commit_report) :: result

    result%size = c_sizeof(result)
    call self%finish(c_mesh_complete(self%handle, result), ierr)
    if (present(report)) report = result
  end subroutine complete

  !> Chooses the locator, in place of the scene's choice; the next commit makes it.
  !! insitu_error_unsupported: an explicit choice cannot be had here.
  subroutine choose_locator(self, method, ierr, backend)
    class(insitu_mesh), intent(in) :: self
    integer, intent(in) :: method
    integer, intent(out) :: ierr
    integer, intent(in), optional :: backend
    type(c_locator) :: choice

    choice%size = c_sizeof(choice)
    choice%method = int(method, c_int)
    if (present(backend)) choice%backend = int(backend, c_int)
    call self%finish(c_mesh_locator(self%handle, choice), ierr)
  end subroutine choose_locator

  !> Fills info with what answers queries. insitu_error_order: the mesh has no commit yet.
  subroutine locator_info(self, info, ierr)
    class(insitu_mesh), intent(in) :: self
    type(insitu_locator_info), intent(out) :: info
    integer, intent(out) :: ierr
    type(c_locator_info), target :: raw

    raw%size = c_sizeof(raw)
    call self%finish(c_mesh_locator_info(self%handle, raw), ierr)
    if (ierr /= insitu_ok) return
    info%method = int(raw%method)
    info%backend = int(raw%backend)
    info%reason = from_c(c_loc(raw%reason))
    info%primitives = raw%primitives
    info%bytes = raw%bytes
    info%bytes_peak = raw%bytes_peak
    info%bytes_copied = raw%bytes_copied
    info%kept = raw%kept
    info%by_neighbour = raw%by_neighbour
    info%by_tree = raw%by_tree
    info%settled_on_host = raw%settled_on_host
  end subroutine locator_info

  !> Validates the arrays as they are now. insitu_error_mesh: a commit would refuse the mesh; the
  !! call fills the counts in either case. A commit has to follow before the next query.
  subroutine validate(self, validation, ierr)
    class(insitu_mesh), intent(in) :: self
    type(insitu_validation), intent(out) :: validation
    integer, intent(out) :: ierr

    validation%size = c_sizeof(validation)
    call self%finish(c_mesh_validate(self%handle, validation), ierr)
  end subroutine validate

  subroutine audit(self, entries, ierr)
    class(insitu_mesh), intent(in) :: self
    type(insitu_audit_entry), allocatable, intent(out) :: entries(:)
    integer, intent(out) :: ierr
    type(c_audit_entry), allocatable, target :: raw(:)
    integer(c_int32_t) :: count
    integer :: i

    count = 0
    call self%finish(c_mesh_audit(self%handle, c_null_ptr, count), ierr)
    allocate (raw(count), entries(count))
    if (ierr /= insitu_ok .or. count == 0) return
    raw%size = c_sizeof(raw(1))
    call self%finish(c_mesh_audit(self%handle, c_loc(raw), count), ierr)
    do i = 1, size(raw)
      entries(i)%name = from_c(c_loc(raw(i)%name))
      entries(i)%reason = from_c(c_loc(raw(i)%reason))
      entries(i)%bytes = raw(i)%bytes
      entries(i)%borrowed = raw(i)%borrowed /= 0
      entries(i)%address = raw(i)%data
    end do
  end subroutine audit

  !> Samples a field at one point in the mesh's frame. values has room for the field's components,
  !! and gets NaN outside.
  subroutine sample_point(self, field, point, values, ierr, found)
    class(insitu_mesh), intent(in) :: self
    character(len=*), intent(in) :: field
    real(real64), intent(in) :: point(3)
    real(real64), intent(inout), contiguous :: values(:)
    integer, intent(out) :: ierr
    logical, intent(out), optional :: found
    integer(c_int32_t) :: components, inside
    integer(c_int) :: association

    components = 0
    association = insitu_vertex
    inside = 0
    if (present(found)) found = .false.
    call self%finish(c_mesh_field_info(self%handle, to_c(field), components, association), ierr)
    if (ierr /= insitu_ok) return
    if (size(values) < components) then
      call self%refuse("sample_point '" // trim(field) // "': too little room for its components", ierr)
      return
    end if
    call self%finish(c_mesh_sample_point(self%handle, to_c(field), point, values, inside), ierr)
    if (present(found)) found = inside /= 0
  end subroutine sample_point

  include 'insitu_adaptive.inc'

end module insitu
