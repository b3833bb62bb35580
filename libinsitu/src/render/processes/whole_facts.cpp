#include "render/processes/whole_facts.h"

#include "parallel/bytes.h"

namespace insitu::render {

using parallel::ByteReader;
using parallel::ByteWriter;

namespace {

std::vector<std::byte> written(const mesh::MeshFacts& facts) {
  ByteWriter writer;
  writer.value(facts.bounds);
  writer.value(facts.cells);
  for (const mesh::MeshFacts::SizeClass& size : facts.sizes)
    writer.value(size);
  return writer.bytes();
}

mesh::MeshFacts read(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  mesh::MeshFacts facts;
  facts.bounds = reader.value<mesh::Box>();
  facts.cells = reader.value<std::int64_t>();
  while (!reader.at_end())
    facts.sizes.push_back(reader.value<mesh::MeshFacts::SizeClass>());
  return facts;
}

} // namespace

mesh::MeshFacts whole_facts(parallel::World& world, const mesh::MeshFacts& mine) {
  if (world.size() == 1)
    return mine;
  std::vector<std::byte> bytes;
  mesh::MeshFacts whole;
  world.agree_after([&] { bytes = written(mine); });
  // Facts are short, and come in one piece each.
  constexpr std::size_t most = std::size_t(1) << 20;
  world.gather(bytes, most, [&](int, std::span<const std::byte> part) { whole.add(read(part)); });
  std::string text;
  world.agree_after([&] {
    bytes = written(whole);
    text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  });
  text = world.broadcast(text);
  world.agree_after([&] { whole = read(std::as_bytes(std::span(text))); });
  return whole;
}

} // namespace insitu::render
