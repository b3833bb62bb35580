!> Every way to give cells: the four shapes, mixed and padded, blocks, pieces, ghosts.
program shapes_test
  use, intrinsic :: iso_c_binding, only: c_loc
  use, intrinsic :: iso_fortran_env, only: int32, int64, int8, real32, real64
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use checks
  use insitu
  implicit none

  real(real64), parameter :: rounding = 1.0e-12_real64

  !> A cube's corners, then the apex of a pyramid that stands on its top.
  real(real64), target :: house(3, 9) = reshape(real([ &
      0,0,0, 1,0,0, 1,1,0, 0,1,0, 0,0,1, 1,0,1, 1,1,1, 0,1,1, 1,1,3], real64), [3, 9])

  type(insitu_session) :: session
  integer :: ierr

  call session%open(ierr=ierr, strict=.true., threads=2)
  call expect_ok('open', session, ierr)
  call single_shapes()
  call mixed_and_padded()
  call faces()
  call blocks()
  call pieces_and_ghosts()
  call session%close(ierr)
  call finish_checks()

contains

  !> The linear field at the cell's vertex average, found in the cell.
  subroutine expect_cells(what, mesh, connectivity)
    character(len=*), intent(in) :: what
    type(insitu_mesh), intent(inout) :: mesh
    integer, intent(in) :: connectivity(:,:)
    real(real64), target :: f(9)
    real(real64) :: centre(3, size(connectivity, 2)), values(size(connectivity, 2))
    real(real64) :: parametric(3, size(connectivity, 2))
    integer :: cells(size(connectivity, 2)), i
    logical :: found(size(connectivity, 2))
    type(insitu_validation) :: validation

    f = linear(house)
    do i = 1, size(connectivity, 2)
      associate (ids => pack(connectivity(:, i), connectivity(:, i) > 0))
        centre(:, i) = sum(house(:, ids), dim=2) / real(size(ids), real64)
      end associate
    end do
    call mesh%points(house, ierr)
    call expect_ok(what // ': points', session, ierr)
    call mesh%vertex_field('f', f, ierr)
    call expect_ok(what // ': field', session, ierr)
    call mesh%validate(validation, ierr)
    call expect(what // ': valid, none inverted', ierr == insitu_ok .and. &
                validation%cells == size(connectivity, 2) .and. validation%inverted_cells == 0 .and. &
                validation%zero_volume_cells == 0)
    call mesh%commit(ierr)
    call expect_ok(what // ': commit', session, ierr)
    call mesh%locate(centre, cells, ierr, found=found, parametric=parametric, accuracy=insitu_exact)
    call expect_ok(what // ': locate', session, ierr)
    call expect(what // ': ids', all(found) .and. all(cells == [(i, i=1, size(cells))]))
    call expect(what // ': parametric', all(parametric > 0.0_real64 .and. parametric < 1.0_real64))
    call mesh%sample('f', centre, values, ierr, found=found)
    call expect_near(what // ': values', values, linear(centre), rounding)
    call expect(what // ': all found', all(found))
  end subroutine expect_cells

  subroutine single_shapes()
    integer(int32), target :: tetrahedra(4, 6), wedges(6, 2), hexahedra(8, 1), voxels(8, 1)
    integer(int64), target :: pyramids(5, 1), wide(6, 2)
    type(insitu_mesh) :: mesh

    tetrahedra = 1 + reshape([0,1,2,6, 0,2,3,6, 0,3,7,6, 0,7,4,6, 0,4,5,6, 0,5,1,6], [4, 6])
    wedges = reshape([1,3,2,5,7,6, 1,4,3,5,8,7], [6, 2]) ! the first triangle faces away from the second
    wide = int(wedges, int64)
    hexahedra(:, 1) = [1, 2, 3, 4, 5, 6, 7, 8]
    voxels(:, 1) = [1, 2, 4, 3, 5, 6, 8, 7]
    pyramids(:, 1) = [5_int64, 6_int64, 7_int64, 8_int64, 9_int64]

    call session%mesh('tetrahedra', mesh, ierr)
    call mesh%tetrahedra(tetrahedra, ierr)
    call expect_cells('tetrahedra', mesh, tetrahedra)
    call session%mesh('wedges', mesh, ierr)
    call mesh%wedges(wedges, ierr)
    call expect_cells('wedges', mesh, wedges)
    call mesh%wedges(wide, ierr)
    call expect_cells('int64 wedges', mesh, wedges)
    call expect_borrowed(session, mesh, 'connectivity', c_loc(wide))
    call session%mesh('hexahedra', mesh, ierr)
    call mesh%hexahedra(hexahedra, ierr)
    call expect_cells('hexahedra', mesh, hexahedra)
    call mesh%voxels(voxels, ierr)
    call expect_cells('voxels', mesh, voxels)
    call session%mesh('pyramids', mesh, ierr)
    call mesh%pyramids(pyramids, ierr)
    call expect_cells('pyramids', mesh, int(pyramids))
  end subroutine single_shapes

  subroutine mixed_and_padded()
    integer(int32), target :: padded(8, 3)
    integer(int8), target :: types(3)
    integer(int32), target :: offsets(4), ids(17)
    integer(int64), target :: wide_offsets(3), wide_ids(17)
    type(insitu_mesh) :: mesh

    padded = -1
    padded(1:6, 1) = [1, 3, 2, 5, 7, 6]
    padded(1:6, 2) = [1, 4, 3, 5, 8, 7]
    padded(1:5, 3) = [5, 6, 7, 8, 9]
    call session%mesh('padded', mesh, ierr)
    call mesh%cells(padded, ierr)
    call expect_ok('padded', session, ierr)
    call expect_cells('padded', mesh, padded)

    ids = pack(padded, padded > 0)
    offsets = [1, 7, 13, 18]
    types = int([insitu_wedge, insitu_wedge, insitu_pyramid], int8)
    call session%mesh('mixed', mesh, ierr)
    call mesh%cells(types, offsets, ids, ierr)
    call expect_ok('mixed', session, ierr)
    call expect_cells('mixed', mesh, padded)
    wide_ids = int(ids, int64)
    wide_offsets = int(offsets(:3), int64)
    call mesh%cells(types, wide_offsets, wide_ids, ierr)
    call expect_cells('mixed, int64, without the last offset', mesh, padded)
    call expect_borrowed(session, mesh, 'types', c_loc(types))
    call expect_borrowed(session, mesh, 'offsets', c_loc(wide_offsets))
  end subroutine mixed_and_padded

  !> The cube and the pyramid by their faces, in both forms, and both together as one cell.
  subroutine faces()
    integer(int32), target :: vertices(36), offsets(11), owner(10), neighbour(1), lists(11), starts(3)
    integer(int64), target :: wide_vertices(32), wide_offsets(10), one_list(9), one_start(2)
    integer :: padded(8, 2), cells(1), i
    logical :: found(1)
    real(real64), target :: f(9)
    type(insitu_audit_entry), allocatable :: entries(:)
    real(real64) :: values(1)
    type(insitu_mesh) :: mesh

    padded = -1
    padded(:, 1) = [1, 2, 3, 4, 5, 6, 7, 8]
    padded(1:5, 2) = [5, 6, 7, 8, 9]
    vertices = [5, 6, 7, 8, 1, 2, 3, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 4, 8, 7, 4, 1, 5, 8, &
                5, 6, 9, 6, 7, 9, 7, 8, 9, 8, 5, 9]
    offsets = [1, 5, 9, 13, 17, 21, 25, 28, 31, 34, 37]
    owner = [1, 1, 1, 1, 1, 1, 2, 2, 2, 2]
    neighbour = [2]
    call session%mesh('faces', mesh, ierr)
    call mesh%faces(vertices, offsets, owner, neighbour, 2, ierr)
    call expect_ok('faces', session, ierr)
    call expect_cells('faces', mesh, padded)
    call mesh%audit(entries, ierr)
    call expect('faces: read in place', count(entries%name == 'piece 0 owner' .and. entries%borrowed) == 1)
    call expect('faces: one copy', count(.not. entries%borrowed) == 1)
    lists = [1, 2, 3, 4, 5, 6, 1, 7, 8, 9, 10]
    starts = [1, 7, 12]
    call mesh%faces_of_cells(vertices, offsets, lists, starts, ierr)
    call expect_ok('faces of cells', session, ierr)
    call expect_cells('faces of cells', mesh, padded)
    wide_vertices = int(vertices(5:), int64)
    wide_offsets = int(offsets(2:) - 4, int64)
    one_list = [(int(i, int64), i=1, 9)]
    one_start = [1_int64, 10_int64]
    call session%mesh('house', mesh, ierr)
    call mesh%faces_of_cells(wide_vertices, wide_offsets, one_list, one_start, ierr)
    call expect_ok('house', session, ierr)
    call mesh%points(house, ierr)
    f = linear(house)
    call mesh%vertex_field('f', f, ierr)
    call mesh%commit(ierr)
    call expect_ok('house: commit', session, ierr)
    call mesh%locate(reshape([0.9_real64, 0.9_real64, 1.1_real64], [3, 1]), cells, ierr, found=found)
    call expect('house: locate', ierr == insitu_ok .and. found(1) .and. cells(1) == 1)
    call mesh%sample('f', reshape([0.5_real64, 0.25_real64, 0.75_real64], [3, 1]), values, ierr)
    call expect_near('house: value', values, &
                     linear(reshape([0.5_real64, 0.25_real64, 0.75_real64], [3, 1])), rounding)
  end subroutine faces

  !> The same block four ways, of larger arrays with a ghost layer; cell fields with one, too.
  subroutine blocks()
    real(real64), target :: x(0:nx + 2, 0:ny + 2, 0:nz + 2)
    real(real64), target :: y(0:nx + 2, 0:ny + 2, 0:nz + 2), z(0:nx + 2, 0:ny + 2, 0:nz + 2)
    real(real32), target :: xyz(3, 0:nx + 2, 0:ny + 2, 0:nz + 2)
    real(real64), target :: f(0:nx + 1, 0:ny + 1, 0:nz + 1), axis(0:max(nx, ny, nz), 3)
    real(real64), target :: flow(3, 0:nx + 2, 0:ny + 2, 0:nz + 2)
    real(real64) :: points(3, box_vertices)
    type(insitu_mesh) :: mesh
    integer :: i

    x = ieee_value(x, ieee_quiet_nan)
    y = x
    z = x
    f = ieee_value(f, ieee_quiet_nan)
    points = box_points()
    x(1:nx + 1, 1:ny + 1, 1:nz + 1) = reshape(points(1, :), [nx + 1, ny + 1, nz + 1])
    y(1:nx + 1, 1:ny + 1, 1:nz + 1) = reshape(points(2, :), [nx + 1, ny + 1, nz + 1])
    z(1:nx + 1, 1:ny + 1, 1:nz + 1) = reshape(points(3, :), [nx + 1, ny + 1, nz + 1])
    flow(1, :, :, :) = x
    flow(2, :, :, :) = y
    flow(3, :, :, :) = z
    xyz = real(flow, real32)
    f(1:nx, 1:ny, 1:nz) = reshape([(real(i, real64), i=1, box_cells)], [nx, ny, nz])
    axis(:, 1) = [(real(i, real64), i=0, ubound(axis, 1))]
    axis(:, 2) = 0.5_real64 * axis(:, 1)
    axis(:, 3) = 2.0_real64 * axis(:, 1)

    call session%mesh('curvilinear', mesh, ierr)
    call mesh%curvilinear_block(x(1:nx + 1, 1:ny + 1, 1:nz + 1), y(1:nx + 1, 1:ny + 1, 1:nz + 1), &
                                z(1:nx + 1, 1:ny + 1, 1:nz + 1), ierr)
    call expect_block('curvilinear', mesh, f, flow)
    call expect_borrowed(session, mesh, "points component 2", c_loc(z(1, 1, 1)))
    call session%mesh('interleaved', mesh, ierr)
    call mesh%curvilinear_block(xyz(:, 1:nx + 1, 1:ny + 1, 1:nz + 1), ierr)
    call expect_block('interleaved, real32', mesh, f, flow)
    call session%mesh('rectilinear', mesh, ierr)
    call mesh%rectilinear_block(axis(0:nx, 1), axis(0:ny, 2), axis(0:nz, 3), ierr)
    call expect_block('rectilinear', mesh, f, flow)
    call session%mesh('uniform', mesh, ierr)
    call mesh%uniform_block([nx + 1, ny + 1, nz + 1], [0.0_real64, 0.0_real64, 0.0_real64], &
                            [1.0_real64, 0.5_real64, 2.0_real64], ierr)
    call expect_block('uniform', mesh, f, flow)
  end subroutine blocks

  subroutine expect_block(what, mesh, f, flow)
    character(len=*), intent(in) :: what
    type(insitu_mesh), intent(inout) :: mesh
    real(real64), intent(in), target :: f(0:,0:,0:), flow(:,0:,0:,0:)
    real(real64) :: values(box_cells), vectors(3, box_cells)
    integer :: i

    call expect_ok(what // ': block', session, ierr)
    call mesh%cell_field('f', f(1:nx, 1:ny, 1:nz), ierr)
    call expect_ok(what // ': cell field', session, ierr)
    call mesh%vertex_field('flow', flow(:, 1:nx + 1, 1:ny + 1, 1:nz + 1), ierr)
    call expect_ok(what // ': vertex field', session, ierr)
    call mesh%commit(ierr)
    call expect_ok(what // ': commit', session, ierr)
    call expect_borrowed(session, mesh, "field 'f'", c_loc(f(1, 1, 1)))
    call mesh%sample('f', box_centres(), values, ierr)
    call expect_near(what // ': cells', values, [(real(i, real64), i=1, box_cells)], 0.0_real64)
    call mesh%sample('flow', box_centres(), vectors, ierr)
    associate (centres => box_centres())
      call expect_near(what // ': vertices', vectors(3, :), centres(3, :), rounding)
    end associate
  end subroutine expect_block

  !> Two cubes side by side as pieces 1 and 2; then the second cube is a ghost.
  subroutine pieces_and_ghosts()
    real(real64), target :: left(3, 8), right(3, 8)
    integer(int32), target :: cube(8, 1)
    integer(int8), target :: bits(1)
    real(real64) :: points(3, 3)
    integer(int64) :: cells(3)
    integer :: pieces(3), i
    logical :: found(3)
    type(insitu_mesh) :: mesh

    left = house(:, 1:8)
    right = left
    right(1, :) = right(1, :) + 1.0_real64
    cube(:, 1) = [(i, i=1, 8)]
    points = 0.5_real64
    points(1, :) = [0.5_real64, 1.5_real64, 2.5_real64]
    call session%mesh('pieces', mesh, ierr)
    call mesh%points(left, ierr)
    call mesh%hexahedra(cube, ierr)
    call mesh%points(right, ierr, piece=2)
    call expect_ok('points of piece 2', session, ierr)
    call mesh%hexahedra(cube, ierr, piece=2)
    call mesh%commit(ierr)
    call expect_ok('commit of two pieces', session, ierr)
    call mesh%locate(points, cells, ierr, found=found, pieces=pieces)
    call expect('pieces count from 1, 0 outside', all(pieces == [1, 2, 0]))
    call expect('cells count from 1, 0 outside', all(cells == [1_int64, 1_int64, 0_int64]))
    call expect('found', all(found .eqv. [.true., .true., .false.]))

    bits = 1_int8
    call mesh%ghosts(bits, ierr, piece=2)
    call mesh%commit(ierr)
    call expect_ok('commit with ghosts', session, ierr)
    call mesh%locate(points, cells, ierr, pieces=pieces)
    call expect('a ghost cell owns no point', all(pieces == [1, 0, 0]))
  end subroutine pieces_and_ghosts

end program shapes_test
