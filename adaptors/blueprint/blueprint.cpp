#include "insitu/blueprint.h"

#include <memory>
#include <new>
#include <string>

#include "attachment.h"

using insitu::Error;
using insitu::blueprint::Attachment;
using insitu::blueprint::Conduit;
using insitu::blueprint::Node;

struct insitu_blueprint_handle {
  explicit insitu_blueprint_handle(insitu_mesh mesh) : attachment(mesh) {}

  Attachment attachment;
  Attachment::Options options;
  std::string left_out;
};

namespace {

thread_local std::string message;

/// Runs a call; no exception leaves the library.
template <class Call>
insitu_status guarded(Call&& call) noexcept {
  try {
    message.clear();
    call();
    return INSITU_OK;
  } catch (const Error& e) {
    try {
      message = e.what();
    } catch (const std::bad_alloc&) {
    }
    return e.status();
  } catch (const std::bad_alloc&) {
    return INSITU_ERROR_MEMORY;
  } catch (...) {
    return INSITU_ERROR_INTERNAL;
  }
}

void require(const void* pointer, const char* name) {
  if (!pointer)
    throw Error(INSITU_ERROR_ARGUMENT, std::string(name) + ": null");
}

} // namespace

insitu_status insitu_blueprint_attach(insitu_session session, const char* name, const void* node,
                                      const insitu_blueprint_options* options,
                                      insitu_blueprint* blueprint) {
  return guarded([&] {
    require(name, "name");
    require(node, "node");
    require(blueprint, "blueprint");
    if (!*blueprint) {
      insitu_mesh mesh = nullptr;
      if (const insitu_status status = insitu_session_mesh(session, name, &mesh);
          status != INSITU_OK)
        throw Error(status, insitu_last_message());
      auto fresh = std::make_unique<insitu_blueprint_handle>(mesh);
      if (options) {
        if (options->size != sizeof *options)
          throw Error(INSITU_ERROR_ARGUMENT, "options: size is " + std::to_string(options->size) +
                                                 ", expected " + std::to_string(sizeof *options));
        fresh->options.topology = options->topology ? options->topology : "";
        fresh->options.adaptive = options->adaptive != 0;
      }
      *blueprint = fresh.release(); // it holds copies that the mesh may use after an error
    }
    insitu_blueprint_handle& b = **blueprint;
    const Node root(Conduit::resolve(Conduit::Preferred::own), const_cast<void*>(node), name);
    b.attachment.update(root, b.options);
    b.left_out.clear();
    for (const std::string& line : b.attachment.left_out())
      b.left_out += line + "\n";
  });
}

const char* insitu_blueprint_left_out(insitu_blueprint blueprint) {
  return blueprint ? blueprint->left_out.c_str() : "";
}

void insitu_blueprint_release(insitu_blueprint* blueprint) {
  if (!blueprint)
    return;
  delete *blueprint;
  *blueprint = nullptr;
}

const char* insitu_blueprint_message(void) {
  return message.c_str();
}
