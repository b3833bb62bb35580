!> The temperature: carried by the currents' volume fluxes (upwind), mixed along the levels and, in
!! time implicitly, up and down, and drawn towards the air's at the surface. It exerts no force.
!!
!! Every flux leaves one cell and enters another, so the heat changes by what the surface lets in, to
!! rounding; and as the fluxes balance, an even temperature stays even. Upwind differences add a
!! diffusivity of speed times spacing / 2 of their own, in the open ocean less than the eddies'.
module gyre_heat
  use, intrinsic :: iso_fortran_env, only: real64
  use gyre_flow, only: flow_type
  use gyre_mesh, only: mesh_type
  implicit none
  private

  public :: air_temperature

  real(real64), parameter :: eddy_diffusivity = 500.0_real64       !< along the levels, m2/s
  real(real64), parameter :: mixed_diffusivity = 1.0e-2_real64     !< up and down, near the surface
  real(real64), parameter :: deep_diffusivity = 1.0e-4_real64
  real(real64), parameter :: mixed_depth = 50.0_real64             !< m
  real(real64), parameter :: exchange = 1.0e-5_real64              !< with the air, m/s: 40 W/m2/K
  real(real64), parameter :: deep = 3.0_real64, thermocline = 700.0_real64 !< degrees C, m
  real(real64), parameter :: courant = 0.9_real64

  type, public :: heat_type
    !> Degrees C (ncolumns, 0:nlevels + 1): level 0 is the sea floor, equal to the lowest one, and
    !! level nlevels + 1 the air.
    real(real64), allocatable :: t(:,:)
    real(real64) :: gained = 0.0_real64                  !< through the surface, K m3
    real(real64), allocatable, private :: along(:,:)     !< (nlevels, nedges), m3/s of mixing
    real(real64), allocatable, private :: upright(:,:)   !< (ncolumns, 2:nlevels), m3/s of mixing
  contains
    procedure :: start
    procedure :: step
    procedure :: content
  end type heat_type

contains

  !> Of the air over a latitude, degrees C; the sea begins with it at its surface.
  elemental real(real64) function air_temperature(latitude)
    real(real64), intent(in) :: latitude
    air_temperature = 28.0_real64 - 25.0_real64 * ((latitude - 10.0_real64) / 52.0_real64)**2
  end function air_temperature

  subroutine start(self, mesh)
    class(heat_type), intent(out) :: self
    type(mesh_type), intent(in) :: mesh
    real(real64) :: depth(mesh%ncolumns, mesh%nlevels + 1), latitude(mesh%ncolumns), edge(mesh%nlevels + 1)
    integer :: c, e, k, n

    n = mesh%nlevels
    do c = 1, mesh%ncolumns
      latitude(c) = sum(mesh%lat(mesh%triangle(:, c))) / 3.0_real64
      do k = 1, n + 1
        depth(c, k) = sum(mesh%depth(mesh%triangle(:, c) + (k - 1) * mesh%nv)) / 3.0_real64
      end do
    end do
    allocate (self%t(mesh%ncolumns, 0:n + 1))
    do k = 1, n
      self%t(:, k) = deep + (air_temperature(latitude) - deep) &
                   * exp(-0.5_real64 * (depth(:, k) + depth(:, k + 1)) / thermocline)
    end do
    self%t(:, 0) = self%t(:, 1)
    self%t(:, n + 1) = air_temperature(latitude)

    allocate (self%along(n, mesh%nedges), self%upright(mesh%ncolumns, 2:n))
    do e = 1, mesh%nedges
      edge = mesh%edge_depth(e)
      self%along(:, e) = eddy_diffusivity * (edge(:n) - edge(2:)) * norm2(mesh%edge_vector(:, e)) &
                       / mesh%centre_distance(e)
    end do
    do k = 2, n
      self%upright(:, k) = mesh%area * 2.0_real64 / (depth(:, k - 1) - depth(:, k + 1)) &
          * (deep_diffusivity + (mixed_diffusivity - deep_diffusivity) * exp(-(depth(:, k) / mixed_depth)**2))
    end do
  end subroutine start

  !> dt seconds, in as many steps as the currents and the mixing along the levels need.
  subroutine step(self, mesh, flow, dt)
    class(heat_type), intent(inout) :: self
    type(mesh_type), intent(in) :: mesh
    type(flow_type), intent(in) :: flow
    real(real64), intent(in) :: dt
    integer :: i, n

    n = max(1, ceiling(dt * fastest(self, mesh, flow) / courant))
    do i = 1, n
      call carry(self, mesh, flow, dt / real(n, real64))
      call mix_upright(self, mesh, dt / real(n, real64))
      self%t(:, 0) = self%t(:, 1)
    end do
  end subroutine step

  !> The largest share of a cell's water that is exchanged in a second.
  pure real(real64) function fastest(self, mesh, flow)
    class(heat_type), intent(in) :: self
    type(mesh_type), intent(in) :: mesh
    type(flow_type), intent(in) :: flow
    real(real64) :: rate(mesh%ncolumns, mesh%nlevels)
    integer :: e

    associate (n => mesh%nlevels)
      rate = max(0.0_real64, flow%upward(:, 2:)) - min(0.0_real64, flow%upward(:, :n))
    end associate
    do e = 1, mesh%nedges
      associate (c => mesh%edge_columns(:, e), f => flow%across(:, e))
        rate(c(1), :) = rate(c(1), :) + max(0.0_real64, f) + self%along(:, e)
        rate(c(2), :) = rate(c(2), :) - min(0.0_real64, f) + self%along(:, e)
      end associate
    end do
    fastest = maxval(rate / mesh%volume)
  end function fastest

  subroutine carry(self, mesh, flow, dt)
    class(heat_type), intent(inout) :: self
    type(mesh_type), intent(in) :: mesh
    type(flow_type), intent(in) :: flow
    real(real64), intent(in) :: dt
    real(real64) :: gain(mesh%ncolumns, mesh%nlevels), through(mesh%nlevels), upwards(mesh%ncolumns)
    integer :: e, k

    gain = 0.0_real64
    do e = 1, mesh%nedges
      associate (l => mesh%edge_columns(1, e), r => mesh%edge_columns(2, e), f => flow%across(:, e), &
                 n => mesh%nlevels)
        through = max(f, 0.0_real64) * self%t(l, 1:n) + min(f, 0.0_real64) * self%t(r, 1:n) &
                + self%along(:, e) * (self%t(l, 1:n) - self%t(r, 1:n))
        gain(l, :) = gain(l, :) - through
        gain(r, :) = gain(r, :) + through
      end associate
    end do
    do k = 2, mesh%nlevels
      upwards = max(flow%upward(:, k), 0.0_real64) * self%t(:, k - 1) &
              + min(flow%upward(:, k), 0.0_real64) * self%t(:, k)
      gain(:, k - 1) = gain(:, k - 1) - upwards
      gain(:, k) = gain(:, k) + upwards
    end do
    self%t(:, 1:mesh%nlevels) = self%t(:, 1:mesh%nlevels) + dt * gain / mesh%volume
  end subroutine carry

  !> Implicit: a tridiagonal system in each column, solved from the bottom up and back.
  subroutine mix_upright(self, mesh, dt)
    class(heat_type), intent(inout) :: self
    type(mesh_type), intent(in) :: mesh
    real(real64), intent(in) :: dt
    real(real64) :: ratio(mesh%ncolumns, mesh%nlevels), pivot(mesh%ncolumns), above(mesh%ncolumns)
    real(real64) :: below(mesh%ncolumns)
    integer :: k

    associate (n => mesh%nlevels)
      below = 0.0_real64
      do k = 1, n
        above = dt * exchange * mesh%area
        if (k < n) above = dt * self%upright(:, k + 1)
        pivot = mesh%volume(:, k) + below + above
        if (k > 1) pivot = pivot - below * ratio(:, k - 1)
        self%t(:, k) = mesh%volume(:, k) * self%t(:, k)
        if (k > 1) self%t(:, k) = self%t(:, k) + below * self%t(:, k - 1)
        self%t(:, k) = self%t(:, k) / pivot
        ratio(:, k) = above / pivot
        below = above
      end do
      do k = n, 1, -1                                    ! begins with the air's
        self%t(:, k) = self%t(:, k) + ratio(:, k) * self%t(:, k + 1)
      end do
      self%gained = self%gained + dt * exchange * sum(mesh%area * (self%t(:, n + 1) - self%t(:, n)))
    end associate
  end subroutine mix_upright

  !> The temperature's integral, K m3.
  pure real(real64) function content(self, mesh)
    class(heat_type), intent(in) :: self
    type(mesh_type), intent(in) :: mesh
    content = sum(mesh%volume * self%t(:, 1:mesh%nlevels))
  end function content

end module gyre_heat
