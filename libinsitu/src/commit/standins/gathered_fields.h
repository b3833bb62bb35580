#pragma once

#include <algorithm>
#include <memory>
#include <mutex>
#include <vector>

#include "mesh/view.h"

namespace insitu::commit {

/// The solver's fields at the vertices or cells of a stand-in, each gathered when it is first asked
/// for after its values changed. Gathered has `name`, `fresh`, and what the views of the field
/// view.
template <class Gathered>
class GatheredFields {
public:
  /// The field at hand; make() makes one (a std::unique_ptr), gather(g) brings it up to date.
  /// Thread-safe; what it returns stays until clear().
  template <class Make, class Gather>
  Gathered& find(const mesh::FieldView& own, Make&& make, Gather&& gather) {
    const std::lock_guard lock(mutex_);
    const auto known =
        std::ranges::find_if(fields_, [&](const auto& f) { return f->name == own.name; });
    Gathered& g = known != fields_.end() ? **known : *fields_.emplace_back(make());
    if (!g.fresh) {
      g.name = own.name;
      gather(g);
      g.fresh = true;
    }
    return g;
  }

  void values_changed() {
    for (const auto& f : fields_)
      f->fresh = false;
  }
  void clear() { fields_.clear(); }

  auto begin() const { return fields_.begin(); }
  auto end() const { return fields_.end(); }

private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Gathered>> fields_;
};

} // namespace insitu::commit
