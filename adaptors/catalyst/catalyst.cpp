// Catalyst 2's interface, as its loader asks for it: one data symbol, catalyst_api_impl. The
// loader's program has the Conduit whose nodes come here.
#include <memory>
#include <new>

#include "blueprint/conduit.h"
#include "run.h"

namespace {

using insitu::Error;
using insitu::blueprint::Conduit;
using insitu::blueprint::Node;
using insitu::catalyst::Run;
using insitu::catalyst::say;

/// What a call returns: 0, or this number and the library's status (insitu_status).
constexpr int failed = 1000;

std::unique_ptr<Run> run;

/// No exception leaves the library, and what went wrong is told on stderr.
template <class Call>
int guarded(const char* name, Call&& call) noexcept {
  try {
    return call();
  } catch (const insitu::catalyst::Logged& e) {
    return failed + e.status();
  } catch (const Error& e) {
    say("error: ", std::string(name) + ": " + e.what());
    return failed + e.status();
  } catch (const std::bad_alloc&) {
    return failed + INSITU_ERROR_MEMORY;
  } catch (const std::exception& e) {
    say("error: ", std::string(name) + ": " + e.what());
    return failed + INSITU_ERROR_INTERNAL;
  } catch (...) {
    return failed + INSITU_ERROR_INTERNAL;
  }
}

Node parameters(const void* node) {
  const Node root(Conduit::resolve(Conduit::Preferred::catalyst), const_cast<void*>(node), "");
  return root.at("catalyst");
}

int initialize(const void* node) {
  return guarded("initialize", [&] {
    if (run)
      throw Error(INSITU_ERROR_ORDER, "the session is open already");
    run = std::make_unique<Run>(parameters(node));
    return 0;
  });
}

int execute(const void* node) {
  return guarded("execute", [&] {
    if (!run)
      throw Error(INSITU_ERROR_ORDER, "catalyst_initialize did not succeed before");
    return run->execute(parameters(node)) ? 0 : failed + INSITU_ERROR_ACTION;
  });
}

int finalize(const void* /*node*/) {
  return guarded("finalize", [&] {
    if (const std::unique_ptr<Run> last = std::move(run))
      last->close();
    return 0;
  });
}

int about(void* node) {
  return guarded("about", [&] {
    const Conduit& c = Conduit::resolve(Conduit::Preferred::catalyst);
    const auto [major, minor, patch] = insitu::version();
    c.set_path_char8_str(node, "catalyst/implementation", "insitu");
    c.set_path_char8_str(
        node, "catalyst/insitu/version",
        (std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch))
            .c_str());
    return 0;
  });
}

int results(void* node) {
  return guarded("results", [&] {
    if (run)
      run->write_results(Conduit::resolve(Conduit::Preferred::catalyst), node);
    return 0;
  });
}

} // namespace

extern "C" {
/// As the loader declares it: catalyst_impl of version 1.
struct insitu_catalyst_implementation {
  int version;
  int (*initialize)(const void*);
  int (*execute)(const void*);
  int (*finalize)(const void*);
  int (*about)(void*);
  int (*results)(void*);
};

extern __attribute__((visibility("default")))
const insitu_catalyst_implementation catalyst_api_impl;
const insitu_catalyst_implementation catalyst_api_impl = {1,        initialize, execute,
                                                          finalize, about,      results};
}
