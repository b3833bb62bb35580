!> Expectations that count their failures, and a box of cells to couple.
module checks
  use, intrinsic :: iso_c_binding, only: c_associated, c_loc, c_ptr
  use, intrinsic :: iso_fortran_env, only: error_unit, real64
  use insitu
  implicit none
  private

  public :: expect, expect_ok, expect_error, expect_near, expect_borrowed, finish_checks
  public :: box_points, box_hexahedra, box_centres, linear

  !> Numbers of the box's cells along x, y and z.
  integer, parameter, public :: nx = 4, ny = 3, nz = 2
  integer, parameter, public :: box_vertices = (nx + 1) * (ny + 1) * (nz + 1)
  integer, parameter, public :: box_cells = nx * ny * nz

  integer :: failures = 0

contains

  subroutine expect(what, holds)
    character(len=*), intent(in) :: what
    logical, intent(in) :: holds
    if (holds) return
    failures = failures + 1
    write (error_unit, '(2a)') 'failed: ', what
  end subroutine expect

  subroutine expect_ok(what, session, ierr)
    character(len=*), intent(in) :: what
    type(insitu_session), intent(in) :: session
    integer, intent(in) :: ierr
    call expect(what, ierr == insitu_ok)
    if (ierr /= insitu_ok) write (error_unit, '(4a)') '  ', insitu_status_name(ierr), ': ', &
        session%message()
  end subroutine expect_ok

  !> The status, and every word of the message that `words` lists, split by '|'.
  subroutine expect_error(what, session, ierr, status, words)
    character(len=*), intent(in) :: what, words
    type(insitu_session), intent(in) :: session
    integer, intent(in) :: ierr, status
    character(len=:), allocatable :: rest, message
    logical :: good
    integer :: bar

    message = session%message()
    good = ierr == status
    rest = words // '|'
    do while (len(rest) > 0)
      bar = index(rest, '|')
      good = good .and. index(message, rest(:bar - 1)) > 0
      rest = rest(bar + 1:)
    end do
    call expect(what, good)
    if (.not. good) write (error_unit, '(4a)') '  ', insitu_status_name(ierr), ': ', message
  end subroutine expect_error

  subroutine expect_near(what, found, expected, tolerance)
    character(len=*), intent(in) :: what
    real(real64), intent(in) :: found(:), expected(:), tolerance
    call expect(what // ': count', size(found) == size(expected))
    if (size(found) == size(expected)) then
      call expect(what, all(abs(found - expected) <= tolerance)) ! false for NaN
    end if
  end subroutine expect_near

  !> Every array of the mesh is the solver's own memory; the one of that name starts at `address`.
  subroutine expect_borrowed(session, mesh, name, address)
    type(insitu_session), intent(in) :: session
    type(insitu_mesh), intent(in) :: mesh
    character(len=*), intent(in) :: name
    type(c_ptr), intent(in) :: address
    type(insitu_audit_entry), allocatable :: entries(:)
    integer :: ierr, i, matches

    call mesh%audit(entries, ierr)
    call expect_ok('audit', session, ierr)
    call expect('nothing was converted', all(entries%borrowed) .and. all(entries%reason == ''))
    matches = 0
    do i = 1, size(entries)
      if (index(entries(i)%name, name) == 0) cycle
      matches = matches + 1
      call expect(trim(entries(i)%name) // ' is read in place', &
                  c_associated(entries(i)%address, address))
    end do
    call expect('one array of the audit is ' // name, matches == 1)
  end subroutine expect_borrowed

  subroutine finish_checks()
    if (failures == 0) return
    write (error_unit, '(i0, a)') failures, ' checks failed'
    error stop 1
  end subroutine finish_checks

  !> (3, box_vertices): the unit spacing's corners, pulled apart unevenly so that axes differ.
  function box_points() result(xyz)
    real(real64) :: xyz(3, box_vertices)
    integer :: i, j, k, v
    v = 0
    do k = 0, nz
      do j = 0, ny
        do i = 0, nx
          v = v + 1
          xyz(:, v) = [real(i, real64), 0.5_real64 * real(j, real64), 2.0_real64 * real(k, real64)]
        end do
      end do
    end do
  end function box_points

  !> (8, box_cells), from 1, in VTK's order.
  function box_hexahedra() result(connectivity)
    integer :: connectivity(8, box_cells)
    integer :: i, j, k, c, v
    c = 0
    do k = 0, nz - 1
      do j = 0, ny - 1
        do i = 0, nx - 1
          c = c + 1
          v = 1 + i + (nx + 1) * (j + (ny + 1) * k)
          connectivity(1:4, c) = [v, v + 1, v + nx + 2, v + nx + 1]
          connectivity(5:8, c) = connectivity(1:4, c) + (nx + 1) * (ny + 1)
        end do
      end do
    end do
  end function box_hexahedra

  function box_centres() result(centre)
    real(real64) :: centre(3, box_cells)
    real(real64) :: xyz(3, box_vertices)
    integer :: connectivity(8, box_cells), c

    xyz = box_points()
    connectivity = box_hexahedra()
    do c = 1, box_cells
      centre(:, c) = sum(xyz(:, connectivity(:, c)), dim=2) / 8.0_real64
    end do
  end function box_centres

  !> A field that every shape interpolates exactly.
  pure function linear(xyz) result(f)
    real(real64), intent(in) :: xyz(:,:)
    real(real64) :: f(size(xyz, 2))
    f = xyz(1, :) + 2.0_real64 * xyz(2, :) + 3.0_real64 * xyz(3, :)
  end function linear

end module checks
