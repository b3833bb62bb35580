!> A basin in local metres, a gauge in longitude and latitude: only the point is converted.
program geodetic_gauge
  use, intrinsic :: iso_fortran_env, only: int32, output_unit, real64
  use insitu
  implicit none

  real(real64), parameter :: size_m = 1000.0_real64, depth_m = 50.0_real64
  real(real64), target :: x(8), y(8), z(8)
  integer(int32), target :: connectivity(8, 1) = reshape([1, 2, 4, 3, 5, 6, 8, 7], [8, 1])
  real(real64) :: gauge(3, 2), east(2)
  logical :: found(2)
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  integer :: ierr

  x = size_m * real([-1, 1, -1, 1, -1, 1, -1, 1], real64)
  y = size_m * real([-1, -1, 1, 1, -1, -1, 1, 1], real64)
  z = depth_m * real([-1, -1, -1, -1, 0, 0, 0, 0], real64)
  gauge(:, 1) = [5.010_real64, 52.001_real64, -10.0_real64]  ! longitude, latitude, height
  gauge(:, 2) = [5.100_real64, 52.001_real64, -10.0_real64]

  call session%open(ierr=ierr)
  call session%mesh('basin', mesh, ierr)
  call mesh%points(x, y, z, ierr, frame='enu 5.0 52.0 0.0')  ! metres east, north, up of this origin
  call mesh%hexahedra(connectivity, ierr)
  call mesh%vertex_field('east', x, ierr)
  call mesh%commit(ierr)
  if (ierr /= insitu_ok) error stop 1

  call mesh%sample('east', gauge, east, ierr, found=found, frame='geodetic')
  write (output_unit, '(a, f8.3, a)') 'the gauge stands ', east(1), ' m east of the origin'
  if (.not. found(2)) write (output_unit, '(a)') 'the other one stands outside'
  call session%close(ierr)
end program geodetic_gauge
