!> Self-check of the heat example: geometry, conservation, and convergence to the closed form.
program heat_check
  use, intrinsic :: iso_fortran_env, only: error_unit, int32, output_unit, real64
  use heat_case, only: flux_error, height, initial_heat, inner, largest_error, outer
  use heat_mesh, only: mesh_type, wedge_volume
  use heat_solver, only: heat_type, nhalo
  implicit none

  real(real64), parameter :: pi = acos(-1.0_real64)
  integer :: failures = 0

  call check_mesh(9)
  call check_energy(9)
  call check_convergence(12, 24)
  if (failures > 0) error stop 1

contains

  !> Volumes are positive by VTK's rule and fill the polygonal ring; ids fit the arrays.
  subroutine check_mesh(resolution)
    integer, intent(in) :: resolution
    type(heat_type) :: model
    real(real64), allocatable :: volume(:)
    real(real64) :: ring, unit_wedge(3, 6)
    integer :: sides, i

    ! (0,1,2) in VTK's order, seen from outside, turns counter-clockwise: here it is the top.
    unit_wedge(:, 1:3) = reshape([0, 0, 1, 1, 0, 1, 0, 1, 1], [3, 3])
    unit_wedge(:, 4:6) = unit_wedge(:, 1:3)
    unit_wedge(3, 4:6) = 0.0_real64
    call expect_near('unit wedge', wedge_volume(unit_wedge), 0.5_real64, 1.0e-15_real64)
    call expect_near('unit wedge upside down', wedge_volume(unit_wedge(:, [4, 5, 6, 1, 2, 3])), &
                     -0.5_real64, 1.0e-15_real64)

    call initial_heat(resolution, model)
    associate (mesh => model%mesh)
      allocate (volume(mesh%ncells()))
      do i = 1, mesh%ncells()
        volume(i) = wedge_volume(corners(mesh, mesh%connectivity(:, i)))
      end do
      sides = mesh%nv / (resolution + 1)
      ring = 0.5_real64 * real(sides, real64) * sin(2.0_real64 * pi / real(sides, real64)) &
           * (outer**2 - inner**2) * height
      call expect('smallest volume is positive', minval(volume) > 0.0_real64)
      call expect_near('volume of the ring', sum(volume), ring, 1.0e-12_real64 * ring)
      call expect('ids start at 1', minval(mesh%connectivity) == 1_int32)
      call expect('ids end at the last vertex', maxval(mesh%connectivity) == size(mesh%x))
      call expect('Euler''s formula of a ring', &
                  mesh%nv - (size(mesh%edge_vertices, 2) + 2 * sides) + mesh%ncolumns == 0)
    end associate
  end subroutine check_mesh

  pure function corners(mesh, ids) result(p)
    type(mesh_type), intent(in) :: mesh
    integer(int32), intent(in) :: ids(6)
    real(real64) :: p(3, 6)
    p(1, :) = mesh%x(ids)
    p(2, :) = mesh%y(ids)
    p(3, :) = mesh%z(ids)
  end function corners

  !> Insulated: energy stays, to rounding, while the temperature evens out; ghosts mirror the wall.
  subroutine check_energy(resolution)
    integer, intent(in) :: resolution
    integer, parameter :: cycles = 200
    type(heat_type) :: model
    real(real64) :: before, dt, range
    integer :: i

    call initial_heat(resolution, model)
    before = model%energy()
    range = spread_of(model)
    dt = model%stable_step()
    do i = 1, cycles
      call model%step(dt)
    end do
    call expect_near('energy', model%energy(), before, 1.0e-13_real64 * before)
    call expect('temperature evens out', spread_of(model) < 0.5_real64 * range)
    call expect('lower ghost level', all(same(model%t(:, 1), model%t(:, 1 + nhalo))))
    call expect('upper ghost level', all(same(model%t(:, ubound(model%t, 2)), &
                                              model%t(:, model%mesh%nlevels + nhalo))))
  end subroutine check_energy

  elemental logical function same(a, b)
    real(real64), intent(in) :: a, b
    same = .not. abs(a - b) > 0.0_real64
  end function same

  pure real(real64) function spread_of(model)
    type(heat_type), intent(in) :: model
    spread_of = maxval(model%t) - minval(model%t)
  end function spread_of

  !> Temperature converges with order two. The flux at vertices with order one at least: at walls the
  !! plane is one-sided.
  subroutine check_convergence(coarse, fine)
    integer, intent(in) :: coarse, fine
    real(real64) :: at_coarse(2), at_fine(2), order(2)

    at_coarse = errors(coarse)
    at_fine = errors(fine)
    order = log(at_coarse / at_fine) / log(real(fine, real64) / real(coarse, real64))
    write (output_unit, '(a, 2es10.2, a, f5.2)') 'temperature error', at_coarse(1), at_fine(1), &
        '  order', order(1)
    write (output_unit, '(a, 2es10.2, a, f5.2)') 'flux error       ', at_coarse(2), at_fine(2), &
        '  order', order(2)
    call expect('order of the temperature is two', order(1) > 1.8_real64 .and. order(1) < 2.5_real64)
    call expect('order of the flux is one or more', order(2) > 0.9_real64)
    call expect('error of the temperature', at_fine(1) < 5.0e-3_real64)
  end subroutine check_convergence

  !> Of temperature and flux when the mode has decayed to a third or so.
  function errors(resolution)
    integer, intent(in) :: resolution
    real(real64) :: errors(2)
    real(real64), parameter :: end_time = 0.25_real64
    type(heat_type) :: model
    integer :: i, cycles

    call initial_heat(resolution, model)
    cycles = ceiling(end_time / model%stable_step())
    do i = 1, cycles
      call model%step(end_time / real(cycles, real64))
    end do
    call model%update_flux()
    errors = [largest_error(model), flux_error(model)]
  end function errors

  subroutine expect_near(what, found, expected, tolerance)
    character(len=*), intent(in) :: what
    real(real64), intent(in) :: found, expected, tolerance
    call expect(what, abs(found - expected) <= tolerance)
    if (abs(found - expected) > tolerance) then
      write (error_unit, '(2(a, es24.16))') '  expected', expected, ', found', found
    end if
  end subroutine expect_near

  subroutine expect(what, holds)
    character(len=*), intent(in) :: what
    logical, intent(in) :: holds
    if (holds) return
    failures = failures + 1
    write (error_unit, '(2a)') 'failed: ', what
  end subroutine expect

end program heat_check
