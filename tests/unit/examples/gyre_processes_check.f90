!> The gyre on several processes (mpirun -n 3 gyre_processes_check): every number that a process has is
!! the one of a run on one process, to the bit. Each process makes that run too, and compares.
program gyre_processes_check
  use, intrinsic :: iso_fortran_env, only: real64
  use gyre_basin, only: atlantic
  use gyre_model, only: model_type
  use processes_checks, only: end_checks, expect, expect_same, processes
  use solver_processes, only: processes_type
  implicit none

  call processes%launch()
  call check_sums()
  call check_run(4, 12)
  call check_run(1, 30)                                  ! 4 strips: with more processes, some have none
  call end_checks()

contains

  subroutine check_run(resolution, days)
    integer, intent(in) :: resolution, days
    type(model_type) :: part, whole
    real(real64) :: cells
    integer :: day

    call part%start(atlantic(), resolution, processes)
    call whole%start(atlantic(), resolution)
    call compare(part, whole)
    do day = 1, days
      call part%advance()
      call whole%advance()
    end do
    call compare(part, whole)
    cells = processes%total([real(part%mesh%ncells(), real64)])
    call expect('every cell is in one strip', nint(cells) == whole%mesh%ncells())
  end subroutine check_run

  subroutine compare(part, whole)
    type(model_type), intent(in) :: part, whole
    integer :: i, c, k

    associate (p => part%mesh, w => whole%mesh, cells => part%mesh%cell_ids + 1, vertices => part%mesh%vertex_ids + 1)
      call expect_same('longitudes', p%lon, w%lon(vertices))
      call expect_same('latitudes', p%lat, w%lat(vertices))
      call expect_same('depths', p%depth, w%depth(vertices))
      do i = 1, 3
        call expect_same('velocities', part%flow%velocity(i, :), whole%flow%velocity(i, vertices))
      end do
      do i = 1, 6
        call expect('connectivity', all(vertices(p%connectivity(i, :)) == w%connectivity(i, cells)))
      end do
      i = 0
      do k = 1, p%nlevels
        do c = p%first_column, p%last_column
          i = i + 1
          call expect('cells are counted by levels', cells(i) == c + (k - 1) * p%ncolumns)
          call expect_same('volumes', [p%volume(c, k)], [w%volume(c, k)])
          call expect_same('temperatures', [part%heat%t(c, k)], [whole%heat%t(c, k)])
        end do
      end do
    end associate
    call expect_same('the transport', part%transport%psi, whole%transport%psi)
    call expect_same('the imbalance', [part%flow%imbalance(part%mesh)], [whole%flow%imbalance(whole%mesh)])
    call expect_same('the lost heat', [part%heat_error()], [whole%heat_error()])
    call expect_same('the heat', [part%heat%content(part%mesh)], [whole%heat%content(whole%mesh)])
  end subroutine compare

  !> Numbers of very different sizes, whose sums in doubles depend on the order.
  subroutine check_sums()
    type(processes_type) :: one
    real(real64) :: terms(1001)
    integer :: i

    terms = [(scale(1.0_real64, modulo(i, 40)) * real(2 * modulo(i, 2) - 1, real64) / real(i + 2, real64), i=1, 1001)]
    call expect_same('a sum', [processes%total(terms(processes%rank + 1::processes%number))], [one%total(terms)])
    call expect('a sum is right', abs(one%total(terms) - sum(terms)) <= 1.0e-12_real64 * abs(sum(terms)))
  end subroutine check_sums

end program gyre_processes_check
