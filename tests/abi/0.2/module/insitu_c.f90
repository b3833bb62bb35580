!> Flat bind(C) interfaces of insitu.h: constants, argument structs and functions, one to one.
!!
!! Module `insitu` is what solvers use; this one is for those who need the C API itself. insitu.h says
!! what each member and function means.
module insitu_c
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_float, c_int, c_int32_t, c_int64_t, &
      c_null_funptr, c_null_ptr, c_funptr, c_ptr, c_size_t
  implicit none
  public

  private :: c_char, c_double, c_float, c_int, c_int32_t, c_int64_t, c_null_funptr, c_null_ptr, &
      c_funptr, c_ptr, c_size_t

  ! insitu_status
  integer(c_int), parameter :: &
      insitu_ok = 0, insitu_error_argument = 1, insitu_error_handle = 2, insitu_error_busy = 3, &
      insitu_error_order = 4, insitu_error_mesh = 5, insitu_error_field = 6, &
      insitu_error_scene = 7, insitu_error_file = 8, insitu_error_memory = 9, &
      insitu_error_unsupported = 10, insitu_error_conversion = 11, insitu_error_action = 12, &
      insitu_error_internal = 100

  ! insitu_type
  integer(c_int), parameter :: &
      insitu_float32 = 1, insitu_float64 = 2, insitu_int32 = 3, insitu_int64 = 4, insitu_uint8 = 5

  ! insitu_memory, insitu_association
  integer(c_int), parameter :: insitu_host = 0, insitu_device = 1
  integer(c_int), parameter :: insitu_vertex = 0, insitu_cell = 1

  ! insitu_shape
  integer(c_int), parameter :: &
      insitu_triangle = 5, insitu_pixel = 8, insitu_quad = 9, insitu_tetrahedron = 10, &
      insitu_voxel = 11, insitu_hexahedron = 12, insitu_wedge = 13, insitu_pyramid = 14

  ! insitu_accuracy
  integer(c_int), parameter :: insitu_fast = 0, insitu_standard = 1, insitu_exact = 2

  ! insitu_method, insitu_backend
  integer(c_int), parameter :: &
      insitu_method_auto = 0, insitu_method_bvh = 1, insitu_method_user_geometry = 2, &
      insitu_method_replicated_faces = 3, insitu_method_shared_faces = 4, &
      insitu_method_shared_bilinear_faces = 5
  integer(c_int), parameter :: &
      insitu_backend_auto = 0, insitu_backend_cpu = 1, insitu_backend_cuda = 2, &
      insitu_backend_optix = 3

  ! INSITU_CHANGED_*; combine with ior. Short names, as a solver writes them every step.
  integer, parameter :: &
      insitu_nothing = 0, insitu_fields = 1, insitu_geometry = 2, insitu_topology = 4, insitu_all = 7

  ! insitu_log_level
  integer(c_int), parameter :: &
      insitu_log_error = 1, insitu_log_warning = 2, insitu_log_info = 3, insitu_log_debug = 4

  ! Of a session that is given no communicator: 0 is Open MPI's MPI_COMM_WORLD
  integer(c_int32_t), parameter :: insitu_no_communicator = -1

  ! insitu_layout, insitu_block_kind, insitu_faces_form, insitu_ghost_convention
  integer(c_int), parameter :: &
      insitu_layout_uniform = 0, insitu_layout_mixed = 1, insitu_layout_padded = 2
  integer(c_int), parameter :: &
      insitu_block_uniform = 0, insitu_block_rectilinear = 1, insitu_block_curvilinear = 2
  integer(c_int), parameter :: insitu_faces_owners = 0, insitu_faces_cells = 1
  integer(c_int), parameter :: insitu_ghosts_vtk = 0, insitu_ghosts_ascent = 1

  ! insitu_scope
  integer(c_int), parameter :: insitu_scope_local = 0, insitu_scope_everywhere = 1

  ! insitu_outside
  integer(c_int), parameter :: insitu_outside_none = 0, insitu_outside_nearest = 1

  ! insitu_reconstruction
  integer(c_int), parameter :: insitu_dual = 0, insitu_nearest = 1

  ! insitu_frame_kind
  integer(c_int), parameter :: &
      insitu_frame_cartesian = 0, insitu_frame_geocentric = 1, insitu_frame_geodetic = 2, &
      insitu_frame_enu = 3, insitu_frame_utm = 4

  ! insitu_angle, insitu_length, insitu_vertical
  integer(c_int), parameter :: &
      insitu_degrees = 0, insitu_radians = 1, insitu_metres = 0, insitu_kilometres = 1, &
      insitu_up = 0, insitu_down = 1

  ! insitu_action
  integer(c_int), parameter :: insitu_keep = 0, insitu_refit = 1, insitu_rebuild = 2

  ! insitu_builder
  integer(c_int), parameter :: &
      insitu_builder_none = 0, insitu_builder_morton = 1, insitu_builder_surface_area = 2

  ! insitu_reason: what locate answers, and the indices of located_by_reason in insitu_report
  integer, parameter :: &
      insitu_reason_outside = 0, insitu_reason_certified = 1, insitu_reason_exact = 2, &
      insitu_reason_on_face = 3, insitu_reason_on_edge = 4, insitu_reason_on_vertex = 5, &
      insitu_reason_count = 6

  ! insitu_ending and insitu_purpose, as indices into the arrays of insitu_report: the values of
  ! insitu.h plus 1
  integer, parameter :: &
      insitu_end_alive = 1, insitu_end_left = 2, insitu_end_stagnated = 3, insitu_end_expired = 4, &
      insitu_end_step_limit = 5, insitu_end_seed_outside = 6, insitu_end_not_finite = 7, &
      insitu_end_killed = 8, insitu_end_stopped = 9, insitu_end_removed = 10, &
      insitu_end_step_too_small = 11, insitu_end_hole = 12, insitu_end_hidden = 13, &
      insitu_end_blank = 14, insitu_end_partition = 15, insitu_end_count = 15
  integer, parameter :: &
      insitu_memory_tree = 1, insitu_memory_build = 2, insitu_memory_ranges = 3, &
      insitu_memory_earlier = 4, insitu_memory_query = 5, insitu_memory_tracer = 6, &
      insitu_memory_frame = 7, insitu_memory_converted = 8, insitu_memory_embree = 9, &
      insitu_memory_device = 10, insitu_memory_amr = 11, insitu_memory_gathered = 12, &
      insitu_memory_geocentric = 13, insitu_memory_chart = 14, insitu_memory_neighbours = 15, &
      insitu_memory_blank = 16, insitu_memory_halo = 17, insitu_memory_polyhedra = 18, &
      insitu_memory_flat = 19, insitu_memory_held = 20, insitu_memory_count = 20

  ! The room of the lists in insitu_report
  integer, parameter :: &
      insitu_memory_room = 32, insitu_end_room = 32, insitu_reason_room = 16

  type, bind(c) :: c_session_options
    integer(c_size_t) :: size = 0
    type(c_ptr) :: scene = c_null_ptr
    type(c_ptr) :: scene_text = c_null_ptr
    type(c_ptr) :: output = c_null_ptr
    integer(c_int32_t) :: default_scene = 0
    integer(c_int32_t) :: threads = 0
    integer(c_int32_t) :: strict = 0
    integer(c_int) :: log_level = insitu_log_warning
    type(c_funptr) :: log = c_null_funptr
    type(c_ptr) :: log_user = c_null_ptr
    type(c_ptr) :: communicator = c_null_ptr
    integer(c_int32_t) :: fortran_communicator = insitu_no_communicator
    integer(c_int32_t) :: preview = 0
  end type c_session_options

  type, bind(c) :: c_array
    integer(c_size_t) :: size = 0
    type(c_ptr) :: data = c_null_ptr
    integer(c_int) :: type = insitu_float64
    integer(c_int32_t) :: components = 1
    integer(c_int64_t) :: count = 0
    integer(c_int64_t) :: extent(3) = 0
    integer(c_int64_t) :: stride(3) = 0
    integer(c_int64_t) :: component_stride = 0
    integer(c_int) :: memory = insitu_host
    type(c_ptr) :: converted = c_null_ptr
    integer(c_int32_t) :: indirect = 0
    integer(c_int64_t) :: offset = 0
    integer(c_int64_t) :: reserved(8) = 0
  end type c_array

  type, bind(c) :: c_cells
    integer(c_size_t) :: size = 0
    integer(c_int) :: layout = insitu_layout_uniform
    integer(c_int) :: shape = insitu_hexahedron
    integer(c_int64_t) :: count = 0
    type(c_array) :: connectivity
    type(c_array) :: types
    type(c_array) :: offsets
    integer(c_int32_t) :: index_base = 1
    integer(c_int32_t) :: reserved = 0
  end type c_cells

  type, bind(c) :: c_faces
    integer(c_size_t) :: size = 0
    integer(c_int) :: form = insitu_faces_owners
    integer(c_int32_t) :: index_base = 1
    integer(c_int64_t) :: cell_count = 0
    integer(c_int64_t) :: face_count = 0
    type(c_array) :: vertices
    type(c_array) :: offsets
    type(c_array) :: owner
    type(c_array) :: neighbour
    integer(c_int64_t) :: boundary_count = 0
    type(c_array) :: boundary_vertices
    type(c_array) :: boundary_offsets
    type(c_array) :: boundary_owner
    integer(c_int64_t) :: far_cells = 0
    type(c_array) :: cell_faces
    type(c_array) :: cell_offsets
  end type c_faces

  type, bind(c) :: c_block
    integer(c_size_t) :: size = 0
    integer(c_int) :: kind = insitu_block_curvilinear
    integer(c_int64_t) :: vertices(3) = 0
    real(c_double) :: origin(3) = 0.0_c_double
    real(c_double) :: spacing(3) = 1.0_c_double
    type(c_array) :: coordinates(3)
    integer(c_int64_t) :: first(3) = 0
    integer(c_int32_t) :: dimensions = 3
    integer(c_int32_t) :: reserved = 0
  end type c_block

  type, bind(c) :: c_amr
    integer(c_size_t) :: size = 0
    real(c_double) :: origin(3) = 0.0_c_double
    real(c_double) :: spacing(3) = 1.0_c_double
    integer(c_int32_t) :: level_count = 1
    type(c_ptr) :: ratios = c_null_ptr
    integer(c_int32_t) :: finest_first = 0
    integer(c_int) :: reconstruction = insitu_dual
    integer(c_int32_t) :: dimensions = 3
    integer(c_int32_t) :: reserved = 0
  end type c_amr

  type, bind(c) :: c_patch
    integer(c_size_t) :: size = 0
    integer(c_int32_t) :: level = 0
    integer(c_int64_t) :: lower(3) = 0, cells(3) = 0
    integer(c_int32_t) :: ghosts_before(3) = 0, ghosts_after(3) = 0
  end type c_patch

  type, bind(c) :: c_leaves
    integer(c_size_t) :: size = 0
    type(c_array) :: levels, corners
    integer(c_int32_t) :: corner_bits = -1
    integer(c_int64_t) :: offset(3) = 0
  end type c_leaves

  type, bind(c) :: insitu_amr_info
    integer(c_size_t) :: size = 0
    integer(c_int64_t) :: leaves = 0, masked = 0, gridlets = 0, cubes = 0, stitching = 0
    integer(c_int64_t) :: folded = 0, repaired = 0, bytes = 0
    real(c_double) :: build_s = 0.0_c_double
    integer(c_int64_t) :: by_places = 0
  end type insitu_amr_info

  type, bind(c) :: c_frame
    integer(c_size_t) :: size = 0
    integer(c_int) :: kind = insitu_frame_cartesian
    real(c_double) :: origin(3) = 0.0_c_double
    integer(c_int32_t) :: utm_zone = 0
    integer(c_int32_t) :: utm_north = 1
    integer(c_int) :: angle = insitu_degrees
    integer(c_int) :: length = insitu_metres
    integer(c_int) :: vertical = insitu_up
    integer(c_int32_t) :: reserved = 0
  end type c_frame

  type, bind(c) :: insitu_commit_report
    integer(c_size_t) :: size = 0
    integer(c_int) :: action = insitu_keep
    integer(c_int32_t) :: validated = 0
    real(c_double) :: seconds = 0.0_c_double
    integer(c_int64_t) :: cells = 0, vertices = 0, bytes = 0, bytes_allocated = 0
    real(c_double) :: cost_ratio = 1.0_c_double
    integer(c_int) :: builder = insitu_builder_none
    integer(c_int32_t) :: reserved = 0
  end type insitu_commit_report

  type, bind(c) :: insitu_validation
    integer(c_size_t) :: size = 0
    integer(c_int64_t) :: cells = 0
    integer(c_int64_t) :: index_errors = 0, shape_errors = 0, coordinate_errors = 0
    integer(c_int64_t) :: inverted_cells = 0, zero_volume_cells = 0, folded_cells = 0
    integer(c_int64_t) :: collapsed_cells = 0, ghost_cells = 0
    integer(c_int64_t) :: coincident_vertices = 0, crowded_faces = 0, split_faces = 0
    integer(c_int64_t) :: hanging_vertices = 0, covered_vertices = 0
  end type insitu_validation

  type, bind(c) :: c_locator
    integer(c_size_t) :: size = 0
    integer(c_int) :: method = insitu_method_auto
    integer(c_int) :: backend = insitu_backend_auto
  end type c_locator

  type, bind(c) :: c_locator_info
    integer(c_size_t) :: size = 0
    integer(c_int) :: method = insitu_method_auto
    integer(c_int) :: backend = insitu_backend_auto
    character(kind=c_char) :: reason(128)
    integer(c_int64_t) :: primitives = 0, bytes = 0, bytes_peak = 0, bytes_copied = 0
    integer(c_int64_t) :: kept = 0, by_neighbour = 0, by_tree = 0, settled_on_host = 0
  end type c_locator_info

  type, bind(c) :: c_audit_entry
    integer(c_size_t) :: size = 0
    character(kind=c_char) :: name(64)
    type(c_ptr) :: data = c_null_ptr
    integer(c_int64_t) :: bytes = 0
    integer(c_int32_t) :: borrowed = 0
    character(kind=c_char) :: reason(64)
    integer(c_int32_t) :: reserved(9) = 0
  end type c_audit_entry

  type, bind(c) :: c_locate_args
    integer(c_size_t) :: size = 0
    type(c_ptr) :: points = c_null_ptr
    integer(c_int32_t) :: point_arrays = 1
    type(c_ptr) :: frame = c_null_ptr
    integer(c_int) :: accuracy = insitu_standard
    integer(c_int64_t) :: cell_base = 1
    type(c_ptr) :: cells = c_null_ptr
    type(c_ptr) :: pieces = c_null_ptr
    type(c_ptr) :: parametric = c_null_ptr
    type(c_ptr) :: found = c_null_ptr
    type(c_ptr) :: reasons = c_null_ptr
    integer(c_int) :: memory = insitu_host
    type(c_ptr) :: stream = c_null_ptr
    integer(c_int) :: scope = insitu_scope_local
    integer(c_int32_t) :: padding = 0
    type(c_ptr) :: ranks = c_null_ptr
    type(c_ptr) :: global_cells = c_null_ptr
    integer(c_int) :: outside = insitu_outside_none
    integer(c_int32_t) :: padding_outside = 0
    real(c_double) :: greatest_distance = 0.0_c_double
    type(c_ptr) :: distances = c_null_ptr
    type(c_ptr) :: nearest = c_null_ptr
    integer(c_int64_t) :: reserved(9) = 0
  end type c_locate_args

  type, bind(c) :: c_vertices_args
    integer(c_size_t) :: size = 0
    type(c_ptr) :: points = c_null_ptr
    integer(c_int32_t) :: point_arrays = 1
    integer(c_int32_t) :: nearest = 1
    type(c_ptr) :: frame = c_null_ptr
    real(c_double) :: greatest_distance = 0.0_c_double
    integer(c_int) :: scope = insitu_scope_local
    integer(c_int32_t) :: vertex_base = 1
    type(c_ptr) :: vertices = c_null_ptr
    type(c_ptr) :: pieces = c_null_ptr
    type(c_ptr) :: ranks = c_null_ptr
    type(c_ptr) :: global_vertices = c_null_ptr
    type(c_ptr) :: distances = c_null_ptr
    type(c_ptr) :: places = c_null_ptr
  end type c_vertices_args

  type, bind(c) :: c_sample_args
    integer(c_size_t) :: size = 0
    type(c_locate_args) :: locate
    type(c_ptr) :: fields = c_null_ptr
    integer(c_int32_t) :: field_count = 0
    type(c_ptr) :: values = c_null_ptr
  end type c_sample_args

  type, bind(c) :: c_probe_answers
    integer(c_size_t) :: size = 0
    type(c_ptr) :: name = c_null_ptr
    integer(c_int64_t) :: cycle = 0
    real(c_double) :: time = 0.0_c_double
    integer(c_int32_t) :: answered = 0, column_count = 0
    integer(c_int64_t) :: point_count = 0
    type(c_ptr) :: column_names = c_null_ptr, points = c_null_ptr, inside = c_null_ptr
    type(c_ptr) :: values = c_null_ptr
  end type c_probe_answers

  !> Totals since the session was opened; particles, bytes_by_purpose and located_by_reason are
  !! indexed by insitu_end_*, insitu_memory_* and insitu_reason_*; purposes, endings and reasons tell
  !! how many of each the library that runs counts, the first ones.
  type, bind(c) :: insitu_report
    integer(c_size_t) :: size = 0
    integer(c_int64_t) :: executions = 0
    real(c_double) :: commit_s = 0.0_c_double, query_s = 0.0_c_double, advect_s = 0.0_c_double
    real(c_double) :: render_s = 0.0_c_double, output_s = 0.0_c_double
    integer(c_int64_t) :: keeps = 0, refits = 0, rebuilds = 0
    integer(c_int64_t) :: bytes_borrowed = 0, bytes_held = 0, bytes_peak = 0
    integer(c_int64_t) :: bytes_by_purpose(insitu_memory_room) = 0
    integer(c_int64_t) :: points_located = 0, points_outside = 0
    integer(c_int64_t) :: particles_seeded = 0
    integer(c_int64_t) :: particles(insitu_end_room) = 0
    integer(c_int64_t) :: frames = 0, probe_rows = 0, files = 0
    integer(c_int64_t) :: failures = 0
    integer(c_int64_t) :: located_by_reason(0:insitu_reason_room - 1) = 0
    real(c_double) :: ranges_s = 0.0_c_double, classify_s = 0.0_c_double
    integer(c_int32_t) :: purposes = 0, endings = 0, reasons = 0, reserved = 0
    integer(c_int64_t) :: halo_cells = 0, messages_sent = 0, bytes_sent = 0
  end type insitu_report

  include 'insitu_c_functions.inc'

end module insitu_c
