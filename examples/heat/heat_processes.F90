!> The processes among which the ring's levels are dealt out, and all that the heat asks of MPI: the
!! largest of numbers, the numbers of all levels, and what neighbours have. One process does without.
module heat_processes
  use, intrinsic :: iso_fortran_env, only: int64, real64
#ifdef HEAT_HAVE_MPI
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
    procedure :: levels_below
    procedure :: holder
    procedure :: largest
    procedure :: join
    procedure :: swap
  end type processes_type

contains

  !> Those that a launcher such as mpirun has started; a process that no launcher started is alone, and
  !! MPI is left out of it. Launchers tell a process its rank: those with PMIx (Open MPI, Slurm), with
  !! PMI (MPICH, Slurm).
  subroutine launch(self)
    class(processes_type), intent(inout) :: self
#ifdef HEAT_HAVE_MPI
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
#ifdef HEAT_HAVE_MPI
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
#ifdef HEAT_HAVE_MPI
    call MPI_Allreduce(mine, largest, 1, MPI_DOUBLE_PRECISION, MPI_MAX, world(self))
#endif
  end function largest

  !> How many of so many levels lie below those of a process: equal shares, of which some may be empty.
  pure integer function levels_below(self, levels, rank)
    class(processes_type), intent(in) :: self
    integer, intent(in) :: levels, rank
    levels_below = int(int(levels, int64) * rank / self%number)
  end function levels_below

  !> The process that has a level; -1: there is no such level.
  pure integer function holder(self, levels, level)
    class(processes_type), intent(in) :: self
    integer, intent(in) :: levels, level
    holder = -1
    if (level < 1 .or. level > levels) return
    do while (self%levels_below(levels, holder + 1) < level)
      holder = holder + 1
    end do
  end function holder

  !> Numbers of which each process has some, and 0 for those of others: all of them, on all.
  subroutine join(self, numbers)
    class(processes_type), intent(in) :: self
    real(real64), intent(inout) :: numbers(:)
    if (self%number == 1) return
#ifdef HEAT_HAVE_MPI
    call MPI_Allreduce(MPI_IN_PLACE, numbers, size(numbers), MPI_DOUBLE_PRECISION, MPI_SUM, world(self))
#endif
  end subroutine join

  !> Sends an array to one process and receives one from another; -1: there is none, and received stays
  !! as it is.
  subroutine swap(self, sent, receiver, received, sender)
    class(processes_type), intent(in) :: self
    real(real64), intent(in) :: sent(:,:)
    integer, intent(in) :: receiver, sender
    real(real64), intent(inout) :: received(:,:)
#ifdef HEAT_HAVE_MPI
    integer :: to, from
#endif

    if (self%number == 1) then
      if (receiver == 0 .and. sender == 0) received = sent
      return
    end if
#ifdef HEAT_HAVE_MPI
    to = merge(receiver, MPI_PROC_NULL, receiver >= 0)
    from = merge(sender, MPI_PROC_NULL, sender >= 0)
    call MPI_Sendrecv(sent, size(sent), MPI_DOUBLE_PRECISION, to, 0, received, size(received), &
                      MPI_DOUBLE_PRECISION, from, 0, world(self), MPI_STATUS_IGNORE)
#endif
  end subroutine swap

#ifdef HEAT_HAVE_MPI
  pure type(MPI_Comm) function world(self)
    class(processes_type), intent(in) :: self
    world%mpi_val = self%communicator
  end function world
#endif

end module heat_processes
