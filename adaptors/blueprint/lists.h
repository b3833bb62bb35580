#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "node.h"
#include "shapes.h"

namespace insitu::blueprint {

/// The sizes of items, which are counts.
Leaf sizes_of(const Node& sizes);

/// A relation's lists of ids, one an item, packed or not, as they are read one by one where the
/// library cannot read them in place.
class IdLists {
public:
  IdLists() = default;
  /// relation: with connectivity, and sizes or offsets or both. each: the size of every item where
  /// the tree has neither, or 0. Throws Error, by the path.
  IdLists(const Node& relation, int each);

  std::int64_t count() const { return static_cast<std::int64_t>(places_.size()); }
  std::int64_t id_count() const { return ids_.count; }
  void read(std::int64_t item, std::vector<std::int64_t>& ids) const;

private:
  struct Place {
    std::int64_t begin, end;
  };
  void place_by_offsets(const Node& relation);
  void place_by_sizes(const Node& relation, const Leaf* offsets);

  Leaf ids_;
  std::vector<Place> places_;
};

/// The cells of an unstructured topology one by one: of one shape, mixed, or in a list of
/// topologies of one shape each (children of elements), whose cells follow each other.
class CellLists {
public:
  explicit CellLists(const Node& topology);

  struct Cell {
    const ShapeName* shape;
    std::int64_t number; ///< among all cells
    std::vector<std::int64_t> ids;
    const Node* elements; ///< which lists it
  };
  std::int64_t count() const;
  std::int64_t id_count() const;

  template <class F>
  void for_each(F&& f) const {
    Cell cell{nullptr, 0, {}, nullptr};
    for (const Group& group : groups_)
      for (std::int64_t i = 0; i < group.lists.count(); ++i, ++cell.number) {
        cell.shape = group.shape ? group.shape : &group.shape_of_mixed(i);
        cell.elements = &group.elements;
        group.lists.read(i, cell.ids);
        require_size(cell);
        f(static_cast<const Cell&>(cell));
      }
  }

private:
  struct Group {
    Node elements;
    const ShapeName* shape = nullptr; ///< null: mixed
    IdLists lists;
    Node shapes; ///< of mixed cells
    Leaf numbers;
    Shapes map;
    const ShapeName& shape_of_mixed(std::int64_t i) const {
      return shape_at(shapes, numbers, i, map);
    }
  };
  void add(const Node& elements);
  static void require_size(const Cell& cell);

  std::vector<Group> groups_;
};

} // namespace insitu::blueprint
