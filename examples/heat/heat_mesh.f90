!> A layered mesh of wedges: a triangulated ring (columns), extruded into levels.
!!
!! Vertex v of interface k has id v + (k - 1)*nv, the cell of column c in level k has id
!! c + (k - 1)*ncolumns; both count from 1 and from the bottom. Of several processes each has some levels
!! and the interfaces around them, and its own ids count these; a process without a level has an
!! interface's vertices.
module heat_mesh
  use, intrinsic :: iso_fortran_env, only: int32, int64, real64
  use solver_processes, only: processes_type
  implicit none
  private

  public :: ring_mesh, wedge_volume

  real(real64), parameter :: pi = acos(-1.0_real64)

  !> Share of a level's uniform spacing by which levels crowd towards bottom and top, below 1/(2 pi).
  real(real64), parameter :: crowding = 0.1_real64

  type, public :: mesh_type
    integer :: nv = 0                                    !< vertices of one interface
    integer :: ncolumns = 0
    integer :: nlevels = 0                               !< of this process
    integer :: all_levels = 0
    integer :: below = 0                                 !< levels of other processes below these
    type(processes_type) :: processes
    integer(int64), allocatable :: cell_ids(:), vertex_ids(:) !< in the whole mesh, from 0
    real(real64), allocatable :: x(:), y(:), z(:)        !< all vertices: nv*(nlevels + 1)
    integer(int32), allocatable :: connectivity(:,:)     !< (6, ncells), VTK's order
    integer, allocatable :: triangle(:,:)                !< (3, ncolumns), counter-clockwise from above
    real(real64), allocatable :: area(:)                 !< (ncolumns)
    real(real64), allocatable :: centre(:,:)             !< (2, ncolumns), the centroids
    real(real64), allocatable :: interface_z(:)          !< (all_levels + 1)
    real(real64), allocatable :: level_z(:)              !< (all_levels), the middles
    integer, allocatable :: edge_vertices(:,:)           !< (2, nedges), edges between two columns
    integer, allocatable :: edge_columns(:,:)            !< (2, nedges), the column on either side
    integer, allocatable :: star_start(:)                !< (nv + 1), into star
    integer, allocatable :: star(:)                      !< columns around each vertex
    real(real64), allocatable :: wall_normal(:,:)        !< (2, nv), unit and outwards; 0 inside
  contains
    procedure :: ncells
    procedure :: levels_below
    procedure :: holder
  end type mesh_type

contains

  pure integer function ncells(self)
    class(mesh_type), intent(in) :: self
    ncells = self%ncolumns * self%nlevels
  end function ncells

  !> How many levels lie below those of a process: equal shares, of which some may be empty.
  pure integer function levels_below(self, rank)
    class(mesh_type), intent(in) :: self
    integer, intent(in) :: rank
    levels_below = int(int(self%all_levels, int64) * rank / self%processes%number)
  end function levels_below

  !> The process that has a level; -1: there is no such level.
  pure integer function holder(self, level)
    class(mesh_type), intent(in) :: self
    integer, intent(in) :: level
    holder = -1
    if (level < 1 .or. level > self%all_levels) return
    do while (self%levels_below(holder + 1) < level)
      holder = holder + 1
    end do
  end function holder

  !> The ring inner <= r <= outer, 0 <= z <= height, of nradial x nangular quads, each cut in two.
  !! Radial mesh lines are spirals that turn by `twist` radians from the inner to the outer wall.
  function ring_mesh(inner, outer, height, nradial, nangular, nlevels, twist, processes) result(mesh)
    real(real64), intent(in) :: inner, outer, height, twist
    integer, intent(in) :: nradial, nangular, nlevels
    type(processes_type), intent(in) :: processes
    type(mesh_type) :: mesh

    mesh%nv = (nradial + 1) * nangular
    mesh%ncolumns = 2 * nradial * nangular
    mesh%processes = processes
    mesh%all_levels = nlevels
    mesh%below = mesh%levels_below(processes%rank)
    mesh%nlevels = mesh%levels_below(processes%rank + 1) - mesh%below
    call place_vertices(mesh, inner, outer, height, nradial, nangular, twist)
    call cut_triangles(mesh, nradial, nangular)
    call extrude(mesh)
    call measure_columns(mesh)
    call find_stars(mesh)
    call find_edges(mesh)
  end function ring_mesh

  subroutine place_vertices(mesh, inner, outer, height, nradial, nangular, twist)
    type(mesh_type), intent(inout) :: mesh
    real(real64), intent(in) :: inner, outer, height, twist
    integer, intent(in) :: nradial, nangular
    real(real64) :: share, angle, radius
    integer :: i, j, k, v

    allocate (mesh%interface_z(mesh%all_levels + 1))
    do k = 1, mesh%all_levels + 1
      share = real(k - 1, real64) / real(mesh%all_levels, real64)
      mesh%interface_z(k) = height * (share - crowding * sin(2.0_real64 * pi * share))
    end do
    mesh%interface_z(mesh%all_levels + 1) = height
    mesh%level_z = 0.5_real64 * (mesh%interface_z(:mesh%all_levels) + mesh%interface_z(2:))

    allocate (mesh%x(mesh%nv * (mesh%nlevels + 1)))
    allocate (mesh%y, mesh%z, mold=mesh%x)
    do j = 0, nradial
      share = real(j, real64) / real(nradial, real64)
      radius = inner + share * (outer - inner)
      do i = 0, nangular - 1
        angle = 2.0_real64 * pi * real(i, real64) / real(nangular, real64) + twist * share
        v = 1 + i + j * nangular
        mesh%x(v::mesh%nv) = radius * cos(angle)
        mesh%y(v::mesh%nv) = radius * sin(angle)
        mesh%z(v::mesh%nv) = mesh%interface_z(mesh%below + 1:mesh%below + mesh%nlevels + 1)
      end do
    end do
    allocate (mesh%vertex_ids(size(mesh%x)), mesh%cell_ids(mesh%ncells()))
    mesh%vertex_ids(:) = [(int(mesh%below, int64) * mesh%nv + v - 1, v=1, size(mesh%x))]
    mesh%cell_ids(:) = [(int(mesh%below, int64) * mesh%ncolumns + v - 1, v=1, mesh%ncells())]
  end subroutine place_vertices

  subroutine cut_triangles(mesh, nradial, nangular)
    type(mesh_type), intent(inout) :: mesh
    integer, intent(in) :: nradial, nangular
    integer :: i, j, c, a, b

    allocate (mesh%triangle(3, mesh%ncolumns))
    c = 0
    do j = 0, nradial - 1
      do i = 0, nangular - 1
        a = 1 + i + j * nangular
        b = 1 + modulo(i + 1, nangular) + j * nangular
        mesh%triangle(:, c + 1) = [a, a + nangular, b + nangular]
        mesh%triangle(:, c + 2) = [a, b + nangular, b]
        c = c + 2
      end do
    end do
  end subroutine cut_triangles

  !> By VTK's rule the normal of a wedge's first triangle, by the right hand, points away from the
  !! second one: so the upper triangle, counter-clockwise from above, comes first.
  subroutine extrude(mesh)
    type(mesh_type), intent(inout) :: mesh
    integer :: k, c, cell

    allocate (mesh%connectivity(6, mesh%ncells()))
    cell = 0
    do k = 1, mesh%nlevels
      do c = 1, mesh%ncolumns
        cell = cell + 1
        mesh%connectivity(1:3, cell) = int(mesh%triangle(:, c) + k * mesh%nv, int32)
        mesh%connectivity(4:6, cell) = int(mesh%triangle(:, c) + (k - 1) * mesh%nv, int32)
      end do
    end do
  end subroutine extrude

  subroutine measure_columns(mesh)
    type(mesh_type), intent(inout) :: mesh
    real(real64) :: p(2, 3)
    integer :: c

    allocate (mesh%area(mesh%ncolumns), mesh%centre(2, mesh%ncolumns))
    do c = 1, mesh%ncolumns
      p(1, :) = mesh%x(mesh%triangle(:, c))
      p(2, :) = mesh%y(mesh%triangle(:, c))
      mesh%area(c) = 0.5_real64 * ((p(1, 2) - p(1, 1)) * (p(2, 3) - p(2, 1)) &
                                 - (p(2, 2) - p(2, 1)) * (p(1, 3) - p(1, 1)))
      mesh%centre(:, c) = sum(p, dim=2) / 3.0_real64
    end do
  end subroutine measure_columns

  subroutine find_stars(mesh)
    type(mesh_type), intent(inout) :: mesh
    integer, allocatable :: next(:)
    integer :: c, i, v

    allocate (mesh%star_start(mesh%nv + 1), source=0)
    do c = 1, mesh%ncolumns
      do i = 1, 3
        v = mesh%triangle(i, c)
        mesh%star_start(v + 1) = mesh%star_start(v + 1) + 1
      end do
    end do
    mesh%star_start(1) = 1
    do v = 1, mesh%nv
      mesh%star_start(v + 1) = mesh%star_start(v) + mesh%star_start(v + 1)
    end do

    allocate (mesh%star(3 * mesh%ncolumns))
    allocate (next(mesh%nv))
    next(:) = mesh%star_start(:mesh%nv)
    do c = 1, mesh%ncolumns
      do i = 1, 3
        v = mesh%triangle(i, c)
        mesh%star(next(v)) = c
        next(v) = next(v) + 1
      end do
    end do
  end subroutine find_stars

  !> Edges between two columns go into the list, edges of one column make up the walls.
  subroutine find_edges(mesh)
    type(mesh_type), intent(inout) :: mesh
    real(real64) :: outwards(2), length
    integer :: c, i, a, b, other, found, pass, v

    allocate (mesh%wall_normal(2, mesh%nv), source=0.0_real64)
    do pass = 1, 2                                       ! count, then fill
      found = 0
      do c = 1, mesh%ncolumns
        do i = 1, 3
          a = mesh%triangle(i, c)
          b = mesh%triangle(1 + modulo(i, 3), c)
          other = column_across(mesh, c, a, b)
          if (other > c) then
            found = found + 1
            if (pass == 2) mesh%edge_vertices(:, found) = [a, b]
            if (pass == 2) mesh%edge_columns(:, found) = [c, other]
          else if (other == 0 .and. pass == 2) then
            outwards = [mesh%y(b) - mesh%y(a), mesh%x(a) - mesh%x(b)]
            mesh%wall_normal(:, a) = mesh%wall_normal(:, a) + outwards
            mesh%wall_normal(:, b) = mesh%wall_normal(:, b) + outwards
          end if
        end do
      end do
      if (pass == 1) allocate (mesh%edge_vertices(2, found), mesh%edge_columns(2, found))
    end do
    do v = 1, mesh%nv
      length = norm2(mesh%wall_normal(:, v))
      if (length > 0.0_real64) mesh%wall_normal(:, v) = mesh%wall_normal(:, v) / length
    end do
  end subroutine find_edges

  !> The other column that holds the edge (a, b) of column c; 0 at a wall.
  pure integer function column_across(mesh, c, a, b) result(other)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: c, a, b
    integer :: s

    do s = mesh%star_start(a), mesh%star_start(a + 1) - 1
      other = mesh%star(s)
      if (other /= c .and. any(mesh%triangle(:, other) == b)) return
    end do
    other = 0
  end function column_across

  !> Signed volume of a wedge with vertices p(3, 6) in VTK's order, positive by VTK's rule; exact for
  !! planar sides, otherwise that of the sides' two triangles.
  pure real(real64) function wedge_volume(p) result(volume)
    real(real64), intent(in) :: p(3, 6)

    volume = (triple(p(:, 1), p(:, 2), p(:, 3), p(:, 4)) &
            + triple(p(:, 2), p(:, 5), p(:, 6), p(:, 4)) &
            + triple(p(:, 2), p(:, 6), p(:, 3), p(:, 4))) / 6.0_real64
  end function wedge_volume

  !> Six times the volume of a tetrahedron, positive when a, b, c turn counter-clockwise seen from
  !! outside, that is from the side away from d.
  pure real(real64) function triple(a, b, c, d)
    real(real64), intent(in) :: a(3), b(3), c(3), d(3)
    real(real64) :: u(3), v(3), w(3)

    u = a - d
    v = b - d
    w = c - d
    triple = u(1) * (v(2) * w(3) - v(3) * w(2)) + u(2) * (v(3) * w(1) - v(1) * w(3)) &
           + u(3) * (v(1) * w(2) - v(2) * w(1))
  end function triple

end module heat_mesh
