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
    procedure :: find_vertices
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

  include 'insitu_core_queries.inc'

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
