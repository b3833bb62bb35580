!> The example's case: a twisted ring with a mode of heat on top of an even temperature.
module heat_case
  use, intrinsic :: iso_fortran_env, only: real64
  use heat_mesh, only: mesh_type, ring_mesh
  use heat_mode, only: mode_type
  use solver_processes, only: processes_type
  use heat_solver, only: heat_type, nhalo
  implicit none
  private

  public :: initial_heat, largest_error, flux_error

  real(real64), parameter, public :: inner = 1.0_real64, outer = 2.0_real64, height = 0.5_real64
  real(real64), parameter :: twist = 0.6_real64
  real(real64), parameter :: even = 1.0_real64           !< mean temperature
  real(real64), parameter :: swing = 0.5_real64          !< largest deviation from it
  real(real64), parameter :: diffusivity = 0.1_real64
  integer, parameter :: angular_per_radial = 8           !< squares at mid-ring: about 3 pi

contains

  !> The ring with `resolution` cells across, and half as many levels, at time 0; of several processes,
  !! those of this one.
  subroutine initial_heat(resolution, model, processes)
    integer, intent(in) :: resolution
    type(heat_type), intent(out) :: model
    type(processes_type), intent(in), optional :: processes
    type(processes_type) :: among
    type(mesh_type) :: mesh

    if (present(processes)) among = processes
    mesh = ring_mesh(inner, outer, height, resolution, angular_per_radial * resolution, &
                     (resolution + 1) / 2, twist, among)
    call model%start(mesh, exact(mesh, 0.0_real64), diffusivity)
  end subroutine initial_heat

  !> Closed form at the cells' middles.
  function exact(mesh, time) result(t)
    type(mesh_type), intent(in) :: mesh
    real(real64), intent(in) :: time
    real(real64) :: t(mesh%ncolumns, mesh%nlevels)
    type(mode_type) :: mode
    integer :: k

    mode = mode_type(inner, outer, height)
    do k = 1, mesh%nlevels
      t(:, k) = even + swing * mode%value(mesh%centre(1, :), mesh%centre(2, :), mesh%level_z(k + mesh%below), &
                                          diffusivity, time)
    end do
  end function exact

  !> Largest difference from the closed form at the cells' middles, of all processes.
  real(real64) function largest_error(model)
    type(heat_type), intent(in) :: model
    largest_error = model%mesh%processes%largest(maxval(abs( &
        model%t(:, 1 + nhalo:model%mesh%nlevels + nhalo) - exact(model%mesh, model%time))))
  end function largest_error

  !> Largest difference of the vertices' flux from the closed form's, by central differences.
  real(real64) function flux_error(model)
    type(heat_type), intent(in) :: model
    real(real64), parameter :: h = 1.0e-5_real64
    type(mode_type) :: mode
    real(real64) :: slope(3, size(model%mesh%x)), shift(3)
    integer :: i

    mode = mode_type(inner, outer, height)
    associate (x => model%mesh%x, y => model%mesh%y, z => model%mesh%z, time => model%time)
      do i = 1, 3
        shift = 0.0_real64
        shift(i) = h
        slope(i, :) = swing / (2.0_real64 * h) &
            * (mode%value(x + shift(1), y + shift(2), z + shift(3), diffusivity, time) &
             - mode%value(x - shift(1), y - shift(2), z - shift(3), diffusivity, time))
      end do
    end associate
    flux_error = maxval(norm2(model%flux + diffusivity * slope, dim=1))
  end function flux_error

end module heat_case
