!> Steps held beside the live one, from Fortran: their values, their cycles, what is refused.
program held_test
  use, intrinsic :: iso_fortran_env, only: int32, int64, real64
  use checks
  use insitu
  implicit none

  real(real64), target :: xyz(3, box_vertices), f(box_vertices)
  integer(int32), target :: connectivity(8, box_cells)
  real(real64), parameter :: points(3, 1) = reshape([0.5_real64, 0.25_real64, 0.5_real64], [3, 1])
  integer(int64), allocatable :: cycles(:)
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  type(insitu_report) :: report
  integer :: ierr, cycle

  xyz = box_points()
  connectivity = box_hexahedra()
  call session%open(ierr=ierr, threads=2)
  call session%mesh('box', mesh, ierr)
  call mesh%points(xyz, ierr)
  call mesh%hexahedra(connectivity, ierr)
  call mesh%vertex_field('f', f, ierr)
  call session%hold(2, ierr)
  call expect_ok('hold', session, ierr)
  do cycle = 1, 3
    f = cycle
    call mesh%changed(insitu_fields)
    call session%execute(cycle, 0.1_real64 * cycle, ierr)
    call expect_ok('execute', session, ierr)
  end do
  call session%held(cycles, ierr)
  call expect_ok('held', session, ierr)
  call expect('the last two are held', size(cycles) == 2)
  call expect('their cycles', all(cycles == [2_int64, 3_int64]))
  call session%show(2, ierr)
  call expect_ok('show', session, ierr)
  call expect('the value of cycle 2', abs(value() - 2) < 1.0e-12_real64)
  call session%show(1_int64, ierr)
  call expect_error('show', session, ierr, insitu_error_argument, 'those held are 2 3')
  call session%show_live(ierr)
  call expect_ok('show_live', session, ierr)
  call expect('the live value', abs(value() - 3) < 1.0e-12_real64)
  call session%report(report, ierr)
  call expect('copies are counted', report%bytes_by_purpose(insitu_memory_held) > 0)
  call session%close(ierr)
  call finish_checks()

contains

  real(real64) function value()
    real(real64) :: values(1)
    call mesh%sample('f', points, values, ierr)
    call expect_ok('sample', session, ierr)
    value = values(1)
  end function value

end program held_test
