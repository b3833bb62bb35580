!> Heat conduction on a layered mesh of wedges: cell-centred finite volumes, explicit in time.
!!
!! The flux through an upright face uses both its columns and its two vertices (the diamond scheme of
!! Coudiere, Vila and Villedieu, M2AN 33 (1999), section 2), so columns need not be orthogonal; the
!! vertices' temperatures come from a weighted least-squares plane through the cells around each.
!! Every flux leaves one cell and enters another: energy is kept to rounding. All walls insulate.
!!
!! A process has the level below its own and the one above as ghost levels, so each number is made of the
!! same ones, in the same order, on any number of processes.
module heat_solver
  use, intrinsic :: iso_fortran_env, only: real64
  use heat_mesh, only: mesh_type
  implicit none
  private

  !> Ghost levels below the bottom and above the top: other processes', or equal to the levels beside walls.
  integer, parameter, public :: nhalo = 1

  !> Share of the largest stable step of the two-point scheme; the diamond scheme's is smaller.
  real(real64), parameter :: step_safety = 0.5_real64

  type, public :: heat_type
    type(mesh_type) :: mesh
    real(real64) :: diffusivity = 1.0_real64
    real(real64) :: time = 0.0_real64
    !> Temperature (ncolumns, nhalo + nlevels + nhalo); inside: t(:, 1 + nhalo:nlevels + nhalo).
    real(real64), allocatable :: t(:,:)
    !> Heat flux at the vertices (3, nv*(nlevels + 1)), diffusivity times minus the gradient.
    real(real64), allocatable :: flux(:,:)
    real(real64), allocatable, private :: vertex_t(:,:)  !< (nv, as t), at the levels' middles
    real(real64), allocatable, private :: weight(:,:)    !< (3, size(star)): value, d/dx, d/dy
    real(real64), allocatable, private :: along(:)       !< per edge: weight of the columns' difference
    real(real64), allocatable, private :: across(:)      !< per edge: weight of the vertices' difference
    real(real64), allocatable, private :: gap(:)         !< (all_levels + 1) between the levels' middles
  contains
    procedure :: start
    procedure :: stable_step
    procedure :: step
    procedure :: energy
    procedure :: update_flux
  end type heat_type

contains

  !> Set up on a mesh with the temperatures (ncolumns, nlevels) at time 0.
  subroutine start(self, mesh, temperature, diffusivity)
    class(heat_type), intent(out) :: self
    type(mesh_type), intent(in) :: mesh
    real(real64), intent(in) :: temperature(:,:)
    real(real64), intent(in) :: diffusivity
    integer :: nlevels, all

    nlevels = mesh%nlevels
    all = mesh%all_levels
    self%mesh = mesh
    self%diffusivity = diffusivity
    allocate (self%t(mesh%ncolumns, nhalo + nlevels + nhalo), source=0.0_real64)
    allocate (self%vertex_t(mesh%nv, nhalo + nlevels + nhalo), source=0.0_real64)
    allocate (self%flux(3, size(mesh%x)), source=0.0_real64)
    self%t(:, 1 + nhalo:nlevels + nhalo) = temperature

    allocate (self%gap(all + 1))
    self%gap(1) = 2.0_real64 * (mesh%level_z(1) - mesh%interface_z(1))
    self%gap(2:all) = mesh%level_z(2:) - mesh%level_z(:all - 1)
    self%gap(all + 1) = 2.0_real64 * (mesh%interface_z(all + 1) - mesh%level_z(all))
    call fit_vertices(self)
    call weigh_edges(self)
    call refresh(self)
    call self%update_flux()
  end subroutine start

  pure real(real64) function stable_step(self)
    class(heat_type), intent(in) :: self
    real(real64) :: rate(size(self%mesh%area))
    real(real64) :: upwards
    integer :: e, k

    rate = 0.0_real64
    do e = 1, size(self%along)
      associate (c => self%mesh%edge_columns(:, e))
        rate(c) = rate(c) + self%along(e) / self%mesh%area(c)
      end associate
    end do
    upwards = 0.0_real64
    do k = 1, self%mesh%all_levels
      upwards = max(upwards, (1.0_real64 / self%gap(k) + 1.0_real64 / self%gap(k + 1)) &
                             / (self%mesh%interface_z(k + 1) - self%mesh%interface_z(k)))
    end do
    stable_step = step_safety / (self%diffusivity * (maxval(rate) + upwards))
  end function stable_step

  !> One explicit step; ghost levels and vertex temperatures are fresh before and after.
  subroutine step(self, dt)
    class(heat_type), intent(inout) :: self
    real(real64), intent(in) :: dt
    real(real64) :: gain(size(self%mesh%area)), below(size(self%mesh%area))
    real(real64) :: above(size(self%mesh%area))
    real(real64) :: flow, thickness
    integer :: e, k, level, first

    first = self%mesh%below + 1
    below = 0.0_real64                                   ! heat that enters through the lower face
    if (first > 1) below = (self%t(:, nhalo) - self%t(:, nhalo + 1)) / self%gap(first) * self%mesh%area
    do level = first, self%mesh%below + self%mesh%nlevels
      k = level - self%mesh%below + nhalo
      thickness = self%mesh%interface_z(level + 1) - self%mesh%interface_z(level)
      above = 0.0_real64                                 ! the upper wall insulates
      if (level < self%mesh%all_levels) then
        above = (self%t(:, k) - self%t(:, k + 1)) / self%gap(level + 1) * self%mesh%area
      end if
      gain = below - above
      below = above
      do e = 1, size(self%along)
        associate (c => self%mesh%edge_columns(:, e), v => self%mesh%edge_vertices(:, e))
          flow = thickness * (self%along(e) * (self%t(c(1), k) - self%t(c(2), k)) &
                            - self%across(e) * (self%vertex_t(v(1), k) - self%vertex_t(v(2), k)))
          gain(c(1)) = gain(c(1)) - flow
          gain(c(2)) = gain(c(2)) + flow
        end associate
      end do
      self%t(:, k) = self%t(:, k) + dt * self%diffusivity * gain / (self%mesh%area * thickness)
    end do
    self%time = self%time + dt
    call refresh(self)
  end subroutine step

  !> The temperature's integral.
  real(real64) function energy(self)
    class(heat_type), intent(in) :: self
    real(real64) :: of_level(self%mesh%nlevels)
    integer :: k, level

    do k = 1, self%mesh%nlevels
      level = k + self%mesh%below
      of_level(k) = dot_product(self%mesh%area, self%t(:, k + nhalo)) &
                  * (self%mesh%interface_z(level + 1) - self%mesh%interface_z(level))
    end do
    energy = self%mesh%processes%total(of_level)
  end function energy

  !> The flux at the vertices: the planes' slopes, and differences between levels.
  subroutine update_flux(self)
    class(heat_type), intent(inout) :: self
    real(real64) :: lower(2, self%mesh%nv), upper(2, self%mesh%nv)
    real(real64) :: share
    integer :: k, level, first, last

    if (self%mesh%nlevels == 0) return
    lower = slopes(self, nhalo)
    do k = 1, self%mesh%nlevels + 1                      ! interface k: between t's k and k + 1
      level = k + self%mesh%below
      upper = slopes(self, k + nhalo)
      share = 0.5_real64
      if (level > 1 .and. level <= self%mesh%all_levels) then
        share = (self%mesh%interface_z(level) - self%mesh%level_z(level - 1)) / self%gap(level)
      end if
      first = 1 + (k - 1) * self%mesh%nv
      last = k * self%mesh%nv
      self%flux(1:2, first:last) = -self%diffusivity * ((1.0_real64 - share) * lower + share * upper)
      self%flux(3, first:last) = -self%diffusivity / self%gap(level) &
          * (self%vertex_t(:, k + nhalo) - self%vertex_t(:, k + nhalo - 1))
      lower = upper
    end do
  end subroutine update_flux

  pure function slopes(self, k) result(slope)
    type(heat_type), intent(in) :: self
    integer, intent(in) :: k
    real(real64) :: slope(2, self%mesh%nv)
    integer :: v, s

    slope = 0.0_real64
    do v = 1, self%mesh%nv
      do s = self%mesh%star_start(v), self%mesh%star_start(v + 1) - 1
        slope(:, v) = slope(:, v) + self%weight(2:3, s) * self%t(self%mesh%star(s), k)
      end do
    end do
  end function slopes

  !> Ghost levels as insulated walls and other processes have them, then the vertices' temperatures.
  subroutine refresh(self)
    class(heat_type), intent(inout) :: self
    integer :: k, v, s, top, down, up

    if (self%mesh%nlevels == 0) return
    top = self%mesh%nlevels + nhalo
    self%t(:, nhalo) = self%t(:, nhalo + 1)
    self%t(:, top + nhalo) = self%t(:, top)
    associate (all => self%mesh%processes)
      down = self%mesh%holder(self%mesh%below)
      up = self%mesh%holder(self%mesh%below + self%mesh%nlevels + 1)
      call all%swap(self%t(:, top:top), up, self%t(:, nhalo:nhalo), down)
      call all%swap(self%t(:, nhalo + 1:nhalo + 1), down, self%t(:, top + nhalo:top + nhalo), up)
    end associate
    do k = 1, top + nhalo
      do v = 1, self%mesh%nv
        self%vertex_t(v, k) = 0.0_real64
        do s = self%mesh%star_start(v), self%mesh%star_start(v + 1) - 1
          self%vertex_t(v, k) = self%vertex_t(v, k) + self%weight(1, s) * self%t(self%mesh%star(s), k)
        end do
      end do
    end do
  end subroutine refresh

  !> Weights that turn the temperatures around a vertex into the value and slope, there, of their
  !! least-squares plane. At a wall each cell also counts as its mirror image, so no heat leaves.
  subroutine fit_vertices(self)
    class(heat_type), intent(inout) :: self
    real(real64) :: moment(3, 3), row(3, 2)
    integer :: v, s, pass

    associate (mesh => self%mesh)
      allocate (self%weight(3, size(mesh%star)))
      do v = 1, mesh%nv
        do pass = 1, 2                                   ! gather the moments, then apply their inverse
          if (pass == 1) moment = 0.0_real64
          if (pass == 2) moment = inverse(moment)
          do s = mesh%star_start(v), mesh%star_start(v + 1) - 1
            row(:, 1) = plane_row(mesh%centre(:, mesh%star(s)))
            row(:, 2) = 0.0_real64
            if (any(abs(mesh%wall_normal(:, v)) > 0.0_real64)) row(:, 2) = mirrored(row(:, 1))
            if (pass == 1) moment = moment + matmul(row, transpose(row)) / nearness(row(:, 1))
            if (pass == 2) self%weight(:, s) = matmul(moment, sum(row, dim=2)) / nearness(row(:, 1))
          end do
        end do
      end do
    end associate

  contains

    pure function plane_row(centre) result(row)
      real(real64), intent(in) :: centre(2)
      real(real64) :: row(3)
      row = [1.0_real64, centre(1) - self%mesh%x(v), centre(2) - self%mesh%y(v)]
    end function plane_row

    pure function mirrored(row)
      real(real64), intent(in) :: row(3)
      real(real64) :: mirrored(3)
      associate (normal => self%mesh%wall_normal(:, v))
        mirrored(1) = row(1)
        mirrored(2:3) = row(2:3) - 2.0_real64 * dot_product(row(2:3), normal) * normal
      end associate
    end function mirrored

    pure real(real64) function nearness(row)
      real(real64), intent(in) :: row(3)
      nearness = dot_product(row(2:3), row(2:3))
    end function nearness

  end subroutine fit_vertices

  !> By the adjugate; the matrix is symmetric and, for three columns not in a row, regular.
  pure function inverse(m) result(inv)
    real(real64), intent(in) :: m(3, 3)
    real(real64) :: inv(3, 3)
    integer :: i, j

    do j = 1, 3
      do i = 1, 3
        associate (i1 => 1 + modulo(i, 3), i2 => 1 + modulo(i + 1, 3), &
                   j1 => 1 + modulo(j, 3), j2 => 1 + modulo(j + 1, 3))
          inv(i, j) = m(j1, i1) * m(j2, i2) - m(j1, i2) * m(j2, i1)
        end associate
      end do
    end do
    inv = inv / dot_product(m(1, :), inv(:, 1))
  end function inverse

  !> The diamond of edge (a, b) between columns l and r, with d = r - l, e = b - a, turned so that
  !! d x e > 0: the flux from l to r is (|e|^2 (t_l - t_r) - (d.e) (t_a - t_b)) / (d x e).
  subroutine weigh_edges(self)
    class(heat_type), intent(inout) :: self
    real(real64) :: d(2), e(2), area
    integer :: i

    associate (mesh => self%mesh)
      allocate (self%along(size(mesh%edge_columns, 2)), self%across(size(mesh%edge_columns, 2)))
      do i = 1, size(self%along)
        associate (a => mesh%edge_vertices(1, i), b => mesh%edge_vertices(2, i))
          d = mesh%centre(:, mesh%edge_columns(2, i)) - mesh%centre(:, mesh%edge_columns(1, i))
          e = [mesh%x(b) - mesh%x(a), mesh%y(b) - mesh%y(a)]
        end associate
        area = d(1) * e(2) - d(2) * e(1)
        self%along(i) = dot_product(e, e) / area
        self%across(i) = dot_product(d, e) / area
      end do
    end associate
  end subroutine weigh_edges

end module heat_solver
