!> Sessions over the processes of communicators of mpi_f08 and of the older module, whose handles are
!! integers: mpiexec -n 2. All processes hear what one of them does wrong.
program fortran_test
  use, intrinsic :: iso_fortran_env, only: error_unit, real64
  use insitu
  use mpi_f08
  implicit none

  integer :: wrong, all_wrong, level
  integer :: rank, processes

  call MPI_Init_thread(MPI_THREAD_FUNNELED, level)
  call MPI_Comm_rank(MPI_COMM_WORLD, rank)
  call MPI_Comm_size(MPI_COMM_WORLD, processes)
  wrong = 0
  call run(MPI_COMM_WORLD%mpi_val, 'f08')
  call run(old_world(), 'old')
  call MPI_Allreduce(wrong, all_wrong, 1, MPI_INTEGER, MPI_SUM, MPI_COMM_WORLD)
  call MPI_Finalize()
  if (all_wrong > 0) error stop 1

contains

  integer function old_world()
    use mpi, only: MPI_COMM_WORLD
    old_world = MPI_COMM_WORLD
  end function old_world

  subroutine expect(what, holds)
    character(len=*), intent(in) :: what
    logical, intent(in) :: holds
    if (.not. holds) then
      write (error_unit, '(a, i0, 2a)') 'process ', rank, ' failed: ', what
      wrong = wrong + 1
    end if
  end subroutine expect

  subroutine run(communicator, name)
    integer, intent(in) :: communicator
    character(len=*), intent(in) :: name
    type(insitu_session) :: session
    type(insitu_mesh) :: mesh
    real(real64), target :: x(2), y(2), z(2), p(2, 2, 2)
    character(len=16) :: folder
    integer :: ierr

    write (folder, '(a, a, i0)') name, '_', rank
    call session%open(ierr=ierr, scene_text='insitu: 1' // new_line('a') // &
                      'probes: [{name: gauge, points: [[0.5, 0.5, 0.5]]}]', output=trim(folder), &
                      communicator=communicator)
    call expect('open ' // name, ierr == insitu_ok)
    x = [rank, rank + 1]
    y = [0, 1]
    z = [0, 1]
    p = rank
    call session%mesh('box', mesh, ierr)
    call mesh%rectilinear_block(x, y, z, ierr)
    call mesh%vertex_field('p', p, ierr)
    call expect('mesh ' // name, ierr == insitu_ok)
    call session%execute(0, 0.0_real64, ierr)
    call expect('execute ' // name, ierr == insitu_ok)
    call session%execute(1 + rank, 0.1_real64, ierr)
    call expect('other cycles ' // name, ierr == insitu_error_argument)
    call session%execute(2, 0.2_real64, ierr)
    call expect('execute again ' // name, ierr == insitu_ok)
    call session%close(ierr)
    call expect('close ' // name, ierr == insitu_ok)
  end subroutine run

end program fortran_test
