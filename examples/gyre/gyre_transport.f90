!> The wind-driven transport: the barotropic vorticity equation with linear drag (H. Stommel, The
!! westward intensification of wind-driven ocean currents, 1948), in time and on the sphere,
!!
!!   d/dt lap(psi) + beta V = curl(stress)/density - drag lap(psi),   psi = 0 along the coast,
!!
!! for the stream function psi (m3/s) of the depth-integrated velocity, U = -dpsi/dy, V = dpsi/dx.
!! The currents are taken to have died away above the bottom, so that its slope exerts no torque.
!!
!! Linear finite elements. The beta term is made skew-symmetric, so it neither makes nor takes energy;
!! in time it is extrapolated (Adams-Bashforth of order 3), the drag is implicit. The matrix is
!! factored once (Cholesky, banded). The surface is small beside the water below it: every process
!! works all of it out.
module gyre_transport
  use, intrinsic :: iso_fortran_env, only: real64
  use gyre_basin, only: earth_spin, earth_radius
  use gyre_mesh, only: mesh_type
  use gyre_wind, only: density, wind_type
  implicit none
  private

  type, public :: transport_type
    real(real64) :: drag = 1.5e-6_real64                 !< 1/s
    real(real64), allocatable :: psi(:)                  !< (nv), m3/s
    real(real64), allocatable, private :: factor(:,:)    !< (0:bandwidth, nv) of the stiffness matrix
    real(real64), allocatable, private :: curl(:)        !< (nv), m/s2 times m2: the wind's torque
    real(real64), allocatable, private :: past(:,:)      !< (nv, 2), beta terms one and two steps ago
    integer, private :: steps = 0
  contains
    procedure :: start
    procedure :: step
    procedure :: energy
  end type transport_type

contains

  !> At rest. Mesh and wind stay the same from here on; the wind's strength is up to step().
  subroutine start(self, mesh, wind, drag)
    class(transport_type), intent(out) :: self
    type(mesh_type), intent(in) :: mesh
    type(wind_type), intent(in) :: wind
    real(real64), intent(in) :: drag
    integer :: c, i

    self%drag = drag
    allocate (self%psi(mesh%nv), self%curl(mesh%nv), source=0.0_real64)
    allocate (self%past(mesh%nv, 2), source=0.0_real64)
    do c = 1, mesh%ncolumns
      associate (v => mesh%triangle(:, c))
        do i = 1, 3
          self%curl(v(i)) = self%curl(v(i)) + mesh%area(c) / (3.0_real64 * density) &
                                            * wind%curl(sum(mesh%surface_lat(v)) / 3.0_real64)
        end do
      end associate
    end do
    call factorise(self, mesh)
  end subroutine start

  !> One step of dt seconds; strength: of the wind, 1 at its full.
  subroutine step(self, mesh, dt, strength)
    class(transport_type), intent(inout) :: self
    type(mesh_type), intent(in) :: mesh
    real(real64), intent(in) :: dt, strength
    real(real64) :: now(mesh%nv), rate(mesh%nv)

    now = beta_term(mesh, self%psi)
    select case (self%steps)
    case (0)
      rate = now
    case (1)
      rate = 1.5_real64 * now - 0.5_real64 * self%past(:, 1)
    case default
      rate = (23.0_real64 * now - 16.0_real64 * self%past(:, 1) + 5.0_real64 * self%past(:, 2)) &
           / 12.0_real64
    end select
    self%past(:, 2) = self%past(:, 1)
    self%past(:, 1) = now
    rate = rate - strength * self%curl
    where (mesh%on_coast) rate = 0.0_real64
    call solve(self, rate)
    self%psi = (self%psi + dt * rate) / (1.0_real64 + dt * self%drag)
    self%steps = self%steps + 1
  end subroutine step

  !> Half the integral of the squared transport, m6/s2.
  pure real(real64) function energy(self, mesh)
    class(transport_type), intent(in) :: self
    type(mesh_type), intent(in) :: mesh
    real(real64) :: slope(2)
    integer :: c

    energy = 0.0_real64
    do c = 1, mesh%ncolumns
      slope = matmul(mesh%gradient(:, :, c), self%psi(mesh%triangle(:, c)))
      energy = energy + 0.5_real64 * mesh%area(c) * dot_product(slope, slope)
    end do
  end function energy

  !> The integral of each hat times beta V, by halves of the two ways to write it.
  pure function beta_term(mesh, psi) result(term)
    type(mesh_type), intent(in) :: mesh
    real(real64), intent(in) :: psi(:)
    real(real64) :: term(mesh%nv)
    real(real64) :: weight
    integer :: c

    term = 0.0_real64
    do c = 1, mesh%ncolumns
      associate (v => mesh%triangle(:, c), east => mesh%gradient(1, :, c))
        weight = earth_spin * mesh%cos_lat(c) / earth_radius * mesh%area(c) / 3.0_real64
        term(v) = term(v) + weight * (dot_product(east, psi(v)) - sum(psi(v)) * east)
      end associate
    end do
  end function beta_term

  !> Of the stiffness matrix with the coast's rows replaced by those of the identity.
  subroutine factorise(self, mesh)
    class(transport_type), intent(inout) :: self
    type(mesh_type), intent(in) :: mesh
    real(real64) :: pivot
    integer :: c, i, j, v, w, n

    n = mesh%bandwidth
    allocate (self%factor(0:n, mesh%nv), source=0.0_real64) ! (d, v): row v + d, column v
    do c = 1, mesh%ncolumns
      do i = 1, 3
        do j = 1, 3
          v = mesh%triangle(i, c)
          w = mesh%triangle(j, c)
          if (w < v .or. mesh%on_coast(v) .or. mesh%on_coast(w)) cycle
          self%factor(w - v, v) = self%factor(w - v, v) + mesh%area(c) &
              * dot_product(mesh%gradient(:, i, c), mesh%gradient(:, j, c))
        end do
      end do
    end do
    where (mesh%on_coast) self%factor(0, :) = 1.0_real64
    do v = 1, mesh%nv
      pivot = sqrt(self%factor(0, v))
      self%factor(:, v) = self%factor(:, v) / pivot
      do i = 1, min(n, mesh%nv - v)
        self%factor(0:n - i, v + i) = self%factor(0:n - i, v + i) &
                                    - self%factor(i, v) * self%factor(i:n, v)
      end do
    end do
  end subroutine factorise

  !> In place.
  pure subroutine solve(self, x)
    class(transport_type), intent(in) :: self
    real(real64), intent(inout) :: x(:)
    integer :: v, n

    do v = 1, size(x)
      n = min(ubound(self%factor, 1), size(x) - v)
      x(v) = x(v) / self%factor(0, v)
      x(v + 1:v + n) = x(v + 1:v + n) - x(v) * self%factor(1:n, v)
    end do
    do v = size(x), 1, -1
      n = min(ubound(self%factor, 1), size(x) - v)
      x(v) = (x(v) - dot_product(self%factor(1:n, v), x(v + 1:v + n))) / self%factor(0, v)
    end do
  end subroutine solve

end module gyre_transport
