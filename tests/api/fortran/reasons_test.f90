!> Why points have their owners: centres, faces, edges and vertices of a box of dyadic cells, outside.
program reasons_test
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use, intrinsic :: iso_fortran_env, only: int32, int64, real32, real64
  use checks
  use insitu
  implicit none

  integer, parameter :: n = box_cells
  real(real64), target :: xyz(3, box_vertices)
  integer(int32), target :: connectivity(8, n)
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  integer :: ierr

  xyz = box_points()
  connectivity = box_hexahedra()
  call session%open(ierr=ierr, threads=2)
  call session%mesh('box', mesh, ierr)
  call mesh%points(xyz, ierr)
  call mesh%hexahedra(connectivity, ierr)
  call mesh%commit(ierr)
  call expect_ok('commit', session, ierr)
  call ask()
  call ask_nearest()
  call choose()
  call session%close(ierr)
  call finish_checks()

contains

  !> Beside the middle of the side x = nx, and far away: the last cell of that row, and none.
  subroutine ask_nearest()
    real(real64), parameter :: points(3, 3) = reshape( &
        [real(real64) :: nx + 0.5, 0.25, 1.0, nx + 50.0, 0.25, 1.0, nx - 0.5, 0.25, 1.0], [3, 3])
    real(real64), parameter :: tiny_length = 1.0e-12_real64
    integer(int64) :: cells(3), vertices(2, 3)
    real(real64) :: distances(3), values(3), apart(2, 3)
    real(real64), target :: numbers(n)
    logical :: found(3)
    integer :: i

    call mesh%locate(points, cells, ierr, found=found, distances=distances, greatest_distance=1.0_real64)
    call expect_ok('nearest cells', session, ierr)
    call expect('the nearest cells', all(cells == [int(nx, int64), 0_int64, int(nx, int64)]))
    call expect('none of them is found but the one inside', &
                all(found .eqv. [.false., .false., .true.]))
    call expect('their distances', all(abs(distances(1:3:2) - [0.5_real64, 0.0_real64]) < tiny_length))
    call expect('no distance to what is too far away', ieee_is_nan(distances(2)))
    numbers = [(real(i, real64), i=1, n)]
    call mesh%cell_field('number', numbers, ierr)
    call mesh%commit(ierr)
    call mesh%sample('number', points(1, :), points(2, :), points(3, :), values, ierr, &
                     distances=distances)
    call expect_ok('samples of the nearest cells', session, ierr)
    call expect('their values', all(abs(values - nx) < tiny_length))
    call expect('a great distance', abs(distances(2) - 50.0_real64) < tiny_length)
    call mesh%nearest_vertices(points, vertices, ierr, distances=apart)
    call expect_ok('nearest vertices', session, ierr)
    do i = 1, 3
      call expect('distances of vertices', all(abs(apart(:, i) - &
                  [norm2(xyz(:, vertices(1, i)) - points(:, i)), &
                   norm2(xyz(:, vertices(2, i)) - points(:, i))]) < tiny_length))
    end do
    call mesh%nearest_vertices(points, vertices(:, :2), ierr)
    call expect_error('room for vertices', session, ierr, insitu_error_argument, &
                      'nearest_vertices: vertices|2|3')
  end subroutine ask_nearest

  !> Another locator gives the same owners; what cannot be had is said.
  subroutine choose()
    integer(int64) :: cells(n)
    type(insitu_locator_info) :: info
    integer :: i

    call mesh%locator(insitu_method_shared_bilinear_faces, ierr, backend=insitu_backend_cpu)
    call expect_ok('locator', session, ierr)
    call mesh%commit(ierr)
    call expect_ok('commit with another locator', session, ierr)
    call mesh%locate(means(8), cells, ierr, accuracy=insitu_exact)
    call expect('cells of centres by rays', &
                ierr == insitu_ok .and. all(cells == [(int(i, int64), i=1, n)]))
    call mesh%locator_info(info, ierr)
    call expect_ok('locator_info', session, ierr)
    call expect('the method', info%method == insitu_method_shared_bilinear_faces)
    call expect('the backend', info%backend == insitu_backend_cpu)
    call expect('the reason', trim(info%reason) == 'as asked for')
    call expect('counts', info%kept > 0 .and. info%bytes > 0)
    call mesh%locator(insitu_method_shared_faces, ierr, backend=insitu_backend_cuda)
    call expect_error('no such method there', session, ierr, insitu_error_unsupported, &
                      'shared_faces|cuda')
  end subroutine choose

  !> The mean of the first `corners` vertices of each cell: 1 a vertex, 2 an edge, 4 a face, 8 inside.
  function means(corners) result(points)
    integer, intent(in) :: corners
    real(real64) :: points(3, n)
    integer :: c
    do c = 1, n
      points(:, c) = sum(xyz(:, connectivity(:corners, c)), dim=2) / real(corners, real64)
    end do
  end function means

  subroutine ask()
    integer, parameter :: corners(4) = [8, 4, 2, 1]
    integer, parameter :: reason(4) = &
        [insitu_reason_certified, insitu_reason_on_face, insitu_reason_on_edge, insitu_reason_on_vertex]
    integer(int64) :: cells(5 * n)
    integer(int32) :: narrow(5 * n)
    integer :: reasons(5 * n), again(5 * n), short(n), expected, i
    real(real64) :: points(3, 5 * n)
    real(real32) :: x(5 * n), y(5 * n), z(5 * n)
    type(insitu_report) :: report

    do i = 1, 4
      points(:, n * (i - 1) + 1:n * i) = means(corners(i))
    end do
    points(:, 4 * n + 1:) = means(8) + 100.0_real64
    reasons = -1
    call mesh%locate(points, cells, ierr, reasons=reasons)
    call expect_ok('locate', session, ierr)
    do i = 1, 4
      associate (found => reasons(n * (i - 1) + 1:n * i))
        expected = reason(i)
        ! How an interior point is made sure of is the library's affair.
        if (i == 1) where (found == insitu_reason_exact) found = insitu_reason_certified
        call expect('reasons of the means of corners', all(found == expected))
      end associate
    end do
    call expect('cells of centres', all(cells(:n) == [(int(i, int64), i=1, n)]))
    call expect('outside', all(reasons(4 * n + 1:) == insitu_reason_outside) .and. &
                all(cells(4 * n + 1:) == 0_int64))

    ! The other ways to give points and to take ids say the same.
    call mesh%locate(points, narrow, ierr, reasons=again)
    where (again(:n) == insitu_reason_exact) again(:n) = insitu_reason_certified
    call expect('32-bit ids', ierr == insitu_ok .and. all(again == reasons) .and. all(narrow == cells))
    x = real(points(1, :), real32)                  ! exact: few digits
    y = real(points(2, :), real32)
    z = real(points(3, :), real32)
    call mesh%locate(x, y, z, cells, ierr, reasons=again)
    where (again(:n) == insitu_reason_exact) again(:n) = insitu_reason_certified
    call expect('three arrays', ierr == insitu_ok .and. all(again == reasons))
    call mesh%locate(x, y, z, narrow, ierr, reasons=again)
    where (again(:n) == insitu_reason_exact) again(:n) = insitu_reason_certified
    call expect('three arrays, 32-bit ids', ierr == insitu_ok .and. all(again == reasons))

    call session%report(report, ierr)
    call expect('report', report%located_by_reason(insitu_reason_outside) == 4 * n .and. &
                report%located_by_reason(insitu_reason_certified) + &
                report%located_by_reason(insitu_reason_exact) == 4 * n .and. &
                report%located_by_reason(insitu_reason_on_face) == 4 * n .and. &
                report%located_by_reason(insitu_reason_on_edge) == 4 * n .and. &
                report%located_by_reason(insitu_reason_on_vertex) == 4 * n)

    call mesh%locate(points, cells, ierr, reasons=short)
    call expect_error('too little room', session, ierr, insitu_error_argument, 'reasons|24|120')
  end subroutine ask

end program reasons_test
