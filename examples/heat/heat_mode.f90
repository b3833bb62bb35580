!> A decaying mode of heat in an insulated ring: the closed form that the solver is held against.
!!
!! exp(-diffusivity (q^2 + p^2) time) R(r) cos(m angle) cos(p z) solves the heat equation in
!! inner <= r <= outer, 0 <= z <= height; R = J_m(q r) Y_m'(q inner) - Y_m(q r) J_m'(q inner), and
!! insulated walls ask for R'(outer) = 0, which gives q, and for p = n pi / height.
module heat_mode
  use, intrinsic :: iso_fortran_env, only: real64
  implicit none
  private

  real(real64), parameter :: pi = acos(-1.0_real64)
  integer, parameter :: around = 2     !< m: waves around the ring
  integer, parameter :: upwards = 1    !< n: half waves from bottom to top

  type, public :: mode_type
    private
    real(real64) :: inner = 0.0_real64
    real(real64) :: q = 0.0_real64
    real(real64) :: p = 0.0_real64
    real(real64) :: largest = 1.0_real64 !< of R, which is scaled by it
  contains
    procedure :: value => mode_value
  end type mode_type

  interface mode_type
    module procedure new_mode
  end interface mode_type

contains

  function new_mode(inner, outer, height) result(mode)
    real(real64), intent(in) :: inner, outer, height
    type(mode_type) :: mode
    real(real64) :: low, high, middle
    integer :: i

    ! The lowest root lies where m waves fit a circle between the two walls.
    low = real(around, real64) / (2.0_real64 * outer)
    high = real(around, real64) / inner
    do i = 1, digits(low)
      middle = 0.5_real64 * (low + high)
      if (wall_slope(low) * wall_slope(middle) > 0.0_real64) then
        low = middle
      else
        high = middle
      end if
    end do
    mode%inner = inner
    mode%q = middle
    mode%p = real(upwards, real64) * pi / height
    mode%largest = max(abs(radial(mode, inner)), abs(radial(mode, outer)))

  contains

    pure real(real64) function wall_slope(q)
      real(real64), intent(in) :: q
      wall_slope = bessel_j_slope(q * outer) * bessel_y_slope(q * inner) &
                 - bessel_y_slope(q * outer) * bessel_j_slope(q * inner)
    end function wall_slope

  end function new_mode

  elemental real(real64) function mode_value(self, x, y, z, diffusivity, time)
    class(mode_type), intent(in) :: self
    real(real64), intent(in) :: x, y, z, diffusivity, time

    mode_value = exp(-diffusivity * (self%q**2 + self%p**2) * time) &
               * radial(self, hypot(x, y)) / self%largest &
               * cos(real(around, real64) * atan2(y, x)) * cos(self%p * z)
  end function mode_value

  pure real(real64) function radial(mode, r)
    type(mode_type), intent(in) :: mode
    real(real64), intent(in) :: r
    radial = bessel_jn(around, mode%q * r) * bessel_y_slope(mode%q * mode%inner) &
           - bessel_yn(around, mode%q * r) * bessel_j_slope(mode%q * mode%inner)
  end function radial

  pure real(real64) function bessel_j_slope(s)
    real(real64), intent(in) :: s
    bessel_j_slope = 0.5_real64 * (bessel_jn(around - 1, s) - bessel_jn(around + 1, s))
  end function bessel_j_slope

  pure real(real64) function bessel_y_slope(s)
    real(real64), intent(in) :: s
    bessel_y_slope = 0.5_real64 * (bessel_yn(around - 1, s) - bessel_yn(around + 1, s))
  end function bessel_y_slope

end module heat_mode
