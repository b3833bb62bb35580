#include "lists.h"

namespace insitu::blueprint {

Leaf sizes_of(const Node& sizes) {
  const Leaf leaf = sizes.leaf();
  for (std::int64_t i = 0; i < leaf.count; ++i)
    if (const std::int64_t size = leaf.integer(i); size < 0 || size > INT32_MAX)
      sizes.refuse(INSITU_ERROR_ARGUMENT,
                   "of item " + std::to_string(i) + " is " + std::to_string(size));
  return leaf;
}

IdLists::IdLists(const Node& relation, int each) {
  const Node connectivity = relation.at("connectivity");
  ids_ = connectivity.leaf();
  if (!ids_.is_integer())
    connectivity.refuse(INSITU_ERROR_ARGUMENT, "holds no integers");
  const Node offsets = relation.find("offsets");
  if (relation.find("sizes")) {
    const Leaf starts = offsets ? offsets.leaf() : Leaf();
    place_by_sizes(relation, offsets ? &starts : nullptr);
  } else if (offsets) {
    place_by_offsets(relation);
  } else if (each > 0) {
    if (ids_.count % each != 0)
      connectivity.refuse(INSITU_ERROR_ARGUMENT, "has " + std::to_string(ids_.count) +
                                                     " ids, which are not whole cells of " +
                                                     std::to_string(each));
    for (std::int64_t at = 0; at < ids_.count; at += each)
      places_.push_back({at, at + each});
  } else {
    (void)relation.at("sizes"); // is missing
  }
}

void IdLists::place_by_sizes(const Node& relation, const Leaf* offsets) {
  const Node node = relation.at("sizes");
  const Leaf sizes = sizes_of(node);
  if (offsets && offsets->count != sizes.count && offsets->count != sizes.count + 1)
    relation.at("offsets").refuse(INSITU_ERROR_ARGUMENT, "has " + std::to_string(offsets->count) +
                                                             " numbers, sizes has " +
                                                             std::to_string(sizes.count));
  std::int64_t at = 0;
  for (std::int64_t i = 0; i < sizes.count; ++i) {
    if (offsets)
      at = offsets->integer(i);
    const std::int64_t size = sizes.integer(i);
    if (at < 0 || at > ids_.count || size > ids_.count - at)
      (offsets ? relation.at("offsets") : node)
          .refuse(INSITU_ERROR_ARGUMENT,
                  "of item " + std::to_string(i) + " is " + std::to_string(offsets ? at : size) +
                      ": " + std::to_string(size) + " ids from " + std::to_string(at) +
                      " on, and there are " + std::to_string(ids_.count));
    places_.push_back({at, at + size});
    at += size;
  }
}

void IdLists::place_by_offsets(const Node& relation) {
  const Node node = relation.at("offsets");
  const Leaf offsets = node.leaf();
  // Every item has ids, so that none begins where all end.
  const bool has_end = offsets.count > 0 && offsets.integer(offsets.count - 1) == ids_.count;
  const std::int64_t items = offsets.count - has_end;
  for (std::int64_t i = 0; i < items; ++i) {
    const std::int64_t begin = offsets.integer(i),
                       end = i + 1 < offsets.count ? offsets.integer(i + 1) : ids_.count;
    if (begin < 0 || end < begin || end > ids_.count)
      node.refuse(INSITU_ERROR_ARGUMENT, "of item " + std::to_string(i) + " is " +
                                             std::to_string(begin) + ", the item ends at " +
                                             std::to_string(end) + ", and there are " +
                                             std::to_string(ids_.count) + " ids");
    places_.push_back({begin, end});
  }
}

void IdLists::read(std::int64_t item, std::vector<std::int64_t>& ids) const {
  const Place& place = places_[static_cast<std::size_t>(item)];
  ids.clear();
  for (std::int64_t i = place.begin; i < place.end; ++i)
    ids.push_back(ids_.integer(i));
}

CellLists::CellLists(const Node& topology) {
  const Node elements = topology.at("elements");
  if (elements.find("shape"))
    add(elements);
  else
    for (std::int64_t i = 0; i < elements.size(); ++i)
      add(elements.child(i));
}

void CellLists::add(const Node& elements) {
  Group group;
  group.elements = elements;
  const Node shape = elements.at("shape");
  if (shape.text() == "mixed") {
    group.shapes = elements.at("shapes");
    group.numbers = group.shapes.leaf();
    group.map = shapes_of(elements.at("shape_map"));
    group.lists = IdLists(elements, 0);
    if (group.lists.count() != group.numbers.count)
      elements.refuse(INSITU_ERROR_ARGUMENT,
                      "has offsets or sizes of " + std::to_string(group.lists.count()) +
                          " cells, and shapes of " + std::to_string(group.numbers.count));
  } else {
    group.shape = shape_of(shape.text());
    if (!group.shape)
      refuse_shape(shape, shape.text());
    group.lists = IdLists(elements, group.shape->ids);
  }
  groups_.push_back(std::move(group));
}

std::int64_t CellLists::count() const {
  std::int64_t n = 0;
  for (const Group& group : groups_)
    n += group.lists.count();
  return n;
}

std::int64_t CellLists::id_count() const {
  std::int64_t n = 0;
  for (const Group& group : groups_)
    n += group.lists.id_count();
  return n;
}

void CellLists::require_size(const Cell& cell) {
  if (cell.shape->ids > 0 && static_cast<std::int64_t>(cell.ids.size()) != cell.shape->ids)
    cell.elements->refuse(INSITU_ERROR_ARGUMENT, "has " + std::to_string(cell.ids.size()) +
                                                     " ids of cell " + std::to_string(cell.number) +
                                                     ", which is a " + cell.shape->name);
}

} // namespace insitu::blueprint
