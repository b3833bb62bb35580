#include "parallel/mpi_world.h"

#include <cstdio>
#include <cstring>
#include <dlfcn.h>
#include <link.h>
#include <new>
#include <string>
#include <unistd.h>
#include <vector>

#include "parallel/mpi/functions.h"

namespace insitu::parallel {

using core::Error;

namespace {

#ifdef INSITU_MPI_LIBRARY
/// Of libinsitu-mpi, and of the MPI it is linked with.
constexpr const char* library_name = INSITU_MPI_LIBRARY;
constexpr const char* mpi_name = INSITU_MPI_OF_BUILD;
#else
constexpr const char* library_name = "";
constexpr const char* mpi_name = "";
#endif

const char* name_in(const char* path) {
  const char* const slash = std::strrchr(path, '/');
  return slash ? slash + 1 : path;
}

/// Throws if the program has another MPI: a handle of one means nothing to the other.
void refuse_other_mpi() {
  char other[256] = "";
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* found) {
        const char* const name = name_in(info->dlpi_name ? info->dlpi_name : "");
        const char* const own = name_in(mpi_name);
        if (mpi_of(name) && std::strncmp(name, own, std::strlen(own)) != 0)
          std::strncpy(static_cast<char*>(found), name, sizeof other - 1);
        return 0;
      },
      other);
  if (*other)
    throw Error(INSITU_ERROR_UNSUPPORTED,
                std::string("communicator: the program has loaded ") + other + " (" +
                    mpi_of(other) + "), but libinsitu-mpi is built with " + name_in(mpi_name) +
                    "; build libinsitu with the program's MPI");
}

/// What one process alone may lack, which cannot tell the others so without MPI. They wait for it.
[[noreturn]] void refuse_alone(const char* why) {
  char host[256] = "", message[2048] = "";
  gethostname(host, sizeof host - 1);
  std::snprintf(
      message, sizeof message,
      "communicator: %s cannot be used by this process, on host '%s': %s. Processes of the "
      "communicator that can use it wait for this one; in a checked session "
      "(INSITU_CHECKED=1) no longer than INSITU_WAIT says",
      library_name, host, why);
  throw Error(INSITU_ERROR_UNSUPPORTED, message);
}

/// The library lies beside the one that this code is in, or where the loader looks. Other processes
/// wait for this one from here on, so nothing takes memory unless it fails on all.
void* load() {
  Dl_info own{};
  char beside[4096] = "", why[1024] = "";
  if (dladdr(reinterpret_cast<void*>(&mpi_of), &own) && own.dli_fname)
    std::snprintf(beside, sizeof beside, "%.*s%s", int(name_in(own.dli_fname) - own.dli_fname),
                  own.dli_fname, library_name);
  for (const char* const path : {static_cast<const char*>(beside), library_name}) {
    if (!*path)
      continue;
    if (void* const library = dlopen(path, RTLD_NOW | RTLD_LOCAL))
      return library;
    const std::size_t end = std::strlen(why);
    std::snprintf(why + end, sizeof why - end, "%s%s", end > 0 ? "; " : "", dlerror());
  }
  refuse_alone(why);
}

const insitu_mpi_functions& functions() {
  static const insitu_mpi_functions* const loaded = [] {
    refuse_other_mpi();
    const auto get =
        reinterpret_cast<const insitu_mpi_functions* (*)()>(dlsym(load(), "insitu_mpi"));
    const insitu_mpi_functions* const all = get ? get() : nullptr;
    if (!all || all->version != INSITU_MPI_VERSION)
      refuse_alone("it is of another version of libinsitu");
    return all;
  }();
  return *loaded;
}

void check(int status, const char* message) {
  switch (status) {
  case INSITU_MPI_OK:
    return;
  case INSITU_MPI_ARGUMENT:
    throw Error(INSITU_ERROR_ARGUMENT, message);
  case INSITU_MPI_ORDER:
  case INSITU_MPI_THREAD:
    throw Error(INSITU_ERROR_ORDER, message);
  case INSITU_MPI_MEMORY:
    throw Error(INSITU_ERROR_MEMORY, message);
  }
  throw Error(INSITU_ERROR_INTERNAL, message);
}

class MpiWorld final : public World {
public:
  explicit MpiWorld(const insitu_mpi_functions& mpi) : mpi_(mpi) {}
  ~MpiWorld() override {
    char message[INSITU_MPI_MESSAGE];
    if (world_)
      mpi_.close(world_, message);
  }
  /// Duplicates the communicator, on all processes. made: null where there was no memory for it.
  static void open(MpiWorld* made, const insitu_mpi_functions& mpi, const void* communicator,
                   std::int32_t fortran_communicator, double seconds, const core::Log& log) {
    insitu_mpi_world* world = nullptr;
    int rank = -1, size = 1, on_this_node = 1, cores_here = 1, single = 0;
    char message[INSITU_MPI_MESSAGE] = "";
    const int status = mpi.open(communicator, fortran_communicator, !made, seconds, &world, &rank,
                                &size, &on_this_node, &cores_here, &single, message);
    if (status == INSITU_MPI_MEMORY)
      throw AgreedError(INSITU_ERROR_MEMORY, message, rank == 0);
    check(status, message);
    made->world_ = world;
    made->rank_ = rank;
    made->size_ = size;
    made->on_this_node_ = on_this_node;
    made->cores_here_ = cores_here;
    made->agree_after([&] {
      if (single && rank == 0)
        log.warning("communicator: MPI is initialised for one thread (MPI_THREAD_SINGLE); the "
                    "library computes in several and calls MPI from the thread that calls it "
                    "alone. MPI_THREAD_FUNNELED says so");
    });
  }

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  int on_this_node() const override { return on_this_node_; }
  int cores_here() const override { return cores_here_; }
  void check_usable() const override {
    char message[INSITU_MPI_MESSAGE] = "";
    check(mpi_.check(message), message);
  }

private:
  int do_wait_for_all(double seconds) override {
    char message[INSITU_MPI_MESSAGE] = "";
    int missing = -1;
    check(mpi_.wait_for_all(world_, seconds, &missing, message), message);
    return missing;
  }
  void do_reduce(std::span<std::int64_t> values, Reduction reduction) override {
    char message[INSITU_MPI_MESSAGE] = "";
    const int op = reduction == Reduction::sum     ? INSITU_MPI_SUM
                   : reduction == Reduction::least ? INSITU_MPI_LEAST
                                                   : INSITU_MPI_GREATEST;
    check(mpi_.reduce(world_, values.data(), values.size(), op, message), message);
  }
  void do_broadcast(std::span<std::byte> bytes, int root) override {
    char message[INSITU_MPI_MESSAGE] = "";
    check(mpi_.broadcast(world_, bytes.data(), bytes.size(), root, message), message);
  }
  void swap_numbers(std::span<const std::int64_t> to, std::span<std::int64_t> from) override {
    char message[INSITU_MPI_MESSAGE] = "";
    check(mpi_.swap_numbers(world_, to.data(), from.data(), message), message);
  }
  void prepare(std::span<const Outgoing> out, std::span<const Incoming> in) override {
    char message[INSITU_MPI_MESSAGE] = "";
    sends_.clear();
    receives_.clear();
    for (const Outgoing& o : out)
      sends_.push_back({o.rank, const_cast<std::byte*>(o.bytes.data()), o.bytes.size()});
    for (const Incoming& i : in)
      receives_.push_back({i.rank, i.bytes.data(), i.bytes.size()});
    check(mpi_.prepare(world_, sends_.data(), sends_.size(), receives_.data(), receives_.size(),
                       message),
          message);
  }
  void transfer(std::span<const Outgoing>, std::span<const Incoming>) override {
    char message[INSITU_MPI_MESSAGE] = "";
    check(mpi_.transfer(world_, sends_.data(), sends_.size(), receives_.data(), receives_.size(),
                        message),
          message);
  }

  const insitu_mpi_functions& mpi_;
  insitu_mpi_world* world_ = nullptr;
  int rank_ = 0, size_ = 1, on_this_node_ = 1, cores_here_ = 1;
  std::vector<insitu_mpi_part> sends_, receives_; ///< of the transfer that is prepared
};

} // namespace

bool has_mpi() {
  return *library_name != '\0';
}

const char* mpi_of(const char* library) {
  struct Mpi {
    const char *file, *name;
  };
  // libmpi.so.12 is MPICH's and Intel's, whose own files tell them apart from Open MPI's.
  static constexpr Mpi known[] = {
      {"libmpi.so.40", "Open MPI"},   {"libmpi.so.20", "Open MPI"},
      {"libmpich.so", "MPICH"},       {"libmpi.so.12", "MPICH or Intel MPI"},
      {"libmpi_cray.so", "Cray MPI"}, {"libmpi_ibm.so", "Spectrum MPI"},
      {"libmpi_mt.so", "Intel MPI"}};
  for (const Mpi& m : known)
    if (std::strncmp(library, m.file, std::strlen(m.file)) == 0)
      return m.name;
  return nullptr;
}

std::shared_ptr<World> make_mpi_world(const void* communicator, std::int32_t fortran_communicator,
                                      const core::Log& log, double seconds) {
  if (!has_mpi())
    throw Error(INSITU_ERROR_UNSUPPORTED, "communicator: this build has no MPI");
  const insitu_mpi_functions& mpi = functions();
  std::shared_ptr<MpiWorld> made;
  try {
    made = std::make_shared<MpiWorld>(mpi);
  } catch (const std::bad_alloc&) { // told to the others, once they can hear of it
  }
  MpiWorld::open(made.get(), mpi, communicator, fortran_communicator, seconds, log);
  return made;
}

} // namespace insitu::parallel
