!> Polyhedra by their faces, as finite-volume solvers hold them: two cells of a honeycomb, six-sided
!! prisms that share one side. A point between them has one owner, and a point outside the nearest.
program faces
  use, intrinsic :: iso_fortran_env, only: int32, int64, output_unit, real64
  use insitu
  implicit none

  integer(int32), parameter :: n = 10                       ! corners on the floor; on the lid as many
  real(real64), parameter :: floor_xy(2, n) = reshape([0.9_real64, 0.5_real64, 0.0_real64, 1.0_real64, &
      -0.9_real64, 0.5_real64, -0.9_real64, -0.5_real64, 0.0_real64, -1.0_real64, 0.9_real64, -0.5_real64, &
      2.7_real64, 0.5_real64, 1.8_real64, 1.0_real64, 1.8_real64, -1.0_real64, 2.7_real64, -0.5_real64], &
      [2, n])
  integer(int32), parameter :: rings(6, 2) = reshape([1, 2, 3, 4, 5, 6, 7, 8, 1, 6, 9, 10], [6, 2])
  real(real64), target :: xyz(3, 2 * n), temperature(2 * n)
  integer(int32), target :: vertices(11 * 4 + 4 * 6), offsets(16) = 1, owner(15)
  integer(int32), target :: neighbour(1) = [2]              ! of the first face alone
  real(real64) :: points(3, 4), values(4), distances(4)
  integer(int64) :: cells(4)
  logical :: inside(4)
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  integer(int32) :: faces_so_far = 0, cell, a, b, i
  integer :: ierr, p

  xyz(1:2, :n) = floor_xy
  xyz(1:2, n + 1:) = floor_xy
  xyz(3, :n) = 0
  xyz(3, n + 1:) = 1
  temperature = 20 + xyz(1, :) + 2 * xyz(2, :) - 3 * xyz(3, :)

  call add_face(1_int32, [6_int32, 1_int32, 1 + n, 6 + n])
  do cell = 1, 2
    do i = 1, 6
      a = rings(i, cell)
      b = rings(mod(i, 6_int32) + 1, cell)
      if (min(a, b) == 1 .and. max(a, b) == 6) cycle        ! the side between both
      call add_face(cell, [a, b, b + n, a + n])
    end do
    call add_face(cell, rings(:, cell))
    call add_face(cell, rings(:, cell) + n)
  end do

  call session%open(ierr=ierr)
  call session%mesh('honeycomb', mesh, ierr)
  call mesh%points(xyz, ierr)
  call mesh%faces(vertices, offsets, owner, neighbour, 2_int32, ierr)
  call mesh%vertex_field('temperature', temperature, ierr)
  call mesh%commit(ierr)
  if (ierr /= insitu_ok) error stop 1

  ! In each cell, on the face between them, and a quarter beyond the second one.
  points = reshape([-0.3_real64, 0.4_real64, 0.2_real64, 2.0_real64, 0.1_real64, 0.7_real64, &
                    0.9_real64, 0.2_real64, 0.5_real64, 2.95_real64, 0.0_real64, 0.5_real64], [3, 4])
  call mesh%locate(points, cells, ierr, found=inside, distances=distances)
  call mesh%sample('temperature', points, values, ierr, distances=distances)
  if (ierr /= insitu_ok) error stop 2
  do p = 1, 4
    if (inside(p)) then
      write (output_unit, '(a, i0, a, i0, a, f7.3)') 'point ', p, ': in cell ', cells(p), &
          ', temperature ', values(p)
    else
      write (output_unit, '(a, i0, a, i0, a, f5.3, a, f7.3)') 'point ', p, ': outside; cell ', cells(p), &
          ' is nearest, ', distances(p), ' away, temperature there ', values(p)
    end if
  end do
  call session%close(ierr)

contains

  subroutine add_face(of_cell, ring)
    integer(int32), intent(in) :: of_cell, ring(:)
    faces_so_far = faces_so_far + 1
    offsets(faces_so_far + 1) = offsets(faces_so_far) + size(ring, kind=int32)
    vertices(offsets(faces_so_far):offsets(faces_so_far + 1) - 1) = ring
    owner(faces_so_far) = of_cell
  end subroutine add_face

end program faces
