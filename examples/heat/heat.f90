!> Heat in an insulated ring, a decaying mode on a mesh of wedges: the Fortran miniapp, coupled. It
!! prints cycle, time, energy, the extremes of the temperature and the error against the closed form,
!! and at the end where the time went. The solver runs on when the library cannot. On several processes
!! (mpirun -n 4 heat ...) the first one alone prints.
program heat
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit, real64
  use heat_case, only: initial_heat, largest_error
  use heat_coupling, only: couple
  use solver_processes, only: processes_type
  use heat_solver, only: heat_type, nhalo
  use insitu
  implicit none

  integer, parameter :: text_length = 1024, report_every = 10

  type :: options_type
    integer :: cycles = 200, resolution = 16, library_threads = 0
    character(len=text_length) :: scene = '', output = ''
    logical :: quiet = .false.
  end type options_type

  type(options_type) :: options
  type(processes_type) :: processes
  type(heat_type), target :: model
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  real(real64) :: dt, solver_s, energy
  integer(int64) :: begin
  integer :: cycle, ierr
  logical :: coupled

  call processes%launch()
  call read_options(options)
  call initial_heat(options%resolution, model, processes)
  dt = model%stable_step()
  energy = model%energy()
  if (processes%is_root()) write (output_unit, '(2(a, i0), a)') 'heat: ', &
      model%mesh%ncolumns * model%mesh%all_levels, ' wedges in ', model%mesh%all_levels, ' levels'

  call session%open(scene=options%scene, output=options%output, threads=options%library_threads, &
                    communicator=processes%communicator, ierr=ierr)
  if (ierr == insitu_ok) call couple(session, model, mesh, ierr)
  coupled = ierr == insitu_ok
  if (.not. coupled) call complain('not coupled')
  call execute(0)
  solver_s = 0.0_real64
  call print_cycle(0)
  do cycle = 1, options%cycles
    begin = ticks()
    call model%step(dt)
    call model%update_flux()
    solver_s = solver_s + seconds_since(begin)
    call execute(cycle)
    if (modulo(cycle, report_every) == 0 .or. cycle == options%cycles) call print_cycle(cycle)
  end do
  call print_summary()
  call session%close(ierr)
  if (ierr /= insitu_ok) call complain('close')
  call processes%finish()

contains

  !> What the scene asks for at this cycle; a part that fails is skipped and told.
  subroutine execute(cycle)
    integer, intent(in) :: cycle
    if (.not. coupled) return
    call mesh%changed(insitu_fields)
    call session%execute(cycle, model%time, ierr)
    if (ierr /= insitu_ok .and. ierr /= insitu_error_action) call complain('execute')
  end subroutine execute

  subroutine complain(what)
    character(len=*), intent(in) :: what
    if (processes%is_root()) write (error_unit, '(6a)') 'heat: ', what, ': ', insitu_status_name(ierr), ': ', session%message()
  end subroutine complain

  subroutine print_cycle(cycle)
    integer, intent(in) :: cycle
    real(real64) :: drift, coldest, warmest, error
    if (options%quiet) return
    drift = model%energy() / energy - 1.0_real64
    associate (t => model%t(:, 1 + nhalo:model%mesh%nlevels + nhalo))
      coldest = -processes%largest(-minval(t))
      warmest = processes%largest(maxval(t))
    end associate
    error = largest_error(model)
    if (processes%is_root()) write (output_unit, '(a, i6, a, es12.5, a, es8.1, 2(a, f9.6), a, es9.2)') &
        'cycle ', cycle, '  time ', model%time, '  drift ', drift, '  temperature ', coldest, ' to ', &
        warmest, '  error ', error
  end subroutine print_cycle

  subroutine print_summary()
    real(real64) :: drift, error

    drift = model%energy() / energy - 1.0_real64
    error = largest_error(model)
    if (processes%is_root()) write (output_unit, '(a, i0, a, f7.3, a, es8.1, a, es9.2)') 'heat: ', &
        options%cycles, ' cycles, solver ', solver_s, ' s, energy drift ', drift, ', error ', error
    if (.not. coupled) return
    if (processes%is_root()) call print_report()
    if (options%output /= '') then
      call session%write_summary(trim(options%output) // '/summary.json', ierr, solver_s=solver_s)
      if (ierr /= insitu_ok) call complain('summary')
    end if
  end subroutine print_summary

  !> Of this process.
  subroutine print_report()
    type(insitu_report) :: report

    call session%report(report, ierr)
    write (output_unit, '(5(a, f7.3), a)') 'library: commit ', report%commit_s, ' s, query ', &
        report%query_s, ' s, advect ', report%advect_s, ' s, render ', report%render_s, &
        ' s, output ', report%output_s, ' s'
    write (output_unit, '(2(a, f7.2), a)') 'bytes: ', 1.0e-6 * real(report%bytes_borrowed), &
        ' MB of the solver''s read in place, ', 1.0e-6 * real(report%bytes_held), ' MB held'
    write (output_unit, '(4(i0, a))') report%frames, ' frames, ', report%probe_rows, &
        ' probe rows, ', report%files, ' files, ', report%failures, ' failures'
  end subroutine print_report

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
        options%resolution = whole_number(option, value, 3)
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
    write (error_unit, '(a)') 'heat: ' // what, 'usage: heat [options]', &
        '  --cycles N           time steps (200)', &
        '  --resolution N       cells across the ring, at least 3 (16)', &
        '  --scene FILE         what libinsitu does with the run (nothing)', &
        '  --output DIR         where it writes, instead of the scene''s folder', &
        '  --library-threads N  threads of libinsitu (all)', &
        '  --quiet              no line per cycle'
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

end program heat
