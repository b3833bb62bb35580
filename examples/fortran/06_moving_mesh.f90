!> Vertices that move: the commit refits what it has, and rebuilds when that got too costly.
program moving_mesh
  use, intrinsic :: iso_fortran_env, only: output_unit, real64
  use insitu
  implicit none

  integer, parameter :: n = 17
  character(len=7), parameter :: action(0:2) = ['keep   ', 'refit  ', 'rebuild']
  real(real64), target :: xyz(3, n, n, n)
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  type(insitu_commit_report) :: report
  integer :: i, j, k, cycle, ierr

  do k = 1, n
    do j = 1, n
      do i = 1, n
        xyz(:, i, j, k) = real([i, j, k] - 1, real64) / real(n - 1, real64)
      end do
    end do
  end do
  call session%open(ierr=ierr)
  call session%mesh('batter', mesh, ierr)
  call mesh%curvilinear_block(xyz, ierr)                 ! vertices move in place below
  do cycle = 0, 9
    if (modulo(cycle, 4) /= 3) then                      ! every fourth cycle nothing moves
      call stir(0.4_real64)
      call mesh%changed(insitu_geometry)
    end if
    call mesh%commit(ierr, report)
    if (ierr /= insitu_ok) error stop 1
    if (report%action == insitu_refit) call mesh%complete(ierr, report) ! else the first query does
    if (ierr /= insitu_ok) error stop 1
    write (output_unit, '(a, i0, 3a, f5.2)') 'cycle ', cycle, ': ', action(report%action), &
        ', cost ratio ', report%cost_ratio
  end do
  call session%close(ierr)

contains

  !> A vortex about the middle: the nearer, the further round.
  subroutine stir(angle)
    real(real64), intent(in) :: angle
    real(real64) :: x, y, turn

    do k = 1, n
      do j = 1, n
        do i = 1, n
          x = xyz(1, i, j, k) - 0.5_real64
          y = xyz(2, i, j, k) - 0.5_real64
          turn = angle * exp(-8.0_real64 * (x * x + y * y))
          xyz(1, i, j, k) = 0.5_real64 + cos(turn) * x - sin(turn) * y
          xyz(2, i, j, k) = 0.5_real64 + sin(turn) * x + cos(turn) * y
        end do
      end do
    end do
  end subroutine stir

end program moving_mesh
