!> The shape of an ocean basin: its coasts by latitude, and its bottom. Angles in degrees, lengths in
!! metres; the Earth is a sphere for the solver's physics.
module gyre_basin
  use, intrinsic :: iso_fortran_env, only: real64
  implicit none
  private

  public :: atlantic, box, radians

  real(real64), parameter, public :: earth_radius = 6.371e6_real64   !< of equal volume
  real(real64), parameter, public :: earth_spin = 7.292115e-5_real64 !< rad/s
  real(real64), parameter :: pi = acos(-1.0_real64)

  !> Coasts of a basin at a few latitudes, which ascend; between them they are smooth.
  type, public :: basin_type
    real(real64), allocatable :: latitude(:), west(:), east(:)
    real(real64) :: coast_depth = 400.0_real64           !< where the slope begins
    real(real64) :: depth = 5000.0_real64
    real(real64) :: slope_width = 250.0e3_real64         !< over which the bottom falls away
    real(real64) :: ridge_height = 2300.0_real64         !< half-way between the coasts
    real(real64) :: ridge_width = 400.0e3_real64
  contains
    procedure :: longitude
    procedure :: bottom
  end type basin_type

contains

  elemental real(real64) function radians(degrees)
    real(real64), intent(in) :: degrees
    radians = degrees * (pi / 180.0_real64)
  end function radians

  !> The North Atlantic from 12 N to 60 N, its coasts read off a map to a degree or two; without
  !! islands and side seas, closed in the south and in the north.
  function atlantic() result(basin)
    type(basin_type) :: basin

    allocate (basin%latitude, source=real([12, 18, 22, 26, 30, 34, 38, 42, 46, 50, 54, 58, 60], real64))
    allocate (basin%west, source=real([-60, -63, -70, -79, -81, -77, -75, -69, -60, -55, -55, -51, -47], real64))
    allocate (basin%east, source=real([-17, -17, -17, -15, -10, -7, -9, -9, -3, -5, -10, -6, -4], real64))
  end function atlantic

  !> A box with a flat bottom.
  function box(west, east, south, north) result(basin)
    real(real64), intent(in) :: west, east, south, north
    type(basin_type) :: basin

    allocate (basin%latitude, source=[south, north])
    allocate (basin%west, source=[west, west])
    allocate (basin%east, source=[east, east])
    basin%coast_depth = basin%depth
    basin%ridge_height = 0.0_real64
  end function box

  !> Longitude at a share (0 to 1) of the way from the western to the eastern coast.
  pure real(real64) function longitude(self, share, latitude)
    class(basin_type), intent(in) :: self
    real(real64), intent(in) :: share, latitude
    longitude = (1.0_real64 - share) * smooth(self%latitude, self%west, latitude) &
              + share * smooth(self%latitude, self%east, latitude)
  end function longitude

  !> Depth of the bottom there.
  pure real(real64) function bottom(self, share, latitude)
    class(basin_type), intent(in) :: self
    real(real64), intent(in) :: share, latitude
    real(real64) :: width, nearest, middle

    width = earth_radius * cos(radians(latitude)) &
          * radians(self%longitude(1.0_real64, latitude) - self%longitude(0.0_real64, latitude))
    nearest = min(share, 1.0_real64 - share) * width
    middle = (share - 0.5_real64) * width
    bottom = self%depth - (self%depth - self%coast_depth) * exp(-(nearest / self%slope_width)**2) &
           - self%ridge_height * exp(-(middle / self%ridge_width)**2)
  end function bottom

  !> Linear between the places x, averaged over three degrees, so that coasts have no corners.
  pure real(real64) function smooth(x, y, at)
    real(real64), intent(in) :: x(:), y(:), at
    smooth = (linear(x, y, at - 1.5_real64) + linear(x, y, at) + linear(x, y, at + 1.5_real64)) &
           / 3.0_real64
  end function smooth

  pure real(real64) function linear(x, y, at)
    real(real64), intent(in) :: x(:), y(:), at
    real(real64) :: share
    integer :: i

    i = 1
    do while (i < size(x) - 1 .and. at > x(min(i + 1, size(x))))
      i = i + 1
    end do
    share = min(1.0_real64, max(0.0_real64, (at - x(i)) / (x(i + 1) - x(i))))
    linear = (1.0_real64 - share) * y(i) + share * y(i + 1)
  end function linear

end module gyre_basin
