!> What the checks of miniapps on several processes share: numbers that are to be the same to the bit.
module processes_checks
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use solver_processes, only: processes_type
  implicit none
  private

  public :: expect, expect_same, end_checks

  type(processes_type), public :: processes
  integer :: failures = 0

contains

  subroutine expect_same(what, found, expected)
    character(len=*), intent(in) :: what
    real(real64), intent(in) :: found(:), expected(:)
    integer(int64) :: bits(0)
    call expect(what // ' are as many', size(found) == size(expected))
    if (size(found) == size(expected)) call expect(what, all(transfer(found, bits) == transfer(expected, bits)))
  end subroutine expect_same

  subroutine expect(what, holds)
    character(len=*), intent(in) :: what
    logical, intent(in) :: holds
    if (holds) return
    failures = failures + 1
    if (failures <= 5) write (error_unit, '(a, i0, a, i0, 2a)') 'process ', processes%rank, ' of ', processes%number, &
        ': ', what
  end subroutine expect

  !> Ends MPI, and the program with 1 if something failed on any process.
  subroutine end_checks()
    logical :: all_well
    all_well = processes%largest(real(failures, real64)) <= 0.0_real64
    call processes%finish()
    if (.not. all_well) error stop 1
  end subroutine end_checks

end module processes_checks
