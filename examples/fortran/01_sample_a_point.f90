!> The smallest coupling: one hexahedron, one field, one value at a point.
program sample_a_point
  use, intrinsic :: iso_fortran_env, only: int32, output_unit, real64
  use insitu
  implicit none

  ! Arrays that the library reads in place need the target attribute.
  real(real64), target :: xyz(3, 8) = reshape(real([ &
      0,0,0, 1,0,0, 1,1,0, 0,1,0, 0,0,1, 1,0,1, 1,1,1, 0,1,1], real64), [3, 8])
  integer(int32), target :: connectivity(8, 1) = reshape([1, 2, 3, 4, 5, 6, 7, 8], [8, 1])
  real(real64), target :: pressure(8) = [0, 1, 1, 0, 2, 3, 3, 2]
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  real(real64) :: value(1)
  integer :: ierr

  call session%open(ierr=ierr)
  call session%mesh('cube', mesh, ierr)
  call mesh%points(xyz, ierr)
  call mesh%hexahedra(connectivity, ierr)
  call mesh%vertex_field('pressure', pressure, ierr)
  call mesh%commit(ierr)
  if (ierr /= insitu_ok) error stop 1

  call mesh%sample_point('pressure', [0.25_real64, 0.5_real64, 0.75_real64], value, ierr)
  write (output_unit, '(a, f5.2)') 'pressure at (0.25, 0.50, 0.75):', value(1)
  call session%close(ierr)
end program sample_a_point
