!> An adaptive mesh of two patches, the coarse one with a ghost layer: read in place, sampled across
!! the levels.
program adaptive
  use, intrinsic :: iso_fortran_env, only: output_unit, real64
  use insitu
  implicit none

  integer, parameter :: n = 4                            ! cells of a patch along each axis
  real(real64), target :: coarse(-1:n, -1:n, -1:n)       ! cells of edge 1, from 0 to 4
  real(real64), target :: fine(0:n - 1, 0:n - 1, 0:n - 1) ! of edge 1/2, from 1 to 3
  real(real64) :: values(1), point(3, 1)
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  integer :: i, j, k, ierr

  coarse = 0.0_real64
  do k = 0, n - 1
    do j = 0, n - 1
      do i = 0, n - 1
        coarse(i, j, k) = linear([i, j, k] + 0.5_real64)
        fine(i, j, k) = linear(1.0_real64 + 0.5_real64 * ([i, j, k] + 0.5_real64))
      end do
    end do
  end do

  call session%open(ierr=ierr, strict=.true.)
  call session%mesh('amr', mesh, ierr)
  call mesh%adaptive([0.0_real64, 0.0_real64, 0.0_real64], [1.0_real64, 1.0_real64, 1.0_real64], &
                     2, ierr)
  call mesh%patch(0, [0, 0, 0], [n, n, n], ierr)         ! level, first cell, how many: from 0
  call mesh%patch(1, [2, 2, 2], [n, n, n], ierr, piece=2)
  call mesh%cell_field('rho', coarse(0:n - 1, 0:n - 1, 0:n - 1), ierr)
  call mesh%cell_field('rho', fine, ierr, piece=2)
  call mesh%commit(ierr)
  if (ierr /= insitu_ok) error stop 1

  point(:, 1) = [0.9_real64, 2.2_real64, 1.7_real64]     ! beside the fine patch
  call mesh%sample('rho', point, values, ierr)
  write (output_unit, '(a, f7.3)') 'rho(0.9, 2.2, 1.7):', values
  call session%close(ierr)

contains

  pure real(real64) function linear(x)
    real(real64), intent(in) :: x(3)
    linear = 1.0_real64 + x(1) + 2.0_real64 * x(2) + 4.0_real64 * x(3)
  end function linear

end program adaptive
