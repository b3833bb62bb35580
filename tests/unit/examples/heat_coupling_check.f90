!> The heat example coupled: the library reads the solver's own memory, step after step, and answers
!! with the solver's numbering.
program heat_coupling_check
  use, intrinsic :: iso_c_binding, only: c_associated, c_loc
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use heat_case, only: initial_heat
  use heat_coupling, only: couple
  use heat_solver, only: heat_type, nhalo
  use insitu
  implicit none

  real(real64), parameter :: rounding = 1.0e-11_real64
  type(heat_type), target :: model
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  real(real64) :: dt
  integer :: cycle, ierr
  integer :: failures = 0

  call initial_heat(6, model)
  dt = model%stable_step()
  call session%open(ierr=ierr, strict=.true.)
  call couple(session, model, mesh, ierr)
  call expect('coupled', ierr == insitu_ok)
  do cycle = 0, 2
    call mesh%changed(insitu_fields)
    call mesh%commit(ierr)
    call expect('commit', ierr == insitu_ok)
    call check_cells()
    call check_vertices()
    call model%step(dt)
    call model%update_flux()
  end do
  call check_audit()
  call check_validation()
  call session%close(ierr)
  if (failures > 0) error stop 1

contains

  !> Every cell is found at its centroid, by its own number, with its own temperature.
  subroutine check_cells()
    real(real64), dimension(model%mesh%ncells()) :: x, y, z, values
    integer(int64) :: cells(model%mesh%ncells())
    integer :: c, k

    c = 0
    do k = 1, model%mesh%nlevels
      x(c + 1:c + model%mesh%ncolumns) = model%mesh%centre(1, :)
      y(c + 1:c + model%mesh%ncolumns) = model%mesh%centre(2, :)
      z(c + 1:c + model%mesh%ncolumns) = model%mesh%level_z(k)
      c = c + model%mesh%ncolumns
    end do
    call mesh%locate(x, y, z, cells, ierr, accuracy=insitu_exact)
    call expect('every cell is found', ierr == insitu_ok .and. &
                all(cells == [(int(c, int64), c=1, model%mesh%ncells())]))
    call mesh%sample('temperature', x, y, z, values, ierr)
    call expect('every cell has its temperature', ierr == insitu_ok .and. &
                all(abs(reshape(values, [model%mesh%ncolumns, model%mesh%nlevels]) &
                        - model%t(:, 1 + nhalo:model%mesh%nlevels + nhalo)) <= 0.0_real64))
  end subroutine check_cells

  subroutine check_vertices()
    real(real64) :: flux(3, size(model%mesh%x))

    call mesh%sample('flux', model%mesh%x, model%mesh%y, model%mesh%z, flux, ierr, &
                     accuracy=insitu_exact)
    call expect('every vertex has its flux', ierr == insitu_ok .and. &
                all(abs(flux - model%flux) <= rounding))
  end subroutine check_vertices

  subroutine check_audit()
    type(insitu_audit_entry), allocatable :: entries(:)
    integer :: i
    logical :: temperature_in_place

    call mesh%audit(entries, ierr)
    call expect('nothing was copied', ierr == insitu_ok .and. size(entries) == 8 .and. &
                all(entries%borrowed))
    temperature_in_place = .false.
    do i = 1, size(entries)
      if (index(entries(i)%name, 'temperature') > 0) temperature_in_place = &
          c_associated(entries(i)%address, c_loc(model%t(1, 1 + nhalo)))
    end do
    call expect('the temperature is read below its ghost level', temperature_in_place)
  end subroutine check_audit

  subroutine check_validation()
    type(insitu_validation) :: validation

    call mesh%validate(validation, ierr)
    call expect('wedges are in VTK''s order', ierr == insitu_ok .and. &
                validation%inverted_cells == 0 .and. validation%zero_volume_cells == 0 .and. &
                validation%folded_cells == 0)
  end subroutine check_validation

  subroutine expect(what, holds)
    character(len=*), intent(in) :: what
    logical, intent(in) :: holds
    if (holds) return
    failures = failures + 1
    write (error_unit, '(a, i0, 3a)') 'failed at cycle ', cycle, ': ', what, ' '//session%message()
  end subroutine expect

end program heat_coupling_check
