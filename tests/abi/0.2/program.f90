!> A solver of version 0.2, in Fortran.
program abi_program
  use, intrinsic :: iso_fortran_env, only: error_unit, int32, int64, real64
  use insitu
  implicit none

  character(len=*), parameter :: nl = new_line('a')
  character(len=*), parameter :: scene = 'insitu: 1' // nl // 'probes:' // nl // &
      '  - {name: point, points: [[0.25, 0.5, 0.5]], fields: [pressure]}' // nl // 'tracers:' // nl // &
      '  - {name: paths, velocity: velocity, seeds: [[0.2, 0.5, 0.5]]}' // nl
  real(real64), target :: x(8) = [0, 1, 1, 0, 0, 1, 1, 0], y(8) = [0, 0, 1, 1, 0, 0, 1, 1]
  real(real64), target :: z(8) = [0, 0, 0, 0, 1, 1, 1, 1], pressure(8), velocity(3, 8)
  integer(int32), target :: connectivity(8, 1) = reshape([1, 2, 3, 4, 5, 6, 7, 8], [8, 1])
  real(real64) :: points(3, 2) = reshape([0.25_real64, 0.5_real64, 0.5_real64, 2.0_real64, 0.0_real64, &
                                          0.0_real64], [3, 2]), values(2)
  integer(int64) :: cells(2)
  logical :: found(2)
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  type(insitu_report) :: report
  type(insitu_commit_report) :: commit
  type(insitu_validation) :: validation
  integer :: ierr, cycle, failures

  failures = 0
  pressure = x
  velocity = 0.0_real64
  velocity(1, :) = 0.01_real64
  call session%open(ierr=ierr, scene_text=scene, threads=2)
  call expect('open', ierr == insitu_ok)
  call session%mesh('hydro', mesh, ierr)
  call mesh%points(x, y, z, ierr)
  call expect('points', ierr == insitu_ok)
  call mesh%hexahedra(connectivity, ierr)
  call expect('hexahedra', ierr == insitu_ok)
  call mesh%vertex_field('pressure', pressure, ierr)
  call expect('pressure', ierr == insitu_ok)
  call mesh%vertex_field('velocity', velocity, ierr, vector=.true.)
  call expect('velocity', ierr == insitu_ok)
  call mesh%validate(validation, ierr)
  call expect('validate', ierr == insitu_ok .and. validation%cells == 1)
  call mesh%commit(ierr, report=commit)
  call expect('commit', ierr == insitu_ok .and. commit%vertices == 8)
  do cycle = 0, 2
    call mesh%changed(insitu_fields, ierr)
    call session%execute(cycle, 0.1_real64 * cycle, ierr)
    call expect('execute', ierr == insitu_ok)
  end do
  call mesh%locate(points, cells, ierr, found=found)
  call expect('locate', ierr == insitu_ok .and. all(cells == [1_int64, 0_int64]) .and. found(1))
  call mesh%sample('pressure', points, values, ierr)
  call expect('sample', ierr == insitu_ok .and. abs(values(1) - 0.25_real64) < 1.0e-14_real64)
  call session%report(report, ierr)
  call expect('report', ierr == insitu_ok .and. report%executions == 3 .and. report%failures == 0)
  call expect('particles', report%particles(insitu_end_alive) == 1 .and. sum(report%particles) == 1)
  call expect('endings', report%endings >= 11 .and. report%purposes >= 15 .and. report%reasons >= 6)
  call session%close(ierr)
  call expect('close', ierr == insitu_ok)
  if (failures > 0) error stop 1

contains

  subroutine expect(what, holds)
    character(len=*), intent(in) :: what
    logical, intent(in) :: holds
    if (holds) return
    failures = failures + 1
    write (error_unit, '(3a, i0, 2a)') what, ' failed: ', 'status ', ierr, ', ', session%message()
  end subroutine expect

end program abi_program
