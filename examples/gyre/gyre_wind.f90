!> The wind over the basin, and the layer under the surface that it drives: Ekman's spiral.
module gyre_wind
  use, intrinsic :: iso_fortran_env, only: real64
  use gyre_basin, only: earth_radius, earth_spin, radians
  implicit none
  private

  public :: coriolis, beta, ekman_pumping

  real(real64), parameter :: pi = acos(-1.0_real64)
  real(real64), parameter, public :: density = 1025.0_real64        !< kg/m3
  real(real64), parameter, public :: eddy_viscosity = 1.0e-2_real64 !< vertical, m2/s

  !> Trades in the south, westerlies in the middle, easterlies in the north: zonal, and a cosine of
  !! the latitude.
  type, public :: wind_type
    real(real64) :: stress = 0.1_real64                  !< largest, N/m2, towards east
    real(real64) :: south = 12.0_real64, north = 60.0_real64
  contains
    procedure :: eastward
    procedure :: curl
    procedure :: ekman_velocity
    procedure :: ekman_transport
  end type wind_type

contains

  elemental real(real64) function coriolis(latitude)
    real(real64), intent(in) :: latitude
    coriolis = 2.0_real64 * earth_spin * sin(radians(latitude))
  end function coriolis

  elemental real(real64) function beta(latitude)
    real(real64), intent(in) :: latitude
    beta = 2.0_real64 * earth_spin * cos(radians(latitude)) / earth_radius
  end function beta

  !> Its stress, N/m2.
  elemental real(real64) function eastward(self, latitude)
    class(wind_type), intent(in) :: self
    real(real64), intent(in) :: latitude
    eastward = -self%stress * cos(phase(self, latitude))
  end function eastward

  !> Of the stress, on the sphere, N/m3.
  elemental real(real64) function curl(self, latitude)
    class(wind_type), intent(in) :: self
    real(real64), intent(in) :: latitude
    curl = -slope(self, latitude) + self%eastward(latitude) * tan(radians(latitude)) / earth_radius
  end function curl

  elemental real(real64) function phase(self, latitude)
    class(wind_type), intent(in) :: self
    real(real64), intent(in) :: latitude
    phase = 2.0_real64 * pi * (latitude - self%south) / (self%north - self%south)
  end function phase

  !> The stress by metres north.
  elemental real(real64) function slope(self, latitude)
    class(wind_type), intent(in) :: self
    real(real64), intent(in) :: latitude
    slope = self%stress * sin(phase(self, latitude)) * 2.0_real64 * pi &
          / (earth_radius * radians(self%north - self%south))
  end function slope

  !> Velocity (east and i times north, m/s) at a depth below a deep sea's surface: V. W. Ekman, On the
  !! influence of the Earth's rotation on ocean currents (1905), for a stress towards east.
  elemental complex(real64) function ekman_velocity(self, latitude, depth) result(velocity)
    class(wind_type), intent(in) :: self
    real(real64), intent(in) :: latitude, depth
    real(real64) :: f

    f = coriolis(latitude)
    velocity = self%eastward(latitude) / (density * sqrt(eddy_viscosity * f)) &
             * exp(cmplx(0.0_real64, -0.25_real64 * pi, real64) - decay(f) * depth)
  end function ekman_velocity

  !> Its integral from a depth to the bottom of the sea, m2/s; from the surface: to the right of the
  !! wind, stress / (density * f).
  elemental complex(real64) function ekman_transport(self, latitude, below) result(transport)
    class(wind_type), intent(in) :: self
    real(real64), intent(in) :: latitude, below
    transport = self%ekman_velocity(latitude, below) / decay(coriolis(latitude))
  end function ekman_transport

  !> (1 + i) by Ekman's depth, 1/m.
  elemental complex(real64) function decay(f)
    real(real64), intent(in) :: f
    decay = cmplx(1.0_real64, 1.0_real64, real64) * sqrt(0.5_real64 * f / eddy_viscosity)
  end function decay

  !> Upward velocity below the spiral, m/s: the divergence of its transport.
  elemental real(real64) function ekman_pumping(wind, latitude) result(pumping)
    type(wind_type), intent(in) :: wind
    real(real64), intent(in) :: latitude
    pumping = (wind%curl(latitude) + wind%eastward(latitude) * beta(latitude) / coriolis(latitude)) &
            / (density * coriolis(latitude))
  end function ekman_pumping

end module gyre_wind
