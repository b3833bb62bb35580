!> A time loop: say what changed, execute, and the scene decides what is done at which cycle.
program time_loop
  use, intrinsic :: iso_fortran_env, only: output_unit, real64
  use insitu
  implicit none

  character(len=*), parameter :: scene = &
      'insitu: 1' // new_line('a') // &
      'output: out/time_loop' // new_line('a') // &
      'every: 2' // new_line('a') // &
      'probes:' // new_line('a') // &
      '  - {name: gauge, points: [[0.5, 0.5, 0.5]], fields: [wave]}' // new_line('a')
  integer, parameter :: n = 8
  real(real64), parameter :: dt = 0.1_real64
  real(real64), target :: wave(n, n, n)
  real(real64) :: x(n), time
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  type(insitu_report) :: report
  integer :: cycle, i, ierr

  x = [(real(i - 1, real64) / real(n - 1, real64), i=1, n)]
  call session%open(ierr=ierr, scene_text=scene)         ! in a solver: scene='scene.yaml'
  if (ierr /= insitu_ok) error stop 1
  call session%mesh('box', mesh, ierr)
  call mesh%uniform_block([n, n, n], [0.0_real64, 0.0_real64, 0.0_real64], &
                          spread(x(2), 1, 3), ierr)
  call mesh%vertex_field('wave', wave, ierr)             ! once: the array keeps its place

  do cycle = 0, 10
    time = dt * real(cycle, real64)
    do i = 1, n
      wave(i, :, :) = sin(x(i) - time)
    end do
    call mesh%changed(insitu_fields)
    call session%execute(cycle, time, ierr)
    if (ierr /= insitu_ok) write (output_unit, '(a)') session%message()
  end do

  call session%report(report, ierr)
  write (output_unit, '(i0, a, i0, a)') report%executions, ' cycles, ', report%probe_rows, &
      ' rows in out/time_loop/gauge.csv'
  call session%close(ierr)
end program time_loop
