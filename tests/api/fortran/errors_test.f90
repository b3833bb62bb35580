!> What goes wrong comes back as ierr and a message, and the session goes on; and what goes right:
!! a scene is executed, and reported.
program errors_test
  use, intrinsic :: iso_fortran_env, only: int32, int64, real64
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
  use checks
  use insitu
  implicit none

  character(len=*), parameter :: newline = new_line('a')
  character(len=*), parameter :: probe_scene = 'insitu: 1' // newline // 'probes:' // newline // &
      '  - name: gauge' // newline // '    points: [[0.5, 0.25, 1.0]]' // newline // &
      '    fields: [f]' // newline

  real(real64), target :: xyz(3, box_vertices), f(box_vertices)
  integer(int32), target :: connectivity(8, box_cells)
  integer :: ierr

  xyz = box_points()
  f = linear(xyz)
  connectivity = box_hexahedra()
  call sessions()
  call meshes()
  call queries()
  call scenes()
  call names()
  call finish_checks()

contains

  subroutine sessions()
    type(insitu_session) :: session, twice
    type(insitu_mesh) :: mesh, orphan

    call expect('no message before the first call', session%message() == '')
    call session%mesh('m', mesh, ierr)
    call expect('a mesh of no session', ierr == insitu_error_handle)
    call session%execute(1, 0.0_real64, ierr)
    call expect('execute before open', ierr == insitu_error_handle)
    call session%close(ierr)
    call expect('close before open', ierr == insitu_ok)
    call orphan%commit(ierr)
    call expect('commit of no mesh', ierr == insitu_error_handle)

    call session%open(scene='no_such_scene.yaml', ierr=ierr)
    call expect_error('missing scene', session, ierr, insitu_error_file, 'no_such_scene.yaml')
    call session%open(ierr=ierr, scene_text='insitu: 1' // newline // 'prbes: []' // newline)
    call expect_error('misspelt key', session, ierr, insitu_error_scene, 'prbes|probes')
    call session%open(scene='a.yaml', ierr=ierr, scene_text=probe_scene)
    call expect_error('two scenes', session, ierr, insitu_error_argument, 'scene')

    call session%open(ierr=ierr, threads=-1)
    call expect_error('threads', session, ierr, insitu_error_argument, 'threads|-1')
    call session%open(ierr=ierr)
    call expect_ok('open after failures', session, ierr)
    call expect('no message left', session%message() == '')
    call session%open(ierr=ierr)
    call expect_error('open twice', session, ierr, insitu_error_order, 'open')
    call session%mesh('m', mesh, ierr)
    call expect_ok('mesh', session, ierr)
    twice = session
    call session%close(ierr)
    call expect_ok('close', session, ierr)
    call session%close(ierr)
    call expect('close twice', ierr == insitu_ok)
    call twice%close(ierr)
    call expect('close of a copy', ierr == insitu_error_handle)
    call mesh%commit(ierr)
    call expect_error('mesh of a closed session', session, ierr, insitu_error_handle, 'mesh')
  end subroutine sessions

  subroutine meshes()
    type(insitu_session) :: session
    type(insitu_mesh) :: mesh
    type(insitu_validation) :: validation
    real(real64), pointer :: nowhere(:)

    call session%open(ierr=ierr, log_level=insitu_log_error)
    call session%mesh('box', mesh, ierr)
    call mesh%hexahedra(connectivity(1:7, :), ierr)
    call expect_error('seven ids', session, ierr, insitu_error_argument, 'box|7|8')
    call mesh%hexahedra(connectivity, ierr)
    call mesh%points(xyz(1:1, :), ierr)
    call expect_error('one component', session, ierr, insitu_error_argument, 'points|1')
    call mesh%points(xyz, ierr, frame='mercator')
    call expect_error('unknown frame', session, ierr, insitu_error_argument, 'mercator|geodetic')
    call mesh%points(xyz, ierr, frame='utm 61N')
    call expect('UTM zone 61', ierr /= insitu_ok)
    call mesh%points(xyz, ierr, frame='utm 33N')
    call expect_ok('UTM zone 33', session, ierr)
    call mesh%points(xyz, ierr, frame='enu 5.0 52.0 0.0')
    call expect_ok('local frame', session, ierr)
    call mesh%points(xyz, ierr, frame='cartesian')
    call expect_ok('Cartesian frame', session, ierr)
    call mesh%points(xyz, ierr, piece=4)
    call expect_error('a gap between pieces', session, ierr, insitu_error_argument, 'piece')
    nowhere => null()
    call mesh%vertex_field('f', nowhere, ierr)
    call expect_error('no target', session, ierr, insitu_error_argument, "'f'|null")
    call mesh%vertex_field('f', f(2:), ierr)
    call mesh%commit(ierr)
    call expect_error('a field too short', session, ierr, insitu_error_field, "'f'|59|60")
    call mesh%vertex_field('f', f, ierr)

    connectivity(3, 5) = 0
    call mesh%validate(validation, ierr)
    call expect('id 0 is found', ierr == insitu_error_mesh .and. validation%index_errors == 1)
    call mesh%changed(insitu_topology)
    call mesh%commit(ierr)
    call expect_error('id 0', session, ierr, insitu_error_mesh, 'box|cell')
    connectivity = box_hexahedra()
    xyz(2, 7) = ieee_value(f(1), ieee_quiet_nan)
    call mesh%changed(insitu_all)
    call mesh%commit(ierr)
    call expect_error('NaN', session, ierr, insitu_error_mesh, 'box')
    xyz = box_points()
    call mesh%changed(insitu_all)
    call mesh%commit(ierr)
    call expect_ok('a good mesh after bad ones', session, ierr)
    call mesh%changed(64, ierr)
    call expect_error('unknown change', session, ierr, insitu_error_argument, '64')
    call mesh%remove_field('g', ierr)
    call expect_error('field to remove', session, ierr, insitu_error_field, 'g')
    call session%close(ierr)
  end subroutine meshes

  subroutine queries()
    type(insitu_session) :: session
    type(insitu_mesh) :: mesh
    real(real64) :: points(3, 2), values(2), three(3), one(1), parametric(2, 2)
    integer(int64) :: cells(2)
    integer(int32) :: few(1)
    logical :: found(2), inside

    points(:, 1) = [0.5_real64, 0.25_real64, 1.0_real64]
    points(:, 2) = ieee_value(one(1), ieee_quiet_nan)
    call session%open(ierr=ierr)
    call session%mesh('box', mesh, ierr)
    call mesh%points(xyz, ierr)
    call mesh%hexahedra(connectivity, ierr)
    call mesh%vertex_field('f', f, ierr)
    call mesh%vertex_field('wide', xyz, ierr, vector=.true.)
    call mesh%locate(points, cells, ierr)
    call expect_error('locate before commit', session, ierr, insitu_error_order, 'box|commit')
    call mesh%commit(ierr)
    call expect_ok('commit', session, ierr)

    call mesh%locate(points, few, ierr)
    call expect_error('too little room for ids', session, ierr, insitu_error_argument, 'cells|1|2')
    call mesh%locate(points(1:2, :), cells, ierr)
    call expect_error('points of two components', session, ierr, insitu_error_argument, 'points|2')
    call mesh%locate(points, cells, ierr, parametric=parametric)
    call expect_error('parametric (2, n)', session, ierr, insitu_error_argument, 'parametric')
    call mesh%locate(points, cells, ierr, accuracy=9)
    call expect_error('accuracy', session, ierr, insitu_error_argument, 'accuracy|9')
    call mesh%locate(points, cells, ierr, frame='utm')
    call expect_error('a frame without its zone', session, ierr, insitu_error_argument, 'utm')
    call mesh%locate(points, cells, ierr, frame='geodetic')
    call expect('a geodetic point in a Cartesian mesh', ierr /= insitu_ok)
    call mesh%sample('g', points, values, ierr)
    call expect_error('no such field', session, ierr, insitu_error_field, "'g'")
    call mesh%sample('f', points, three, ierr)
    call expect_error('too much room', session, ierr, insitu_error_argument, "'f'|3|2")
    call mesh%sample('wide', points, values, ierr)
    call expect_error('no room for components', session, ierr, insitu_error_argument, "'wide'|3|2")
    call mesh%sample_point('wide', points(:, 1), one, ierr)
    call expect_error('no room at one point', session, ierr, insitu_error_argument, "'wide'")

    call mesh%sample('f', points, values, ierr, found=found)
    call expect_ok('sample', session, ierr)
    call expect('a NaN point is outside', all(found .eqv. [.true., .false.]))
    call expect_near('the other one', values(1:1), linear(points(:, 1:1)), 1.0e-14_real64)
    call expect('its value is NaN', ieee_is_nan(values(2)))
    call mesh%sample_point('wide', points(:, 1), three, ierr, found=inside)
    call expect_near('one point', three, points(:, 1), 1.0e-14_real64)
    call expect('found', inside)
    call mesh%sample_point('f', points(:, 2), one, ierr, found=inside)
    call expect('one point outside', ierr == insitu_ok .and. .not. inside .and. ieee_is_nan(one(1)))
    call session%close(ierr)
  end subroutine queries

  !> A probe's table appears; its report says so; a probe of an unknown field fails alone.
  subroutine scenes()
    type(insitu_session) :: session
    type(insitu_mesh) :: mesh
    type(insitu_report) :: report
    character(len=:), allocatable :: text
    logical :: there

    call session%open(ierr=ierr, scene_text=probe_scene, output='errors_test_out')
    call expect_ok('open with a scene', session, ierr)
    call session%mesh('box', mesh, ierr)
    call mesh%points(xyz, ierr)
    call mesh%hexahedra(connectivity, ierr)
    call mesh%vertex_field('f', f, ierr)
    call session%execute(0, 0.0_real64, ierr)
    call expect_ok('execute', session, ierr)
    call session%execute(1_int64, 0.5_real64, ierr)
    call expect_ok('execute, int64 cycle', session, ierr)
    call session%report(report, ierr)
    call expect_ok('report', session, ierr)
    call expect('two executions', report%executions == 2 .and. report%probe_rows == 2)
    call expect('one build', report%rebuilds == 1 .and. report%failures == 0)
    call expect('bytes', report%bytes_by_purpose(insitu_memory_tree) > 0 .and. &
                report%bytes_by_purpose(insitu_memory_converted) == 0)
    call session%plan(text, ierr)
    call expect_ok('plan', session, ierr)
    call expect('the plan names the probe', index(text, "probe '") > 0)
    call session%write_summary('errors_test_out/summary.json', ierr, solver_s=1.0_real64)
    call expect_ok('summary', session, ierr)
    call mesh%remove_field('f', ierr)
    call session%execute(2, 1.0_real64, ierr)
    call expect_error('a probe without its field', session, ierr, insitu_error_action, 'gauge')
    call session%close(ierr)
    inquire (file='errors_test_out/summary.json', exist=there)
    call expect('summary.json is there', there)
  end subroutine scenes

  subroutine names()
    call expect('status name', insitu_status_name(insitu_error_mesh) == 'INSITU_ERROR_MESH')
    call expect('version', index(insitu_version(), '.') > 1)
  end subroutine names

end program errors_test
