!> A basin in longitude, latitude and depth across the date line, and gauges in height and in depth:
!! cells are located as the model means them, straight in these coordinates; points are converted.
program geodetic_gauge
  use, intrinsic :: iso_fortran_env, only: int32, output_unit, real64
  use insitu
  implicit none

  real(real64), parameter :: depth_m = 50.0_real64
  real(real64), target :: lon(8), lat(8), depth(8), temperature(8)
  integer(int32), target :: connectivity(8, 1) = reshape([1, 2, 4, 3, 5, 6, 8, 7], [8, 1])
  real(real64) :: gauge(3, 3), value(3)
  logical :: found(3)
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  integer :: ierr

  lon = [179, -179, 179, -179, 179, -179, 179, -179]  ! it wraps around at 180
  lat = [51, 51, 53, 53, 51, 51, 53, 53]
  depth = depth_m * real([1, 1, 1, 1, 0, 0, 0, 0], real64)
  temperature = 20 - 0.1_real64 * depth
  gauge(:, 1) = [-179.999_real64, 52.001_real64, 0.0_real64]  ! depth 0 is inside, everywhere
  gauge(:, 2) = [180.5_real64, 52.001_real64, 10.0_real64]    ! any name of the meridian
  gauge(:, 3) = [178.5_real64, 52.001_real64, 10.0_real64]

  call session%open(ierr=ierr)
  call session%mesh('basin', mesh, ierr)
  call mesh%points(lon, lat, depth, ierr, frame='geodetic depth')  ! or 'geodetic radians kilometres depth'
  call mesh%hexahedra(connectivity, ierr)
  call mesh%vertex_field('temperature', temperature, ierr)
  call mesh%commit(ierr)
  if (ierr /= insitu_ok) error stop 1

  call mesh%sample('temperature', gauge, value, ierr, found=found)  ! in the mesh's frame
  write (output_unit, '(2(a, f7.3), a)') 'at the surface ', value(1), ', ten metres down ', value(2), ' degrees'
  if (.not. found(3)) write (output_unit, '(a)') 'the third gauge stands outside'

  gauge(3, 2) = -10.0_real64                                        ! as a height
  call mesh%sample('temperature', gauge, value, ierr, frame='geodetic')
  write (output_unit, '(a, f7.3, a)') 'at height -10 m ', value(2), ' degrees'
  call session%close(ierr)
end program geodetic_gauge
