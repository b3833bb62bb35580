#include "parallel/mpi_world.h"

#include <cstring>
#include <dlfcn.h>
#include <link.h>
#include <string>
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

std::string name_in(const std::string& path) {
  return path.substr(path.rfind('/') + 1);
}

/// Throws if the program has another MPI: a handle of one means nothing to the other.
void refuse_other_mpi() {
  std::string other;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* found) {
        const std::string name = name_in(info->dlpi_name ? info->dlpi_name : "");
        const std::string own = name_in(mpi_name);
        if (mpi_of(name.c_str()) && name.compare(0, own.size(), own) != 0)
          *static_cast<std::string*>(found) = name;
        return 0;
      },
      &other);
  if (!other.empty())
    throw Error(INSITU_ERROR_UNSUPPORTED,
                "communicator: the program has loaded " + other + " (" + mpi_of(other.c_str()) +
                    "), but libinsitu-mpi is built with " + name_in(mpi_name) +
                    "; build libinsitu with the program's MPI");
}

/// The library lies beside the one that this code is in, or where the loader looks.
void* load() {
  Dl_info own{};
  std::vector<std::string> paths;
  if (dladdr(reinterpret_cast<void*>(&mpi_of), &own) && own.dli_fname) {
    const std::string file = own.dli_fname;
    if (const std::size_t slash = file.rfind('/'); slash != std::string::npos)
      paths.push_back(file.substr(0, slash + 1) + library_name);
  }
  paths.push_back(library_name);
  std::string why;
  for (const std::string& path : paths) {
    if (void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL))
      return library;
    why += std::string(why.empty() ? "" : "; ") + dlerror();
  }
  throw Error(INSITU_ERROR_UNSUPPORTED, "communicator: " + why);
}

const insitu_mpi_functions& functions() {
  static const insitu_mpi_functions* const loaded = [] {
    refuse_other_mpi();
    const auto get =
        reinterpret_cast<const insitu_mpi_functions* (*)()>(dlsym(load(), "insitu_mpi"));
    const insitu_mpi_functions* const all = get ? get() : nullptr;
    if (!all || all->version != INSITU_MPI_VERSION)
      throw Error(INSITU_ERROR_UNSUPPORTED, std::string("communicator: ") + library_name +
                                                " is of another version of libinsitu");
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
  }
  throw Error(INSITU_ERROR_INTERNAL, message);
}

class MpiWorld final : public World {
public:
  MpiWorld(const void* communicator, std::int32_t fortran_communicator, const core::Log& log)
      : mpi_(functions()) {
    int single = 0;
    char message[INSITU_MPI_MESSAGE] = "";
    check(mpi_.open(communicator, fortran_communicator, &world_, &rank_, &size_, &on_this_node_,
                    &single, message),
          message);
    if (single && is_root())
      log.warning("communicator: MPI is initialised for one thread (MPI_THREAD_SINGLE); the "
                  "library computes in several and calls MPI from the thread that calls it alone. "
                  "MPI_THREAD_FUNNELED says so");
  }
  ~MpiWorld() override {
    char message[INSITU_MPI_MESSAGE];
    mpi_.close(world_, message);
  }

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  int on_this_node() const override { return on_this_node_; }
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
  void transfer(std::span<const Outgoing> out, std::span<const Incoming> in) override {
    char message[INSITU_MPI_MESSAGE] = "";
    std::vector<insitu_mpi_part> sends, receives;
    for (const Outgoing& o : out)
      sends.push_back({o.rank, const_cast<std::byte*>(o.bytes.data()), o.bytes.size()});
    for (const Incoming& i : in)
      receives.push_back({i.rank, i.bytes.data(), i.bytes.size()});
    check(mpi_.transfer(world_, sends.data(), sends.size(), receives.data(), receives.size(),
                        message),
          message);
  }

  const insitu_mpi_functions& mpi_;
  insitu_mpi_world* world_ = nullptr;
  int rank_ = 0, size_ = 1, on_this_node_ = 1;
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

std::unique_ptr<World> make_mpi_world(const void* communicator, std::int32_t fortran_communicator,
                                      const core::Log& log) {
  if (!has_mpi())
    throw Error(INSITU_ERROR_UNSUPPORTED, "communicator: this build has no MPI");
  return std::make_unique<MpiWorld>(communicator, fortran_communicator, log);
}

} // namespace insitu::parallel
