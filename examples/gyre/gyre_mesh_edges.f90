!> The edges of a mesh's columns, found from its triangles.
submodule (gyre_mesh) gyre_mesh_edges
  implicit none

contains

  module subroutine find_edges(mesh)
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
          if (pass == 1) mesh%bandwidth = max(mesh%bandwidth, abs(first(h, 1) - first(h, 2)))
          if (.not. (mesh%is_near(first(h, 3)) .or. mesh%is_near(first(i, 3)))) cycle
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
      between(1) = sum(mesh%surface_lon(mesh%triangle(:, r))) - sum(mesh%surface_lon(mesh%triangle(:, l)))
      between(2) = sum(mesh%surface_lat(mesh%triangle(:, r))) - sum(mesh%surface_lat(mesh%triangle(:, l)))
      between(1) = between(1) * 0.5_real64 * (mesh%cos_lat(l) + mesh%cos_lat(r))
      mesh%centre_distance(e) = earth_radius * norm2(radians(between)) / 3.0_real64
    end subroutine note_edge

    pure function metres(a, b)
      integer, intent(in) :: a, b
      real(real64) :: metres(2)
      associate (lon => mesh%surface_lon, lat => mesh%surface_lat)
        metres(1) = earth_radius * radians(lon(b) - lon(a)) * cos(radians(0.5_real64 * (lat(a) + lat(b))))
        metres(2) = earth_radius * radians(lat(b) - lat(a))
      end associate
    end function metres

  end subroutine find_edges

end submodule gyre_mesh_edges
