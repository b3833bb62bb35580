#include "scene/run/page_record.h"

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <utility>

namespace insitu::scene {

namespace {

using output::JsonText;

/// Entries that wait for a folder that cannot be written; the oldest are dropped.
constexpr std::size_t most_waiting = 64;

void append(std::string& list, const JsonText& item) {
  list += (list.empty() ? "" : ",") + item.text();
}

void add_table(std::string& list, const char* kind, const std::string& name, const char* ending) {
  JsonText item;
  item.open('{').key("kind").value(kind).key("file").value(name + ending).close();
  append(list, item);
}

bool has(const std::vector<TableFormat>& formats, TableFormat format) {
  return std::find(formats.begin(), formats.end(), format) != formats.end();
}

/// How seconds differ between processes.
void add_processes(JsonText& entry, const SecondsOfAll& all) {
  entry.key("processes").open('{').key("count").value(std::int64_t(all.processes));
  for (const auto& [key, seconds] : {std::pair("least", &all.least), std::pair("mean", &all.mean),
                                     std::pair("greatest", &all.greatest)}) {
    entry.key(key).open('[');
    for (const double s : *seconds)
      entry.short_value(s);
    entry.close();
  }
  entry.close();
}

/// The tables that grow over the run: files of a single cycle are too many to list.
std::string tables_of(const SceneDescription& scene) {
  std::string list;
  for (const Probe& p : scene.probes) {
    if (has(p.output, TableFormat::csv))
      add_table(list, "probe", p.name, ".csv");
    if (has(p.output, TableFormat::netcdf))
      add_table(list, "probe", p.name, ".nc");
    if (has(p.output, TableFormat::vtp))
      add_table(list, "probe", p.name, ".pvd");
  }
  for (const Tracer& t : scene.tracers) {
    if (has(t.output, TableFormat::csv) && t.kind != TracerKind::streamline)
      add_table(list, "tracer", t.name, ".csv");
    if (has(t.output, TableFormat::netcdf))
      add_table(list, "tracer", t.name, ".nc");
    if (has(t.output, TableFormat::vtp))
      add_table(list, "tracer", t.name, ".pvd");
  }
  return list;
}

std::string now() {
  const std::time_t t = std::time(nullptr);
  std::tm utc{};
  char text[32] = "";
  if (::gmtime_r(&t, &utc))
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

} // namespace

PageRecord::PageRecord(const SceneDescription& scene, const std::string& folder,
                       core::Context& context, Statistics& statistics)
    : file_(scene.file), folder_(folder), files_(tables_of(scene)), context_(context),
      statistics_(statistics), now_{{}, statistics, {}, {}, {}, {}, {}, {}, false} {}

void PageRecord::begin_step(bool again) {
  if (!again) {
    last_.reset();
  } else if (last_) {
    now_ = *std::exchange(last_, std::nullopt);
    now_.tracers.clear(); // all are noted at the step's end
    replaces_ = true;
  }
}

void PageRecord::add_frame(const std::string& name, const std::string& kind,
                           const std::string& path) {
  if (refused_ || !now_.names.insert(path).second)
    return;
  JsonText item;
  item.open('{').key("name").value(name).key("kind").value(kind);
  item.key("file").value(std::filesystem::path(path).filename().string()).close();
  append(now_.frames, item);
}

void PageRecord::add_probe(const std::string& name, std::span<const std::string> columns,
                           std::span<const math::Vec3d> points, std::span<const std::string> names,
                           std::span<const double> values) {
  if (refused_ || !now_.names.insert(name).second)
    return;
  const std::size_t n = points.size(), shown = std::min(n, most_points),
                    width = std::min(columns.size(), most_columns);
  // Spread over all of them, the first and the last included.
  const auto point = [&](std::size_t i) { return shown < 2 ? i : i * (n - 1) / (shown - 1); };
  JsonText item;
  item.open('{').key("name").value(name);
  std::string description = name;
  for (const std::string& column : columns)
    description += '\n' + column;
  if (described_.insert(description).second) {
    item.key("total").value(std::int64_t(n)).key("all_columns").value(std::int64_t(columns.size()));
    item.key("columns").open('[');
    for (std::size_t c = 0; c < width; ++c)
      item.value(columns[c]);
    item.close().key("points").open('[');
    for (std::size_t i = 0; i < shown; ++i) {
      const std::size_t p = point(i);
      item.open('{').key("point").value(std::int64_t(p));
      if (!names.empty())
        item.key("name").value(names[p]);
      item.key("at").open('[');
      for (int axis = 0; axis < 3; ++axis)
        item.short_value(points[p][axis]);
      item.close().close();
    }
    item.close();
  }
  item.key("values").open('[');
  for (std::size_t i = 0; i < shown; ++i) {
    item.open('[');
    for (std::size_t c = 0; c < width; ++c)
      item.short_value(values[point(i) * columns.size() + c]);
    item.close();
  }
  item.close().close();
  append(now_.probes, item);
}

void PageRecord::add_tracer(const std::string& name, const advect::Counts& counts) {
  if (refused_)
    return;
  JsonText item;
  item.open('{').key("name").value(name).key("seeded").value(counts.seeded);
  item.key("endings").open('[');
  for (const std::int64_t count : counts.by_ending)
    item.value(count);
  item.close().close();
  append(now_.tracers, item);
}

void PageRecord::add_plan(const std::string& text) {
  if (text != last_plan_)
    now_.plan = last_plan_ = text;
}

void PageRecord::add_message(const std::string& level, const std::string& text) {
  if (!refused_)
    now_.messages.push_back({level, text});
}

void PageRecord::add_session(JsonText& entry) const {
  entry.key("session").open('{').key("scene").value(file_).key("started").value(now());
  entry.key("library").value(INSITU_VERSION_STRING);
  entry.key("threads").value(std::int64_t(context_.threads.count()));
  entry.key("tables").raw("[" + files_ + "]");
  entry.key("endings").open('[');
  for (int e = 0; e < INSITU_END_COUNT; ++e)
    entry.value(advect::ending_name(insitu_ending(e)));
  entry.close().key("purposes").open('[');
  for (int p = 0; p < INSITU_MEMORY_COUNT; ++p)
    entry.value(core::purpose_name(insitu_purpose(p)));
  entry.close().close();
}

/// seconds: of several processes; null: the session ends.
std::string PageRecord::make_entry(const SecondsOfAll* all, const core::Timer& began) {
  const Statistics &s = statistics_, &b = now_.before;
  JsonText e;
  e.open('{').key("cycle").value(cycle_).key("time").value(time_);
  if (!now_.begun)
    add_session(e);
  e.key("executions").value(s.executions - b.executions).key("wall");
  e.short_value(now_.since.seconds() - began.seconds());
  e.key("seconds").open('[');
  const Seconds until_now = seconds_of(s), until_before = seconds_of(b);
  for (std::size_t i = 0; i < until_now.size(); ++i)
    e.short_value(until_now[i] - until_before[i]);
  e.close().key("bytes").open('[');
  for (int p = 0; p < INSITU_MEMORY_COUNT; ++p)
    e.value(context_.memory.current(insitu_purpose(p)));
  e.close().key("peak").value(context_.memory.peak());
  if (all && all->processes > 1)
    add_processes(e, *all);
  if (s.failures > b.failures)
    e.key("failures").value(s.failures - b.failures);
  for (const auto& [key, list] :
       {std::pair<const char*, const std::string*>{"frames", &now_.frames},
        {"probes", &now_.probes},
        {"tracers", &now_.tracers}})
    if (!list->empty())
      e.key(key).raw("[" + *list + "]");
  if (!now_.plan.empty())
    e.key("plan").value(now_.plan);
  if (!now_.messages.empty()) {
    e.key("messages").open('[');
    for (const Message& m : now_.messages)
      e.open('{').key("level").value(m.level).key("text").value(m.text).close();
    e.close();
  }
  if (!all)
    e.key("finished").value(true);
  e.close();
  last_ = std::exchange(now_, {began, statistics_, {}, {}, {}, {}, {}, {}, true});
  return e.text();
}

void PageRecord::write(std::string entry) {
  if (replaces_ && !waiting_.empty())
    waiting_.pop_back();
  else if (replaces_ && page_)
    page_->take_back();
  replaces_ = false;
  waiting_.push_back(std::move(entry));
  if (waiting_.size() > most_waiting)
    waiting_.erase(waiting_.begin() + 1); // the first one describes the session
  try {
    if (!page_) {
      page_ = std::make_unique<output::RunPage>(folder_, first_cycle_);
      statistics_.files += 2;
    }
  } catch (const output::BeingWritten& e) {
    refused_ = true;
    waiting_.clear();
    context_.log.warning("the page of the run in '" + folder_ +
                         "' is another session's; this one has none (give it a folder of its own, "
                         "or say 'page: false' in its scene): " +
                         e.what());
    return;
  }
  std::size_t done = 0;
  try {
    for (; done < waiting_.size(); ++done)
      page_->add(waiting_[done]);
  } catch (...) {
    waiting_.erase(waiting_.begin(), waiting_.begin() + std::ptrdiff_t(done));
    throw;
  }
  waiting_.clear();
}

void PageRecord::take_warnings() {
  for (const std::string& warning : context_.log.take_warnings())
    if (warned_.size() < core::Log::most_kept && warned_.insert(warning).second)
      add_message("warning", warning);
}

void PageRecord::end_cycle(std::int64_t cycle, double time, const SecondsOfAll& seconds,
                           const core::Timer& began) {
  if (!now_.begun)
    first_cycle_ = cycle;
  cycle_ = cycle;
  time_ = time;
  write(make_entry(&seconds, began));
}

void PageRecord::finish() {
  if (now_.begun && !refused_)
    write(make_entry(nullptr, {}));
  page_.reset();
}

} // namespace insitu::scene
