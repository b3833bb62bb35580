!> The currents in three dimensions: how the transport and Ekman's spiral lie over the levels.
!!
!! Below the spiral the velocity falls off with depth as exp(-depth/fall) (an equivalent-barotropic
!! ocean: P. D. Killworth, An equivalent-barotropic mode in the Fine Resolution Antarctic Model, 1992);
!! together with the spiral it carries the transport of the stream function. Volume fluxes through the
!! upright faces are differences of the stream function, shared out over the levels, and the upward
!! ones follow by continuity, so each cell gets as much water as it loses, to rounding.
module gyre_flow
  use, intrinsic :: iso_fortran_env, only: real64
  use gyre_mesh, only: mesh_type, vertex_mean
  use gyre_wind, only: wind_type
  implicit none
  private

  real(real64), parameter, public :: fall = 700.0_real64 !< m

  type, public :: flow_type
    real(real64), allocatable :: across(:,:)             !< (nlevels, nedges), m3/s, left to right
    real(real64), allocatable :: upward(:,:)             !< (ncolumns, nlevels + 1), m3/s, at interfaces
    !> East, north, up (m/s) at the vertices: (3, nv*(nlevels + 1)).
    real(real64), allocatable :: velocity(:,:)
    complex(real64), allocatable, private :: spiral(:,:) !< (nlevels, nedges): transport at full wind
    real(real64), allocatable, private :: share(:,:)     !< (nlevels, nedges) of the rest
    real(real64), allocatable, private :: slope(:,:,:)   !< (2, nv, nlevels + 1) of the interfaces
    complex(real64), allocatable, private :: vertex_spiral(:) !< (nv*(nlevels + 1)), m/s
    complex(real64), allocatable, private :: vertex_transport(:) !< (nv), m2/s, of the spiral
  contains
    procedure :: start
    procedure :: update
    procedure :: imbalance
  end type flow_type

contains

  subroutine start(self, mesh, wind)
    class(flow_type), intent(out) :: self
    type(mesh_type), intent(in) :: mesh
    type(wind_type), intent(in) :: wind
    real(real64) :: depth(mesh%nlevels + 1), latitude, of_column(mesh%ncolumns)
    integer :: e, k, i, c, n

    n = mesh%nlevels
    allocate (self%across(n, mesh%nedges), self%upward(mesh%ncolumns, n + 1), source=0.0_real64)
    allocate (self%velocity(3, size(mesh%lon)), source=0.0_real64)
    allocate (self%spiral(n, mesh%nedges), self%share(n, mesh%nedges))
    do e = 1, mesh%nedges
      depth = mesh%edge_depth(e)
      latitude = 0.5_real64 * sum(mesh%lat(mesh%edge_vertices(:, e)))
      self%spiral(:, e) = beside_coast(mesh, e, wind%ekman_transport(latitude, depth(2:)) &
                                              - wind%ekman_transport(latitude, depth(:n)))
      self%share(:, e) = mode_share(depth(2:), depth(:n), depth(1))
    end do
    allocate (self%vertex_spiral(size(mesh%lon)), self%vertex_transport(mesh%nv))
    self%vertex_spiral = wind%ekman_velocity(mesh%lat, mesh%depth)
    self%vertex_transport = wind%ekman_transport(mesh%lat(:mesh%nv), 0.0_real64) &
                          - wind%ekman_transport(mesh%lat(:mesh%nv), mesh%depth(:mesh%nv))
    allocate (self%slope(2, mesh%nv, n + 1))
    do k = 1, n + 1
      do i = 1, 2
        do c = 1, mesh%ncolumns                          ! upwards, so minus the depth's
          of_column(c) = -dot_product(mesh%gradient(i, :, c), &
                                      mesh%depth(mesh%triangle(:, c) + (k - 1) * mesh%nv))
        end do
        self%slope(i, :, k) = vertex_mean(mesh, of_column)
      end do
    end do
  end subroutine start

  !> An edge's transport, as the mean of its two vertices': nothing flows through the coast at those on it,
  !! as in the velocities. So what the spiral carries off rises evenly in the cells along the coast, and
  !! not in those with a side on it alone.
  pure function beside_coast(mesh, e, transport) result(mean)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: e
    complex(real64), intent(in) :: transport(:)
    complex(real64) :: mean(size(transport)), normal
    integer :: i

    mean = transport
    do i = 1, 2
      associate (v => mesh%edge_vertices(i, e))
        if (.not. mesh%on_coast(v)) cycle
        normal = cmplx(mesh%coast_normal(1, v), mesh%coast_normal(2, v), real64)
        mean = mean - 0.5_real64 * real(conjg(normal) * transport) * normal
      end associate
    end do
  end function beside_coast

  !> What of a water column's transport flows between two depths.
  elemental real(real64) function mode_share(upper, lower, bottom) result(share)
    real(real64), intent(in) :: upper, lower, bottom
    share = (exp(-upper / fall) - exp(-lower / fall)) / (1.0_real64 - exp(-bottom / fall))
  end function mode_share

  !> The currents of a stream function (m3/s) under a wind of this strength.
  subroutine update(self, mesh, psi, strength)
    class(flow_type), intent(inout) :: self
    type(mesh_type), intent(in) :: mesh
    real(real64), intent(in) :: psi(:), strength

    call update_fluxes(self, mesh, psi, strength)
    call update_vertices(self, mesh, psi, strength)
  end subroutine update

  subroutine update_fluxes(self, mesh, psi, strength)
    class(flow_type), intent(inout) :: self
    type(mesh_type), intent(in) :: mesh
    real(real64), intent(in) :: psi(:), strength
    real(real64) :: of_spiral(mesh%nlevels)
    integer :: e, k

    self%upward = 0.0_real64
    do e = 1, mesh%nedges
      associate (v => mesh%edge_vertices(:, e), c => mesh%edge_columns(:, e))
        of_spiral = strength * (real(self%spiral(:, e)) * mesh%edge_vector(2, e) &
                              - aimag(self%spiral(:, e)) * mesh%edge_vector(1, e))
        self%across(:, e) = of_spiral + (psi(v(1)) - psi(v(2)) - sum(of_spiral)) * self%share(:, e)
        do k = 1, mesh%nlevels                           ! what flows in is carried up
          self%upward(c(1), k + 1) = self%upward(c(1), k + 1) - self%across(k, e)
          self%upward(c(2), k + 1) = self%upward(c(2), k + 1) + self%across(k, e)
        end do
      end associate
    end do
    do k = 2, mesh%nlevels + 1
      self%upward(:, k) = self%upward(:, k) + self%upward(:, k - 1)
    end do
  end subroutine update_fluxes

  !> Largest flux through the surface, where there should be none, by the largest flux of all.
  pure real(real64) function imbalance(self)
    class(flow_type), intent(in) :: self
    imbalance = maxval(abs(self%upward(:, size(self%upward, 2)))) &
              / max(maxval(abs(self%across)), tiny(1.0_real64))
  end function imbalance

  subroutine update_vertices(self, mesh, psi, strength)
    class(flow_type), intent(inout) :: self
    type(mesh_type), intent(in) :: mesh
    real(real64), intent(in) :: psi(:), strength
    real(real64) :: slope(2, mesh%ncolumns), transport(2, mesh%nv), w(mesh%nv), u(2)
    integer :: c, k, v, id

    do c = 1, mesh%ncolumns
      slope(:, c) = matmul(mesh%gradient(:, :, c), psi(mesh%triangle(:, c)))
    end do
    transport(1, :) = -vertex_mean(mesh, slope(2, :)) - strength * real(self%vertex_transport)
    transport(2, :) = vertex_mean(mesh, slope(1, :)) - strength * aimag(self%vertex_transport)
    do k = 1, mesh%nlevels + 1
      w = 0.0_real64
      if (k > 1 .and. k <= mesh%nlevels) w = vertex_mean(mesh, self%upward(:, k) / mesh%area)
      do v = 1, mesh%nv
        id = v + (k - 1) * mesh%nv
        u = transport(:, v) * exp(-mesh%depth(id) / fall) &
          / (fall * (1.0_real64 - exp(-mesh%depth(v) / fall)))
        u = u + strength * [real(self%vertex_spiral(id)), aimag(self%vertex_spiral(id))]
        if (mesh%on_coast(v)) u = u - dot_product(u, mesh%coast_normal(:, v)) * mesh%coast_normal(:, v)
        self%velocity(1:2, id) = u
        self%velocity(3, id) = w(v) + dot_product(u, self%slope(:, v, k))
      end do
    end do
  end subroutine update_vertices

end module gyre_flow
