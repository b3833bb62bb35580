!> A layered mesh of wedges over a basin: a triangulated surface, in longitude and latitude, extruded
!! down to the bottom.
!!
!! Each process knows the surface of the whole basin, and the water below a strip of it, from one
!! meridian to another. Columns and vertices are numbered meridian by meridian, so a strip's are
!! first_column to last_column and first_vertex to last_vertex; neighbours share the vertices of the
!! meridian between them. To know what happens at its vertices a process follows the columns beside its
!! strip too: its own and these are near.
!!
!! Vertex v of interface k has id v + (k - 1)*nv, the cell of column c in level k has id
!! c + (k - 1)*ncolumns; both count from 1 and from the bottom. In a strip's own numbers its vertices and
!! columns alone count, in the same order. Metric terms are those of a sphere: a triangle is taken at the
!! latitude of its centroid.
module gyre_mesh
  use, intrinsic :: iso_fortran_env, only: int32, int64, real64
  use gyre_basin, only: basin_type, earth_radius, radians
  use solver_processes, only: processes_type
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
    ! The surface of the whole basin.
    integer :: nv = 0                                    !< vertices of one interface
    integer :: ncolumns = 0
    integer :: nlevels = size(fixed_depth) - 1 + nbelow
    integer :: bandwidth = 0                             !< largest difference of an edge's vertices
    real(real64), allocatable :: surface_lon(:), surface_lat(:), bottom(:) !< (nv)
    integer, allocatable :: triangle(:,:)                !< (3, ncolumns), counter-clockwise from above
    real(real64), allocatable :: area(:)                 !< (ncolumns), m2
    real(real64), allocatable :: cos_lat(:)              !< (ncolumns), at the centroids
    real(real64), allocatable :: gradient(:,:,:)         !< (2, 3, ncolumns): east, north of the hats
    logical, allocatable :: on_coast(:)                  !< (nv)
    real(real64), allocatable :: coast_normal(:,:)       !< (2, nv), unit and outwards; 0 inside

    ! This process's strip.
    type(processes_type) :: processes
    integer :: west = -1, east = -1                      !< processes of the neighbouring strips; -1: none
    integer :: first_column = 1, last_column = 0         !< own ones
    integer :: near_first = 1, near_last = 0             !< own columns and those beside the strip
    integer :: first_vertex = 1, last_vertex = 0
    real(real64), allocatable :: lon(:), lat(:), depth(:) !< own vertices, all interfaces
    integer(int32), allocatable :: connectivity(:,:)     !< (6, ncells), VTK's order, in own numbers
    integer(int64), allocatable :: cell_ids(:), vertex_ids(:) !< in the whole basin, from 0 as in tables
    real(real64), allocatable :: volume(:,:)             !< (first_column:last_column, nlevels), m3
    integer :: nedges = 0                                !< edges between two columns, one of them near
    integer, allocatable :: edge_vertices(:,:)           !< (2, nedges)
    integer, allocatable :: edge_columns(:,:)            !< (2, nedges): left of the edge, right of it
    real(real64), allocatable :: edge_vector(:,:)        !< (2, nedges), m east and north
    real(real64), allocatable :: centre_distance(:)      !< (nedges), m
  contains
    procedure :: ncells
    procedure :: own_id
    procedure :: is_own
    procedure :: is_near
    procedure :: interface_depth
    procedure :: edge_depth
  end type mesh_type

  interface
    !> Edges between two columns, one of them near, go into the list; edges of one column are the coast.
    module subroutine find_edges(mesh)
      type(mesh_type), intent(inout) :: mesh
    end subroutine find_edges
  end interface

contains

  !> Of this process's strip.
  pure integer function ncells(self)
    class(mesh_type), intent(in) :: self
    ncells = (self%last_column - self%first_column + 1) * self%nlevels
  end function ncells

  !> Of vertex v of the surface, on interface k, in the strip's own numbers.
  pure integer function own_id(self, v, k)
    class(mesh_type), intent(in) :: self
    integer, intent(in) :: v, k
    own_id = v - self%first_vertex + 1 + (k - 1) * (self%last_vertex - self%first_vertex + 1)
  end function own_id

  pure logical function is_own(self, column)
    class(mesh_type), intent(in) :: self
    integer, intent(in) :: column
    is_own = column >= self%first_column .and. column <= self%last_column
  end function is_own

  pure logical function is_near(self, column)
    class(mesh_type), intent(in) :: self
    integer, intent(in) :: column
    is_near = column >= self%near_first .and. column <= self%near_last
  end function is_near

  !> Depth of interface k at vertex v of the surface.
  pure real(real64) function interface_depth(self, v, k)
    class(mesh_type), intent(in) :: self
    integer, intent(in) :: v, k
    interface_depth = level_depth(self%nlevels + 1 - k, self%bottom(v))
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

  !> nwest by nnorth quadrangles from coast to coast, each cut in two, this way and that; dealt out in
  !! strips between meridians.
  function basin_mesh(basin, nwest, nnorth, processes) result(mesh)
    type(basin_type), intent(in) :: basin
    integer, intent(in) :: nwest, nnorth
    type(processes_type), intent(in), optional :: processes
    type(mesh_type) :: mesh

    if (present(processes)) mesh%processes = processes
    mesh%nv = (nwest + 1) * (nnorth + 1)
    mesh%ncolumns = 2 * nwest * nnorth
    call choose_strip(mesh, nwest, nnorth)
    call place_surface(mesh, basin, nwest, nnorth)
    call place_vertices(mesh)
    call cut_triangles(mesh, nwest, nnorth)
    call extrude(mesh)
    call measure_columns(mesh)
    call find_edges(mesh)
  end function basin_mesh

  !> A process may have no columns.
  subroutine choose_strip(mesh, nwest, nnorth)
    type(mesh_type), intent(inout) :: mesh
    integer, intent(in) :: nwest, nnorth
    integer :: process, first, last, begin(0:mesh%processes%number)

    associate (rank => mesh%processes%rank, number => mesh%processes%number)
      begin = [(nwest * process / number, process=0, number)] ! quadrangles east of that many meridians
      first = begin(rank)
      last = begin(rank + 1)
      if (first == last) return
      do process = 0, number - 1
        if (begin(process) < first .and. begin(process + 1) == first) mesh%west = process
        if (begin(process) == last .and. begin(process + 1) > last) mesh%east = process
      end do
    end associate
    mesh%first_column = 2 * nnorth * first + 1
    mesh%last_column = 2 * nnorth * last
    mesh%near_first = 2 * nnorth * max(first - 1, 0) + 1
    mesh%near_last = 2 * nnorth * min(last + 1, nwest)
    mesh%first_vertex = (nnorth + 1) * first + 1
    mesh%last_vertex = (nnorth + 1) * (last + 1)
  end subroutine choose_strip

  subroutine place_surface(mesh, basin, nwest, nnorth)
    type(mesh_type), intent(inout) :: mesh
    type(basin_type), intent(in) :: basin
    integer, intent(in) :: nwest, nnorth
    real(real64) :: share, latitude
    integer :: i, j, v

    allocate (mesh%surface_lon(mesh%nv), mesh%surface_lat(mesh%nv), mesh%bottom(mesh%nv))
    do i = 0, nwest
      share = (exp(crowding * real(i, real64) / real(nwest, real64)) - 1.0_real64) &
            / (exp(crowding) - 1.0_real64)
      do j = 0, nnorth                                   ! runs first: fewer rows than meridians
        v = 1 + j + i * (nnorth + 1)
        associate (south => basin%latitude(1), north => basin%latitude(size(basin%latitude)))
          latitude = south + (north - south) * real(j, real64) / real(nnorth, real64)
        end associate
        mesh%surface_lon(v) = basin%longitude(share, latitude)
        mesh%surface_lat(v) = latitude
        mesh%bottom(v) = basin%bottom(share, latitude)
      end do
    end do
  end subroutine place_surface

  subroutine place_vertices(mesh)
    type(mesh_type), intent(inout) :: mesh
    integer :: k, v, all

    all = (mesh%last_vertex - mesh%first_vertex + 1) * (mesh%nlevels + 1)
    allocate (mesh%lon(all), mesh%lat(all), mesh%depth(all), mesh%vertex_ids(all))
    do k = 1, mesh%nlevels + 1
      do v = mesh%first_vertex, mesh%last_vertex
        associate (id => mesh%own_id(v, k))
          mesh%lon(id) = mesh%surface_lon(v)
          mesh%lat(id) = mesh%surface_lat(v)
          mesh%depth(id) = mesh%interface_depth(v, k)
          mesh%vertex_ids(id) = int(v - 1, int64) + int(k - 1, int64) * mesh%nv
        end associate
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
    integer :: i, k, c, cell

    allocate (mesh%connectivity(6, mesh%ncells()), mesh%cell_ids(mesh%ncells()))
    cell = 0
    do k = 1, mesh%nlevels
      do c = mesh%first_column, mesh%last_column
        cell = cell + 1
        mesh%cell_ids(cell) = int(c - 1, int64) + int(k - 1, int64) * mesh%ncolumns
        do i = 1, 3
          mesh%connectivity(i, cell) = int(mesh%own_id(mesh%triangle(i, c), k), int32)
          mesh%connectivity(3 + i, cell) = int(mesh%own_id(mesh%triangle(i, c), k + 1), int32)
        end do
      end do
    end do
  end subroutine extrude

  subroutine measure_columns(mesh)
    type(mesh_type), intent(inout) :: mesh
    real(real64) :: x(3), y(3), twice, upper(3), lower(3)
    integer :: c, i, j, k, l

    allocate (mesh%area(mesh%ncolumns), mesh%cos_lat(mesh%ncolumns))
    allocate (mesh%gradient(2, 3, mesh%ncolumns), mesh%volume(mesh%first_column:mesh%last_column, mesh%nlevels))
    do c = 1, mesh%ncolumns
      associate (v => mesh%triangle(:, c))
        mesh%cos_lat(c) = cos(radians(sum(mesh%surface_lat(v)) / 3.0_real64))
        x = earth_radius * mesh%cos_lat(c) * radians(mesh%surface_lon(v))
        y = earth_radius * radians(mesh%surface_lat(v))
        twice = (x(2) - x(1)) * (y(3) - y(1)) - (x(3) - x(1)) * (y(2) - y(1))
        mesh%area(c) = 0.5_real64 * twice
        do i = 1, 3
          j = 1 + modulo(i, 3)
          k = 1 + modulo(i + 1, 3)
          mesh%gradient(:, i, c) = [y(j) - y(k), x(k) - x(j)] / twice
        end do
        if (.not. mesh%is_own(c)) cycle
        do l = 1, mesh%nlevels
          do i = 1, 3
            lower(i) = mesh%interface_depth(v(i), l)
            upper(i) = mesh%interface_depth(v(i), l + 1)
          end do
          mesh%volume(c, l) = mesh%area(c) / 3.0_real64 * sum(lower - upper)
        end do
      end associate
    end do
  end subroutine measure_columns

  !> Values of the near columns at the strip's vertices of the surface: means over the columns around
  !! each, by area.
  pure function vertex_mean(mesh, of_column) result(mean)
    type(mesh_type), intent(in) :: mesh
    real(real64), intent(in) :: of_column(mesh%near_first:)
    real(real64) :: mean(mesh%first_vertex:mesh%last_vertex)
    real(real64) :: weight(mesh%first_vertex:mesh%last_vertex)
    integer :: c, i

    mean = 0.0_real64
    weight = 0.0_real64
    do c = mesh%near_first, mesh%near_last
      do i = 1, 3
        associate (v => mesh%triangle(i, c))
          if (v < mesh%first_vertex .or. v > mesh%last_vertex) cycle
          mean(v) = mean(v) + mesh%area(c) * of_column(c)
          weight(v) = weight(v) + mesh%area(c)
        end associate
      end do
    end do
    mean = mean / weight
  end function vertex_mean

end module gyre_mesh
