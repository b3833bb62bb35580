!> Drifters in a gyre, over two jobs: the first one ends with a checkpoint, the second goes on from it. Their table is the
!! one that a single job would have written.
program drifters
  use, intrinsic :: iso_fortran_env, only: output_unit, real64
  use insitu
  implicit none

  character(len=*), parameter :: scene = &
      'insitu: 1' // new_line('a') // &
      'output: out/drifters' // new_line('a') // &
      'tracers:' // new_line('a') // &
      '  - name: drifters' // new_line('a') // &
      '    velocity: current' // new_line('a') // &
      '    seeds: {line: {from: [0.5, 0.0, 0.5], to: [0.9, 0.0, 0.5], count: 5}}' // new_line('a') // &
      '    output: [csv, netcdf]' // new_line('a')
  integer, parameter :: n = 9
  real(real64), parameter :: dt = 0.25_real64, lowest(3) = [-1.0_real64, -1.0_real64, 0.0_real64]
  real(real64), target :: current(3, n**3)               ! along x, y, z: once around in 2 pi
  integer :: i, j

  do j = 0, n - 1
    do i = 0, n - 1
      current(1, 1 + i + n * j::n**2) = -(lowest(2) + 0.25_real64 * real(j, real64))
      current(2, 1 + i + n * j::n**2) = lowest(1) + 0.25_real64 * real(i, real64)
    end do
  end do
  current(3, :) = 0.0_real64

  call job(0, 12)
  call job(13, 24)
  write (output_unit, '(i0, a)') rows('out/drifters/drifters.csv'), ' rows of 5 drifters at 25 cycles and their ends'

contains

  !> The cycles first to last, of a solver that has come so far.
  subroutine job(first, last)
    integer, intent(in) :: first, last
    type(insitu_session) :: session
    type(insitu_mesh) :: mesh
    type(insitu_report) :: report
    integer :: cycle, ierr

    call session%open(ierr=ierr, scene_text=scene, strict=.true.)
    if (ierr /= insitu_ok) error stop 1
    call session%mesh('basin', mesh, ierr)
    call mesh%uniform_block([n, n, n], lowest, spread(0.25_real64, 1, 3), ierr)
    call mesh%vertex_field('current', current, ierr, vector=.true.)
    if (first > 0) call session%restart('out/drifters/state', ierr)
    if (ierr /= insitu_ok) error stop 2                  ! session%message() says why
    do cycle = first, last
      call session%execute(cycle, dt * real(cycle, real64), ierr)
    end do
    call session%checkpoint('out/drifters/state', ierr)  ! or `checkpoint: {every: 100}` in the scene
    call session%report(report, ierr)
    write (output_unit, '(2(a, i0), a, i0, a)') 'cycles ', first, ' to ', last, ': ', &
        report%particles_seeded, ' drifters'
    call session%close(ierr)
  end subroutine job

  !> Lines of a file after the first.
  integer function rows(path)
    character(len=*), intent(in) :: path
    integer :: unit, status

    rows = -1
    open (newunit=unit, file=path, action='read', status='old', iostat=status)
    do while (status == 0)
      read (unit, *, iostat=status)
      if (status == 0) rows = rows + 1
    end do
    close (unit)
  end function rows

end program drifters
