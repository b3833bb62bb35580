#include <cstdlib>
#include <mpi.h>
#include <stdexcept>

#include "processes.h"

namespace sedov {

namespace {

// Throws nothing: MPI ends the program at an error, as is its default for MPI_COMM_WORLD.
class MpiProcesses final : public Processes {
public:
  MpiProcesses(int& argc, char**& argv) {
    int level = MPI_THREAD_SINGLE; // the solver's threads do not call MPI
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &level);
    MPI_Comm_rank(communicator_, &rank_);
    MPI_Comm_size(communicator_, &size_);
  }
  ~MpiProcesses() override { MPI_Finalize(); }

  int rank() const override { return rank_; }
  int size() const override { return size_; }

  double largest(double value) const override {
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, communicator_);
    return value;
  }
  void add(std::span<std::int64_t> values) const override {
    MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_INT64_T,
                  MPI_SUM, communicator_);
  }
  void exchange(std::span<Message> messages) const override {
    std::vector<MPI_Request> requests(2 * messages.size());
    MPI_Request* next = requests.data();
    for (Message& m : messages)
      MPI_Irecv(m.in.data(), static_cast<int>(m.in.size()), MPI_DOUBLE, m.process, 0, communicator_,
                next++);
    for (const Message& m : messages)
      MPI_Isend(m.out.data(), static_cast<int>(m.out.size()), MPI_DOUBLE, m.process, 0,
                communicator_, next++);
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  }
  [[noreturn]] void abort() const override {
    MPI_Abort(communicator_, EXIT_FAILURE);
    std::abort(); // not reached
  }
  const void* communicator() const override { return &communicator_; }

private:
  MPI_Comm communicator_ = MPI_COMM_WORLD;
  int rank_ = 0, size_ = 1;
};

// Launchers tell a process its rank: those with PMIx (Open MPI, Slurm), with PMI (MPICH, Slurm).
bool is_launched() {
  for (const char* name : {"PMIX_RANK", "OMPI_COMM_WORLD_RANK", "PMI_RANK"})
    if (std::getenv(name))
      return true;
  return false;
}

} // namespace

std::unique_ptr<Processes> launched_processes(int& argc, char**& argv) {
  if (is_launched())
    return std::make_unique<MpiProcesses>(argc, argv);
  return std::make_unique<Processes>();
}

} // namespace sedov
