#include "scene/record/record_file.h"

#include <algorithm>
#include <span>
#include <string_view>

#include "output/files/checksum.h"
#include "parallel/bytes.h"

namespace insitu::scene {

namespace {

constexpr std::size_t most_bytes = std::size_t(1) << 24;   ///< of all processes, on their way
constexpr std::size_t fewest_bytes = std::size_t(1) << 16; ///< of one process

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

} // namespace

/// A dataset that processes add to, as all of them know it; the numbers of the root alone.
struct RecordFile::Dataset {
  std::string where;
  std::int64_t item_bytes = 1;
  std::int64_t most_items = 0; ///< of a process
  insitu_type type = INSITU_FLOAT64;
  int components = 1;
  std::vector<std::int64_t> items; ///< [rank]
  std::vector<std::int64_t> extents;
};

RecordFile::RecordFile(const std::string& path, core::Context& context, parallel::World& world)
    : world_(world), slab_(context.memory, INSITU_MEMORY_CONVERTED) {
  world_.agree_after([&] {
    slab_.resize_discard(std::max(fewest_bytes, most_bytes / std::size_t(world_.size())));
    if (world_.is_root())
      file_.emplace(path);
  });
}

std::vector<std::string> RecordFile::gather(const std::string& mine) {
  std::vector<std::string> texts(world_.is_root() ? std::size_t(world_.size()) : 0);
  world_.gather(bytes_of(mine), slab_.size(), [&](int rank, std::span<const std::byte> some) {
    texts[std::size_t(rank)].append(reinterpret_cast<const char*>(some.data()), some.size());
  });
  return texts;
}

std::int64_t RecordFile::items(const std::string& where) const {
  const auto found = items_.find(where);
  return found == items_.end() ? -1 : found->second;
}

void RecordFile::for_each_dataset(
    core::FunctionRef<void(const std::string&, std::int64_t)> visit) const {
  for (const auto& [where, items] : items_)
    visit(where, items);
}

/// The root puts together what processes add to, in the order in which the lowest rank names it.
std::vector<RecordFile::Dataset>
RecordFile::agree_on_datasets(const std::vector<RecordStream>& streams) {
  const auto write_head = [](parallel::ByteWriter& to, const std::string& where,
                             const std::int64_t(&numbers)[4]) {
    to.value(where.size());
    to.array(std::span<const char>(where));
    to.array(std::span<const std::int64_t>(numbers));
  };
  const auto as_text = [](const parallel::ByteWriter& from) {
    const std::vector<std::byte> bytes = from.bytes();
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  const auto read_heads = [](const std::string& text, auto&& take) {
    parallel::ByteReader reader(bytes_of(text));
    while (!reader.at_end()) {
      const std::vector<char> where = reader.array<char>(reader.value<std::size_t>());
      const std::vector<std::int64_t> numbers = reader.array<std::int64_t>(4);
      take(std::string(where.begin(), where.end()), numbers);
    }
  };
  std::string mine;
  world_.agree_after([&] {
    parallel::ByteWriter heads;
    for (const RecordStream& s : streams)
      write_head(heads, s.where, {s.items(), s.item_bytes(), int(s.type), s.components});
    mine = as_text(heads);
  });
  const std::vector<std::string> heads = gather(mine);
  std::vector<Dataset> datasets;
  std::string all;
  world_.agree_after([&] {
    std::map<std::string, std::size_t> known;
    for (std::size_t rank = 0; rank < heads.size(); ++rank)
      read_heads(heads[rank], [&](const std::string& where, const std::vector<std::int64_t>& n) {
        const auto [at, is_new] = known.emplace(where, datasets.size());
        if (is_new)
          datasets.push_back({where,
                              n[1],
                              0,
                              insitu_type(n[2]),
                              int(n[3]),
                              std::vector<std::int64_t>(heads.size(), 0),
                              {}});
        Dataset& to = datasets[at->second];
        to.items[rank] = n[0];
        to.most_items = std::max(to.most_items, n[0]);
      });
    parallel::ByteWriter merged;
    for (const Dataset& d : datasets)
      write_head(merged, d.where, {d.most_items, d.item_bytes, int(d.type), d.components});
    all = as_text(merged);
  });
  all = world_.broadcast(all);
  world_.agree_after([&] {
    if (world_.is_root())
      return;
    read_heads(all, [&](const std::string& where, const std::vector<std::int64_t>& n) {
      datasets.push_back({where, n[1], n[0], insitu_type(n[2]), int(n[3]), {}, {}});
    });
  });
  return datasets;
}

void RecordFile::write(const std::vector<RecordStream>& streams,
                       const std::map<std::string, std::vector<std::int64_t>>& extents) {
  std::vector<Dataset> datasets = agree_on_datasets(streams);
  std::vector<std::int64_t> sums;
  for (Dataset& dataset : datasets) {
    const auto mine = std::find_if(streams.begin(), streams.end(),
                                   [&](const RecordStream& s) { return s.where == dataset.where; });
    world_.agree_after([&] {
      if (!file_)
        return;
      std::int64_t items = 0;
      for (const std::int64_t n : dataset.items)
        items += n;
      items_[dataset.where] = items;
      dataset.extents.push_back(items);
      if (dataset.components > 1)
        dataset.extents.push_back(dataset.components);
      if (const auto given = extents.find(dataset.where); given != extents.end())
        dataset.extents = given->second;
      file_->make_dataset(dataset.where, dataset.type, dataset.extents);
    });
    sums.push_back(std::int64_t(write(dataset, mine == streams.end() ? nullptr : &*mine)));
  }
  write_checksums(datasets, sums);
}

/// Gathers slab after slab of a dataset; returns the checksum of this process's items.
std::uint64_t RecordFile::write(const Dataset& dataset, const RecordStream* mine) {
  const std::int64_t slab =
      std::max<std::int64_t>(1, std::int64_t(slab_.size()) / dataset.item_bytes);
  std::vector<std::int64_t> next; // of each process, in numbers
  if (file_) {
    next.push_back(0);
    for (const std::int64_t n : dataset.items)
      next.push_back(next.back() + n * dataset.components);
  }
  const std::int64_t items = mine ? mine->items() : 0;
  output::Checksum sum;
  for (std::int64_t begin = 0; begin < dataset.most_items; begin += slab) {
    std::span<const std::byte> bytes;
    world_.agree_after([&] {
      const std::int64_t end = std::min(items, begin + slab);
      if (begin >= end)
        return;
      const auto size = std::size_t((end - begin) * dataset.item_bytes);
      if (size > slab_.size())
        slab_.resize_discard(size); // an item is larger than a slab
      bytes = {mine->items_at(begin, end, slab_.data()), size};
      sum.add({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    });
    const auto most = std::size_t(slab * dataset.item_bytes);
    world_.gather(bytes, most, [&](int rank, std::span<const std::byte> some) {
      std::int64_t& first = next[std::size_t(rank)];
      file_->write(dataset.where, first, some);
      first += std::int64_t(some.size()) / (dataset.item_bytes / dataset.components);
    });
  }
  return sum.sum();
}

void RecordFile::write_checksums(const std::vector<Dataset>& datasets,
                                 const std::vector<std::int64_t>& mine) {
  std::string text;
  world_.agree_after([&] {
    const auto bytes = std::as_bytes(std::span(mine));
    text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  });
  const std::vector<std::string> all = gather(text);
  world_.agree_after([&] {
    if (!file_)
      return;
    for (std::size_t d = 0; d < datasets.size(); ++d) {
      std::vector<std::int64_t> sums;
      for (const std::string& of_rank : all)
        sums.push_back(parallel::items_of<std::int64_t>(bytes_of(of_rank))[d]);
      file_->set_attribute(datasets[d].where, "checksums", std::span<const std::int64_t>(sums));
    }
  });
}

} // namespace insitu::scene
