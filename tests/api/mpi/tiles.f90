!> A solver as CloverLeaf is one, which knows of the library what the guide says: chunks of a box for the
!! processes, several tiles a chunk, and two rows of halo cells around each tile, in which cells of
!! neighbours are, or outside of the box nothing. Fields are known in closed form.
module tiles
  use, intrinsic :: iso_fortran_env, only: int64, int8, real64
  use insitu
  implicit none
  private

  public :: cell_of, density_at, first_of, give_tiles, make_tiles, middle, move_on, plane, velocity_at

  integer, parameter, public :: halo = 2, cells(3) = [13, 11, 10]
  integer, parameter, public :: all_cells = 13 * 11 * 10, all_vertices = 14 * 12 * 11
  integer, parameter :: tiles_a_chunk(3) = [2, 1, 2]
  real(real64), parameter :: spacing(3) = [0.4_real64, 0.47_real64, 0.53_real64] !< where planes are evenly spaced
  logical, public :: is_uniform = .false.                !< if they are
  real(real64), parameter :: nothing = -999.0_real64     ! what halo cells outside of the box hold

  type, public :: tile_type
    integer :: first(3), last(3)                         !< own cells, of the whole box's
    real(real64), allocatable :: vertexx(:), vertexy(:), vertexz(:) !< (first - halo:last + halo + 1)
    !> (first - halo:last + halo), along each axis.
    real(real64), allocatable :: density(:,:,:)
    integer(int8), allocatable :: ghosts(:)              !< the same, 1 of a halo's cells
    integer(int64), allocatable :: cell_ids(:)           !< the same: those of a tile follow each other
    integer(int64), allocatable :: vertex_ids(:)         !< of all its vertices, with the halo's
    real(real64), allocatable :: velocity(:,:,:,:)       !< (3, vertices, with the halo's)
  end type tile_type

contains

  !> Planes between cells, the same on all processes.
  elemental real(real64) function plane(i, axis)
    integer, intent(in) :: i, axis
    plane = real(i, real64) * spacing(axis)
    if (.not. is_uniform) plane = 0.25_real64 * real(i, real64) + 0.01_real64 * real(axis * i * i, real64)
  end function plane

  elemental real(real64) function middle(i, axis)
    integer, intent(in) :: i, axis
    middle = 0.5_real64 * (plane(i, axis) + plane(i + 1, axis))
  end function middle

  !> Of cell (i, j, k), at its centre.
  elemental real(real64) function density_at(i, j, k, time)
    integer, intent(in) :: i, j, k
    real(real64), intent(in) :: time
    density_at = (1.0_real64 + 2.0_real64 * middle(i, 1) + 3.0_real64 * middle(j, 2) - middle(k, 3)) &
               * (1.0_real64 + time)
  end function density_at

  !> Of any place.
  pure function velocity_at(at) result(velocity)
    real(real64), intent(in) :: at(3)
    real(real64) :: velocity(3)
    velocity = [1.0_real64 + at(2), at(3) - at(1), 0.5_real64 * at(1)]
  end function velocity_at

  !> Whose cell it is, which is not on its faces; -1 outside.
  pure function cell_of(at) result(cell)
    real(real64), intent(in) :: at(3)
    integer :: cell(3), a, i

    cell = -1
    do a = 1, 3
      do i = 0, cells(a) - 1
        if (at(a) > plane(i, a) .and. at(a) < plane(i + 1, a)) cell(a) = i
      end do
    end do
  end function cell_of

  !> The cells from low to before high, of chunks(1) by chunks(2) by 1.
  pure subroutine chunk_of(rank, chunks, low, high)
    integer, intent(in) :: rank, chunks(2)
    integer, intent(out) :: low(3), high(3)
    integer :: at(2)

    at = [modulo(rank, chunks(1)), rank / chunks(1)]
    low = [cells(1:2) * at / chunks, 0]
    high = [cells(1:2) * (at + 1) / chunks, cells(3)]
  end subroutine chunk_of

  !> The lowest process with one of the cells from a to b, of those that are in the box.
  pure integer function first_of(a, b, chunks) result(rank)
    integer, intent(in) :: a(3), b(3), chunks(2)
    integer :: low(3), high(3)

    do rank = 0, product(chunks) - 1
      call chunk_of(rank, chunks, low, high)
      if (all(a < high .and. b >= low)) return
    end do
    rank = -1
  end function first_of

  !> The process's chunk, of chunks(1) by chunks(2) by 1, cut into tiles. Cells count from 0.
  subroutine make_tiles(rank, chunks, made)
    integer, intent(in) :: rank, chunks(2)
    type(tile_type), allocatable, intent(out) :: made(:)
    integer :: t, a, at(3), low(3), high(3)

    call chunk_of(rank, chunks, low, high)
    allocate (made(product(tiles_a_chunk)))
    do t = 1, size(made)
      at = [modulo(t - 1, tiles_a_chunk(1)), modulo((t - 1) / tiles_a_chunk(1), tiles_a_chunk(2)), &
            (t - 1) / (tiles_a_chunk(1) * tiles_a_chunk(2))]
      do a = 1, 3
        made(t)%first(a) = low(a) + (high(a) - low(a)) * at(a) / tiles_a_chunk(a)
        made(t)%last(a) = low(a) + (high(a) - low(a)) * (at(a) + 1) / tiles_a_chunk(a) - 1
      end do
      call fill(made(t))
      call number(made(t), int(size(made) * rank + t - 1, int64))
    end do
  end subroutine make_tiles

  subroutine fill(tile)
    type(tile_type), intent(inout) :: tile
    integer :: i, j, k, n, l(3), h(3)

    l = tile%first - halo
    h = tile%last + halo
    allocate (tile%vertexx(l(1):h(1) + 1), tile%vertexy(l(2):h(2) + 1), tile%vertexz(l(3):h(3) + 1))
    tile%vertexx = [(plane(i, 1), i=l(1), h(1) + 1)]
    tile%vertexy = [(plane(i, 2), i=l(2), h(2) + 1)]
    tile%vertexz = [(plane(i, 3), i=l(3), h(3) + 1)]
    allocate (tile%density(l(1):h(1), l(2):h(2), l(3):h(3)))
    allocate (tile%velocity(3, l(1):h(1) + 1, l(2):h(2) + 1, l(3):h(3) + 1))
    do k = l(3), h(3) + 1
      do j = l(2), h(2) + 1
        do i = l(1), h(1) + 1
          tile%velocity(:, i, j, k) = velocity_at([plane(i, 1), plane(j, 2), plane(k, 3)])
        end do
      end do
    end do
    allocate (tile%ghosts(size(tile%density)))
    n = 0
    do k = l(3), h(3)
      do j = l(2), h(2)
        do i = l(1), h(1)
          n = n + 1
          tile%ghosts(n) = merge(0_int8, 1_int8, all([i, j, k] >= tile%first .and. [i, j, k] <= tile%last))
        end do
      end do
    end do
    call set_density(tile, 0.0_real64)
  end subroutine fill

  !> The cells tile by tile, of which this is one; vertices, which tiles share, through the whole box and its halo.
  subroutine number(tile, which)
    type(tile_type), intent(inout) :: tile
    integer(int64), intent(in) :: which
    integer :: i, j, k
    integer(int64) :: n, wide(2)

    n = size(tile%density, kind=int64)
    tile%cell_ids = [(which * product(int(cells, int64)) * 8_int64 + int(i, int64), i=1, int(n))]
    wide = int(cells(1:2) + 1 + 2 * halo, int64)
    tile%vertex_ids = [(((int(i + halo, int64) + wide(1) * (int(j + halo, int64) + wide(2) * int(k + halo, int64)), &
                          i=lbound(tile%vertexx, 1), ubound(tile%vertexx, 1)), &
                         j=lbound(tile%vertexy, 1), ubound(tile%vertexy, 1)), &
                        k=lbound(tile%vertexz, 1), ubound(tile%vertexz, 1))]
  end subroutine number

  !> A step of the solver, its exchange of halos included.
  subroutine move_on(made, time)
    type(tile_type), intent(inout) :: made(:)
    real(real64), intent(in) :: time
    integer :: t
    do t = 1, size(made)
      call set_density(made(t), time)
    end do
  end subroutine move_on

  subroutine set_density(tile, time)
    type(tile_type), intent(inout) :: tile
    real(real64), intent(in) :: time
    integer :: i, j, k

    do k = lbound(tile%density, 3), ubound(tile%density, 3)
      do j = lbound(tile%density, 2), ubound(tile%density, 2)
        do i = lbound(tile%density, 1), ubound(tile%density, 1)
          tile%density(i, j, k) = nothing
          if (all([i, j, k] >= 0 .and. [i, j, k] < cells)) tile%density(i, j, k) = density_at(i, j, k, time)
        end do
      end do
    end do
  end subroutine set_density

  !> The coupling: a piece a tile, with the halo's cells as ghosts and global ids, or without both.
  subroutine give_tiles(mesh, made, with_ghosts, ierr)
    type(insitu_mesh), intent(in) :: mesh
    type(tile_type), intent(in), target :: made(:)
    logical, intent(in) :: with_ghosts
    integer, intent(out) :: ierr
    integer :: t, a(3), b(3)

    do t = 1, size(made)
      associate (tile => made(t))
        a = tile%first - merge(halo, 0, with_ghosts)
        b = tile%last + merge(halo, 0, with_ghosts)
        if (is_uniform) then
          call mesh%uniform_block(b - a + 2, spread(0.0_real64, 1, 3), spacing, ierr, piece=t, first=int(a, int64))
        else
          call mesh%rectilinear_block(tile%vertexx(a(1):b(1) + 1), tile%vertexy(a(2):b(2) + 1), &
                                      tile%vertexz(a(3):b(3) + 1), ierr, piece=t)
        end if
        if (ierr == insitu_ok) call mesh%cell_field('density', tile%density(a(1):b(1), a(2):b(2), a(3):b(3)), ierr, piece=t)
        if (ierr == insitu_ok) call mesh%vertex_field('velocity', &
            tile%velocity(:, a(1):b(1) + 1, a(2):b(2) + 1, a(3):b(3) + 1), ierr, piece=t)
        if (ierr == insitu_ok .and. with_ghosts) call mesh%ghosts(tile%ghosts, ierr, piece=t)
        if (ierr == insitu_ok .and. with_ghosts) call mesh%global_cells(tile%cell_ids, ierr, piece=t)
        if (ierr == insitu_ok .and. with_ghosts) call mesh%global_vertices(tile%vertex_ids, ierr, piece=t)
      end associate
      if (ierr /= insitu_ok) return
    end do
  end subroutine give_tiles

end module tiles
