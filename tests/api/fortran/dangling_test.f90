!> A section given to an explicit-shape dummy is a temporary of the compiler's, gone when the procedure
!! ends. Checked sessions (the test sets INSITU_CHECKED) tell: large ones are unmapped, which is an
!! error of the commit; the memory of small ones holds something else, which is a warning that
!! CMakeLists.txt looks for.
program dangling_test
  use, intrinsic :: iso_fortran_env, only: error_unit, real64
  use checks
  use insitu
  implicit none

  integer, parameter :: n = 64
  real(real64) :: rho(0:n + 1, 0:n + 1, 0:n + 1)
  real(real64), target :: own(4, 4, 4)
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  integer :: ierr

  rho = 7
  own = 7
  call session%open(ierr=ierr)
  call session%mesh('good', mesh, ierr)
  call mesh%uniform_block([5, 5, 5], [0.0_real64, 0.0_real64, 0.0_real64], [1.0_real64, 1.0_real64, 1.0_real64], ierr)
  call mesh%cell_field('own', own, ierr)
  own = 8
  call mesh%changed(insitu_fields)
  call mesh%commit(ierr)
  call expect_ok('values that are said to have changed', session, ierr)

  call session%mesh('large', mesh, ierr)
  call mesh%uniform_block([n + 1, n + 1, n + 1], [0.0_real64, 0.0_real64, 0.0_real64], &
                          [1.0_real64, 1.0_real64, 1.0_real64], ierr)
  call give_large(rho(1:n, 1:n, 1:n))
  call mesh%commit(ierr)
  call expect_error('memory that is gone', session, ierr, insitu_error_argument, "'large'|rho|temporary")

  call session%mesh('small', mesh, ierr)
  call mesh%uniform_block([5, 5, 5], [0.0_real64, 0.0_real64, 0.0_real64], [1.0_real64, 1.0_real64, 1.0_real64], ierr)
  call give_small(rho(1:4, 1:4, 1:4))
  call mesh%commit(ierr)
  call expect_ok('values that are others', session, ierr)
  call session%close(ierr)
  call finish_checks()
  write (error_unit, '(a)') 'all checks are done'

contains

  subroutine give_large(a)
    real(real64), intent(in), target :: a(n, n, n)
    call mesh%cell_field('rho', a, ierr)
  end subroutine give_large

  subroutine give_small(a)
    real(real64), intent(in), target :: a(4, 4, 4)
    call mesh%cell_field('rho', a, ierr)
  end subroutine give_small

end program dangling_test
