!> Adaptive meshes: patches with ghost layers and leaves in both orders, in place; what is refused.
program amr_test
  use, intrinsic :: iso_c_binding, only: c_loc
  use, intrinsic :: iso_fortran_env, only: int32, int64, int8, real64
  use checks
  use insitu
  implicit none

  type(insitu_session) :: session
  integer :: ierr

  call session%open(ierr=ierr, threads=2)
  call patches()
  call ghosts()
  call leaves()
  call quadtree()
  call session%close(ierr)
  call finish_checks()

contains

  !> A linear field in a patch and in its ghost cells, sampled at the boundary; without those after it at the other
  !> end.
  subroutine ghosts()
    type(insitu_mesh) :: mesh
    real(real64), target :: x(0:4, 0:4, 0:4)
    real(real64) :: value(1)
    logical :: found
    real(real64), parameter :: origin(3) = 0.0_real64, spacing(3) = 1.0_real64
    integer :: i

    do i = 0, 4
      x(i, :, :) = real(i, real64) - 0.5_real64
    end do
    call session%mesh('ghosts', mesh, ierr)
    call mesh%adaptive(origin, spacing, 1, ierr)
    call mesh%patch(0, [0, 0, 0], [3, 3, 3], ierr, ghosts_before=[1, 1, 1], ghosts_after=[0, 1, 1])
    call expect_ok('patch with ghosts', session, ierr)
    call mesh%cell_field('x', x(1:3, 1:3, 1:3), ierr)
    call expect_ok('section of its cells', session, ierr)
    call mesh%commit(ierr)
    call expect_ok('commit with ghosts', session, ierr)
    call mesh%sample_point('x', [0.0_real64, 1.5_real64, 1.5_real64], value, ierr, found)
    call expect('the linear field at the boundary', found .and. abs(value(1)) < 1e-14_real64)
    call mesh%sample_point('x', [3.0_real64, 1.5_real64, 1.5_real64], value, ierr, found)
    call expect('the value of the outermost cell', found .and. abs(value(1) - 2.5_real64) < 1e-14_real64)
  end subroutine ghosts

  subroutine patches()
    type(insitu_mesh) :: mesh
    real(real64), target :: coarse(-1:6, -1:6, -1:6), fine(2, 2, 2)
    type(insitu_amr_info) :: info
    real(real64), parameter :: origin(3) = 0.0_real64, spacing(3) = 1.0_real64

    coarse = 1.0_real64
    fine = 2.0_real64
    call session%mesh('patches', mesh, ierr)
    call mesh%amr_info(info, ierr)
    call expect('nothing was made yet', ierr == insitu_error_order)
    call mesh%patch(0, [0, 0, 0], [4, 4, 4], ierr)
    call expect_error('patch first', session, ierr, insitu_error_order, 'insitu_mesh_amr')
    call mesh%adaptive(origin, spacing, 2, ierr, ratios=[3])
    call expect_error('ratio', session, ierr, insitu_error_argument, 'ratio 3')
    call mesh%adaptive(origin, spacing, 2, ierr, ratios=[2, 2])
    call expect_error('ratios', session, ierr, insitu_error_argument, 'one ratio less')
    call mesh%adaptive(origin, -spacing, 2, ierr)
    call expect_error('spacing', session, ierr, insitu_error_argument, 'spacing along axis 0')
    call mesh%adaptive(origin, spacing, 2, ierr, finest_first=.false., reconstruction=insitu_nearest)
    call expect_ok('adaptive', session, ierr)
    call mesh%patch(0, [0, 0, 0], [4, 4, 4], ierr)
    call expect_ok('coarse patch', session, ierr)
    call mesh%patch(1, [2, 2, 2], [2, 2, 2], ierr, piece=2)
    call expect_ok('fine patch', session, ierr)
    call mesh%patch(2, [2, 2, 2], [2, 2, 2], ierr, piece=2)
    call expect_error('level', session, ierr, insitu_error_argument, 'level 2')
    call mesh%cell_field('rho', coarse(0:3, 0:3, 0:3), ierr)
    call expect_ok('coarse field', session, ierr)
    call mesh%cell_field('rho', fine, ierr, piece=2)
    call expect_ok('fine field', session, ierr)
    call mesh%commit(ierr)
    call expect_ok('commit', session, ierr)
    call expect_borrowed(session, mesh, "piece 0 field 'rho'", c_loc(coarse(0, 0, 0)))
    call mesh%amr_info(info, ierr)
    call expect_ok('amr_info', session, ierr)
    call expect('64 coarse cells, one of them under 8 fine ones', info%leaves == 71 .and. info%masked == 1)
    block
      integer(int64) :: cells(3)
      integer :: pieces(3), found(3)
      real(real64) :: places(3, 3)

      places = reshape([0.5_real64, 0.5_real64, 0.5_real64, 1.2_real64, 1.7_real64, 1.2_real64, &
                        -1.0_real64, 0.0_real64, 0.0_real64], [3, 3])
      call mesh%locate(places, cells, ierr, pieces=pieces)
      call expect_ok('locate', session, ierr)
      call mesh%cell_levels(cells, found, ierr, pieces=pieces)
      call expect_ok('cell_levels', session, ierr)
      call expect('the coarse level, the fine one, outside', all(found == [0, 1, -1]))
      call mesh%cell_levels(cells, found, ierr)
      call expect_error('cell_levels', session, ierr, insitu_error_argument, 'pieces: null')
      call mesh%cell_levels(cells, found(1:2), ierr, pieces=pieces)
      call expect_error('cell_levels', session, ierr, insitu_error_argument, 'as many levels as cells')
    end block
    call mesh%drop_pieces(2, ierr)
    call expect_ok('drop_pieces', session, ierr)
    call mesh%commit(ierr)
    call expect_ok('commit of fewer', session, ierr)
  end subroutine patches

  subroutine leaves()
    type(insitu_mesh) :: mesh
    integer(int8), target :: levels(8)
    integer(int32), target :: wide(8), corners(3, 8)
    integer(int64), target :: columns(10, 3)
    integer(int32) :: i

    call session%mesh('leaves', mesh, ierr)
    call mesh%adaptive([0.0_real64, 0.0_real64, 0.0_real64], [1.0_real64, 1.0_real64, 1.0_real64], &
                       2, ierr)
    levels = 1_int8
    wide = 1
    columns = -1_int64
    do i = 1, 8
      corners(:, i) = [iand(i - 1, 1), iand((i - 1) / 2, 1), (i - 1) / 4]
    end do
    columns(2:9, :) = transpose(int(corners, int64))
    call mesh%leaves(levels, corners, ierr)
    call expect_ok('leaves', session, ierr)
    call mesh%commit(ierr)
    call expect_ok('commit of leaves', session, ierr)
    call expect_borrowed(session, mesh, 'piece 0 levels', c_loc(levels))
    call expect_borrowed(session, mesh, 'piece 0 corners', c_loc(corners))
    corners = 4 * corners
    call mesh%leaves(wide, corners, ierr, corner_bits=3, offset=[8_int64, 0_int64, -8_int64])
    call expect_ok('leaves of finer corners', session, ierr)
    call mesh%commit(ierr)
    call expect_ok('commit of finer corners', session, ierr)
    corners(2, 6) = corners(2, 6) + 1
    call mesh%changed(insitu_topology)
    call mesh%commit(ierr)
    call expect_error('corner', session, ierr, insitu_error_mesh, 'piece 0, leaf 5|multiples of 4')
    call mesh%leaves(levels, columns(2:9, :), ierr, columns=.true.)
    call expect_ok('columns', session, ierr)
    call mesh%commit(ierr)
    call expect_ok('commit of columns', session, ierr)
    call expect_borrowed(session, mesh, 'piece 0 corners', c_loc(columns(2, 1)))
    call mesh%leaves(levels(1:7), columns(2:9, :), ierr, columns=.true.)
    call expect_error('numbers', session, ierr, insitu_error_argument, '7 levels, but 8 corners')
  end subroutine leaves

  !> Leaves of two dimensions, of which the first of four is refined; a linear field between their centres.
  subroutine quadtree()
    type(insitu_mesh) :: mesh
    integer(int8), target :: levels(7)
    integer(int32), target :: corners(2, 7)
    real(real64), target :: x(7)
    real(real64) :: value(1)
    logical :: found
    integer(int32) :: i

    levels = [0_int8, 0_int8, 0_int8, 1_int8, 1_int8, 1_int8, 1_int8]
    corners(:, 1:3) = reshape([1, 0, 0, 1, 1, 1], [2, 3])
    do i = 0, 3
      corners(:, 4 + i) = [iand(i, 1), i / 2]
    end do
    do i = 1, 7
      x(i) = (corners(1, i) + 0.5_real64) / 2.0_real64**levels(i)
    end do
    call session%mesh('quadtree', mesh, ierr)
    call mesh%adaptive([0.0_real64, 0.0_real64, 5.0_real64], [1.0_real64, 1.0_real64, 1.0_real64], 2, ierr, &
                       dimensions=2)
    call expect_ok('adaptive of two dimensions', session, ierr)
    call mesh%leaves(levels, corners, ierr)
    call expect_ok('leaves of a quadtree', session, ierr)
    call mesh%cell_field('x', x, ierr)
    call mesh%commit(ierr)
    call expect_ok('commit of a quadtree', session, ierr)
    call mesh%sample_point('x', [0.9_real64, 0.8_real64, 7.0_real64], value, ierr, found)
    call expect('the linear field', found .and. abs(value(1) - 0.9_real64) < 1e-14_real64)
  end subroutine quadtree

end program amr_test
