#include "conduit.h"

#include <cstdlib>
#include <dlfcn.h>
#include <link.h>
#include <string>
#include <vector>

#include "insitu/insitu.hpp"

namespace insitu::blueprint {

namespace {

/// Looks for a function in the program and in libraries that were loaded for themselves alone, as
/// those of Python's modules are.
class Loaded {
public:
  Loaded() {
    dl_iterate_phdr(
        [](dl_phdr_info* info, std::size_t, void* self) {
          if (info->dlpi_name && *info->dlpi_name)
            static_cast<Loaded*>(self)->paths_.emplace_back(info->dlpi_name);
          return 0;
        },
        this);
  }

  void* find(const std::string& function) const {
    if (void* found = dlsym(RTLD_DEFAULT, function.c_str()))
      return found;
    for (const std::string& path : paths_)
      if (void* library = dlopen(path.c_str(), RTLD_LAZY | RTLD_NOLOAD)) {
        void* found = dlsym(library, function.c_str());
        dlclose(library); // the program holds it all the same
        if (found)
          return found;
      }
    return nullptr;
  }

private:
  std::vector<std::string> paths_;
};

template <class Function>
void resolve(const Loaded& loaded, const std::string& name, Function& function) {
  void* found = loaded.find(name);
  if (!found)
    throw Error(INSITU_ERROR_UNSUPPORTED, "Conduit's function " + name +
                                              " is in no library of this program; Conduit 0.8 or "
                                              "later is needed");
  function = reinterpret_cast<Function>(found);
}

Conduit resolve_as(const Loaded& loaded, const std::string& prefix) {
  Conduit c{};
  const std::string node = prefix + "conduit_node_", type = prefix + "conduit_datatype_";
  // Where Conduit counts in 32 bits its functions have other arguments.
  using SizeOf = std::int64_t (*)();
  if (void* size = loaded.find(type + "sizeof_index_t"))
    if (reinterpret_cast<SizeOf>(size)() != 8)
      throw Error(INSITU_ERROR_UNSUPPORTED, "this program's Conduit counts in 32 bits "
                                            "(CONDUIT_INDEX_32), and 64 bits are needed");
  resolve(loaded, node + "has_path", c.has_path);
  resolve(loaded, node + "fetch_existing", c.fetch_existing);
  resolve(loaded, node + "child", c.child);
  resolve(loaded, node + "number_of_children", c.number_of_children);
  resolve(loaded, node + "name", c.name);
  resolve(loaded, node + "dtype", c.dtype);
  resolve(loaded, node + "as_char8_str", c.as_char8_str);
  resolve(loaded, node + "element_ptr", c.element_ptr);
  resolve(loaded, type + "id", c.id);
  resolve(loaded, type + "number_of_elements", c.number_of_elements);
  resolve(loaded, type + "stride", c.stride);
  resolve(loaded, type + "endianness_matches_machine", c.endianness_matches_machine);
  resolve(loaded, node + "set_path_int64", c.set_path_int64);
  resolve(loaded, node + "set_path_float64", c.set_path_float64);
  resolve(loaded, node + "set_path_char8_str", c.set_path_char8_str);
  resolve(loaded, node + "set_path_uint8_ptr", c.set_path_uint8_ptr);
  resolve(loaded, node + "set_path_float64_ptr", c.set_path_float64_ptr);
  return c;
}

} // namespace

const Conduit& Conduit::resolve(Preferred preferred) {
  static const auto find = [](bool catalyst_first) {
    const Loaded loaded;
    const bool embedded = loaded.find("catalyst_conduit_node_has_path") != nullptr;
    const bool own = loaded.find("conduit_node_has_path") != nullptr;
    return resolve_as(loaded, embedded && (catalyst_first || !own) ? "catalyst_" : "");
  };
  // Each is looked for until it is found.
  if (preferred == Preferred::catalyst) {
    static const Conduit first = find(true);
    return first;
  }
  static const Conduit last = find(false);
  return last;
}

} // namespace insitu::blueprint
