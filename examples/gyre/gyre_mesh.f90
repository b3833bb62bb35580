!> A layered mesh of wedges over a basin: a triangulated surface, in longitude and latitude, extruded
!! down to the bottom.
!!
!! Vertex v of interface k has id v + (k - 1)*nv, the cell of column c in level k has id
!! c + (k - 1)*ncolumns; both count from 1 and from the bottom. Metric terms are those of a sphere:
!! a triangle is taken at the latitude of its centroid.
module gyre_mesh
  use, intrinsic :: iso_fortran_env, only: int32, real64
  use gyre_basin, only: basin_type, earth_radius, radians
  implicit none
  private

  public :: basin_mesh, vertex_mean

  !> Interfaces near the surface lie at fixed depths, in metres; those below follow the bottom, and
  !! each level there is thicker than the one above by the same factor.
  real(real64), parameter, public :: fixed_depth(12) = &
      real([0, 5, 10, 15, 20, 30, 40, 60, 80, 110, 150, 200], real64)
  integer, parameter :: nbelow = 14
  real(real64), parameter :: thickening = 1.15_real64

  !> Meridians crowd towards the western coast, where the current is narrow: spacing grows by
  !! exp(crowding) from there to the eastern coast.
  real(real64), parameter :: crowding = 2.5_real64

  type, public :: mesh_type
    integer :: nv = 0                                    !< vertices of one interface
    integer :: ncolumns = 0, nedges = 0
    integer :: nlevels = size(fixed_depth) - 1 + nbelow
    integer :: bandwidth = 0                             !< largest difference of an edge's vertices
    real(real64), allocatable :: lon(:), lat(:), depth(:) !< all vertices: nv*(nlevels + 1)
    integer(int32), allocatable :: connectivity(:,:)     !< (6, ncells), VTK's order
    integer, allocatable :: triangle(:,:)                !< (3, ncolumns), counter-clockwise from above
    real(real64), allocatable :: area(:)                 !< (ncolumns), m2
    real(real64), allocatable :: cos_lat(:)              !< (ncolumns), at the centroids
    real(real64), allocatable :: gradient(:,:,:)         !< (2, 3, ncolumns): east, north of the hats
    logical, allocatable :: on_coast(:)                  !< (nv)
    real(real64), allocatable :: coast_normal(:,:)       !< (2, nv), unit and outwards; 0 inside
    integer, allocatable :: edge_vertices(:,:)           !< (2, nedges), edges between two columns
    integer, allocatable :: edge_columns(:,:)            !< (2, nedges): left of the edge, right of it
    real(real64), allocatable :: edge_vector(:,:)        !< (2, nedges), m east and north
    real(real64), allocatable :: centre_distance(:)      !< (nedges), m
    real(real64), allocatable :: volume(:,:)             !< (ncolumns, nlevels), m3
  contains
    procedure :: ncells
    procedure :: interface_depth
    procedure :: edge_depth
  end type mesh_type

contains

  pure integer function ncells(self)
    class(mesh_type), intent(in) :: self
    ncells = self%ncolumns * self%nlevels
  end function ncells

  !> Depth of interface k at vertex v of the surface.
  pure real(real64) function interface_depth(self, v, k)
    class(mesh_type), intent(in) :: self
    integer, intent(in) :: v, k
    interface_depth = self%depth(v + (k - 1) * self%nv)
  end function interface_depth

  !> Depths of all interfaces at the middle of an edge.
  pure function edge_depth(self, e) result(depth)
    class(mesh_type), intent(in) :: self
    integer, intent(in) :: e
    real(real64) :: depth(self%nlevels + 1)
    integer :: k

    do k = 1, self%nlevels + 1
      depth(k) = 0.5_real64 * (self%interface_depth(self%edge_vertices(1, e), k) &
                             + self%interface_depth(self%edge_vertices(2, e), k))
    end do
  end function edge_depth

  !> nwest by nnorth quadrangles from coast to coast, each cut in two, this way and that.
  function basin_mesh(basin, nwest, nnorth) result(mesh)
    type(basin_type), intent(in) :: basin
    integer, intent(in) :: nwest, nnorth
    type(mesh_type) :: mesh

    mesh%nv = (nwest + 1) * (nnorth + 1)
    mesh%ncolumns = 2 * nwest * nnorth
    call place_vertices(mesh, basin, nwest, nnorth)
    call cut_triangles(mesh, nwest, nnorth)
    call extrude(mesh)
    call measure_columns(mesh)
    call find_edges(mesh)
  end function basin_mesh

  subroutine place_vertices(mesh, basin, nwest, nnorth)
    type(mesh_type), intent(inout) :: mesh
    type(basin_type), intent(in) :: basin
    integer, intent(in) :: nwest, nnorth
    real(real64) :: share, latitude, bottom
    integer :: i, j, k, v, n, all

    n = mesh%nlevels + 1
    all = mesh%nv * n
    allocate (mesh%lon(all), mesh%lat(all), mesh%depth(all))
    do i = 0, nwest
      share = (exp(crowding * real(i, real64) / real(nwest, real64)) - 1.0_real64) &
            / (exp(crowding) - 1.0_real64)
      do j = 0, nnorth                                   ! runs first: fewer rows than meridians
        v = 1 + j + i * (nnorth + 1)
        associate (south => basin%latitude(1), north => basin%latitude(size(basin%latitude)))
          latitude = south + (north - south) * real(j, real64) / real(nnorth, real64)
        end associate
        bottom = basin%bottom(share, latitude)
        do k = 1, n
          mesh%lon(v + (k - 1) * mesh%nv) = basin%longitude(share, latitude)
          mesh%lat(v + (k - 1) * mesh%nv) = latitude
          mesh%depth(v + (k - 1) * mesh%nv) = level_depth(n - k, bottom)
        end do
      end do
    end do
  end subroutine place_vertices

  !> Depth of the interface under as many levels.
  pure real(real64) function level_depth(above, bottom)
    integer, intent(in) :: above
    real(real64), intent(in) :: bottom
    real(real64) :: lowest

    lowest = fixed_depth(size(fixed_depth))
    if (above < size(fixed_depth)) then
      level_depth = fixed_depth(above + 1)
    else
      level_depth = lowest + (bottom - lowest) &
          * (thickening**(above - size(fixed_depth) + 1) - 1.0_real64) &
          / (thickening**nbelow - 1.0_real64)
    end if
  end function level_depth

  subroutine cut_triangles(mesh, nwest, nnorth)
    type(mesh_type), intent(inout) :: mesh
    integer, intent(in) :: nwest, nnorth
    integer :: i, j, c, sw, nw, se, ne

    allocate (mesh%triangle(3, mesh%ncolumns))
    c = 0
    do i = 0, nwest - 1
      do j = 0, nnorth - 1
        sw = 1 + j + i * (nnorth + 1)
        nw = sw + 1
        se = sw + nnorth + 1
        ne = se + 1
        if (modulo(i + j, 2) == 0) then
          mesh%triangle(:, c + 1) = [sw, se, ne]
          mesh%triangle(:, c + 2) = [sw, ne, nw]
        else
          mesh%triangle(:, c + 1) = [sw, se, nw]
          mesh%triangle(:, c + 2) = [se, ne, nw]
        end if
        c = c + 2
      end do
    end do
  end subroutine cut_triangles

  !> By VTK's rule a wedge's first triangle, seen from the second, is clockwise: where the third
  !! coordinate goes down, that is the lower one, listed counter-clockwise from above.
  subroutine extrude(mesh)
    type(mesh_type), intent(inout) :: mesh
    integer :: k, c, cell

    allocate (mesh%connectivity(6, mesh%ncells()))
    cell = 0
    do k = 1, mesh%nlevels
      do c = 1, mesh%ncolumns
        cell = cell + 1
        mesh%connectivity(1:3, cell) = int(mesh%triangle(:, c) + (k - 1) * mesh%nv, int32)
        mesh%connectivity(4:6, cell) = int(mesh%triangle(:, c) + k * mesh%nv, int32)
      end do
    end do
  end subroutine extrude

  subroutine measure_columns(mesh)
    type(mesh_type), intent(inout) :: mesh
    real(real64) :: x(3), y(3), twice
    integer :: c, i, j, k, l

    allocate (mesh%area(mesh%ncolumns), mesh%cos_lat(mesh%ncolumns))
    allocate (mesh%gradient(2, 3, mesh%ncolumns), mesh%volume(mesh%ncolumns, mesh%nlevels))
    do c = 1, mesh%ncolumns
      associate (v => mesh%triangle(:, c))
        mesh%cos_lat(c) = cos(radians(sum(mesh%lat(v)) / 3.0_real64))
        x = earth_radius * mesh%cos_lat(c) * radians(mesh%lon(v))
        y = earth_radius * radians(mesh%lat(v))
        twice = (x(2) - x(1)) * (y(3) - y(1)) - (x(3) - x(1)) * (y(2) - y(1))
        mesh%area(c) = 0.5_real64 * twice
        do i = 1, 3
          j = 1 + modulo(i, 3)
          k = 1 + modulo(i + 1, 3)
          mesh%gradient(:, i, c) = [y(j) - y(k), x(k) - x(j)] / twice
        end do
        do l = 1, mesh%nlevels
          mesh%volume(c, l) = mesh%area(c) / 3.0_real64 &
              * sum(mesh%depth(v + (l - 1) * mesh%nv) - mesh%depth(v + l * mesh%nv))
        end do
      end associate
    end do
  end subroutine measure_columns

  !> Edges between two columns go into the list, edges of one column are the coast.
  subroutine find_edges(mesh)
    type(mesh_type), intent(inout) :: mesh
    integer :: first(3 * mesh%ncolumns, 3)               ! per half edge: lower vertex, higher, column
    integer :: start(mesh%nv + 1)
    integer :: c, i, h, a, b, found, pass

    ! Half edges sorted by their lower vertex, by counting.
    start = 0
    do c = 1, mesh%ncolumns
      do i = 1, 3
        a = min(mesh%triangle(i, c), mesh%triangle(1 + modulo(i, 3), c))
        start(a + 1) = start(a + 1) + 1
      end do
    end do
    start(1) = 1
    do a = 1, mesh%nv
      start(a + 1) = start(a + 1) + start(a)
    end do
    do c = 1, mesh%ncolumns
      do i = 1, 3
        a = mesh%triangle(i, c)
        b = mesh%triangle(1 + modulo(i, 3), c)
        h = start(min(a, b))
        first(h, :) = [a, b, c]
        start(min(a, b)) = h + 1
      end do
    end do
    start(2:) = start(:mesh%nv)                          ! each had moved on to the next
    start(1) = 1

    allocate (mesh%on_coast(mesh%nv), source=.false.)
    allocate (mesh%coast_normal(2, mesh%nv), source=0.0_real64)
    do pass = 1, 2                                       ! count, then fill
      found = 0
      do a = 1, mesh%nv
        do h = start(a), start(a + 1) - 1
          i = partner(h)
          if (i == 0 .and. pass == 1) call note_coast(first(h, 1), first(h, 2))
          if (i <= h) cycle
          found = found + 1
          if (pass == 2) call note_edge(found, h, i)
        end do
      end do
      mesh%nedges = found
      if (pass == 1) allocate (mesh%edge_vertices(2, found), mesh%edge_columns(2, found), &
                               mesh%edge_vector(2, found), mesh%centre_distance(found))
    end do
    do a = 1, mesh%nv
      if (mesh%on_coast(a)) mesh%coast_normal(:, a) = mesh%coast_normal(:, a) &
                                                    / norm2(mesh%coast_normal(:, a))
    end do

  contains

    !> The same edge of the other column; 0 at the coast.
    pure integer function partner(h)
      integer, intent(in) :: h
      associate (low => min(first(h, 1), first(h, 2)))
        do partner = start(low), start(low + 1) - 1
          if (first(partner, 1) == first(h, 2) .and. first(partner, 2) == first(h, 1)) return
        end do
      end associate
      partner = 0
    end function partner

    subroutine note_coast(a, b)
      integer, intent(in) :: a, b
      real(real64) :: along(2)

      along = metres(a, b)
      mesh%on_coast([a, b]) = .true.
      mesh%coast_normal(:, a) = mesh%coast_normal(:, a) + [along(2), -along(1)]
      mesh%coast_normal(:, b) = mesh%coast_normal(:, b) + [along(2), -along(1)]
    end subroutine note_coast

    subroutine note_edge(e, h, other)
      integer, intent(in) :: e, h, other
      real(real64) :: between(2)
      integer :: l, r

      l = first(h, 3)
      r = first(other, 3)
      mesh%edge_vertices(:, e) = first(h, 1:2)
      mesh%edge_columns(:, e) = [l, r]
      mesh%edge_vector(:, e) = metres(first(h, 1), first(h, 2))
      mesh%bandwidth = max(mesh%bandwidth, abs(first(h, 1) - first(h, 2)))
      between(1) = sum(mesh%lon(mesh%triangle(:, r))) - sum(mesh%lon(mesh%triangle(:, l)))
      between(2) = sum(mesh%lat(mesh%triangle(:, r))) - sum(mesh%lat(mesh%triangle(:, l)))
      between(1) = between(1) * 0.5_real64 * (mesh%cos_lat(l) + mesh%cos_lat(r))
      mesh%centre_distance(e) = earth_radius * norm2(radians(between)) / 3.0_real64
    end subroutine note_edge

    pure function metres(a, b)
      integer, intent(in) :: a, b
      real(real64) :: metres(2)
      metres(1) = earth_radius * radians(mesh%lon(b) - mesh%lon(a)) &
                * cos(radians(0.5_real64 * (mesh%lat(a) + mesh%lat(b))))
      metres(2) = earth_radius * radians(mesh%lat(b) - mesh%lat(a))
    end function metres

  end subroutine find_edges

  !> Values of the columns at the vertices of the surface: means over the columns around each, by area.
  pure function vertex_mean(mesh, of_column) result(mean)
    type(mesh_type), intent(in) :: mesh
    real(real64), intent(in) :: of_column(:)
    real(real64) :: mean(mesh%nv)
    real(real64) :: weight(mesh%nv)
    integer :: c

    mean = 0.0_real64
    weight = 0.0_real64
    do c = 1, mesh%ncolumns
      associate (v => mesh%triangle(:, c))
        mean(v) = mean(v) + mesh%area(c) * of_column(c)
        weight(v) = weight(v) + mesh%area(c)
      end associate
    end do
    mean = mean / weight
  end function vertex_mean

end module gyre_mesh
