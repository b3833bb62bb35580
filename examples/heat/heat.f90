!> Heat in an insulated ring: a decaying mode on a mesh of wedges.
!!
!!   heat [cycles [resolution]]
!!
!! prints cycle, time, energy, the extremes of the temperature and the error against the closed form.
program heat
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit, real64
  use heat_case, only: initial_heat, largest_error
  use heat_solver, only: heat_type, nhalo
  implicit none

  integer, parameter :: report_every = 10
  type(heat_type) :: model
  real(real64) :: dt
  integer :: cycle, cycles, resolution

  cycles = integer_argument(1, 100)
  resolution = integer_argument(2, 12)
  if (cycles < 0 .or. resolution < 3) then
    write (error_unit, '(a)') 'usage: heat [cycles >= 0 [resolution >= 3]]'
    error stop 2
  end if

  call initial_heat(resolution, model)
  dt = model%stable_step()
  write (output_unit, '(a, i0, a, i0, a)') 'heat: ', model%mesh%ncells(), ' wedges in ', &
      model%mesh%nlevels, ' levels'
  call report(0)
  do cycle = 1, cycles
    call model%step(dt)
    if (modulo(cycle, report_every) == 0 .or. cycle == cycles) call report(cycle)
  end do

contains

  subroutine report(cycle)
    integer, intent(in) :: cycle
    associate (t => model%t(:, 1 + nhalo:model%mesh%nlevels + nhalo))
      write (output_unit, '(a, i6, a, es12.5, a, es20.13, 2(a, f9.6), a, es9.2)') 'cycle ', cycle, &
          '  time ', model%time, '  energy ', model%energy(), '  temperature ', minval(t), ' to ', &
          maxval(t), '  error ', largest_error(model)
    end associate
  end subroutine report

  integer function integer_argument(position, default) result(value)
    integer, intent(in) :: position, default
    character(len=32) :: text
    integer :: status

    value = default
    if (command_argument_count() < position) return
    call get_command_argument(position, text)
    read (text, *, iostat=status) value
    if (status /= 0) value = -1
  end function integer_argument

end program heat
