!> What probes answer, for a solver in Fortran that acts on it.
program answers_test
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use, intrinsic :: iso_fortran_env, only: int32, int64, real64
  use checks
  use insitu
  implicit none

  character(len=*), parameter :: newline = new_line('a')
  character(len=*), parameter :: scene = 'insitu: 1' // newline // 'probes:' // newline // &
      '  - {name: often, points: [[0.5, 0.25, 0.5], [99, 9, 9]], fields: [f, v]}' // newline // &
      '  - {name: rare, every: 2, points: [[0.5, 0.25, 0.5]], fields: [f]}' // newline
  real(real64), target :: xyz(3, box_vertices), f(box_vertices), v(3, box_vertices)
  integer(int32), target :: connectivity(8, box_cells)
  real(real64), allocatable :: values(:, :), points(:, :)
  logical, allocatable :: inside(:)
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  integer(int64) :: cycle
  real(real64) :: time
  integer :: ierr

  xyz = box_points()
  connectivity = box_hexahedra()
  call session%open(ierr=ierr, scene_text=scene, output='out', threads=1)
  call session%mesh('box', mesh, ierr)
  call mesh%points(xyz, ierr)
  call mesh%hexahedra(connectivity, ierr)
  f = 1
  v = spread([2.0_real64, 3.0_real64, 4.0_real64], 2, box_vertices)
  call mesh%vertex_field('f', f, ierr)
  call mesh%vertex_field('v', v, ierr, vector=.true.)
  call session%keep_answers(ierr)
  call expect_ok('keep_answers', session, ierr)
  call session%answers(1, values, ierr, points, inside)
  call expect_ok('answers before an execute', session, ierr)
  call expect('there are none', size(values) == 0 .and. size(points) == 0 .and. size(inside) == 0)
  call session%execute(1, 0.25_real64, ierr)
  call expect_ok('execute', session, ierr)
  call session%answers(1, values, ierr, points, inside, cycle, time)
  call expect_ok('answers', session, ierr)
  call expect('columns and points', all(shape(values) == [4, 2]))
  call expect('a point beyond the mesh', .not. inside(2) .and. all(ieee_is_nan(values(:, 2))))
  call expect('a point in it', inside(1))
  ! Means of equal numbers, rounded.
  call expect('values', all(abs(values(:, 1) - [1, 2, 3, 4]) < 1.0e-14_real64))
  call expect('points', all(abs(points(:, 1) - [0.5_real64, 0.25_real64, 0.5_real64]) < tiny(time)))
  call expect('cycle and time', cycle == 1 .and. abs(time - 0.25_real64) < tiny(time))
  call session%answers(2, values, ierr)
  call expect('a probe that was not due', ierr == insitu_ok .and. size(values) == 0)
  call session%answers(3, values, ierr)
  call expect_error('answers', session, ierr, insitu_error_argument, 'the scene has 2 probes')
  call session%keep_answers(ierr, keep=.false.)
  call session%answers(1, values, ierr)
  call expect('answers that are kept no more', ierr == insitu_ok .and. size(values) == 0)
  call session%close(ierr)
  call finish_checks()

end program answers_test
