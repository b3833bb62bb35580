!> Checkpoint and restart from Fortran: a run that goes on from its checkpoint writes the table of one
!! that was never stopped, and what cannot be taken up is told.
program checkpoint_test
  use, intrinsic :: iso_fortran_env, only: int32, int64, real64
  use checks
  use insitu
  implicit none

  character(len=*), parameter :: newline = new_line('a')
  character(len=*), parameter :: scene = 'insitu: 1' // newline // 'page: false' // newline // &
      'tracers:' // newline // '  - {name: t, velocity: u, time_interpolation: quadratic,' // newline // &
      '     seeds: [[0.5, 0.25, 1.0], [1.5, 1.25, 0.5]]}' // newline

  real(real64), target :: xyz(3, box_vertices), u(3, box_vertices)
  integer(int32), target :: connectivity(8, box_cells)
  integer :: ierr
  character(len=:), allocatable :: whole, resumed

  xyz = box_points()
  connectivity = box_hexahedra()
  call run_from(0, 4, checkpoint_after=2)
  whole = table()
  call run_from(0, 3, checkpoint_after=-1)            ! a row beyond the checkpoint, and the ends
  call run_from(3, 4, checkpoint_after=-1)
  resumed = table()
  call expect('the table is the whole run''s', len(whole) > 100 .and. resumed == whole)
  deallocate (whole, resumed)
  call refusals()
  call finish_checks()

contains

  !> Cycles first to last; from another than 0 on, by the checkpoint.
  subroutine run_from(first, last, checkpoint_after)
    integer, intent(in) :: first, last, checkpoint_after
    type(insitu_session) :: session
    type(insitu_mesh) :: mesh
    integer :: cycle

    call open_box(session, mesh)
    if (first > 0) then
      call session%restart('state', ierr)
      call expect_ok('restart', session, ierr)
    end if
    do cycle = first, last
      u(1, :) = 0.01_real64 * cycle**2
      u(2, :) = 0.01_real64
      u(3, :) = -0.002_real64 * cycle
      call mesh%changed(insitu_fields)
      call session%execute(cycle, 1.0_real64 * cycle, ierr)
      call expect_ok('execute', session, ierr)
      if (cycle == checkpoint_after) then
        call session%checkpoint('state', ierr)
        call expect_ok('checkpoint', session, ierr)
        call session%record('record.hdf', ierr)
        if (ierr /= insitu_error_unsupported) call expect_ok('record', session, ierr)
      end if
    end do
    call session%close(ierr)
    call expect('close', ierr == insitu_ok)
  end subroutine run_from

  subroutine open_box(session, mesh)
    type(insitu_session), intent(inout) :: session
    type(insitu_mesh), intent(inout) :: mesh

    call session%open(ierr=ierr, scene_text=scene, output='out')
    call expect_ok('open', session, ierr)
    call session%mesh('box', mesh, ierr)
    call mesh%points(xyz, ierr)
    call mesh%hexahedra(connectivity, ierr)
    call mesh%vertex_field('u', u, ierr, vector=.true.)
    call expect_ok('mesh', session, ierr)
  end subroutine open_box

  function table() result(text)
    character(len=:), allocatable :: text
    character(len=1024) :: line
    integer :: unit, status

    text = ''
    open (newunit=unit, file='out/t.csv', status='old', action='read')
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      text = text // trim(line) // newline
    end do
    close (unit)
  end function table

  subroutine refusals()
    type(insitu_session) :: session
    type(insitu_mesh) :: mesh

    call session%restart('state', ierr)
    call expect('restart before open', ierr == insitu_error_handle)
    call open_box(session, mesh)
    call session%checkpoint('early', ierr)
    call expect_error('checkpoint before execute', session, ierr, insitu_error_order, 'early')
    call session%restart('no_such_state', ierr)
    call expect_error('no such checkpoint', session, ierr, insitu_error_file, 'no_such_state')
    call session%close(ierr)
  end subroutine refusals

end program checkpoint_test
