!> Array sections of every kind are read in place: padded, strided, backwards, record components.
program sections_test
  use, intrinsic :: iso_c_binding, only: c_loc
  use, intrinsic :: iso_fortran_env, only: int32, int64, real32, real64
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use checks
  use insitu
  implicit none

  integer, parameter :: ncolumns = nx * ny, nlevels = nz, halo = 2
  real(real64), parameter :: rounding = 1.0e-12_real64, rounding32 = 1.0e-5_real64

  type :: record_type
    integer(int64) :: id = 0
    real(real32) :: t = 0.0_real32
    real(real32) :: unused = 0.0_real32
    real(real64) :: wind(3) = 0.0_real64
  end type record_type

  type(insitu_session) :: session
  real(real64), target :: centres(3, box_cells)
  real(real64) :: not_there
  integer :: ierr

  centres = box_centres()
  not_there = ieee_value(not_there, ieee_quiet_nan)
  call session%open(ierr=ierr, strict=.true., threads=2)
  call expect_ok('open', session, ierr)
  call padded_levels()
  call strided_points()
  call single_precision()
  call record_components()
  call extents_of_one_and_none()
  call session%close(ierr)
  call expect_ok('close', session, ierr)
  call finish_checks()

contains

  !> t(ncolumns + padding, halo + nlevels + halo): the section has gaps in both dimensions.
  subroutine padded_levels()
    real(real64), target :: xyz(3, box_vertices), t(ncolumns + 3, halo + nlevels + halo)
    integer(int32), target :: connectivity(8, box_cells)
    real(real64) :: values(box_cells), expected(box_cells)
    type(insitu_mesh) :: mesh
    integer :: i

    xyz = box_points()
    connectivity = box_hexahedra()
    t = not_there
    t(2:ncolumns + 1, 1 + halo:nlevels + halo) = &
        reshape([(real(i, real64), i=1, box_cells)], [ncolumns, nlevels])
    call session%mesh('levels', mesh, ierr)
    call expect_ok('mesh', session, ierr)
    call mesh%points(xyz, ierr)
    call expect_ok('points', session, ierr)
    call mesh%hexahedra(connectivity, ierr)
    call expect_ok('hexahedra', session, ierr)
    call mesh%cell_field('t', t(2:ncolumns + 1, 1 + halo:nlevels + halo), ierr)
    call expect_ok('cell field, a section', session, ierr)
    call mesh%commit(ierr)
    call expect_ok('commit', session, ierr)
    call expect_borrowed(session, mesh, "field 't'", c_loc(t(2, 1 + halo)))

    call mesh%sample('t', centres, values, ierr)
    call expect_ok('sample', session, ierr)
    call expect_near('every cell has its own value', values, [(real(i, real64), i=1, box_cells)], &
                     0.0_real64)

    t = 2.0_real64 * t                                   ! in place: no pointer is given again
    call mesh%changed(insitu_fields)
    call mesh%commit(ierr)
    call expect_ok('commit of changed values', session, ierr)
    call mesh%sample('t', centres, values, ierr)
    expected = 2.0_real64 * [(real(i, real64), i=1, box_cells)]
    call expect_near('the new values', values, expected, 0.0_real64)

    ! The same levels upside down, and columns from the last to the first.
    call mesh%cell_field('t', t(ncolumns + 1:2:-1, nlevels + halo:1 + halo:-1), ierr)
    call expect_ok('cell field, backwards', session, ierr)
    call mesh%commit(ierr)
    call expect_borrowed(session, mesh, "field 't'", c_loc(t(ncolumns + 1, nlevels + halo)))
    call mesh%sample('t', centres, values, ierr)
    call expect_near('backwards', values, expected(box_cells:1:-1), 0.0_real64)
  end subroutine padded_levels

  !> x, y, z as rows of a wider array, every other column; a vector field by its first dimension, by
  !! three arrays, and backwards; 64-bit ids with rows to spare; query points as a section.
  subroutine strided_points()
    real(real64), target :: store(7, 2 * box_vertices), backwards(box_vertices)
    integer(int64), target :: ids(10, box_cells)
    real(real64) :: values(box_cells), vectors(3, box_cells)
    real(real64), target :: wide(5, 3 * box_cells)
    integer(int64) :: cells(box_cells)
    integer(int32) :: cells32(box_cells)
    type(insitu_mesh) :: mesh
    integer :: c

    store = not_there
    store(2:4, 1::2) = box_points()
    store(5:7, 1::2) = store(2:4, 1::2)
    backwards = linear(box_points())
    backwards = backwards(box_vertices:1:-1)
    ids = -7_int64
    ids(2:9, :) = int(box_hexahedra(), int64)
    wide = not_there
    wide(2:4, 2::3) = centres

    call session%mesh('strided', mesh, ierr)
    call mesh%points(store(2, 1::2), store(3, 1::2), store(4, 1::2), ierr)
    call expect_ok('points x, y, z', session, ierr)
    call mesh%hexahedra(ids(2:9, :), ierr)
    call expect_ok('int64 hexahedra', session, ierr)
    call mesh%vertex_field('f', backwards(box_vertices:1:-1), ierr)
    call expect_ok('vertex field', session, ierr)
    call mesh%vertex_field('place', store(5:7, 1::2), ierr, vector=.true.)
    call expect_ok('vector field', session, ierr)
    call mesh%vertex_field('turned', store(7, 1::2), store(6, 1::2), store(5, 1::2), ierr)
    call expect_ok('vector field of three arrays', session, ierr)
    call mesh%commit(ierr)
    call expect_ok('commit', session, ierr)
    call expect_borrowed(session, mesh, 'points component 1', c_loc(store(3, 1)))
    call expect_borrowed(session, mesh, 'connectivity', c_loc(ids(2, 1)))
    call expect_borrowed(session, mesh, "field 'f'", c_loc(backwards(box_vertices)))
    call expect_borrowed(session, mesh, "field 'place'", c_loc(store(5, 1)))

    call mesh%sample('f', wide(2:4, 2::3), values, ierr)
    call expect_ok('sample at a section', session, ierr)
    call expect_near('linear field', values, linear(centres), rounding)
    call mesh%sample('place', wide(2, 2::3), wide(3, 2::3), wide(4, 2::3), vectors, ierr)
    call expect_ok('sample of a vector', session, ierr)
    call expect_near('vector', reshape(vectors, [size(vectors)]), reshape(centres, [size(centres)]), &
                     rounding)
    call mesh%sample('turned', centres, vectors, ierr)
    call expect_near('three arrays', vectors(1, :), centres(3, :), rounding)

    call mesh%locate(wide(2:4, 2::3), cells, ierr)
    call expect_ok('locate', session, ierr)
    call expect('ids count from 1', all(cells == [(int(c, int64), c=1, box_cells)]))
    call mesh%locate(centres(1, :), centres(2, :), centres(3, :), cells32, ierr)
    call expect_ok('locate, 32-bit ids', session, ierr)
    call expect('32-bit ids', all(cells32 == [(c, c=1, box_cells)]))
  end subroutine strided_points

  !> real32 everywhere, with a moved vertex to follow.
  subroutine single_precision()
    real(real32), target :: xyz(3, box_vertices), f(2, box_vertices), points(3, box_cells)
    real(real64) :: values(box_cells)
    integer(int32), target :: connectivity(8, box_cells)
    type(insitu_mesh) :: mesh
    type(insitu_commit_report) :: report

    xyz = real(box_points(), real32)
    f(1, :) = 0.0_real32
    f(2, :) = real(linear(box_points()), real32)
    connectivity = box_hexahedra()
    points = real(centres, real32)
    call session%mesh('single', mesh, ierr)
    call mesh%points(xyz, ierr)
    call mesh%hexahedra(connectivity, ierr)
    call mesh%vertex_field('f', f(2, :), ierr)
    call mesh%commit(ierr, report)
    call expect_ok('commit', session, ierr)
    call expect('built', report%action == insitu_rebuild .and. report%cells == box_cells)
    call expect_borrowed(session, mesh, 'points', c_loc(xyz))
    call expect_borrowed(session, mesh, "field 'f'", c_loc(f(2, 1)))
    call mesh%sample('f', points, values, ierr)
    call expect_near('real32', values, linear(centres), rounding32)

    xyz(1, :) = xyz(1, :) + 100.0_real32
    points(1, :) = points(1, :) + 100.0_real32
    call mesh%changed(insitu_geometry)
    call mesh%commit(ierr, report)
    call expect('refitted', ierr == insitu_ok .and. report%action == insitu_refit)
    call mesh%sample('f', points, values, ierr)
    call expect_near('real32, moved', values, linear(centres), rounding32)
  end subroutine single_precision

  !> cell(:)%t steps over whole records; a pointer to it is given (see module insitu for why).
  subroutine record_components()
    type(record_type), target :: cell(box_cells)
    real(real64), target :: xyz(3, box_vertices)
    integer(int32), target :: connectivity(8, box_cells)
    real(real64) :: values(box_cells), wind(3, box_cells)
    real(real32), pointer :: t(:)
    real(real64), pointer :: east(:), north(:), up(:)
    type(insitu_mesh) :: mesh
    integer :: c

    xyz = box_points()
    connectivity = box_hexahedra()
    t => cell%t
    east => cell%wind(1)
    north => cell%wind(2)
    up => cell%wind(3)
    do c = 1, box_cells
      cell(c)%t = real(c, real32)
      cell(c)%wind = real(c, real64) * [1.0_real64, 10.0_real64, 100.0_real64]
    end do
    call session%mesh('records', mesh, ierr)
    call mesh%points(xyz, ierr)
    call mesh%hexahedra(connectivity, ierr)
    call mesh%cell_field('t', t, ierr)
    call mesh%cell_field('wind', east, north, up, ierr)
    call mesh%commit(ierr)
    call expect_ok('commit', session, ierr)
    call expect_borrowed(session, mesh, "field 't'", c_loc(cell(1)%t))
    call mesh%sample('t', centres, values, ierr)
    call expect_near('records', values, [(real(c, real64), c=1, box_cells)], 0.0_real64)
    call mesh%sample('wind', centres, wind, ierr)
    call expect_near('wind', wind(2, :), [(10.0_real64 * real(c, real64), c=1, box_cells)], 0.0_real64)
  end subroutine record_components

  !> One cell; sections with an extent of 1 before, between or after; no points, no cells at all.
  subroutine extents_of_one_and_none()
    real(real64), target :: xyz(3, 8), t(4, 3, 5), none(3, 0), u(2, 8, 2)
    real(real64) :: value(1), vector(3, 1), nothing(0)
    integer(int32), target :: connectivity(8, 1), no_ids(8, 0)
    integer(int64) :: no_cells(0)
    type(insitu_mesh) :: mesh
    integer :: v

    xyz = reshape(real([0,0,0, 1,0,0, 1,1,0, 0,1,0, 0,0,1, 1,0,1, 1,1,1, 0,1,1], real64), [3, 8])
    connectivity(:, 1) = [(v, v=1, 8)]
    t = not_there
    t(3, 2, 4) = 5.0_real64
    u = not_there
    u(2, :, 2) = linear(xyz)
    call session%mesh('one', mesh, ierr)
    call mesh%points(xyz, ierr)
    call mesh%hexahedra(connectivity, ierr)
    call mesh%cell_field('t', t(3:3, 2, 4), ierr)
    call mesh%cell_field('t2', t(3:3, 2:2, 4), ierr)
    call mesh%cell_field('t3', t(3:3, 2:2, 4:4), ierr)
    call mesh%vertex_field('u', u(2:2, :, 2:2), ierr)
    call mesh%vertex_field('u_vector', u(2:2, :, 2), ierr, vector=.true.)
    call mesh%commit(ierr)
    call expect_ok('commit of one cell', session, ierr)
    call expect_borrowed(session, mesh, "field 't3'", c_loc(t(3, 2, 4)))
    call mesh%sample('t3', xyz(:, 1:1), value, ierr)
    call expect_near('extents of 1', value, [5.0_real64], 0.0_real64)
    call mesh%sample('u', 0.5_real64 * xyz(:, 7:7), value, ierr)
    call expect_near('extent between ones', value, 0.5_real64 * linear(xyz(:, 7:7)), rounding)
    call mesh%sample('u_vector', 0.5_real64 * xyz(:, 7:7), vector(1:1, :), ierr)
    call expect_near('one component', vector(1, :), 0.5_real64 * linear(xyz(:, 7:7)), rounding)
    call mesh%locate(none, no_cells, ierr)
    call expect_ok('no points to locate', session, ierr)
    call mesh%sample('u', none, nothing, ierr)
    call expect_ok('no points to sample', session, ierr)

    call session%mesh('none', mesh, ierr)
    call mesh%points(none, ierr)
    call mesh%hexahedra(no_ids, ierr)
    call mesh%commit(ierr)
    call expect_ok('no cells', session, ierr)
    call mesh%sample_point('u', [0.0_real64, 0.0_real64, 0.0_real64], value, ierr)
    call expect_error('no field', session, ierr, insitu_error_field, 'u')
  end subroutine extents_of_one_and_none

end program sections_test
