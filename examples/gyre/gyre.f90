!> The wind-driven circulation of an ocean basin on the sphere, from rest: a miniapp in Fortran,
!! coupled. It prints the day, the gyres' transport, the fastest current, what is lost of water and
!! heat, and at the end where the time went. The solver runs on when the library cannot.
program gyre
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit, real64
  use gyre_basin, only: atlantic
  use gyre_coupling, only: couple, show
  use gyre_model, only: model_type
  use insitu
  implicit none

  integer, parameter :: text_length = 1024, report_every = 10

  type :: options_type
    integer :: cycles = 120, resolution = 16, library_threads = 0
    character(len=text_length) :: scene = '', output = ''
    logical :: quiet = .false.
  end type options_type

  type(options_type) :: options
  type(model_type), target :: model
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  real(real64) :: solver_s
  integer(int64) :: begin
  integer :: cycle, ierr
  logical :: coupled

  call read_options(options)
  call model%start(atlantic(), options%resolution)
  write (output_unit, '(2(a, i0), a)') 'gyre: ', model%mesh%ncells(), ' wedges in ', &
      model%mesh%nlevels, ' levels'

  call session%open(scene=options%scene, output=options%output, threads=options%library_threads, &
                    ierr=ierr)
  if (ierr == insitu_ok) call couple(session, model, mesh, ierr)
  coupled = ierr == insitu_ok
  if (.not. coupled) call complain('not coupled')
  call execute(0)
  solver_s = 0.0_real64
  call print_day(0)
  do cycle = 1, options%cycles
    begin = ticks()
    call model%advance()
    solver_s = solver_s + seconds_since(begin)
    call execute(cycle)
    if (modulo(cycle, report_every) == 0 .or. cycle == options%cycles) call print_day(cycle)
  end do
  call print_summary()
  call session%close(ierr)
  if (ierr /= insitu_ok) call complain('close')

contains

  !> A part that fails is skipped and told.
  subroutine execute(cycle)
    integer, intent(in) :: cycle
    if (.not. coupled) return
    call show(session, mesh, cycle, model%time, ierr)
    if (ierr /= insitu_ok .and. ierr /= insitu_error_action) call complain('execute')
  end subroutine execute

  subroutine complain(what)
    character(len=*), intent(in) :: what
    write (error_unit, '(6a)') 'gyre: ', what, ': ', insitu_status_name(ierr), ': ', session%message()
  end subroutine complain

  subroutine print_day(cycle)
    integer, intent(in) :: cycle
    real(real64), parameter :: sverdrup = 1.0e6_real64
    if (options%quiet) return
    associate (psi => model%transport%psi, t => model%heat%t(:, 1:model%mesh%nlevels))
      write (output_unit, '(a, i4, 2(a, f6.1), a, f6.3, 2(a, f6.2), 2(a, es8.1))') 'day ', cycle, &
          '  transport ', minval(psi) / sverdrup, ' to ', maxval(psi) / sverdrup, ' Sv  current ', &
          maxval(norm2(model%flow%velocity, dim=1)), ' m/s  temperature ', minval(t), ' to ', &
          maxval(t), '  lost: water ', model%flow%imbalance(), ' heat ', model%heat_error()
    end associate
  end subroutine print_day

  subroutine print_summary()
    type(insitu_report) :: report

    write (output_unit, '(a, i0, a, f7.3, 2(a, es8.1))') 'gyre: ', options%cycles, &
        ' days, solver ', solver_s, ' s, lost: water ', model%flow%imbalance(), ', heat ', &
        model%heat_error()
    if (.not. coupled) return
    call session%report(report, ierr)
    write (output_unit, '(5(a, f7.3), a)') 'library: commit ', report%commit_s, ' s, query ', &
        report%query_s, ' s, advect ', report%advect_s, ' s, render ', report%render_s, &
        ' s, output ', report%output_s, ' s'
    write (output_unit, '(3(a, f7.2), a)') 'bytes: ', 1.0e-6 * real(report%bytes_borrowed), &
        ' MB of the solver''s read in place, ', 1.0e-6 * real(report%bytes_held), ' MB held, ', &
        1.0e-6 * real(report%bytes_by_purpose(insitu_memory_geocentric)), &
        ' MB of them vertices drawn geocentric'
    write (output_unit, '(4(i0, a))') report%frames, ' frames, ', report%probe_rows, &
        ' probe rows, ', report%files, ' files, ', report%failures, ' failures'
    if (options%output /= '') then
      call session%write_summary(trim(options%output) // '/summary.json', ierr, solver_s=solver_s)
      if (ierr /= insitu_ok) call complain('summary')
    end if
  end subroutine print_summary

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
    write (error_unit, '(a)') 'gyre: ' // what, 'usage: gyre [options]', &
        '  --cycles N           days (120)', &
        '  --resolution N       a quarter of the cells from west to east, a third of those from', &
        '                       south to north, at least 2 (16)', &
        '  --scene FILE         what libinsitu does with the run (nothing)', &
        '  --output DIR         where it writes, instead of the scene''s folder', &
        '  --library-threads N  threads of libinsitu (all)', &
        '  --quiet              no line per day'
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
