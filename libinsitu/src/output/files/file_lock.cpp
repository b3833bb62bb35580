#include "output/files/file_lock.h"

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

#include "core/text.h"
#include "output/files/atomic_file.h"
#include "output/files/file_system.h"

namespace insitu::output {

namespace {

constexpr std::string_view first_line = "libinsitu writes here";

// ------------------------------------------------------------------------------------ processes

/// Who holds a lock.
struct Holder {
  long process = 0;
  std::string started;    ///< the process's start, in the system's ticks; empty: unknown
  std::string host;       ///< its name
  std::string name_space; ///< of process numbers; containers of one host have several

  bool same_numbers(const Holder& other) const {
    return host == other.host && name_space == other.name_space;
  }
};

/// The start of a process in clock ticks since the system's, from Linux' /proc; nothing: there is
/// no such process, or a dead one that waits for its parent; empty: unknown here.
std::optional<std::string> start_of(long process) {
  if (::kill(pid_t(process), 0) != 0 && errno == ESRCH)
    return std::nullopt;
  const std::string line =
      core::read_file("/proc/" + std::to_string(process) + "/stat").value_or("");
  std::size_t at = line.rfind(')'); // names may hold anything
  if (at == std::string::npos)
    return std::string();
  const std::string state = line.substr(at, 3);
  if (state == ") Z" || state == ") X")
    return std::nullopt;
  for (int i = 0; i < 20 && at != std::string::npos; ++i) // words, each after a space
    at = line.find(' ', at + 1);
  return at == std::string::npos ? std::string()
                                 : line.substr(at + 1, line.find(' ', at + 1) - at - 1);
}

Holder myself() {
  Holder me;
  me.process = long(::getpid());
  me.started = start_of(me.process).value_or(std::string());
  char host[256] = {};
  if (::gethostname(host, sizeof host - 1) == 0)
    me.host = host;
  char name_space[64] = {};
  if (::readlink("/proc/self/ns/pid", name_space, sizeof name_space - 1) > 0)
    me.name_space = name_space;
  return me;
}

bool runs(const Holder& holder) {
  const std::optional<std::string> start = start_of(holder.process);
  return start && (start->empty() || holder.started.empty() || *start == holder.started);
}

std::string text_of(const Holder& h) {
  return std::string(first_line) + "\nprocess " + std::to_string(h.process) + "\nstarted " +
         h.started + "\nhost " + h.host + "\nnamespace " + h.name_space + "\n";
}

std::optional<Holder> holder_in(const std::string& text) {
  std::string_view rest = text;
  Holder h;
  if (core::take_line(rest) != first_line)
    return std::nullopt;
  const auto value_of = [&](std::string_view key, std::string& value) {
    const std::optional<std::string_view> line = core::take_line(rest);
    if (!line || !line->starts_with(key))
      return false;
    value = line->substr(key.size());
    return true;
  };
  std::string process;
  if (!value_of("process ", process) || !value_of("started ", h.started) ||
      !value_of("host ", h.host) || !value_of("namespace ", h.name_space))
    return std::nullopt;
  h.process = std::strtol(process.c_str(), nullptr, 10);
  return h.process > 0 ? std::optional(h) : std::nullopt;
}

// --------------------------------------------------------------------------- what is held here

struct Held {
  dev_t device;
  ino_t inode;
  pid_t process;
};

/// The lock files of this process, so that its exit can remove those of sessions that nobody
/// closed. Never destroyed: a solver may close its sessions from a static destructor.
struct HeldLocks {
  std::mutex mutex;
  std::map<std::string, Held> by_path;
  std::set<std::string> made_folders; ///< for a lock; they go with the last one if nothing came in
};

void remove_held(const std::string& path, const Held& held) {
  struct stat now {};
  if (held.process == ::getpid() && ::stat(path.c_str(), &now) == 0 && now.st_dev == held.device &&
      now.st_ino == held.inode)
    ::unlink(path.c_str());
}

HeldLocks& held_locks();

/// Whether this process holds the lock file: by its path, or under another name of the folder.
bool holds(const std::string& path, int descriptor) {
  struct stat file {};
  if (::fstat(descriptor, &file) != 0)
    return true;
  HeldLocks& all = held_locks();
  const std::lock_guard<std::mutex> lock(all.mutex);
  for (const auto& [name, held] : all.by_path)
    if (held.process == ::getpid() &&
        (name == path || (held.device == file.st_dev && held.inode == file.st_ino)))
      return true;
  return false;
}

HeldLocks& held_locks() {
  static auto* const locks = [] {
    auto* const fresh = new HeldLocks;
    std::atexit([] {
      HeldLocks& all = held_locks();
      const std::lock_guard<std::mutex> lock(all.mutex);
      for (const auto& [path, held] : all.by_path)
        remove_held(path, held);
      all.by_path.clear();
    });
    return fresh;
  }();
  return *locks;
}

// -------------------------------------------------------------------------------------- making

/// A descriptor that is closed.
struct Open {
  explicit Open(int d) : descriptor(d) {}
  ~Open() {
    if (descriptor >= 0)
      ::close(descriptor);
  }
  Open(const Open&) = delete;
  Open& operator=(const Open&) = delete;
  int descriptor;
};

/// Whether the lock file was made; otherwise errno says why not, EEXIST where there is one.
bool make(const std::string& path, const std::string& text, Held& held) {
  static std::atomic<unsigned> counter{0};
  const std::string part = path + "." + std::to_string(::getpid()) + "-" +
                           std::to_string(counter++) + std::string(part_suffix);
  const Open file(::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (file.descriptor < 0)
    return false;
  (void)::flock(file.descriptor, LOCK_EX); // so that nobody takes it for a dead writer's
  std::size_t done = 0;
  int error = write_all(file.descriptor, text.data(), text.size(), &done);
  if (error == 0 && ::link(part.c_str(), path.c_str()) != 0)
    error = errno;
  struct stat status {};
  const bool known = ::fstat(file.descriptor, &status) == 0;
  if (error != 0 && known && status.st_nlink == 2) // an answer that a network lost
    error = 0;
  ::unlink(part.c_str());
  if (error == EPERM || error == ENOTSUP || error == ENOSYS || error == EMLINK) { // no links there
    const Open whole(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    error =
        whole.descriptor < 0 ? errno : write_all(whole.descriptor, text.data(), text.size(), &done);
    if (whole.descriptor >= 0 && (error != 0 || ::fstat(whole.descriptor, &status) != 0)) {
      ::unlink(path.c_str());
      error = error != 0 ? error : EIO;
    }
  }
  held = {status.st_dev, status.st_ino, ::getpid()};
  errno = error;
  return error == 0;
}

/// The same, and notes it before any other thread can look. Makes the folder if absent.
bool make_and_note(const std::string& path, const std::string& text) {
  HeldLocks& all = held_locks();
  const std::lock_guard<std::mutex> lock(all.mutex);
  const std::string folder = folder_of(path);
  std::error_code error;
  const bool absent = !std::filesystem::exists(folder, error);
  try {
    prepare_folder(folder);
    if (absent)
      all.made_folders.insert(folder);
  } catch (const core::Error&) {
    errno = ENOTDIR; // or whatever it was
    return false;
  }
  Held held{};
  if (!make(path, text, held))
    return false;
  all.by_path[path] = held;
  return true;
}

// ----------------------------------------------------------------------------------- the others

class Others {
public:
  Others(const std::string& path, const std::string& shown, const Holder& me)
      : path_(path), shown_(shown), me_(me) {}

  /// Looks at the lock file that is there. Returns if it is worth another try, having removed a
  /// stale one; throws BeingWritten otherwise. last: of the tries.
  void look(bool last) const {
    int descriptor = ::open(path_.c_str(), O_RDWR | O_CLOEXEC);
    if (descriptor < 0 && (errno == EACCES || errno == EROFS))
      descriptor = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    const Open file(descriptor);
    if (descriptor < 0) {
      if (errno == ENOENT && !last)
        return; // it was closed just now
      refuse("its lock file cannot be read (" + system_reason(errno) + ")", true);
    }
    char text[1024];
    const ssize_t bytes = ::pread(descriptor, text, sizeof text, 0);
    const std::optional<Holder> holder =
        holder_in(std::string(text, std::size_t(bytes > 0 ? bytes : 0)));
    if (!holder) { // being written, on a file system without links
      if (last)
        refuse("its lock file does not say who holds it", true);
      wait();
      return;
    }
    if (!holder->same_numbers(me_))
      refuse("process " + std::to_string(holder->process) + " on host '" + holder->host + "'" +
                 (holder->host == me_.host ? ", in another container," : "") + " holds it",
             true);
    const bool mine = holder->process == me_.process && holder->started == me_.started;
    if (mine && holds(path_, descriptor))
      refuse("another session or table of this process (" + std::to_string(me_.process) +
                 ") holds it",
             false);
    if (!mine && runs(*holder)) // one of this process that it does not hold is a folder's copy
      refuse("process " + std::to_string(holder->process) + " on this host ('" + holder->host +
                 "') holds it",
             false);
    take_over(descriptor, *holder, last);
  }

private:
  /// Removes the stale lock file that is open. Only who holds the system's lock on it may, and only
  /// while it bears the name: the file of one who was faster is another one.
  void take_over(int descriptor, const Holder& dead, bool last) const {
    const std::string gone = "process " + std::to_string(dead.process) +
                             ", which has ended, left "
                             "its lock file, which cannot be removed (";
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK || last)
        refuse(gone + system_reason(errno) + ")", true);
      wait();
      return;
    }
    struct stat opened {
    }, named{};
    const bool same = ::fstat(descriptor, &opened) == 0 && ::stat(path_.c_str(), &named) == 0 &&
                      opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
    if (same && ::unlink(path_.c_str()) != 0 && errno != ENOENT)
      refuse(gone + system_reason(errno) + ")", true);
  }

  [[noreturn]] void refuse(const std::string& why, bool by_hand) const {
    throw BeingWritten(
        "cannot write '" + shown_ + "': " + why + " (lock file '" + path_ + "'); " +
        (by_hand ? "if nobody writes there any more, remove '" + folder_of(path_) + "/*" +
                       std::string(lock_suffix) + "'"
                 : "each session, and each rank, needs an output folder of its own, or names of "
                   "its own, while it is open"));
  }
  static void wait() { std::this_thread::sleep_for(std::chrono::milliseconds(2)); }

  const std::string &path_, &shown_;
  const Holder& me_;
};

} // namespace

FileLock::FileLock(const std::string& target, const std::string& shown) {
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::absolute(target, error);
  const std::filesystem::path real = std::filesystem::weakly_canonical(absolute, error);
  const std::string path = (error ? absolute : real).string() + std::string(lock_suffix);
  const Holder me = myself();
  const std::string text = text_of(me);
  constexpr int most_tries = 500;
  for (int i = 0; i <= most_tries; ++i) {
    if (make_and_note(path, text)) {
      path_ = path;
      return;
    }
    if (errno == EEXIST)
      Others(path, shown, me).look(i == most_tries);
    else if (errno != ENOENT && errno != EINTR)
      return;
  }
}

FileLock::~FileLock() {
  if (path_.empty())
    return;
  HeldLocks& all = held_locks();
  const std::lock_guard<std::mutex> lock(all.mutex);
  const auto it = all.by_path.find(path_);
  if (it == all.by_path.end()) // at the process's exit
    return;
  remove_held(path_, it->second);
  all.by_path.erase(it);
  const auto folder = all.made_folders.find(folder_of(path_));
  if (folder != all.made_folders.end() && ::rmdir(folder->c_str()) == 0)
    all.made_folders.erase(folder);
}

} // namespace insitu::output
