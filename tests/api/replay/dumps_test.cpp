// Dumps of Catalyst's calls, as its stub writes them: files of bytes and their schemas, a process
// each.
#include <algorithm>

#include "replay.h"

namespace {

/// Writes the leaves of a tree one after the other, and their schema.
class DumpWriter {
public:
  void text(const std::string& path, const std::string& value) {
    leaf(path, "char8_str", std::int64_t(value.size()) + 1, 1, value.c_str());
  }
  void integer(const std::string& path, std::int64_t value) { leaf(path, "int64", 1, 8, &value); }
  void real(const std::string& path, double value) { leaf(path, "float64", 1, 8, &value); }
  void reals(const std::string& path, const std::vector<double>& values) {
    leaf(path, "float64", std::int64_t(values.size()), 8, values.data());
  }

  void write(const std::string& file) const {
    std::ofstream(file, std::ios::binary).write(bytes_.data(), std::streamsize(bytes_.size()));
    std::ofstream(file + "_json") << schema_of(root_);
  }

private:
  struct Entry {
    std::string leaf;
    std::vector<std::pair<std::string, Entry>> children;
  };
  void leaf(const std::string& path, const char* type, std::int64_t count, std::int64_t bytes,
            const void* data) {
    Entry* at = &root_;
    std::istringstream names(path);
    for (std::string name; std::getline(names, name, '/');) {
      const auto found = std::find_if(at->children.begin(), at->children.end(),
                                      [&](const auto& child) { return child.first == name; });
      at = found != at->children.end() ? &found->second
                                       : &at->children.emplace_back(name, Entry()).second;
    }
    at->leaf =
        "{\"dtype\":\"" + std::string(type) + "\",\"number_of_elements\":" + std::to_string(count) +
        ",\"offset\":" + std::to_string(bytes_.size()) + ",\"stride\":" + std::to_string(bytes) +
        ",\"element_bytes\":" + std::to_string(bytes) + ",\"endianness\":\"little\"}";
    const char* from = static_cast<const char*>(data);
    bytes_.insert(bytes_.end(), from, from + count * bytes);
  }
  static std::string schema_of(const Entry& entry) {
    if (!entry.leaf.empty())
      return entry.leaf;
    std::string out;
    for (const auto& [name, child] : entry.children)
      out += (out.empty() ? "\"" : ",\n\"") + name + "\":" + schema_of(child);
    return "{" + out + "}";
  }

  Entry root_;
  std::vector<char> bytes_;
};

struct Dumps : Replay {
  /// Two processes with a box of two cells each, beside each other along x; f is x + cycle.
  void dump(int cycle, int process) const {
    DumpWriter w;
    const std::string data = "catalyst/channels/grid/data/";
    w.integer("catalyst/state/timestep", cycle);
    w.real("catalyst/state/time", 0.5 * cycle);
    w.text("catalyst/channels/grid/type", "mesh");
    if (cycle > 4) // each process numbers its own domain
      w.integer(data + "state/domain_id", 0);
    w.text(data + "coordsets/c/type", "uniform");
    w.integer(data + "coordsets/c/dims/i", 3);
    w.integer(data + "coordsets/c/dims/j", 2);
    w.integer(data + "coordsets/c/dims/k", 2);
    w.real(data + "coordsets/c/origin/x", 2.0 * process);
    w.text(data + "topologies/t/type", "uniform");
    w.text(data + "topologies/t/coordset", "c");
    w.text(data + "fields/f/association", "vertex");
    w.text(data + "fields/f/topology", "t");
    std::vector<double> f;
    for (int v = 0; v < 12; ++v)
      f.push_back(2 * process + v % 3 + cycle);
    w.reals(data + "fields/f/values", f);
    w.write(name_of(cycle, process));
  }
  std::string name_of(int cycle, int process) const {
    return path("execute_invc" + std::to_string(cycle) + "_params.conduit_bin.2." +
                std::to_string(process));
  }
  void SetUp() override {
    Replay::SetUp();
    put("dumps.yaml", "insitu: 1\nprobes:\n  - {name: g, mesh: grid, points: [[0.5, 0.5, 0.5], "
                      "[3.25, 0.5, 0.5]], fields: [f]}\n");
    for (int cycle = 0; cycle < 11; ++cycle) // 10 is not between 1 and 2
      for (int process = 0; process < 2; ++process)
        dump(cycle, process);
  }
};

TEST_F(Dumps, OfSeveralProcessesAreOneMesh) {
  const Outcome o = run("--scene dumps.yaml --out out .");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Row> rows = Replay::rows("out/g.csv");
  ASSERT_EQ(rows.size(), 22u);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double cycle = double(r / 2);
    EXPECT_EQ(rows[r].at("cycle"), cycle);
    EXPECT_EQ(rows[r].at("time"), 0.5 * cycle);
    EXPECT_EQ(rows[r].at("f"), (r % 2 == 0 ? 0.5 : 3.25) + cycle);
  }
}

TEST_F(Dumps, ThatAreCutShortOrMissingAreNamed) {
  const auto expect = [&](const std::string& text) {
    const Outcome o = run("--scene dumps.yaml --out out .");
    EXPECT_EQ(o.code, 1);
    EXPECT_NE(o.err.find(text), std::string::npos) << o.err;
  };
  fs::resize_file(name_of(3, 1), 150);
  expect("execute_invc3_params.conduit_bin.2.1: /catalyst/");
  dump(3, 1);
  fs::resize_file(name_of(3, 1) + "_json", 150);
  expect("execute_invc3_params.conduit_bin.2.1_json: is no JSON");
  fs::remove(name_of(3, 1));
  expect("the dump of process 1 of 2 is missing");
  const Outcome o = run("--plan .");
  EXPECT_EQ(o.code, 2) << o.err;
}

} // namespace
