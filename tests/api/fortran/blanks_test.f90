!> Blank values and hidden points: cells own points there, samples are NaN, and particles that go
!! there say so.
program blanks_test
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use, intrinsic :: iso_fortran_env, only: int32, int8, real32, real64
  use checks
  use insitu
  implicit none

  real(real64), target :: points(3, box_vertices)
  integer(int32), target :: cells(8, box_cells)
  real(real32), target :: salt(box_vertices)
  real(real64), target :: flow(3, box_vertices)
  integer(int8), target :: bits(box_vertices)
  real(real64) :: centres(3, box_cells), values(box_cells)
  integer :: owners(box_cells), ierr, i
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  type(insitu_report) :: report

  points = box_points()
  cells = box_hexahedra()
  centres = box_centres()
  salt = real(points(2, :), real32)
  flow = 0.0_real64
  flow(1, :) = 1.0_real64
  where (points(1, :) > nx - 0.5_real64)
    salt = 1.0e20_real32
  end where
  call session%open(ierr=ierr, scene_text='insitu: 1' // new_line('a') // 'page: false' // &
      new_line('a') // 'tracers:' // new_line('a') // &
      '  - {name: t, kind: streamline, velocity: flow, seeds: [[0.5, 0.5, 0.5]]}' // new_line('a'), &
      output='.')
  call expect_ok('open', session, ierr)
  call session%mesh('box', mesh, ierr)
  call mesh%points(points, ierr)
  call mesh%hexahedra(cells, ierr)
  call mesh%vertex_field('salt', salt, ierr)
  call mesh%vertex_field('flow', flow, ierr, vector=.true.)
  call mesh%field_blank('salt', 1.0e20_real64, ierr)
  call expect_ok('blank', session, ierr)
  call mesh%field_blank('salty', 1.0e20_real64, ierr)
  call expect_error('no such field', session, ierr, insitu_error_field, 'salty|salt')
  call mesh%commit(ierr)
  call expect_ok('commit', session, ierr)
  call mesh%locate(centres, owners, ierr)
  call expect('cells own points where a field is blank', all(owners == [(i, i=1, box_cells)]))
  call mesh%sample('salt', centres, values, ierr)
  call expect('NaN in cells with blank vertices, and there alone', &
      all(ieee_is_nan(values) .eqv. centres(1, :) > nx - 1))

  bits = 0_int8
  where (points(1, :) > nx - 0.5_real64) bits = 2_int8
  call mesh%hidden_points(bits, ierr)
  call expect_ok('hidden points', session, ierr)
  call session%execute(0, 0.0_real64, ierr)
  call expect_ok('execute', session, ierr)
  call session%report(report, ierr)
  call expect('the line ends where the flow is blank', &
      report%particles(insitu_end_blank) == 1 .and. sum(report%particles) == 1)
  call session%close(ierr)
  call finish_checks()
end program blanks_test
