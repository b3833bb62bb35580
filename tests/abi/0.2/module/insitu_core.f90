!> What every kind of array ends in: the calls of insitu.h on a mesh, and the message they leave.
module insitu_core
  use, intrinsic :: iso_c_binding, only: c_associated, c_int, c_int32_t, c_int64_t, c_int8_t, &
      c_loc, c_null_char, c_null_ptr, c_ptr, c_sizeof
  use, intrinsic :: iso_fortran_env, only: int32, int64, int8, real64
  use insitu_c
  use insitu_text, only: from_c, read_frame, to_c
  implicit none
  private

  public :: piece_index, keep_message

  integer, parameter, public :: message_length = 4096
  !> What the message of a session begins with from an open that failed to the next one: the handles
  !! that were not made are no news then.
  character(len=*), parameter, public :: not_open = 'the session was not opened: '

  !> A mesh as the layers for each kind of array extend it; solvers use insitu_mesh of module insitu.
  type, public :: mesh_core
    type(c_ptr) :: handle = c_null_ptr
    character(len=message_length), pointer :: text => null()  !< the session's last message
  contains
    procedure :: finish
    procedure :: refuse
    procedure :: give_points
    procedure :: give_cells
    procedure :: give_faces
    procedure :: give_block
    procedure :: give_leaves
    procedure :: give_global_ids
    procedure :: give_field
    procedure :: find_cells
    procedure :: find_values
    procedure :: narrow
  end type mesh_core

contains

  !> Pieces count from 1 in Fortran and from 0 in C.
  pure integer(c_int32_t) function piece_index(piece)
    integer, intent(in), optional :: piece
    piece_index = 0
    if (present(piece)) piece_index = int(piece - 1, c_int32_t)
  end function piece_index

  subroutine keep_message(text, status)
    character(len=*), pointer, intent(in) :: text
    integer(c_int), intent(in) :: status
    if (.not. associated(text) .or. status == insitu_ok) return
    if (status == insitu_error_handle .and. index(text, not_open) == 1) return
    text = from_c(c_last_message())
  end subroutine keep_message

  subroutine finish(self, status, ierr)
    class(mesh_core), intent(in) :: self
    integer(c_int), intent(in) :: status
    integer, intent(out) :: ierr
    call keep_message(self%text, status)
    ierr = int(status)
  end subroutine finish

  !> For what is wrong before the library is called.
  subroutine refuse(self, what, ierr)
    class(mesh_core), intent(in) :: self
    character(len=*), intent(in) :: what
    integer, intent(out) :: ierr
    if (associated(self%text)) self%text = what
    ierr = int(insitu_error_argument)
  end subroutine refuse

  subroutine give_points(self, arrays, ierr, frame, piece)
    class(mesh_core), intent(in) :: self
    type(c_array), intent(in) :: arrays(:)
    integer, intent(out) :: ierr
    character(len=*), intent(in), optional :: frame
    integer, intent(in), optional :: piece
    type(c_frame) :: mesh_frame
    logical :: good

    if (present(frame)) then
      call read_frame(frame, mesh_frame, good)
      if (.not. good) then
        call self%refuse(bad_frame('points', frame), ierr)
        return
      end if
      call self%finish(c_mesh_frame(self%handle, mesh_frame), ierr)
      if (ierr /= insitu_ok) return
    end if
    call self%finish(c_mesh_points(self%handle, piece_index(piece), arrays, &
                                   size(arrays, kind=c_int32_t)), ierr)
  end subroutine give_points

  subroutine give_cells(self, cells, ierr, piece)
    class(mesh_core), intent(in) :: self
    type(c_cells), intent(in) :: cells
    integer, intent(out) :: ierr
    integer, intent(in), optional :: piece
    type(c_cells) :: sized

    sized = cells
    sized%size = c_sizeof(sized)
    if (sized%types%size == 0) sized%types%size = c_sizeof(sized%types)
    if (sized%offsets%size == 0) sized%offsets%size = c_sizeof(sized%offsets)
    call self%finish(c_mesh_cells(self%handle, piece_index(piece), sized), ierr)
  end subroutine give_cells

  subroutine give_faces(self, faces, ierr, piece)
    class(mesh_core), intent(in) :: self
    type(c_faces), intent(in) :: faces
    integer, intent(out) :: ierr
    integer, intent(in), optional :: piece
    type(c_faces) :: sized

    sized = faces
    sized%size = c_sizeof(sized)
    if (sized%owner%size == 0) sized%owner%size = c_sizeof(sized%owner)
    if (sized%neighbour%size == 0) sized%neighbour%size = c_sizeof(sized%neighbour)
    if (sized%boundary_vertices%size == 0) sized%boundary_vertices%size = c_sizeof(sized%owner)
    if (sized%boundary_offsets%size == 0) sized%boundary_offsets%size = c_sizeof(sized%owner)
    if (sized%boundary_owner%size == 0) sized%boundary_owner%size = c_sizeof(sized%owner)
    if (sized%cell_faces%size == 0) sized%cell_faces%size = c_sizeof(sized%owner)
    if (sized%cell_offsets%size == 0) sized%cell_offsets%size = c_sizeof(sized%owner)
    call self%finish(c_mesh_faces(self%handle, piece_index(piece), sized), ierr)
  end subroutine give_faces

  subroutine give_block(self, block, ierr, piece)
    class(mesh_core), intent(in) :: self
    type(c_block), intent(in) :: block
    integer, intent(out) :: ierr
    integer, intent(in), optional :: piece
    type(c_block) :: sized

    sized = block
    sized%size = c_sizeof(sized)
    where (sized%coordinates%size == 0) sized%coordinates%size = c_sizeof(sized%coordinates(1))
    call self%finish(c_mesh_block(self%handle, piece_index(piece), sized), ierr)
  end subroutine give_block

  subroutine give_global_ids(self, association, ids, ierr, piece)
    class(mesh_core), intent(in) :: self
    integer(c_int), intent(in) :: association
    type(c_array), intent(in) :: ids
    integer, intent(out) :: ierr
    integer, intent(in), optional :: piece
    call self%finish(c_mesh_global_ids(self%handle, piece_index(piece), association, ids), ierr)
  end subroutine give_global_ids

  subroutine give_leaves(self, leaves, ierr, corner_bits, offset, piece)
    class(mesh_core), intent(in) :: self
    type(c_leaves), intent(in) :: leaves
    integer, intent(out) :: ierr
    integer, intent(in), optional :: corner_bits, piece
    integer(int64), intent(in), optional :: offset(3)
    type(c_leaves) :: sized

    sized = leaves
    sized%size = c_sizeof(sized)
    if (present(corner_bits)) sized%corner_bits = int(corner_bits, c_int32_t)
    if (present(offset)) sized%offset = offset
    call self%finish(c_mesh_leaves(self%handle, piece_index(piece), sized), ierr)
  end subroutine give_leaves

  subroutine give_field(self, name, association, arrays, ierr, piece)
    class(mesh_core), intent(in) :: self
    character(len=*), intent(in) :: name
    integer(c_int), intent(in) :: association
    type(c_array), intent(in) :: arrays(:)
    integer, intent(out) :: ierr
    integer, intent(in), optional :: piece
    call self%finish(c_mesh_field(self%handle, piece_index(piece), to_c(name), association, arrays, &
                                  size(arrays, kind=c_int32_t)), ierr)
  end subroutine give_field

  !> cells, found, pieces, reasons, ranks (from 0, -1 outside), global_cells: one item a point; parametric: (3, points).
  !! everywhere: of the cells of all processes, which all call this; one that finds an error takes part and fails with
  !! all others.
  subroutine find_cells(self, points, cells, ierr, found, pieces, parametric, frame, accuracy, reasons, &
                        everywhere, ranks, global_cells)
    class(mesh_core), intent(in) :: self
    type(c_array), intent(in), target :: points(:)
    integer(int64), intent(out), contiguous, target :: cells(:)
    integer, intent(out) :: ierr
    logical, intent(out), optional :: found(:)
    integer, intent(out), optional :: pieces(:)
    real(real64), intent(out), contiguous, optional, target :: parametric(:,:)
    character(len=*), intent(in), optional :: frame
    integer, intent(in), optional :: accuracy
    integer, intent(out), optional :: reasons(:)
    logical, intent(in), optional :: everywhere
    integer, intent(out), optional :: ranks(:)
    integer(int64), intent(out), optional :: global_cells(:)
    type(c_locate_args) :: args
    type(c_frame), target :: point_frame
    integer(c_int32_t), allocatable, target :: owners(:), processes(:)
    integer(c_int64_t), allocatable, target :: ids(:)
    integer(c_int8_t), allocatable, target :: why(:)

    call fill(self, 'locate', points, args, point_frame, ierr, frame, accuracy)
    call expect_room(self, 'locate: cells', size(cells), points, ierr)
    if (present(found)) call expect_room(self, 'locate: found', size(found), points, ierr)
    if (present(pieces)) call expect_room(self, 'locate: pieces', size(pieces), points, ierr)
    if (present(reasons)) call expect_room(self, 'locate: reasons', size(reasons), points, ierr)
    if (present(ranks)) call expect_room(self, 'locate: ranks', size(ranks), points, ierr)
    if (present(global_cells)) then
      call expect_room(self, 'locate: global_cells', size(global_cells), points, ierr)
    end if
    if (present(parametric)) then
      call expect_room(self, 'locate: parametric', size(parametric, 2), points, ierr)
      if (size(parametric, 1) /= 3) then
        call self%refuse('locate: parametric: the first extent must be 3', ierr)
      end if
    end if
    if (asks_all(everywhere)) args%scope = insitu_scope_everywhere
    if (ierr /= insitu_ok) then
      if (asks_all(everywhere)) call take_part(self, args)
      return
    end if

    if (size(cells) > 0) args%cells = c_loc(cells)
    if (present(parametric)) then
      if (size(parametric) > 0) args%parametric = c_loc(parametric)
    end if
    if (size(cells) > 0) then
      if (present(pieces)) then
        allocate (owners(size(cells)))
        args%pieces = c_loc(owners)
      end if
      if (present(reasons)) then
        allocate (why(size(cells)))
        args%reasons = c_loc(why)
      end if
      if (present(ranks)) then
        allocate (processes(size(cells)))
        args%ranks = c_loc(processes)
      end if
      if (present(global_cells)) then
        allocate (ids(size(cells)))
        args%global_cells = c_loc(ids)
      end if
    end if
    call self%finish(c_mesh_locate(self%handle, args), ierr)
    if (ierr /= insitu_ok) return
    if (present(found)) found = cells > 0
    if (allocated(owners)) pieces = int(owners) + 1
    if (allocated(why)) reasons = int(why)
    if (allocated(processes)) ranks = int(processes)
    if (allocated(ids)) global_cells = ids
  end subroutine find_cells

  !> values: `room` contiguous numbers, the components of an item adjacent.
  subroutine find_values(self, field, points, values, room, ierr, found, frame, accuracy, everywhere)
    class(mesh_core), intent(in) :: self
    character(len=*), intent(in) :: field
    type(c_array), intent(in), target :: points(:)
    type(c_ptr), intent(in), target :: values
    integer, intent(in) :: room
    integer, intent(out) :: ierr
    logical, intent(out), optional :: found(:)
    character(len=*), intent(in), optional :: frame
    integer, intent(in), optional :: accuracy
    logical, intent(in), optional :: everywhere
    type(c_sample_args) :: args
    type(c_frame), target :: point_frame
    type(c_ptr), target :: name_at
    character(len=len_trim(field) + 1), target :: name
    integer(c_int8_t), allocatable, target :: inside(:)
    integer(c_int32_t) :: components
    integer(c_int) :: association

    components = 0
    association = insitu_vertex
    call self%finish(c_mesh_field_info(self%handle, to_c(field), components, association), ierr)
    if (asks_all(everywhere)) args%locate%scope = insitu_scope_everywhere
    if (ierr /= insitu_ok) then
      if (.not. asks_all(everywhere)) return
      if (points(1)%count > 0) then  ! at which this process has no field to tell the components
        call take_part(self, args%locate)
        return
      end if
    end if
    call fill(self, 'sample', points, args%locate, point_frame, ierr, frame, accuracy)
    call expect_values(self, field, room, int(components), points, ierr)
    if (present(found)) call expect_room(self, 'sample: found', size(found), points, ierr)
    if (ierr /= insitu_ok) then
      if (asks_all(everywhere)) call take_part(self, args%locate)
      return
    end if

    name = trim(field) // c_null_char
    name_at = c_loc(name)
    args%size = c_sizeof(args)
    args%fields = c_loc(name_at)
    args%field_count = 1
    args%values = c_loc(values)
    allocate (inside(points(1)%count))
    if (size(inside) > 0) args%locate%found = c_loc(inside)
    call self%finish(c_mesh_sample(self%handle, args), ierr)
    if (ierr == insitu_ok .and. present(found)) found = inside /= 0_int8
  end subroutine find_values

  pure logical function asks_all(everywhere)
    logical, intent(in), optional :: everywhere
    asks_all = .false.
    if (present(everywhere)) asks_all = everywhere
  end function asks_all

  !> Takes part in a query everywhere that this process has found to be wrong, so that all fail and none waits. The
  !! message stays that of the error.
  subroutine take_part(self, args)
    class(mesh_core), intent(in) :: self
    type(c_locate_args), intent(inout) :: args
    integer(c_int) :: status

    args%size = c_sizeof(args)
    args%points = c_null_ptr
    status = c_mesh_locate(self%handle, args)
  end subroutine take_part

  !> Ids as 32-bit integers, if they fit.
  subroutine narrow(self, wide, cells, ierr)
    class(mesh_core), intent(in) :: self
    integer(int64), intent(in) :: wide(:)
    integer(int32), intent(out) :: cells(:)
    integer, intent(inout) :: ierr

    cells = 0_int32
    if (ierr /= insitu_ok) return
    if (any(wide > int(huge(cells), int64))) then
      call self%refuse('locate: cells: ids of this mesh need 64-bit integers', ierr)
    else
      cells = int(wide, int32)
    end if
  end subroutine narrow

  subroutine fill(self, call_name, points, args, point_frame, ierr, frame, accuracy)
    class(mesh_core), intent(in) :: self
    character(len=*), intent(in) :: call_name
    type(c_array), intent(in), target :: points(:)
    type(c_locate_args), intent(inout) :: args
    type(c_frame), intent(out), target :: point_frame
    integer, intent(out) :: ierr
    character(len=*), intent(in), optional :: frame
    integer, intent(in), optional :: accuracy
    logical :: good

    ierr = insitu_ok
    args%size = c_sizeof(args)
    args%points = c_loc(points)
    args%point_arrays = size(points, kind=c_int32_t)
    if (present(accuracy)) args%accuracy = int(accuracy, c_int)
    if (present(frame)) then
      call read_frame(frame, point_frame, good)
      if (.not. good) call self%refuse(bad_frame(call_name, frame), ierr)
      args%frame = c_loc(point_frame)
    end if
  end subroutine fill

  subroutine expect_room(self, what, room, points, ierr)
    class(mesh_core), intent(in) :: self
    character(len=*), intent(in) :: what
    integer, intent(in) :: room
    type(c_array), intent(in) :: points(:)
    integer, intent(inout) :: ierr

    if (ierr /= insitu_ok .or. room == points(1)%count) return
    call self%refuse(what // ': room for ' // digits_of(int(room, int64)) // ' given, ' // &
                     digits_of(points(1)%count) // ' points asked for', ierr)
  end subroutine expect_room

  subroutine expect_values(self, field, room, components, points, ierr)
    class(mesh_core), intent(in) :: self
    character(len=*), intent(in) :: field
    integer, intent(in) :: room, components
    type(c_array), intent(in) :: points(:)
    integer, intent(inout) :: ierr

    if (ierr /= insitu_ok .or. room == components * points(1)%count) return
    call self%refuse("sample '" // trim(field) // "': room for " // digits_of(int(room, int64)) // &
                     ' values given, ' // digits_of(int(components, int64)) // ' components of ' // &
                     digits_of(points(1)%count) // ' points asked for', ierr)
  end subroutine expect_values

  pure function digits_of(number) result(text)
    integer(int64), intent(in) :: number
    character(len=:), allocatable :: text
    character(len=20) :: buffer
    write (buffer, '(i0)') number
    text = trim(buffer)
  end function digits_of

  pure function bad_frame(call_name, frame) result(text)
    character(len=*), intent(in) :: call_name, frame
    character(len=:), allocatable :: text
    text = call_name // ": frame '" // trim(frame) // "': expected cartesian, geocentric, " // &
        "'geodetic [radians] [kilometres] [depth]', 'enu <longitude> <latitude> <height>' or " // &
        "'utm <zone>N'"
  end function bad_frame

end module insitu_core
