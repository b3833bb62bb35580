!> Levels with ghosts below and above: the section is read where it is, and the audit says so.
program section_in_place
  use, intrinsic :: iso_fortran_env, only: output_unit, real64
  use insitu
  implicit none

  integer, parameter :: ncolumns = 16, nlevels = 4, nghost = 2
  real(real64), target :: t(ncolumns, 1 - nghost:nlevels + nghost)
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  type(insitu_audit_entry), allocatable :: entries(:)
  real(real64) :: value(1)
  integer :: i, ierr

  t = -999.0_real64                                      ! what the ghost levels keep
  do i = 1, nlevels
    t(:, i) = 10.0_real64 * real(i, real64)
  end do

  call session%open(ierr=ierr, strict=.true.)            ! strict: refuse any copy
  call session%mesh('ocean', mesh, ierr)
  call mesh%uniform_block([5, 5, nlevels + 1], [0.0_real64, 0.0_real64, 0.0_real64], &
                          [1.0_real64, 1.0_real64, 1.0_real64], ierr)
  call mesh%cell_field('temperature', t(:, 1:nlevels), ierr)
  call mesh%commit(ierr)
  if (ierr /= insitu_ok) error stop 1

  call mesh%audit(entries, ierr)
  do i = 1, size(entries)
    write (output_unit, '(2a, i0, 2a)') trim(entries(i)%name), ': ', entries(i)%bytes, ' bytes, ', &
        merge('borrowed ', 'converted', entries(i)%borrowed)
  end do
  call mesh%sample_point('temperature', [2.5_real64, 1.5_real64, 3.5_real64], value, ierr)
  write (output_unit, '(a, f5.1)') 'temperature in the top level:', value(1)
  call session%close(ierr)
end program section_in_place
