!> The wind-driven circulation of an ocean basin on the sphere, from rest: a miniapp in Fortran,
!! coupled. It prints the day, the gyres' transport, the fastest current, what is lost of water and
!! heat, and at the end where the time went. The solver runs on when the library cannot. On several
!! processes (mpirun -n 4 gyre ...) the first one alone prints.
program gyre
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit, real64
  use gyre_basin, only: atlantic
  use gyre_coupling, only: coupling_type
  use gyre_model, only: model_type
  use solver_processes, only: processes_type
  implicit none

  integer, parameter :: text_length = 1024, report_every = 10

  type :: options_type
    integer :: cycles = 120, resolution = 16, library_threads = 0
    character(len=text_length) :: scene = '', output = ''
    logical :: quiet = .false.
  end type options_type

  type(options_type) :: options
  type(processes_type) :: processes
  type(model_type), target :: model
  type(coupling_type) :: coupling
  real(real64) :: solver_s
  integer(int64) :: begin
  integer :: cycle

  call processes%launch()
  call read_options(options)
  call model%start(atlantic(), options%resolution, processes)
  if (processes%is_root()) write (output_unit, '(2(a, i0), a)') 'gyre: ', &
      model%mesh%ncolumns * model%mesh%nlevels, ' wedges in ', model%mesh%nlevels, ' levels'

  call coupling%begin(model, options%scene, options%output, options%library_threads)
  call coupling%show(0, model%time)
  solver_s = 0.0_real64
  call print_day(0)
  do cycle = 1, options%cycles
    begin = ticks()
    call model%advance()
    solver_s = solver_s + seconds_since(begin)
    call coupling%show(cycle, model%time)
    if (modulo(cycle, report_every) == 0 .or. cycle == options%cycles) call print_day(cycle)
  end do
  call print_end()
  if (coupling%works) call coupling%finish(options%output, solver_s)
  call processes%finish()

contains

  subroutine print_day(cycle)
    integer, intent(in) :: cycle
    real(real64), parameter :: sverdrup = 1.0e6_real64
    real(real64) :: current, coldest, warmest, water, heat
    if (options%quiet) return
    current = processes%largest(maxval(norm2(model%flow%velocity, dim=1)))
    associate (t => model%heat%t(model%mesh%first_column:model%mesh%last_column, 1:model%mesh%nlevels))
      coldest = -processes%largest(-minval(t))
      warmest = processes%largest(maxval(t))
    end associate
    water = model%flow%imbalance(model%mesh)
    heat = model%heat_error()
    associate (psi => model%transport%psi)
      if (processes%is_root()) write (output_unit, '(a, i4, 2(a, f6.1), a, f6.3, 2(a, f6.2), 2(a, es8.1))') &
          'day ', cycle, '  transport ', minval(psi) / sverdrup, ' to ', maxval(psi) / sverdrup, ' Sv  current ', &
          current, ' m/s  temperature ', coldest, ' to ', warmest, '  lost: water ', water, ' heat ', heat
    end associate
  end subroutine print_day

  subroutine print_end()
    real(real64) :: water, heat
    water = model%flow%imbalance(model%mesh)
    heat = model%heat_error()
    if (processes%is_root()) write (output_unit, '(a, i0, a, f7.3, 2(a, es8.1))') 'gyre: ', options%cycles, &
        ' days, solver ', solver_s, ' s, lost: water ', water, ', heat ', heat
  end subroutine print_end

  subroutine read_options(options)
    type(options_type), intent(out) :: options
    character(len=text_length) :: option, value
    integer :: i

    i = 1
    do while (i <= command_argument_count())
      call get_command_argument(i, option)
      call get_command_argument(i + 1, value)
      i = i + 2
      select case (option)
      case ('--cycles')
        options%cycles = whole_number(option, value, 0)
      case ('--resolution')
        options%resolution = whole_number(option, value, 2)
      case ('--library-threads')
        options%library_threads = whole_number(option, value, 0)
      case ('--scene')
        options%scene = value
      case ('--output')
        options%output = value
      case ('--quiet')
        options%quiet = .true.
        i = i - 1
      case default
        call stop_with_usage(trim(option) // ': no such option')
      end select
    end do
  end subroutine read_options

  integer function whole_number(option, value, lowest) result(number)
    character(len=*), intent(in) :: option, value
    integer, intent(in) :: lowest
    integer :: status

    read (value, '(i32)', iostat=status) number
    if (status /= 0 .or. value == '') number = lowest - 1
    if (number < lowest) call stop_with_usage(trim(option) // ': ''' // trim(value) // &
                                              ''' is not a whole number in range')
  end function whole_number

  subroutine stop_with_usage(what)
    character(len=*), intent(in) :: what
    if (processes%is_root()) write (error_unit, '(a)') &
        'gyre: ' // what, 'usage: gyre [options], or mpirun -n PROCESSES gyre [options]', &
        '  --cycles N           days (120)', &
        '  --resolution N       a quarter of the cells from west to east, a third of those from', &
        '                       south to north, at least 2 (16)', &
        '  --scene FILE         what libinsitu does with the run (nothing)', &
        '  --output DIR         where it writes, instead of the scene''s folder', &
        '  --library-threads N  threads of libinsitu (all)', &
        '  --quiet              no line per day'
    call processes%finish()
    stop 1
  end subroutine stop_with_usage

  integer(int64) function ticks()
    call system_clock(ticks)
  end function ticks

  real(real64) function seconds_since(begin)
    integer(int64), intent(in) :: begin
    integer(int64) :: now, rate
    call system_clock(now, rate)
    seconds_since = real(now - begin, real64) / real(rate, real64)
  end function seconds_since

end program gyre
