!> A session that cannot be opened says so: to standard error, which the test reads, and by every
!! later ierr, the last one too; a block of no cells is a mesh; and a communicator of a program
!! that does not initialise MPI is told of.
program silent_test
  use, intrinsic :: iso_fortran_env, only: error_unit, real64
  use checks
  use insitu
  implicit none

  character(len=*), parameter :: newline = new_line('a')
  integer :: ierr

  call silent()
  call empty()
  call communicators()
  call finish_checks()
  write (error_unit, '(a)') 'all checks are done'

contains

  subroutine silent()
    real(real64), target :: x(5) = [0, 1, 2, 3, 4], p(4, 4, 4) = 1
    type(insitu_session) :: session
    type(insitu_mesh) :: mesh

    call session%open(ierr=ierr, scene_text='insitu: 1' // newline // 'prbes: []' // newline)
    call expect('open', ierr == insitu_error_scene)
    call session%mesh('ocean', mesh, ierr)
    call expect('mesh', ierr == insitu_error_handle)
    call mesh%rectilinear_block(x, x, x, ierr)
    call expect('block', ierr == insitu_error_handle)
    call mesh%cell_field('p', p, ierr)
    call mesh%changed(insitu_fields)
    call session%execute(1, 1.0_real64, ierr)
    call expect('execute', ierr == insitu_error_handle)
    call expect('the cause is kept', index(session%message(), 'not opened') > 0 .and. &
                index(session%message(), "did you mean 'probes'") > 0)
    call session%close(ierr)
    call expect('close', ierr == insitu_error_scene)
    call session%close(ierr)
    call expect('close again', ierr == insitu_ok)
    call session%open(ierr=ierr)
    call expect_ok('open after that', session, ierr)
    call session%close(ierr)
    call expect('close of a good one', ierr == insitu_ok)
  end subroutine silent

  !> Nothing given, one layer of vertices, no vertices, one vertex.
  subroutine empty()
    character(len=*), parameter :: scene = 'insitu: 1' // newline // 'page: false' // newline // &
        'probes:' // newline // '  - {name: pr, points: [[0.5, 0.5, 0.5]], fields: [p]}' // newline // &
        'tracers:' // newline // '  - {name: tr, velocity: u, seeds: [[0.5, 0.5, 0.5]]}' // newline // &
        'frames:' // newline // '  - {name: fr, size: [32, 32], volume: {field: p}}' // newline // &
        '  - {name: wh, size: [32, 32], volume: {field: p}, when: max(p) > 1}' // newline
    integer, parameter :: vertices(3, 4) = reshape([-1, 0, 0, 5, 5, 1, 0, 0, 0, 1, 1, 1], [3, 4])
    type(insitu_session) :: session
    type(insitu_mesh) :: mesh
    type(insitu_report) :: report
    real(real64), allocatable, target :: x(:), y(:), z(:), p(:,:,:), u(:,:,:)
    integer :: how, cycle, n(3), c(3)

    do how = 1, 4
      n = max(vertices(:, how), 0)
      c = max(n - 1, 0)
      allocate (x(n(1)), y(n(2)), z(n(3)), p(c(1), c(2), c(3)), u(n(1), n(2), n(3)))
      x = 0; y = 0; z = 0; p = 0; u = 0
      call session%open(ierr=ierr, scene_text=scene, output='silent_test_out', strict=.true., &
                        log_level=insitu_log_error)
      call session%mesh('m', mesh, ierr)
      if (vertices(1, how) >= 0) then
        call mesh%rectilinear_block(x, y, z, ierr)
        call expect_ok('block', session, ierr)
        call mesh%cell_field('p', p, ierr)
        call expect_ok('cell field', session, ierr)
        call mesh%vertex_field('u', u, u, u, ierr)
        call expect_ok('vertex field', session, ierr)
      end if
      do cycle = 0, 2
        call mesh%changed(insitu_fields)
        call session%execute(cycle, real(cycle, real64), ierr)
        call expect_ok('execute', session, ierr)
      end do
      call session%report(report, ierr)
      call expect('no frames, no failures', report%frames == 0 .and. report%failures == 0)
      call session%close(ierr)
      call expect('close', ierr == insitu_ok)
      deallocate (x, y, z, p, u)
    end do
  end subroutine empty

  !> A communicator is one of number 0 too (Open MPI's MPI_COMM_WORLD), of which something is said where
  !! MPI is not initialised; of none nothing is. What is printed between these lines is part of the answer.
  subroutine communicators()
    type(insitu_session) :: session

    write (error_unit, '(a)') 'no communicator:'
    call session%open(ierr=ierr)
    call session%close(ierr)
    write (error_unit, '(a)') 'communicator 0:'
    call session%open(ierr=ierr, communicator=0)
    call session%close(ierr)
  end subroutine communicators

end program silent_test
