!> The heat on several processes (mpirun -n 3 heat_processes_check): every number that a process has is
!! the one of a run on one process, to the bit. Each process makes that run too, and compares.
program heat_processes_check
  use, intrinsic :: iso_fortran_env, only: real64
  use heat_case, only: initial_heat, largest_error
  use heat_solver, only: heat_type, nhalo
  use processes_checks, only: end_checks, expect, expect_same, processes
  implicit none

  call processes%launch()
  call check_run(9, 40)                                  ! 5 levels
  call check_run(3, 20)                                  ! 2 levels: with more processes, some have none
  call end_checks()

contains

  subroutine check_run(resolution, cycles)
    integer, intent(in) :: resolution, cycles
    type(heat_type) :: part, whole
    real(real64) :: levels
    integer :: cycle

    call initial_heat(resolution, part, processes)
    call initial_heat(resolution, whole)
    call compare(part, whole)
    call expect_same('the step', [part%stable_step()], [whole%stable_step()])
    do cycle = 1, cycles
      call part%step(whole%stable_step())
      call part%update_flux()
      call whole%step(whole%stable_step())
      call whole%update_flux()
    end do
    call compare(part, whole)
    levels = processes%total([real(part%mesh%nlevels, real64)])
    call expect('every level is on one process', nint(levels) == whole%mesh%nlevels)
  end subroutine check_run

  subroutine compare(part, whole)
    type(heat_type), intent(in) :: part, whole
    integer :: i, k

    associate (p => part%mesh, w => whole%mesh, cells => part%mesh%cell_ids + 1, vertices => part%mesh%vertex_ids + 1)
      call expect_same('x', p%x, w%x(vertices))
      call expect_same('y', p%y, w%y(vertices))
      call expect_same('z', p%z, w%z(vertices))
      do i = 1, 6
        call expect('connectivity', all(vertices(p%connectivity(i, :)) == w%connectivity(i, cells)))
      end do
      do k = 1, p%nlevels
        call expect_same('temperatures', part%t(:, k + nhalo), whole%t(:, k + p%below + nhalo))
      end do
      do i = 1, 3
        if (p%nlevels > 0) call expect_same('fluxes', part%flux(i, :), whole%flux(i, vertices))
      end do
    end associate
    call expect_same('the energy', [part%energy()], [whole%energy()])
    call expect_same('the error', [largest_error(part)], [largest_error(whole)])
  end subroutine compare

end program heat_processes_check
