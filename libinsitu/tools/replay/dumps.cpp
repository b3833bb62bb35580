#include "dumps.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <set>

#include "catalyst/run.h"
#include "check.h"
#include "dump_arrays.h"
#include "options.h"
#include "read.h"
#include "runs/runs_of_others.h"

namespace insitu_replay {

namespace {

using insitu::blueprint::Conduit;
using insitu::blueprint::Node;
using insitu::catalyst::Tree;
using Json = nlohmann::ordered_json;

/// A dump's name: which call, of how many processes, of which.
struct DumpName {
  std::optional<long> call; ///< of execute; none: initialize
  long processes = 1, process = 0;
};

std::optional<DumpName> name_of(const std::string& path) {
  static const std::regex form(
      R"((initialize|execute_invc([0-9]{1,9}))_params\.conduit_bin\.([0-9]{1,9})\.([0-9]{1,9}))");
  const std::string name = std::filesystem::path(path).filename().string();
  std::smatch parts;
  if (!std::regex_match(name, parts, form))
    return {};
  DumpName out;
  if (parts[2].matched && parts[2].length() > 0)
    out.call = std::stol(parts[2]);
  out.processes = std::stol(parts[3]);
  out.process = std::stol(parts[4]);
  return out;
}

std::vector<char> bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in)
    throw FileError(path, "cannot be opened");
  std::vector<char> bytes(static_cast<std::size_t>(std::max<std::streamoff>(in.tellg(), 0)));
  in.seekg(0);
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!in)
    throw FileError(path, "cannot be read");
  return bytes;
}

Conduit::TypeId type_of(const std::string& name) {
  static const std::map<std::string, Conduit::TypeId> types = {
      {"empty", Conduit::empty},     {"int8", Conduit::int8},
      {"int16", Conduit::int16},     {"int32", Conduit::int32},
      {"int64", Conduit::int64},     {"uint8", Conduit::uint8},
      {"uint16", Conduit::uint16},   {"uint32", Conduit::uint32},
      {"uint64", Conduit::uint64},   {"float32", Conduit::float32},
      {"float64", Conduit::float64}, {"char8_str", Conduit::char8_str}};
  const auto found = types.find(name);
  return found == types.end() ? Conduit::object : found->second;
}

/// Makes trees of schemas.
class Reader {
public:
  Reader(const std::string& path, Dump& dump) : path_(path), dump_(dump) {}

  void read(const Json& schema, Tree& tree, const std::string& at, int depth) {
    if (depth > 64)
      throw FileError(path_, at + ": is more than 64 levels deep");
    if (schema.is_object() && schema.contains("dtype") && schema["dtype"].is_string()) {
      read_leaf(schema, tree, at);
    } else if (schema.is_object()) {
      for (const auto& [name, child] : schema.items())
        read(child, child_of(tree, name), at + "/" + name, depth + 1);
    } else if (schema.is_array()) {
      for (const Json& child : schema)
        read(child, tree.append(), at + "/" + std::to_string(tree.children.size() - 1), depth + 1);
    } else {
      throw FileError(path_, at + ": the schema has neither a type nor children");
    }
  }

private:
  /// Names of children may hold slashes, which make() would take for a path.
  static Tree& child_of(Tree& tree, const std::string& name) {
    tree.type = Conduit::object;
    Tree& child = *tree.children.emplace_back(std::make_unique<Tree>());
    child.name = name;
    return child;
  }

  static std::int64_t number(const Json& schema, const char* key, std::int64_t otherwise) {
    const auto found = schema.find(key);
    return found != schema.end() && found->is_number_integer() ? found->get<std::int64_t>()
                                                               : otherwise;
  }

  void read_leaf(const Json& schema, Tree& tree, const std::string& at) {
    const auto type = type_of(schema["dtype"].get<std::string>());
    if (type == Conduit::object)
      throw FileError(path_, at + ": has the unknown type " + schema["dtype"].dump());
    if (type == Conduit::empty)
      return;
    const std::int64_t bytes = Conduit::bytes_of(type),
                       count = number(schema, "number_of_elements", 1),
                       offset = number(schema, "offset", 0),
                       stride = number(schema, "stride", bytes),
                       size = std::int64_t(dump_.bytes.size());
    const bool fits =
        count >= 0 && offset >= 0 && offset <= size && stride >= 0 &&
        (count == 0 || (bytes <= size - offset &&
                        (stride == 0 || count - 1 <= (size - offset - bytes) / stride)));
    if (!fits)
      throw FileError(path_, at + ": " + std::to_string(count) + " values from byte " +
                                 std::to_string(offset) + " on reach beyond the file's " +
                                 std::to_string(size) + " bytes");
    if (type == Conduit::char8_str &&
        (count == 0 || dump_.bytes[std::size_t(offset + (count - 1) * stride)] != '\0'))
      throw FileError(path_, at + ": is a text without an end");
    tree.set_external(type, dump_.bytes.data(), count, offset, stride);
    if (type == Conduit::char8_str) // read from its first byte on
      tree.set_external(type, dump_.bytes.data() + offset, count, 0, stride);
    const auto order = schema.find("endianness");
    tree.same_endianness = order == schema.end() || *order != "big";
  }

  const std::string& path_;
  Dump& dump_;
};

/// The meshes of a process's channels as domains among those of the others.
void add_domains(Tree& all, Tree& of_process, std::size_t process) {
  Tree* channels = of_process.find("catalyst/channels");
  if (!channels)
    return;
  for (const auto& channel : channels->children) {
    Tree& to = all.make("catalyst/channels/" + channel->name);
    for (auto& part : channel->children)
      if (part && part->name != "data" && !to.find(part->name))
        to.children.push_back(std::move(part));
    Tree* data = nullptr;
    for (const auto& part : channel->children)
      if (part && part->name == "data")
        data = part.get();
    if (!data)
      continue;
    const Tree* type = to.find("type");
    const bool blocks = type && type->data && std::string(type->data) == "multimesh";
    const auto put = [&](Tree& under, std::unique_ptr<Tree> domain) {
      domain->name = "process_" + std::to_string(process) + "_" + domain->name;
      under.type = Conduit::object;
      under.children.push_back(std::move(domain));
    };
    Tree& under = to.make("data");
    const auto add = [&](Tree& meshes, Tree& mesh) { // a mesh, or its domains
      if (mesh.find("coordsets") || mesh.find("topologies")) {
        auto domain = std::make_unique<Tree>(std::move(mesh));
        put(meshes, std::move(domain));
      } else {
        for (auto& domain : mesh.children)
          put(meshes, std::move(domain));
      }
    };
    if (!blocks)
      add(under, *data);
    else
      for (const auto& block : data->children)
        add(under.make(block->name), *block);
  }
}

/// Takes the ids of a mesh's domains away where two have the same: each process numbered its own,
/// and the domains' order is that of the processes.
void drop_repeated_ids_of_mesh(Tree& domains) {
  std::set<std::int64_t> known;
  bool again = false;
  const auto id_of = [](Tree& domain) {
    return Node(Tree::functions(), &domain, "").find("state/domain_id");
  };
  for (const auto& domain : domains.children)
    if (const Node id = id_of(*domain))
      again = !known.insert(id.integer()).second || again;
  for (const auto& domain : domains.children)
    if (again && id_of(*domain))
      domain->remove("state/domain_id");
}

void drop_repeated_ids(Tree& call) {
  Tree* channels = call.find("catalyst/channels");
  for (std::size_t c = 0; channels && c < channels->children.size(); ++c)
    if (Tree* data = channels->children[c]->find("data")) {
      drop_repeated_ids_of_mesh(*data);
      for (const auto& block : data->children) // of a multimesh
        drop_repeated_ids_of_mesh(*block);
    }
}

} // namespace

std::unique_ptr<Dump> read_dump(const std::string& path) {
  auto dump = std::make_unique<Dump>();
  dump->bytes = bytes_of(path);
  const std::string schema_path = path + "_json";
  const std::vector<char> text = bytes_of(schema_path);
  const Json schema = Json::parse(text.begin(), text.end(), nullptr, false);
  if (schema.is_discarded())
    throw FileError(schema_path, "is no JSON");
  Reader(path, *dump).read(schema, dump->tree, "", 0);
  return dump;
}

bool are_dumps(const std::vector<std::string>& files) {
  return std::any_of(files.begin(), files.end(), [](const std::string& file) {
    return name_of(file) || (std::filesystem::is_directory(file) && !is_openfoam_case(file));
  });
}

DumpedRun find_dumps(const std::vector<std::string>& files) {
  std::map<long, std::map<long, std::string>> calls; // -1: initialize
  std::map<long, long> processes;
  const auto add = [&](const std::string& path) {
    if (const auto name = name_of(path)) {
      calls[name->call.value_or(-1)][name->process] = path;
      processes[name->call.value_or(-1)] = name->processes;
    }
  };
  for (const std::string& file : files)
    if (std::filesystem::is_directory(file))
      for (const auto& entry : std::filesystem::directory_iterator(file))
        add(entry.path().string());
    else
      add(file);
  DumpedRun run;
  for (const auto& [call, dumps] : calls) {
    std::vector<std::string> paths;
    for (long p = 0; p < processes[call]; ++p) {
      const auto found = dumps.find(p);
      if (found == dumps.end())
        throw FileError(dumps.begin()->second, "the dump of process " + std::to_string(p) + " of " +
                                                   std::to_string(processes[call]) + " is missing");
      paths.push_back(found->second);
    }
    if (call < 0)
      run.initialize = paths;
    else
      run.executes.push_back(paths);
  }
  if (run.executes.empty())
    throw FileError(files.front(), "has no dumps of Catalyst's calls "
                                   "(execute_invcN_params.conduit_bin.RANKS.RANK)");
  return run;
}

namespace {

/// One call: the dumps of all processes, and their channels as one tree.
class Call {
public:
  Call(const std::vector<std::string>& paths, DumpArrays& arrays) {
    for (const std::string& path : paths) {
      dumps_.push_back(read_dump(path));
      if (arrays.take(dumps_.back()->tree, dumps_.size() - 1))
        dumps_.back()->bytes = {};
    }
    if (dumps_.size() == 1)
      return;
    for (std::size_t p = 0; p < dumps_.size(); ++p)
      add_domains(all_, dumps_[p]->tree, p);
    if (Tree* state = dumps_[0]->tree.find("catalyst/state"))
      all_.make("catalyst/state") = std::move(*state);
    drop_repeated_ids(all_);
  }
  Node catalyst() { return catalyst_of(dumps_.size() == 1 ? dumps_[0]->tree : all_); }
  static Node catalyst_of(Tree& tree) { return Node(Tree::functions(), &tree, "").at("catalyst"); }

private:
  std::vector<std::unique_ptr<Dump>> dumps_;
  Tree all_;
};

/// The parameters of initialize, as the command line changes them.
void change_start(const ReplayOptions& options, Tree& start) {
  start.make("catalyst");
  start.remove("catalyst/mpi_comm"); // a number of another run
  if (!options.out.empty())
    start.make("catalyst/insitu/output")
        .set_copy(Conduit::char8_str, options.out.c_str(), std::int64_t(options.out.size()) + 1);
  if (options.threads > 0)
    Tree::functions().set_path_int64(&start, "catalyst/insitu/threads", options.threads);
  if (options.strict)
    Tree::functions().set_path_int64(&start, "catalyst/insitu/strict", 1);
}

void refuse_other_options(const ReplayOptions& options) {
  if (options.reverse || options.preview || options.separate_pieces || !options.probe.empty() ||
      !options.blanks.empty() || !options.summary.empty())
    throw UsageError("dumps of Catalyst's calls are replayed with --scene, --out, --threads, "
                     "--strict, --check, --plan and --validate alone");
}

/// Prints the plan of a run of which the first call was given, or its dry run; true if no item is
/// skipped.
bool look_at(const ReplayOptions& options, insitu::catalyst::Run& run, const Node& start,
             std::size_t calls) {
  if (options.plan) {
    std::cout << run.session().plan();
    return true;
  }
  const std::string scene =
      options.scene.empty() ? insitu::catalyst::scene_of(start) : options.scene;
  const Node output = start.find("insitu/output");
  const std::vector<std::string> problems = check_run(
      run.session(), run.meshes(), calls, text_of(scene), output ? output.text() : std::string());
  for (const std::string& problem : problems)
    std::fprintf(stderr, "insitu-replay: %s\n", problem.c_str());
  return problems.empty();
}

} // namespace

bool replay_dumps(const ReplayOptions& options) {
  refuse_other_options(options);
  const DumpedRun calls = find_dumps(options.files);
  std::unique_ptr<Dump> first =
      calls.initialize.empty() ? std::make_unique<Dump>() : read_dump(calls.initialize[0]);
  change_start(options, first->tree);
  const Node start = Call::catalyst_of(first->tree);
  DumpArrays arrays;                  // as long as the session may read them
  std::unique_ptr<Call> before, call; // and what these hold
  insitu::catalyst::Run run(start, options.scene);
  bool well = true;
  for (const std::vector<std::string>& paths : calls.executes)
    try {
      call = std::make_unique<Call>(paths, arrays);
      if (options.check || options.plan) {
        run.give(call->catalyst());
        well = look_at(options, run, start, calls.executes.size());
        break;
      }
      if (options.validate) {
        run.give(call->catalyst());
        well = validate_meshes(run.meshes(), paths.front()) && well;
      } else {
        well = run.execute(call->catalyst()) && well;
      }
      arrays.forget_replaced();
      before = std::move(call);
    } catch (const insitu::Error& e) {
      throw FileError(paths.front(), e.what());
    }
  run.close();
  return well;
}

} // namespace insitu_replay
