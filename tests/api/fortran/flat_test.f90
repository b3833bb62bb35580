!> Flat meshes from Fortran: triangles, quads, pixels, padded cells and the three blocks, with two coordinates.
program flat_test
  use, intrinsic :: iso_fortran_env, only: int32, int64, real32, real64
  use checks
  use insitu
  implicit none

  real(real64), parameter :: rounding = 1.0e-14_real64  ! of sums of a few terms below 10

  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  integer :: ierr, i, j
  real(real64), target :: x(9), y(9), f(9), x2(3, 3), y2(3, 3), f2(3, 3), axis(3), u(2, 9)
  integer(int32), target :: triangles(3, 8), quads(4, 4), pixels(4, 4), mixed(4, 5)

  do j = 1, 3
    do i = 1, 3
      x2(i, j) = i - 1
      y2(i, j) = 2 * (j - 1)
    end do
  end do
  f2 = 1 + 2 * x2 - 3 * y2
  x = reshape(x2, [9])
  y = reshape(y2, [9])
  f = reshape(f2, [9])
  axis = [0.0_real64, 1.0_real64, 2.0_real64]
  do j = 0, 1
    do i = 0, 1
      associate (cell => 1 + i + 2 * j, v => 1 + i + 3 * j)
        quads(:, cell) = [v, v + 1, v + 4, v + 3]
        pixels(:, cell) = [v, v + 1, v + 3, v + 4]
        triangles(:, 2 * cell - 1) = [v, v + 1, v + 4]
        triangles(:, 2 * cell) = [v, v + 4, v + 3]
      end associate
    end do
  end do
  mixed(:, 1:3) = quads(:, 1:3)
  mixed(:, 4) = [triangles(1, 7), triangles(2, 7), triangles(3, 7), -1]
  mixed(:, 5) = [triangles(1, 8), triangles(2, 8), triangles(3, 8), -1]
  u(1, :) = -y
  u(2, :) = x

  call session%open(ierr=ierr, strict=.true., threads=2)
  call expect_ok('open', session, ierr)

  call session%mesh('triangles', mesh, ierr)
  call mesh%flat_points(x, y, ierr)
  call expect_ok('points', session, ierr)
  call mesh%triangles(triangles, ierr)
  call expect_ok('triangles', session, ierr)
  call expect_values('triangles', 8)
  call session%mesh('quads', mesh, ierr)
  call mesh%flat_points(x, y, ierr)
  call mesh%quads(quads, ierr)
  call expect_ok('quads', session, ierr)
  call expect_values('quads', 4)
  call session%mesh('pixels', mesh, ierr)
  call mesh%flat_points(x, y, ierr)
  call mesh%pixels(pixels, ierr)
  call expect_values('pixels', 4)
  call session%mesh('padded', mesh, ierr)
  call mesh%flat_points(x, y, ierr)
  call mesh%flat_cells(mixed, ierr)
  call expect_values('padded', 5)
  call session%mesh('curvilinear', mesh, ierr)
  call mesh%flat_curvilinear_block(x2, y2, ierr)
  call expect_ok('curvilinear', session, ierr)
  call expect_values('curvilinear', 4)
  call session%mesh('uniform', mesh, ierr)
  call mesh%flat_uniform_block([3, 3], [0.0_real64, 0.0_real64], [1.0_real64, 2.0_real64], ierr)
  call expect_ok('uniform', session, ierr)
  call expect_values('uniform', 4)
  call session%mesh('rectilinear', mesh, ierr)
  block
    real(real64), target :: twice(3)
    twice = 2 * axis
    call mesh%flat_rectilinear_block(axis, twice, ierr)
    call expect_ok('rectilinear', session, ierr)
    call expect_values('rectilinear', 4)
  end block
  call session%close(ierr)
  call finish_checks()

contains

  subroutine expect_values(what, cells)
    character(len=*), intent(in) :: what
    integer, intent(in) :: cells
    real(real64) :: at(3, 3), values(3), vectors(2, 3)
    type(insitu_validation) :: validation
    logical :: found(3)

    at = reshape([0.3_real64, 0.4_real64, 0.0_real64, 1.7_real64, 3.9_real64, 99.0_real64, &
                  0.5_real64, 2.5_real64, -5.0_real64], [3, 3])
    call mesh%vertex_field('f', f, ierr)
    call expect_ok(what // ': field', session, ierr)
    call mesh%vertex_field('u', u, ierr, vector=.true.)
    call mesh%validate(validation, ierr)
    call expect(what // ': valid', ierr == insitu_ok .and. validation%cells == cells .and. &
                validation%inverted_cells == 0 .and. validation%zero_volume_cells == 0)
    call mesh%commit(ierr)
    call expect_ok(what // ': commit', session, ierr)
    call mesh%sample('f', at, values, ierr, found=found)
    call expect(what // ': found', all(found))
    call expect_near(what // ': values', values, 1 + 2 * at(1, :) - 3 * at(2, :), rounding)
    call mesh%sample('u', at, vectors, ierr)
    call expect_near(what // ': vectors', vectors(2, :), at(1, :), rounding)
  end subroutine expect_values
end program flat_test
