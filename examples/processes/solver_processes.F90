!> The processes among which the Fortran miniapps deal out their meshes, and all that these ask of MPI: the
!! largest of numbers, exact sums, and what neighbours have. One process does without.
module solver_processes
  use, intrinsic :: iso_fortran_env, only: int64, real64
#ifdef SOLVER_HAVE_MPI
  use mpi_f08
#endif
  implicit none
  private

  type, public :: processes_type
    integer :: rank = 0, number = 1
    integer :: communicator = -1                         !< MPI's handle; -1: alone, without MPI
  contains
    procedure :: launch
    procedure :: finish
    procedure :: is_root
    procedure :: largest
    procedure :: total
    procedure :: swap
  end type processes_type

contains

  !> Those that a launcher such as mpirun has started; a process that no launcher started is alone, and
  !! MPI is left out of it. Launchers tell a process its rank: those with PMIx (Open MPI, Slurm), with
  !! PMI (MPICH, Slurm).
  subroutine launch(self)
    class(processes_type), intent(inout) :: self
#ifdef SOLVER_HAVE_MPI
    character(len=20), parameter :: names(3) = [character(len=20) :: 'PMIX_RANK', 'OMPI_COMM_WORLD_RANK', 'PMI_RANK']
    integer :: i, status, level
    logical :: is_launched

    is_launched = .false.
    do i = 1, size(names)
      call get_environment_variable(trim(names(i)), status=status)
      is_launched = is_launched .or. status == 0
    end do
    if (.not. is_launched) return
    call MPI_Init_thread(MPI_THREAD_FUNNELED, level)
    call MPI_Comm_rank(MPI_COMM_WORLD, self%rank)
    call MPI_Comm_size(MPI_COMM_WORLD, self%number)
    self%communicator = MPI_COMM_WORLD%mpi_val
#else
    self%communicator = -1
#endif
  end subroutine launch

  !> After the last call of the library and of this module.
  subroutine finish(self)
    class(processes_type), intent(inout) :: self
#ifdef SOLVER_HAVE_MPI
    if (self%communicator /= -1) call MPI_Finalize()
#endif
    self%communicator = -1
  end subroutine finish

  pure logical function is_root(self)
    class(processes_type), intent(in) :: self
    is_root = self%rank == 0
  end function is_root

  !> Of the numbers of all processes.
  real(real64) function largest(self, mine)
    class(processes_type), intent(in) :: self
    real(real64), intent(in) :: mine
    largest = mine
    if (self%number == 1) return
#ifdef SOLVER_HAVE_MPI
    call MPI_Allreduce(mine, largest, 1, MPI_DOUBLE_PRECISION, MPI_MAX, world(self))
#endif
  end function largest

  !> The sum of the terms of all processes: the same to the bit however they are dealt out. Each term
  !! becomes a whole multiple of a coarse unit and one of a fine unit for the rest, 2**30 at most both;
  !! sums of fewer than 2**33 whole numbers are exact, so their order does not matter.
  real(real64) function total(self, terms)
    class(processes_type), intent(in) :: self
    real(real64), intent(in) :: terms(:)
    real(real64) :: coarse, fine
    integer(int64) :: mine(2), sums(2)

    total = self%largest(max(0.0_real64, maxval(abs(terms))))
    if (total <= 0.0_real64 .or. total > huge(total)) return
    coarse = scale(1.0_real64, exponent(total) - 30)
    fine = scale(coarse, -31)
    mine(1) = sum(nint(terms / coarse, int64))
    mine(2) = sum(nint((terms - anint(terms / coarse) * coarse) / fine, int64))
    sums = mine
#ifdef SOLVER_HAVE_MPI
    if (self%number > 1) call MPI_Allreduce(mine, sums, 2, MPI_INTEGER8, MPI_SUM, world(self))
#endif
    total = real(sums(1), real64) * coarse + real(sums(2), real64) * fine
  end function total

  !> Sends an array to one process and receives one from another; -1: there is none, and received stays
  !! as it is.
  subroutine swap(self, sent, receiver, received, sender)
    class(processes_type), intent(in) :: self
    real(real64), intent(in) :: sent(:,:)
    integer, intent(in) :: receiver, sender
    real(real64), intent(inout) :: received(:,:)
#ifdef SOLVER_HAVE_MPI
    integer :: to, from
#endif

    if (self%number == 1) then
      if (receiver == 0 .and. sender == 0) received = sent
      return
    end if
#ifdef SOLVER_HAVE_MPI
    to = merge(receiver, MPI_PROC_NULL, receiver >= 0)
    from = merge(sender, MPI_PROC_NULL, sender >= 0)
    call MPI_Sendrecv(sent, size(sent), MPI_DOUBLE_PRECISION, to, 0, received, size(received), &
                      MPI_DOUBLE_PRECISION, from, 0, world(self), MPI_STATUS_IGNORE)
#endif
  end subroutine swap

#ifdef SOLVER_HAVE_MPI
  pure type(MPI_Comm) function world(self)
    class(processes_type), intent(in) :: self
    world%mpi_val = self%communicator
  end function world
#endif

end module solver_processes
