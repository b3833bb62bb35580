#include "run.h"

#include <cstdio>
#include <cstdlib>

namespace insitu::catalyst {

namespace {

using blueprint::Node;

bool ends_in(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool is_scene(const std::string& path) {
  return ends_in(path, ".yaml") || ends_in(path, ".yml");
}

Options options_of(const Node& catalyst, const std::string& scene) {
  Options o;
  o.scene = scene.empty() ? scene_of(catalyst) : scene;
  o.default_scene = o.scene.empty();
  if (const Node communicator = catalyst.find("mpi_comm"))
    o.fortran_communicator = static_cast<int>(communicator.integer());
  if (const Node output = catalyst.find("insitu/output"))
    o.output = output.text();
  if (const Node threads = catalyst.find("insitu/threads"))
    o.threads = static_cast<int>(threads.integer());
  if (const Node strict = catalyst.find("insitu/strict"))
    o.strict = strict.integer() != 0;
  return o;
}

/// A probe's points, and what it answered there, by columns as its table has them.
void write_answers(const ProbeAnswers& a, const blueprint::Conduit& conduit, void* node) {
  const std::string path = "catalyst/insitu/probes/" + std::string(a.name) + "/";
  const auto points = static_cast<std::size_t>(a.point_count);
  std::vector<double> column(points);
  const auto write = [&](const std::string& name, const double* first, std::size_t step) {
    for (std::size_t p = 0; p < points; ++p)
      column[p] = first[p * step];
    conduit.set_path_float64_ptr(node, (path + name).c_str(), column.data(), a.point_count);
  };
  conduit.set_path_int64(node, (path + "cycle").c_str(), a.cycle);
  conduit.set_path_float64(node, (path + "time").c_str(), a.time);
  for (std::size_t c = 0; c < 3; ++c)
    write(std::string("points/") + "xyz"[c], a.points + c, 3);
  std::vector<std::uint8_t> inside(a.inside, a.inside + points);
  conduit.set_path_uint8_ptr(node, (path + "inside").c_str(), inside.data(), a.point_count);
  const auto columns = static_cast<std::size_t>(a.column_count);
  for (std::size_t c = 0; c < columns; ++c)
    write("fields/" + std::string(a.column_names[c]), a.values + c, columns);
}

} // namespace

void say(const char* prefix, const std::string& text) {
  std::fprintf(stderr, "insitu: %scatalyst: %s\n", prefix, text.c_str());
}

std::string scene_of(const Node& catalyst) {
  if (const char* scene = std::getenv("INSITU_SCENE"); scene && *scene)
    return scene;
  std::string found;
  const Node scripts = catalyst.find("scripts");
  for (std::int64_t i = 0; i < scripts.size(); ++i) {
    Node script = scripts.child(i);
    if (!script.is_leaf())
      script = script.at("filename");
    const std::string path = script.text();
    if (!is_scene(path))
      continue; // another implementation's
    if (!found.empty())
      script.refuse(INSITU_ERROR_UNSUPPORTED,
                    "is a second scene, " + path + ", after " + found + "; a run has one");
    found = path;
  }
  return found;
}

Run::Run(const Node& catalyst, const std::string& scene) {
  const Options options = options_of(catalyst, scene);
  try {
    session_.emplace(options);
    const Node answers = catalyst.find("insitu/answers");
    session_->keep_answers(!answers || answers.integer() != 0); // all processes agree
  } catch (const Error& e) {
    throw Logged(e);
  }
}

void Run::say_once(const std::string& text) {
  if (said_.insert(text).second)
    say("warning: ", text);
}

void Run::attach(const std::string& mesh, const Node& data,
                 const blueprint::Attachment::Options& options) {
  std::unique_ptr<Channel>& c = channels_[mesh];
  const bool fresh = !c;
  if (fresh) {
    c = std::make_unique<Channel>(session_->mesh(mesh).handle());
    c->adaptive = options.adaptive;
  }
  try {
    c->present = true;
    c->attachment.update(data, options);
    for (const std::string& line : c->attachment.left_out())
      say_once("left out: " + line);
  } catch (const Error& e) {
    if (e.status() != INSITU_ERROR_UNSUPPORTED)
      throw;
    say_once(e.what());
    c->present = false; // the mesh then has no cells
  }
}

void Run::attach_all(const std::string& mesh, const Node& data, const Node& channel) {
  attach(mesh, data, {"", false, false, channel});
  for (const std::string& topology : blueprint::other_topologies_of(data))
    attach(mesh + "/" + topology, data, {topology, true, false, channel});
}

void Run::attach_channel(const Node& channel) {
  const Node type_node = channel.find("type");
  const std::string type = type_node ? type_node.text() : "mesh";
  const Node data = channel.find("data");
  if (type == "mesh") {
    attach_all(channel.name(), data, channel);
  } else if (type == "amrmesh") {
    attach(channel.name(), data, {"", false, true, channel});
  } else if (type == "multimesh") {
    for (std::int64_t i = 0; i < data.size(); ++i)
      attach_all(channel.name() + "/" + data.child(i).name(), data.child(i), channel);
  } else {
    say_once(type_node.path() + " is " + type + "; mesh, multimesh and amrmesh are supported");
  }
}

void Run::take_clock(const Node& catalyst) {
  const Node state = catalyst.find("state");
  Node cycle = state.find("timestep");
  if (!cycle)
    cycle = state.find("cycle");
  cycle_ = cycle ? cycle.integer() : cycle_ + 1;
  if (const Node time = state.find("time"))
    time_ = time.real();
  else
    time_ = static_cast<double>(cycle_);
}

std::optional<Error> Run::give_channels(const Node& catalyst) {
  take_clock(catalyst);
  for (auto& [name, channel] : channels_)
    channel->present = false;
  std::optional<Error> wrong;
  const Node channels = catalyst.find("channels");
  for (std::int64_t i = 0; i < channels.size(); ++i)
    try {
      attach_channel(channels.child(i));
    } catch (const Error& e) { // its mesh is refused, which the session tells all processes
      wrong = e;
    }
  for (auto& [name, channel] : channels_)
    if (!channel->present) // its arrays may be gone
      channel->attachment.update({}, {"", false, channel->adaptive, {}});
  return wrong;
}

void Run::give(const Node& catalyst) {
  if (const std::optional<Error> wrong = give_channels(catalyst))
    throw *wrong;
}

std::vector<std::pair<std::string, Mesh>> Run::meshes() {
  std::vector<std::pair<std::string, Mesh>> out;
  for (const auto& [name, channel] : channels_)
    if (channel->present)
      out.emplace_back(name, session_->mesh(name));
  return out;
}

bool Run::execute(const Node& catalyst) {
  const std::optional<Error> wrong = give_channels(catalyst);
  const bool all_well = session_->execute(cycle_, time_);
  if (wrong)
    throw *wrong;
  return all_well;
}

void Run::write_results(const blueprint::Conduit& conduit, void* node) const {
  const Report r = session_->report();
  const auto count = [&](const char* name, std::int64_t value) {
    conduit.set_path_int64(node, (std::string("catalyst/insitu/") + name).c_str(), value);
  };
  count("cycle", cycle_);
  count("executions", r.executions);
  count("frames", r.frames);
  count("probe_rows", r.probe_rows);
  count("failures", r.failures);
  count("points_located", r.points_located);
  count("points_outside", r.points_outside);
  count("particles_seeded", r.particles_seeded);
  count("particles_alive", r.particles[INSITU_END_ALIVE]);
  conduit.set_path_float64(node, "catalyst/insitu/time", time_);
  for (const ProbeAnswers& answers : session_->answers())
    if (answers.answered)
      write_answers(answers, conduit, node);
}

} // namespace insitu::catalyst
