!> A solver with halos around its arrays, whose loops run in OpenMP's threads. The library reads the inner part of each
!! array where it is, and has threads of its own; it is called outside of parallel regions.
module advection
  use, intrinsic :: iso_fortran_env, only: real64
  implicit none
  private

  public :: set_up, step

  integer, parameter, public :: n = 16, halo = 2         ! cells along each axis, halo layers on each side
  real(real64), parameter, public :: h = 1.0_real64 / n, dt = 0.25_real64 * h
  real(real64), parameter :: wind = 1.0_real64
  ! Variables of a module keep their place, and with target may be given in sections.
  real(real64), allocatable, target, public :: q(:, :, :)
  real(real64), allocatable :: flux(:, :, :)

contains

  subroutine set_up()
    integer :: i

    allocate (q(1 - halo:n + halo, 1 - halo:n + halo, 1 - halo:n + halo), flux(0:n, n, n))
    q = -999.0_real64                                    ! what halos hold is no value
    do i = 1, n
      q(i, 1:n, 1:n) = merge(1.0_real64, 0.0_real64, i <= n / 4)
    end do
  end subroutine set_up

  !> Upwind along x, periodic.
  subroutine step()
    integer :: i, j, k

    q(0, :, :) = q(n, :, :)
    !$omp parallel do collapse(2) schedule(static)
    do k = 1, n
      do j = 1, n
        do i = 0, n
          flux(i, j, k) = wind * q(i, j, k)
        end do
      end do
    end do
    !$omp end parallel do
    !$omp parallel do collapse(2) schedule(static)
    do k = 1, n
      do j = 1, n
        do i = 1, n
          q(i, j, k) = q(i, j, k) - dt / h * (flux(i, j, k) - flux(i - 1, j, k))
        end do
      end do
    end do
    !$omp end parallel do
  end subroutine step

end module advection

!> All that knows of the library.
module coupling
  use, intrinsic :: iso_fortran_env, only: real64
  use insitu
  implicit none
  private

  public :: couple

contains

  !> Gives a field's inner part. The dummy is of assumed shape and a target, so the section arrives by its descriptor;
  !! inner(n, n, n) or a contiguous dummy would get a temporary copy, whose memory is gone at the end of the call.
  subroutine couple(mesh, inner, spacing, ierr)
    type(insitu_mesh), intent(in) :: mesh
    real(real64), intent(in), target :: inner(:, :, :)
    real(real64), intent(in) :: spacing
    integer, intent(out) :: ierr

    call mesh%uniform_block(shape(inner) + 1, spread(0.0_real64, 1, 3), spread(spacing, 1, 3), ierr)
    if (ierr == insitu_ok) call mesh%cell_field('q', inner, ierr)
  end subroutine couple

end module coupling

program halo_and_threads
  !$ use omp_lib, only: omp_get_max_threads
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit, real64
  use advection
  use coupling
  use insitu
  implicit none

  character(len=*), parameter :: scene = &
      'insitu: 1' // new_line('a') // &
      'output: out/halo' // new_line('a') // &
      'every: 8' // new_line('a') // &
      'probes:' // new_line('a') // &
      '  - {name: line, points: {line: {from: [0, 0.5, 0.5], to: [1, 0.5, 0.5], count: 5}}}' // new_line('a')
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  type(insitu_audit_entry), allocatable :: entries(:)
  integer :: cycle, ierr, threads

  threads = 0                                            ! all that the process may use
  !$ threads = omp_get_max_threads()                     ! as many as the solver's own loops
  call set_up()
  call session%open(scene_text=scene, threads=threads, strict=.true., ierr=ierr)
  if (ierr == insitu_ok) call session%mesh('box', mesh, ierr)
  if (ierr == insitu_ok) call couple(mesh, q(1:n, 1:n, 1:n), h, ierr)
  if (ierr /= insitu_ok) then                            ! a solver would run on without the library
    write (error_unit, '(a)') session%message()
    error stop 1
  end if

  do cycle = 0, 64
    if (cycle > 0) call step()
    call mesh%changed(insitu_fields)
    call session%execute(cycle, dt * real(cycle, real64), ierr)
    if (ierr /= insitu_ok) write (error_unit, '(a)') session%message()
  end do
  call mesh%audit(entries, ierr)
  write (output_unit, '(2a, i0, 2a)') trim(entries(1)%name), ': ', entries(1)%bytes, ' bytes, ', &
      merge('in place', 'a copy  ', entries(1)%borrowed)
  write (output_unit, '(a, f8.5)') 'sum after once around: ', sum(q(1:n, 1:n, 1:n)) * h**3
  call session%close(ierr)
end program halo_and_threads
