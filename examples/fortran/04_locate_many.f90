!> Many points at once: which cell holds each, counted from 1; 0 is outside.
program locate_many
  use, intrinsic :: iso_fortran_env, only: int32, output_unit, real64
  use insitu
  implicit none

  real(real64), target :: x(8) = [0, 1, 0, 1, 0, 1, 0, 1], y(8) = [0, 0, 1, 1, 0, 0, 1, 1]
  real(real64), target :: z(8) = [0, 0, 0, 0, 1, 1, 1, 1]
  ! Two wedges of a cube. VTK's order: seen from outside, the first triangle turns counter-clockwise.
  integer(int32), target :: connectivity(6, 2) = reshape([1, 4, 2, 5, 8, 6, 1, 3, 4, 5, 7, 8], [6, 2])
  real(real64) :: points(3, 4) = reshape([0.9_real64, 0.1_real64, 0.5_real64, &
                                          0.1_real64, 0.9_real64, 0.5_real64, &
                                          0.5_real64, 0.5_real64, 0.5_real64, &
                                          1.5_real64, 0.5_real64, 0.5_real64], [3, 4])
  real(real64) :: parametric(3, 4)
  integer(int32) :: cells(4)
  logical :: found(4)
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  integer :: i, ierr

  call session%open(ierr=ierr)
  call session%mesh('cube', mesh, ierr)
  call mesh%points(x, y, z, ierr)
  call mesh%wedges(connectivity, ierr)
  call mesh%commit(ierr)
  if (ierr /= insitu_ok) error stop 1

  ! The third point lies on the face of both wedges: the lower number owns it.
  call mesh%locate(points, cells, ierr, found=found, parametric=parametric, accuracy=insitu_exact)
  do i = 1, 4
    if (found(i)) then
      write (output_unit, '(a, i0, a, i0, a, 3f6.2)') 'point ', i, ': cell ', cells(i), ' at', &
          parametric(:, i)
    else
      write (output_unit, '(a, i0, a)') 'point ', i, ': outside'
    end if
  end do
  call session%close(ierr)
end program locate_many
