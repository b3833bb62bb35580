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
    !> Degrees C (near_first:near_last, 0:nlevels + 1): level 0 is the sea floor, equal to the lowest one, and
    !! level nlevels + 1 the air.
    real(real64), allocatable :: t(:,:)
    real(real64) :: gained = 0.0_real64                  !< through the whole surface, K m3
    real(real64), allocatable, private :: along(:,:)     !< (nlevels, nedges), m3/s of mixing
    real(real64), allocatable, private :: upright(:,:)   !< (own columns, 2:nlevels), m3/s of mixing
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
    real(real64) :: depth(mesh%near_first:mesh%near_last, mesh%nlevels + 1)
    real(real64) :: latitude(mesh%near_first:mesh%near_last), edge(mesh%nlevels + 1), corner(3)
    integer :: c, e, i, k, n

    n = mesh%nlevels
    do c = mesh%near_first, mesh%near_last
      latitude(c) = sum(mesh%surface_lat(mesh%triangle(:, c))) / 3.0_real64
      do k = 1, n + 1
        do i = 1, 3
          corner(i) = mesh%interface_depth(mesh%triangle(i, c), k)
        end do
        depth(c, k) = sum(corner) / 3.0_real64
      end do
    end do
    allocate (self%t(mesh%near_first:mesh%near_last, 0:n + 1))
    do k = 1, n
      self%t(:, k) = deep + (air_temperature(latitude) - deep) &
                   * exp(-0.5_real64 * (depth(:, k) + depth(:, k + 1)) / thermocline)
    end do
    self%t(:, 0) = self%t(:, 1)
    self%t(:, n + 1) = air_temperature(latitude)

    allocate (self%along(n, mesh%nedges), self%upright(mesh%first_column:mesh%last_column, 2:n))
    do e = 1, mesh%nedges
      edge = mesh%edge_depth(e)
      self%along(:, e) = eddy_diffusivity * (edge(:n) - edge(2:)) * norm2(mesh%edge_vector(:, e)) &
                       / mesh%centre_distance(e)
    end do
    associate (a => mesh%first_column, b => mesh%last_column)
      do k = 2, n
        self%upright(:, k) = mesh%area(a:b) * 2.0_real64 / (depth(a:b, k - 1) - depth(a:b, k + 1)) &
            * (deep_diffusivity + (mixed_diffusivity - deep_diffusivity) * exp(-(depth(a:b, k) / mixed_depth)**2))
      end do
    end associate
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
      call refresh_neighbours(self, mesh)
      call carry(self, mesh, flow, dt / real(n, real64))
      call mix_upright(self, mesh, dt / real(n, real64))
      self%t(:, 0) = self%t(:, 1)
    end do
  end subroutine step

  !> The columns beside the strip get the temperatures that their own processes have.
  subroutine refresh_neighbours(self, mesh)
    class(heat_type), intent(inout) :: self
    type(mesh_type), intent(in) :: mesh
    integer :: row                                       !< columns between two meridians

    row = max(mesh%near_last - mesh%last_column, mesh%first_column - mesh%near_first)
    if (row == 0) return
    associate (a => mesh%first_column, b => mesh%last_column, n => mesh%nlevels, lower => mesh%near_first, &
               upper => mesh%near_last)
      call mesh%processes%swap(self%t(a:a + row - 1, 1:n), mesh%west, self%t(b + 1:upper, 1:n), mesh%east)
      call mesh%processes%swap(self%t(b - row + 1:b, 1:n), mesh%east, self%t(lower:a - 1, 1:n), mesh%west)
    end associate
  end subroutine refresh_neighbours

  !> The largest share of a cell's water that is exchanged in a second, in the whole basin.
  real(real64) function fastest(self, mesh, flow)
    class(heat_type), intent(in) :: self
    type(mesh_type), intent(in) :: mesh
    type(flow_type), intent(in) :: flow
    real(real64) :: rate(mesh%first_column:mesh%last_column, mesh%nlevels)
    integer :: e

    associate (a => mesh%first_column, b => mesh%last_column, n => mesh%nlevels)
      rate = max(0.0_real64, flow%upward(a:b, 2:)) - min(0.0_real64, flow%upward(a:b, :n))
    end associate
    do e = 1, mesh%nedges
      associate (c => mesh%edge_columns(:, e), f => flow%across(:, e))
        if (mesh%is_own(c(1))) rate(c(1), :) = rate(c(1), :) + max(0.0_real64, f) + self%along(:, e)
        if (mesh%is_own(c(2))) rate(c(2), :) = rate(c(2), :) - min(0.0_real64, f) + self%along(:, e)
      end associate
    end do
    fastest = mesh%processes%largest(maxval(rate / mesh%volume))
  end function fastest

  subroutine carry(self, mesh, flow, dt)
    class(heat_type), intent(inout) :: self
    type(mesh_type), intent(in) :: mesh
    type(flow_type), intent(in) :: flow
    real(real64), intent(in) :: dt
    real(real64) :: gain(mesh%first_column:mesh%last_column, mesh%nlevels), through(mesh%nlevels)
    real(real64) :: upwards(mesh%first_column:mesh%last_column)
    integer :: e, k

    gain = 0.0_real64
    do e = 1, mesh%nedges
      associate (l => mesh%edge_columns(1, e), r => mesh%edge_columns(2, e), f => flow%across(:, e), &
                 n => mesh%nlevels)
        if (.not. (mesh%is_own(l) .or. mesh%is_own(r))) cycle
        through = max(f, 0.0_real64) * self%t(l, 1:n) + min(f, 0.0_real64) * self%t(r, 1:n) &
                + self%along(:, e) * (self%t(l, 1:n) - self%t(r, 1:n))
        if (mesh%is_own(l)) gain(l, :) = gain(l, :) - through
        if (mesh%is_own(r)) gain(r, :) = gain(r, :) + through
      end associate
    end do
    associate (a => mesh%first_column, b => mesh%last_column, n => mesh%nlevels)
      do k = 2, n
        upwards = max(flow%upward(a:b, k), 0.0_real64) * self%t(a:b, k - 1) &
                + min(flow%upward(a:b, k), 0.0_real64) * self%t(a:b, k)
        gain(:, k - 1) = gain(:, k - 1) - upwards
        gain(:, k) = gain(:, k) + upwards
      end do
      self%t(a:b, 1:n) = self%t(a:b, 1:n) + dt * gain / mesh%volume
    end associate
  end subroutine carry

  !> Implicit: a tridiagonal system in each column, solved from the bottom up and back.
  subroutine mix_upright(self, mesh, dt)
    class(heat_type), intent(inout) :: self
    type(mesh_type), intent(in) :: mesh
    real(real64), intent(in) :: dt
    real(real64) :: ratio(mesh%first_column:mesh%last_column, mesh%nlevels)
    real(real64), dimension(mesh%first_column:mesh%last_column) :: pivot, above, below
    integer :: k

    associate (a => mesh%first_column, b => mesh%last_column, n => mesh%nlevels)
      below = 0.0_real64
      do k = 1, n
        above = dt * exchange * mesh%area(a:b)
        if (k < n) above = dt * self%upright(:, k + 1)
        pivot = mesh%volume(:, k) + below + above
        if (k > 1) pivot = pivot - below * ratio(:, k - 1)
        self%t(a:b, k) = mesh%volume(:, k) * self%t(a:b, k)
        if (k > 1) self%t(a:b, k) = self%t(a:b, k) + below * self%t(a:b, k - 1)
        self%t(a:b, k) = self%t(a:b, k) / pivot
        ratio(:, k) = above / pivot
        below = above
      end do
      do k = n, 1, -1                                    ! begins with the air's
        self%t(a:b, k) = self%t(a:b, k) + ratio(:, k) * self%t(a:b, k + 1)
      end do
      self%gained = self%gained + dt * exchange &
          * mesh%processes%total(mesh%area(a:b) * (self%t(a:b, n + 1) - self%t(a:b, n)))
    end associate
  end subroutine mix_upright

  !> The temperature's integral over the whole basin, K m3.
  real(real64) function content(self, mesh)
    class(heat_type), intent(in) :: self
    type(mesh_type), intent(in) :: mesh
    associate (t => self%t(mesh%first_column:mesh%last_column, 1:mesh%nlevels))
      content = mesh%processes%total(pack(mesh%volume * t, .true.))
    end associate
  end function content

end module gyre_heat
