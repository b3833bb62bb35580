!> A curvilinear block inside larger arrays with a ghost layer on every side: no connectivity, no copy.
program block_with_ghosts
  use, intrinsic :: iso_fortran_env, only: output_unit, real64
  use insitu
  implicit none

  integer, parameter :: ni = 9, nj = 5, nk = 3           ! vertices of the block itself
  real(real64), parameter :: pi = acos(-1.0_real64)
  real(real64), target, dimension(0:ni + 1, 0:nj + 1, 0:nk + 1) :: x, y, z
  real(real64), target :: wind(3, 0:ni + 1, 0:nj + 1, 0:nk + 1)
  real(real64) :: radius, angle, values(3, 1), point(3, 1)
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  integer :: i, j, k, ierr

  do j = 0, nj + 1                                       ! a sector of a ring
    do i = 0, ni + 1
      radius = 1.0_real64 + 0.25_real64 * real(j - 1, real64)
      angle = 0.5_real64 * pi * real(ni - i, real64) / real(ni - 1, real64) ! i, j, k right-handed
      x(i, j, :) = radius * cos(angle)
      y(i, j, :) = radius * sin(angle)
      z(i, j, :) = [(0.5_real64 * real(k - 1, real64), k=0, nk + 1)]
    end do
  end do
  wind(1, :, :, :) = -y                                  ! solid rotation
  wind(2, :, :, :) = x
  wind(3, :, :, :) = 0.0_real64

  call session%open(ierr=ierr, strict=.true.)
  call session%mesh('sector', mesh, ierr)
  call mesh%curvilinear_block(x(1:ni, 1:nj, 1:nk), y(1:ni, 1:nj, 1:nk), z(1:ni, 1:nj, 1:nk), ierr)
  call mesh%vertex_field('wind', wind(:, 1:ni, 1:nj, 1:nk), ierr)
  call mesh%commit(ierr)
  if (ierr /= insitu_ok) error stop 1

  point(:, 1) = [1.0_real64, 1.0_real64, 0.5_real64]
  call mesh%sample('wind', point, values, ierr)          ! (components, points)
  write (output_unit, '(a, 3f7.3)') 'wind at (1, 1, 0.5):', values
  call session%close(ierr)
end program block_with_ghosts
