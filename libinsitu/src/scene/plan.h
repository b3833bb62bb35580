#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace insitu::scene {

/// What the items of a scene need beyond the meshes' trees, and what they do without: for people to
/// read before a run, and for tests to hold against what was made.
class Plan {
public:
  struct Entry {
    std::string of;   ///< "frame 'blast'"
    std::string mesh; ///< its name
    std::string item; ///< "value ranges of 'pressure'"
    bool needed = false;
    bool shared = false;     ///< with an entry before it, where its bytes count
    std::int64_t bytes = -1; ///< of memory; -1: none to speak of
    std::string why;
  };

  /// What follows is of this item of the scene.
  void begin(std::string of, std::string mesh);
  /// bytes: held from one cycle to the next, or while the item is executed; -1: none.
  void need(std::string item, std::int64_t bytes, std::string why);
  void skip(std::string item, std::string why);

  const std::vector<Entry>& entries() const { return entries_; }
  /// Of what is needed.
  std::int64_t bytes() const;
  /// A line each, and the sum.
  std::string text() const;

private:
  std::string of_, mesh_;
  std::vector<Entry> entries_;
};

} // namespace insitu::scene
