!> The gyre example coupled: the library reads the ocean's own arrays, longitude, latitude and depth, and
!! answers with its numbering; at the surface too, where the depth is 0 exactly.
program gyre_coupling_check
  use, intrinsic :: iso_c_binding, only: c_associated, c_loc
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use gyre_basin, only: atlantic
  use gyre_coupling, only: coupling_type
  use gyre_model, only: model_type
  use insitu
  implicit none

  type(model_type), target :: model
  type(coupling_type) :: coupling
  integer :: ierr
  integer :: failures = 0

  call model%start(atlantic(), 6)
  call coupling%begin(model, '', '', 0)
  call expect('coupled', coupling%works)
  call model%advance()
  call model%advance()
  call coupling%mesh%changed(insitu_fields)
  call coupling%mesh%commit(ierr)
  call expect('commit', ierr == insitu_ok)
  call check_cells()
  call check_surface()
  call check_audit()
  call coupling%session%close(ierr)
  if (failures > 0) error stop 1

contains

  !> Every cell is found at its middle, by its own number, with its own temperature.
  subroutine check_cells()
    real(real64), dimension(model%mesh%ncells()) :: lon, lat, depth, values
    integer(int64) :: cells(model%mesh%ncells())
    integer :: c

    do c = 1, model%mesh%ncells()
      associate (id => model%mesh%connectivity(:, c))
        lon(c) = sum(model%mesh%lon(id)) / 6.0_real64
        lat(c) = sum(model%mesh%lat(id)) / 6.0_real64
        depth(c) = sum(model%mesh%depth(id)) / 6.0_real64
      end associate
    end do
    call coupling%mesh%locate(lon, lat, depth, cells, ierr, accuracy=insitu_exact)
    call expect('every cell is found', ierr == insitu_ok .and. &
                all(cells == [(int(c, int64), c=1, model%mesh%ncells())]))
    call coupling%mesh%sample('temperature', lon, lat, depth, values, ierr)
    call expect('every cell has its temperature', ierr == insitu_ok .and. &
                all(abs(reshape(values, [model%mesh%ncolumns, model%mesh%nlevels]) &
                        - model%heat%t(:, 1:model%mesh%nlevels)) <= 0.0_real64))
  end subroutine check_cells

  !> At depth 0 exactly, under every triangle, the velocity is the vertices' mean.
  subroutine check_surface()
    real(real64), dimension(model%mesh%ncolumns) :: lon, lat, depth
    real(real64) :: velocity(3, model%mesh%ncolumns)
    logical :: found(model%mesh%ncolumns)
    integer :: c, top

    top = model%mesh%nlevels * model%mesh%nv
    depth = 0.0_real64
    do c = 1, model%mesh%ncolumns
      lon(c) = sum(model%mesh%lon(model%mesh%triangle(:, c))) / 3.0_real64
      lat(c) = sum(model%mesh%lat(model%mesh%triangle(:, c))) / 3.0_real64
    end do
    call coupling%mesh%sample('velocity', lon, lat, depth, velocity, ierr, found=found)
    call expect('the surface is inside', ierr == insitu_ok .and. all(found))
    do c = 1, model%mesh%ncolumns
      velocity(:, c) = velocity(:, c) - sum(model%flow%velocity(:, top + model%mesh%triangle(:, c)), dim=2) / 3.0_real64
    end do
    call expect('it flows as the vertices do', all(abs(velocity) < 1.0e-12_real64))
    depth = -1.0e-9_real64
    call coupling%mesh%sample('velocity', lon, lat, depth, velocity, ierr, found=found)
    call expect('a nanometre above is the air', ierr == insitu_ok .and. .not. any(found))
  end subroutine check_surface

  subroutine check_audit()
    type(insitu_audit_entry), allocatable :: entries(:)
    type(insitu_validation) :: validation
    integer :: i
    logical :: in_place

    call coupling%mesh%audit(entries, ierr)
    call expect('nothing was copied', ierr == insitu_ok .and. size(entries) > 0 .and. all(entries%borrowed))
    in_place = .false.
    do i = 1, size(entries)
      if (index(entries(i)%name, 'temperature') > 0) in_place = &
          c_associated(entries(i)%address, c_loc(model%heat%t(1, 1)))
    end do
    call expect('the temperature is read above its floor', in_place)
    call coupling%mesh%validate(validation, ierr)
    call expect('wedges are in VTK''s order', ierr == insitu_ok .and. validation%inverted_cells == 0 .and. &
                validation%zero_volume_cells == 0 .and. validation%folded_cells == 0)
  end subroutine check_audit

  subroutine expect(what, holds)
    character(len=*), intent(in) :: what
    logical, intent(in) :: holds
    if (holds) return
    failures = failures + 1
    write (error_unit, '(4a)') 'failed: ', what, ' ', coupling%session%message()
  end subroutine expect

end program gyre_coupling_check
