// Records whose description says anything: each one is refused with the file's name and a path in
// it, or gives meshes that the library takes or refuses; nothing crashes, and nothing is read
// outside the datasets. Input is a description; the datasets are of any length that it asks for, up
// to a few hundred numbers. HDF5's own metadata have checksums, and are not made up here.
#include <cstdint>
#include <cstring>
#include <map>
#include <string>

#include "output/files/checksum.h"
#include "promises.h"
#include "records/meshes.h"

namespace {

using insitu::output::HdfDataset;

class Source final : public insitu_replay::RecordSource {
public:
  explicit Source(std::string description) : description_(std::move(description)) {}

  HdfDataset dataset(const std::string& where) const override {
    if (where == "/insitu/description" || where == "/insitu/scene")
      return {INSITU_UINT8, {std::int64_t(text_of(where).size())}};
    HdfDataset out;
    constexpr std::int64_t most = 400;
    out.extents = {most};
    for (const auto& [name, type] : {std::pair{".float32", INSITU_FLOAT32},
                                     {".float64", INSITU_FLOAT64},
                                     {".int32", INSITU_INT32},
                                     {".int64", INSITU_INT64},
                                     {".uint8", INSITU_UINT8}})
      if (where.find(name) != std::string::npos)
        out.type = type;
    // As many numbers as the name ends in, if it does: "points.float64x3 24".
    if (const auto blank = where.rfind(' '); blank != std::string::npos) {
      const long asked = std::strtol(where.c_str() + blank, nullptr, 10);
      if (asked > 0 && asked < most)
        out.extents = {asked};
    }
    return out;
  }
  void read(const std::string& where, const HdfDataset& dataset, std::int64_t first,
            std::int64_t count, std::byte* to) const override {
    fuzz::require(first >= 0 && count >= 0 && first <= dataset.numbers() - count,
                  "values that are there");
    if (dataset.type == INSITU_UINT8 && where.find('.') == std::string::npos) {
      std::memcpy(to, text_of(where).data() + first, std::size_t(count));
      return;
    }
    const std::byte* const begin = to;
    for (std::int64_t i = 0; i < count; ++i) { // small numbers: ids of vertices, among others
      const auto n = std::int64_t((first + i) * 7 % 8);
      const double real = double(n) / 4;
      const float single = float(real);
      const auto integer = std::int32_t(n);
      const auto byte = std::uint8_t(n == 7 ? 12 : 0);
      const auto put = [&](const auto& value) {
        std::memcpy(to, &value, sizeof value);
        to += sizeof value;
      };
      switch (dataset.type) {
      case INSITU_FLOAT32:
        put(single);
        break;
      case INSITU_FLOAT64:
        put(real);
        break;
      case INSITU_INT32:
        put(integer);
        break;
      case INSITU_INT64:
        put(n);
        break;
      case INSITU_UINT8:
        put(byte);
        break;
      }
    }
    sums_[where].add({reinterpret_cast<const char*>(begin), std::size_t(to - begin)});
  }
  /// Those of what was read, as of one process; records of several are refused at the end.
  std::vector<std::int64_t> checksums(const std::string& where) const override {
    if (where.find('.') != std::string::npos)
      return {std::int64_t(sums_[where].sum())};
    insitu::output::Checksum sum;
    sum.add(text_of(where));
    return {std::int64_t(sum.sum())};
  }
  std::string path() const override { return "record.hdf"; }

private:
  const std::string& text_of(const std::string& where) const {
    static const std::string scene = "insitu: 1\n";
    return where == "/insitu/scene" ? scene : description_;
  }
  std::string description_;
  mutable std::map<std::string, insitu::output::Checksum> sums_; ///< by dataset
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Source source(std::string(reinterpret_cast<const char*>(data), size));
  insitu::Options options;
  options.threads = 1;
  options.log = [](insitu::LogLevel, const std::string&) {};
  insitu_replay::RecordedMeshes meshes; // outlives the session, which reads its arrays
  insitu::Session session(options);
  try {
    const insitu_replay::Record record = insitu_replay::read_record(source);
    meshes.give(session, source, record);
    (void)session.execute(0, 0.0);
  } catch (const insitu_replay::FileError& e) {
    fuzz::require(std::string(e.what()).rfind("record.hdf: ", 0) == 0, "the file's name");
  } catch (const insitu::Error&) { // the mesh is refused
  }
  return 0;
}
