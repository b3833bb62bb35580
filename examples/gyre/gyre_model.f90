!> The whole ocean: transport, currents and temperature, from rest.
module gyre_model
  use, intrinsic :: iso_fortran_env, only: real64
  use gyre_basin, only: basin_type
  use gyre_flow, only: flow_type
  use gyre_heat, only: heat_type
  use gyre_mesh, only: basin_mesh, mesh_type
  use solver_processes, only: processes_type
  use gyre_transport, only: transport_type
  use gyre_wind, only: wind_type
  implicit none
  private

  real(real64), parameter, public :: day = 86400.0_real64
  real(real64), parameter, public :: drag = 1.5e-6_real64 !< 1/s: Stommel's layer is 75 km wide at 30 N
  real(real64), parameter :: rising = 5.0_real64 * day    !< over which the wind comes up
  integer, parameter :: steps_a_day = 4

  type, public :: model_type
    type(mesh_type) :: mesh
    type(wind_type) :: wind
    type(transport_type) :: transport
    type(flow_type) :: flow
    type(heat_type) :: heat
    real(real64) :: time = 0.0_real64                    !< s
    real(real64), private :: heat_at_start = 0.0_real64
  contains
    procedure :: start
    procedure :: advance
    procedure :: strength
    procedure :: heat_error
  end type model_type

contains

  !> 4 and 3 times `resolution` quadrangles from west to east and from south to north; dealt out to the
  !! processes, which all make it and step it alike.
  subroutine start(self, basin, resolution, processes)
    class(model_type), intent(out) :: self
    type(basin_type), intent(in) :: basin
    integer, intent(in) :: resolution
    type(processes_type), intent(in), optional :: processes

    self%mesh = basin_mesh(basin, 4 * resolution, 3 * resolution, processes)
    self%wind%south = basin%latitude(1)
    self%wind%north = basin%latitude(size(basin%latitude))
    call self%transport%start(self%mesh, self%wind, drag)
    call self%flow%start(self%mesh, self%wind)
    call self%heat%start(self%mesh)
    self%heat_at_start = self%heat%content(self%mesh)
  end subroutine start

  !> Of the wind: it comes up within days.
  pure real(real64) function strength(self)
    class(model_type), intent(in) :: self
    strength = 1.0_real64 - exp(-self%time / rising)
  end function strength

  !> One day.
  subroutine advance(self)
    class(model_type), intent(inout) :: self
    real(real64) :: dt
    integer :: i

    dt = day / real(steps_a_day, real64)
    do i = 1, steps_a_day
      self%time = self%time + dt
      call self%transport%step(self%mesh, dt, self%strength())
    end do
    call self%flow%update(self%mesh, self%transport%psi, self%strength())
    call self%heat%step(self%mesh, self%flow, day)
  end subroutine advance

  !> What of the heat is not accounted for by the surface, of all.
  real(real64) function heat_error(self)
    class(model_type), intent(in) :: self
    heat_error = (self%heat%content(self%mesh) - self%heat_at_start - self%heat%gained) &
               / self%heat_at_start
  end function heat_error

end module gyre_model
