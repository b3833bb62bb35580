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
    !> (near_first:near_last, nlevels + 1), m3/s, at interfaces.
    real(real64), allocatable :: upward(:,:)
    !> East, north, up (m/s) at the strip's vertices, all interfaces.
    real(real64), allocatable :: velocity(:,:)
    complex(real64), allocatable, private :: spiral(:,:) !< (nlevels, nedges): transport at full wind
    real(real64), allocatable, private :: share(:,:)     !< (nlevels, nedges) of the rest
    ! At the strip's vertices, first_vertex to last_vertex of the surface.
    real(real64), allocatable, private :: slope(:,:,:)   !< (2, :, nlevels + 1) of the interfaces
    complex(real64), allocatable, private :: vertex_spiral(:) !< on all interfaces, m/s
    complex(real64), allocatable, private :: vertex_transport(:) !< m2/s, of the spiral
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
    real(real64) :: depth(mesh%nlevels + 1), latitude, hat(3), of_column(mesh%near_first:mesh%near_last)
    integer :: e, k, i, j, c, n

    n = mesh%nlevels
    allocate (self%across(n, mesh%nedges), source=0.0_real64)
    allocate (self%upward(mesh%near_first:mesh%near_last, n + 1), source=0.0_real64)
    allocate (self%velocity(3, size(mesh%lon)), source=0.0_real64)
    allocate (self%spiral(n, mesh%nedges), self%share(n, mesh%nedges))
    do e = 1, mesh%nedges
      depth = mesh%edge_depth(e)
      latitude = 0.5_real64 * sum(mesh%surface_lat(mesh%edge_vertices(:, e)))
      self%spiral(:, e) = beside_coast(mesh, e, wind%ekman_transport(latitude, depth(2:)) &
                                              - wind%ekman_transport(latitude, depth(:n)))
      self%share(:, e) = mode_share(depth(2:), depth(:n), depth(1))
    end do
    allocate (self%vertex_spiral(size(mesh%lon)), self%vertex_transport(mesh%first_vertex:mesh%last_vertex))
    self%vertex_spiral = wind%ekman_velocity(mesh%lat, mesh%depth)
    associate (floor => size(self%vertex_transport))     ! its vertices come first
      self%vertex_transport = wind%ekman_transport(mesh%lat(:floor), 0.0_real64) &
                            - wind%ekman_transport(mesh%lat(:floor), mesh%depth(:floor))
    end associate
    allocate (self%slope(2, mesh%first_vertex:mesh%last_vertex, n + 1))
    do k = 1, n + 1
      do i = 1, 2
        do c = mesh%near_first, mesh%near_last           ! upwards, so minus the depth's
          do j = 1, 3
            hat(j) = mesh%interface_depth(mesh%triangle(j, c), k)
          end do
          of_column(c) = -dot_product(mesh%gradient(i, :, c), hat)
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
        ! What flows in is carried up.
        if (mesh%is_near(c(1))) self%upward(c(1), 2:) = self%upward(c(1), 2:) - self%across(:, e)
        if (mesh%is_near(c(2))) self%upward(c(2), 2:) = self%upward(c(2), 2:) + self%across(:, e)
      end associate
    end do
    do k = 2, mesh%nlevels + 1
      self%upward(:, k) = self%upward(:, k) + self%upward(:, k - 1)
    end do
  end subroutine update_fluxes

  !> Largest flux through the surface, where there should be none, by the largest flux of all: over the
  !! whole basin.
  real(real64) function imbalance(self, mesh)
    class(flow_type), intent(in) :: self
    type(mesh_type), intent(in) :: mesh
    real(real64) :: lost, flux

    lost = mesh%processes%largest(maxval(abs(self%upward(:, size(self%upward, 2)))))
    flux = mesh%processes%largest(maxval(abs(self%across)))
    imbalance = lost / max(flux, tiny(1.0_real64))
  end function imbalance

  subroutine update_vertices(self, mesh, psi, strength)
    class(flow_type), intent(inout) :: self
    type(mesh_type), intent(in) :: mesh
    real(real64), intent(in) :: psi(:), strength
    real(real64) :: slope(2, mesh%near_first:mesh%near_last), u(2)
    real(real64), dimension(mesh%first_vertex:mesh%last_vertex) :: w, eastwards, northwards
    integer :: c, k, v, id

    do c = mesh%near_first, mesh%near_last
      slope(:, c) = matmul(mesh%gradient(:, :, c), psi(mesh%triangle(:, c)))
    end do
    eastwards = -vertex_mean(mesh, slope(2, :)) - strength * real(self%vertex_transport)
    northwards = vertex_mean(mesh, slope(1, :)) - strength * aimag(self%vertex_transport)
    do k = 1, mesh%nlevels + 1
      w = 0.0_real64
      if (k > 1 .and. k <= mesh%nlevels) &
        w = vertex_mean(mesh, self%upward(:, k) / mesh%area(mesh%near_first:mesh%near_last))
      do v = mesh%first_vertex, mesh%last_vertex
        id = mesh%own_id(v, k)
        u = [eastwards(v), northwards(v)] * exp(-mesh%depth(id) / fall) &
          / (fall * (1.0_real64 - exp(-mesh%depth(mesh%own_id(v, 1)) / fall)))
        u = u + strength * [real(self%vertex_spiral(id)), aimag(self%vertex_spiral(id))]
        if (mesh%on_coast(v)) u = u - dot_product(u, mesh%coast_normal(:, v)) * mesh%coast_normal(:, v)
        self%velocity(1:2, id) = u
        self%velocity(3, id) = w(v) + dot_product(u, self%slope(:, v, k))
      end do
    end do
  end subroutine update_vertices

end module gyre_flow
