#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace insitu::scene {

/// What was decided, and why.
struct Decision {
  bool made = false;
  const char* why = "";
  explicit operator bool() const { return made; }
};

/// What the items of a scene need beyond the meshes' trees, and what they do without: for people to
/// read before a run, and for tests to hold against what was made.
class Plan {
public:
  enum class Held {
    kept,           ///< from one cycle to the next
    while_executed, ///< given back when the item has been executed
    with_mesh       ///< by the mesh's commit, whatever the scene asks for
  };
  struct Entry {
    std::string of;   ///< "frame 'blast'"
    std::string mesh; ///< its name
    std::string item; ///< "value ranges of 'pressure'"
    bool needed = false;
    bool shared = false;     ///< with an entry before it, where its bytes count
    std::int64_t bytes = -1; ///< of memory, as far as the library counts it; -1: none to speak of
    bool at_most = false;    ///< the bytes: what is held may be less, or nothing
    Held held = Held::kept;
    std::string why;
  };

  /// What follows is of this item of the scene; of no item (empty): of the mesh itself.
  void begin(std::string of, std::string mesh);
  void need(std::string item, std::int64_t bytes, std::string why, Held held = Held::kept);
  /// Of what is decided, or found out, when it is made.
  void need_at_most(std::string item, std::int64_t bytes, std::string why, Held held = Held::kept);
  void skip(std::string item, std::string why);
  /// Either of need() or need_at_most(), and skip(), as was decided.
  void tell(std::string item, const Decision& decision, std::int64_t bytes = -1,
            Held held = Held::kept);
  void tell_at_most(std::string item, const Decision& decision, std::int64_t bytes,
                    Held held = Held::kept);

  const std::vector<Entry>& entries() const { return entries_; }
  /// Of what is needed and kept, beside what meshes hold themselves.
  std::int64_t kept_bytes() const;
  /// The most at any time: what is kept, and what the most demanding item holds for itself.
  std::int64_t bytes() const;
  /// A line each, and the sums.
  std::string text() const;

private:
  void add(std::string item, std::int64_t bytes, bool at_most, std::string why, Held held);

  std::string of_, mesh_;
  std::vector<Entry> entries_;
};

} // namespace insitu::scene
