!> A host with its own floating-point environment: traps on invalid, zero and overflow, denormals
!! flushed, rounding downwards. The library must neither trap nor change it, and must answer bit for bit
!! as it does for a host with the default one; and so on every SIMD target that it can dispatch to.
!!
!!   float_environment_test [trap | flush]
!!
!! says what the compiler's options should have set when the program starts.
program float_environment_test
  use, intrinsic :: ieee_arithmetic
  use, intrinsic :: ieee_exceptions
  use, intrinsic :: iso_c_binding, only: c_char, c_int
  use, intrinsic :: iso_fortran_env, only: int32, int64, real64
  use checks
  use insitu
  implicit none

  !> Centres of cells, vertices (each on up to eight cells), and some that are no place in the mesh;
  !! again and again, so that worker threads get their share and packs every alignment.
  integer, parameter :: places = box_cells + box_vertices + 4
  integer, parameter :: points_asked = 151 * places
  type(ieee_flag_type), parameter :: trapped(3) = [ieee_invalid, ieee_divide_by_zero, ieee_overflow]

  type :: environment_type
    logical :: halting(3) = .false., flags(3) = .false., gradual = .true., flushes_inputs = .false.
    type(ieee_round_type) :: rounding
  end type environment_type

  type :: answers_type
    integer(int64), allocatable :: cells(:)
    integer, allocatable :: reasons(:)
    integer(int64), allocatable :: parametric(:), values(:)    ! as bits
  end type answers_type

  interface
    !> How many SIMD targets this machine has; `use_simd_target` takes their numbers from 0, and 0 is
    !! the one that the library chooses by itself.
    function simd_targets() bind(c) result(count)
      import :: c_int
      integer(c_int) :: count
    end function simd_targets
    subroutine use_simd_target(number, name) bind(c)
      import :: c_char, c_int
      integer(c_int), value :: number
      character(kind=c_char), intent(out) :: name(16)
    end subroutine use_simd_target
  end interface

  real(real64), target :: xyz(3, box_vertices), f(box_vertices), tiny_field(box_vertices)
  integer(int32), target :: connectivity(8, box_cells)
  real(real64) :: points(3, points_asked)
  type(environment_type) :: start
  type(answers_type) :: as_started, usual, odd, on_target
  character(kind=c_char) :: name(16)
  logical :: underflow_control
  character(len=8) :: expected
  integer :: i

  underflow_control = ieee_support_underflow_control(f(1))
  start = environment()
  call get_command_argument(1, expected)
  if (expected == 'trap') call expect('started with traps', all(start%halting))
  if (expected == 'flush') call expect('started flushing', start%flushes_inputs)
  connectivity = box_hexahedra()
  call fill()
  call ieee_set_flag(ieee_all, .false.)
  as_started = answers('as started')
  call set_usual_environment()
  usual = answers('usual')
  call set_odd_environment()
  odd = answers('odd')
  call set_usual_environment()
  call expect_same('as started', as_started, usual)
  call expect_same('odd', odd, usual)
  do i = 1, simd_targets() - 1
    call use_simd_target(int(i, c_int), name)
    if (expected == 'trap') call ieee_set_halting_mode(trapped, .true.)
    on_target = answers(name_of(name))
    call set_odd_environment()
    odd = answers(name_of(name) // ', odd')
    call set_usual_environment()
    call expect_same(name_of(name), on_target, usual)
    call expect_same(name_of(name) // ', odd', odd, usual)
  end do
  call expect('cells of points inside', &
              all(usual%cells(:box_cells) == [(int(i, int64), i=1, box_cells)]))
  call expect('cells of vertices', all(usual%cells(box_cells + 1:places - 4) > 0) .and. &
              all(usual%reasons(box_cells + 1:places - 4) == insitu_reason_on_vertex))
  call expect('no cells of points outside', all(usual%cells(places - 3:places) == 0))
  call expect('denormal values come through', all(usual%values(:box_cells) > 0_int64 .and. &
                                                  usual%values(:box_cells) < 2_int64**52))
  call finish_checks()

contains

  function name_of(name) result(text)
    character(kind=c_char), intent(in) :: name(16)
    character(len=:), allocatable :: text
    integer :: k
    text = ''
    do k = 1, size(name)
      if (name(k) /= ' ') text = text // name(k)
    end do
  end function name_of

  subroutine set_usual_environment()
    call ieee_set_halting_mode(trapped, .false.)
    call ieee_set_rounding_mode(ieee_nearest)
    if (underflow_control) call ieee_set_underflow_mode(gradual=.true.)
  end subroutine set_usual_environment

  subroutine set_odd_environment()
    if (underflow_control) call ieee_set_underflow_mode(gradual=.false.)
    call ieee_set_rounding_mode(ieee_down)
    call ieee_set_flag(ieee_all, .false.)
    call ieee_set_halting_mode(trapped, .true.)
  end subroutine set_odd_environment

  !> A curved box; a field of denormals; query points inside, outside, far away, infinite and NaN.
  subroutine fill()
    real(real64) :: nan, infinity

    nan = ieee_value(nan, ieee_quiet_nan)
    infinity = ieee_value(infinity, ieee_positive_inf)
    xyz = box_points()
    xyz(2, :) = xyz(2, :) + 0.1_real64 * sin(xyz(1, :) * xyz(3, :))
    f = linear(xyz)
    tiny_field = transfer([(1000000_int64 * i, i=1, box_vertices)], tiny_field)
    do i = 1, box_cells
      points(:, i) = sum(xyz(:, connectivity(:, i)), dim=2) / 8.0_real64
    end do
    points(:, box_cells + 1:places - 4) = xyz
    points(:, places - 3) = [-1.0_real64, 0.0_real64, 0.0_real64]
    points(:, places - 2) = [1.0e300_real64, -1.0e300_real64, 1.0e300_real64]
    points(:, places - 1) = [0.5_real64, infinity, 0.5_real64]
    points(:, places) = [nan, 0.5_real64, 0.5_real64]
    do i = places + 1, points_asked
      points(:, i) = points(:, i - places)
    end do
  end subroutine fill

  !> The same calls in whatever environment holds; each must leave it as it was.
  function answers(what) result(all_of)
    character(len=*), intent(in) :: what
    type(answers_type) :: all_of
    type(environment_type) :: before
    type(insitu_session) :: session
    type(insitu_mesh) :: mesh
    real(real64), allocatable :: parametric(:,:), values(:)
    real(real64) :: at_one(1)
    integer(int64), allocatable :: standard(:)
    integer :: ierr

    allocate (standard(points_asked))
    allocate (all_of%cells(points_asked), all_of%reasons(points_asked))
    allocate (parametric(3, points_asked), values(points_asked))
    before = environment()
    call session%open(ierr=ierr, threads=2, output='float_environment_out', scene_text= &
        'insitu: 1' // new_line('a') // 'probes: [{name: gauge, points: [[0.5, 0.3, 1.0], ' // &
        '[9, 9, 9]], fields: [f, tiny]}]' // new_line('a'))
    call expect_ok(what // ': open', session, ierr)
    call session%mesh('box', mesh, ierr)
    call mesh%points(xyz, ierr)
    call mesh%hexahedra(connectivity, ierr)
    call mesh%vertex_field('f', f, ierr)
    call mesh%vertex_field('tiny', tiny_field, ierr)
    call mesh%commit(ierr)
    call expect_ok(what // ': commit', session, ierr)
    call expect_kept(what // ', commit', before)
    call mesh%locate(points, all_of%cells, ierr, parametric=parametric, &
                     accuracy=insitu_exact, reasons=all_of%reasons)
    call expect_ok(what // ': locate', session, ierr)
    call expect_kept(what // ', locate', before)
    call mesh%locate(points, standard, ierr)
    call expect(what // ': standard is exact', ierr == insitu_ok .and. all(standard == all_of%cells))
    call expect_kept(what // ', locate in standard', before)
    call mesh%sample('tiny', points, values, ierr)
    call expect_ok(what // ': sample', session, ierr)
    call expect_kept(what // ', sample', before)
    call mesh%sample_point('f', points(:, places), at_one, ierr)
    call expect_ok(what // ': sample_point', session, ierr)
    call expect_kept(what // ', sample_point', before)
    call session%execute(1, 0.0_real64, ierr)
    call expect_ok(what // ': execute', session, ierr)
    call expect_kept(what // ', execute', before)
    call mesh%vertex_field('f', f(2:), ierr)
    call mesh%commit(ierr)
    call expect(what // ': a refused commit', ierr == insitu_error_field)
    call expect_kept(what // ', an error', before)
    call session%close(ierr)
    call expect_kept(what // ', close', before)
    all_of%parametric = transfer(parametric, [0_int64])
    all_of%values = transfer(values, [0_int64])
  end function answers

  function environment() result(now)
    type(environment_type) :: now
    real(real64), volatile :: denormal
    real(real64), parameter :: large = 2.0_real64**1000

    call ieee_get_halting_mode(trapped, now%halting)
    call ieee_get_flag(trapped, now%flags)
    call ieee_get_rounding_mode(now%rounding)
    if (underflow_control) call ieee_get_underflow_mode(now%gradual)
    denormal = transfer(1_int64, denormal)
    denormal = denormal * large
    now%flushes_inputs = transfer(denormal, 0_int64) == 0_int64
  end function environment

  subroutine expect_kept(what, before)
    character(len=*), intent(in) :: what
    type(environment_type), intent(in) :: before
    type(environment_type) :: now

    now = environment()
    call expect(what // ': traps', all(now%halting .eqv. before%halting))
    call expect(what // ': flags', all(now%flags .eqv. before%flags))
    call expect(what // ': rounding', now%rounding == before%rounding)
    call expect(what // ': underflow mode', now%gradual .eqv. before%gradual)
    call expect(what // ': denormal inputs', now%flushes_inputs .eqv. before%flushes_inputs)
  end subroutine expect_kept

  subroutine expect_same(what, found, expected)
    character(len=*), intent(in) :: what
    type(answers_type), intent(in) :: found, expected
    call expect(what // ': cells', all(found%cells == expected%cells))
    call expect(what // ': reasons', all(found%reasons == expected%reasons))
    call expect(what // ': parametric coordinates', all(found%parametric == expected%parametric))
    call expect(what // ': values', all(found%values == expected%values))
  end subroutine expect_same

end program float_environment_test
