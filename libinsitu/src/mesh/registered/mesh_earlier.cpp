/// What a mesh keeps of the steps before, for pathlines.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mesh/registered/copy_items.h"
#include "mesh/registered/mesh.h"

namespace insitu::mesh {

namespace {

constexpr std::int64_t copy_grain = 1 << 14;
constexpr std::int64_t few_points = 256; ///< of which a copy stays in the cache

/// Whether all coordinates are told by axes, or by origins and spacings.
bool is_implicit(const MeshView& mesh) {
  for (std::int32_t p = 0; p < mesh.piece_count; ++p)
    if (mesh.pieces[p].vertex_count > 0 && !mesh.pieces[p].implicit_points)
      return false;
  return mesh.vertex_count() > 0;
}

std::int64_t axis_values(const MeshView& mesh) {
  std::int64_t values = 0;
  for (std::int32_t p = 0; p < mesh.piece_count; ++p)
    for (int a = 0; a < 3; ++a)
      values += mesh.pieces[p].axis[a] ? mesh.pieces[p].block_vertices[a] : 0;
  return values;
}

} // namespace

std::int64_t Mesh::earlier_points_bytes() const {
  const MeshView& now = view();
  if (has_still_vertices())
    return 0;
  return is_implicit(now) ? axis_values(now) * std::int64_t(sizeof(double))
                          : now.vertex_count() * std::int64_t(sizeof(math::Vec3d));
}

void Mesh::hide_earlier() {
  for (MeshView* const view : {&view_, &shown()}) {
    view->earlier_points = nullptr;
    view->largest_displacement = 0.0;
  }
}

/// The copies of a field; those of other numbers than it has now are dropped.
EarlierField& Mesh::earlier_field_for(const std::string& name, insitu_association association,
                                      int components) {
  const MeshView& now = view();
  const std::int64_t* first = association == INSITU_CELL ? now.first_cell : now.first_vertex;
  const auto values = std::size_t(first[now.piece_count] * components);
  const auto known = std::find_if(earlier_fields_.begin(), earlier_fields_.end(),
                                  [&](const auto& e) { return e->name == name; });
  EarlierField& to = known != earlier_fields_.end()
                         ? **known
                         : *earlier_fields_.emplace_back(std::make_unique<EarlierField>());
  if (to.association != association || to.components != components ||
      (!to.steps.empty() && to.steps[0]->values.size() != values))
    to.steps.clear();
  to.name = name;
  to.association = association;
  to.components = components;
  return to;
}

void EarlierField::begin_step(int count, const MeshView& mesh, core::Memory& memory) {
  const auto pieces = std::size_t(mesh.piece_count);
  const std::int64_t* first = association == INSITU_CELL ? mesh.first_cell : mesh.first_vertex;
  const int n = components;
  if (steps.size() > std::size_t(count))
    steps.resize(std::size_t(count));
  if (steps.size() < std::size_t(count))
    steps.push_back(std::make_unique<Step>(memory));
  std::rotate(steps.begin(), steps.end() - 1, steps.end()); // the oldest one's room is taken
  Step& to = *steps.front();
  to.values.resize_discard(std::size_t(first[pieces] * n));
  to.bases.assign(std::size_t(n) * pieces, nullptr);
  to.views.clear();
  for (std::size_t p = 0; p < pieces; ++p) {
    const double* values = to.values.data() + first[p] * n;
    const std::byte** bases = to.bases.data() + p * std::size_t(n);
    for (int c = 0; c < n; ++c)
      bases[c] = reinterpret_cast<const std::byte*>(values + c);
    const std::int64_t items = first[p + 1] - first[p];
    const std::int64_t stride = n * std::int64_t(sizeof(double));
    to.views.push_back({bases, {items, {items, 1}, {stride, items * stride, items * stride}}});
  }
}

void Mesh::keep_earlier(const std::vector<KeptField>& fields, const core::Threads& threads) {
  const MeshView& now = view();
  const auto pieces = std::size_t(now.piece_count);
  std::erase_if(earlier_fields_, [&](const auto& e) {
    return std::none_of(fields.begin(), fields.end(),
                        [&](const KeptField& f) { return f.name == e->name; });
  });
  for (const KeptField& kept : fields) {
    const FieldView from = field(kept.name);
    EarlierField& to = earlier_field_for(kept.name, from.association, from.components);
    to.begin_step(kept.steps, now, *memory_);
    const std::int64_t* first = from.association == INSITU_CELL ? now.first_cell : now.first_vertex;
    const int n = from.components;
    for (std::size_t p = 0; p < pieces; ++p) {
      double* values = to.steps[0]->values.data() + first[p] * n;
      threads.parallel_for(first[p + 1] - first[p], copy_grain,
                           [&](std::int64_t begin, std::int64_t end) {
                             copy_items(from.pieces[p], n, begin, end, values + begin * n);
                           });
    }
  }
  if (has_still_vertices())
    return;
  earlier_blocks_.clear();
  if (is_implicit(now)) {
    earlier_points_.release();
    keep_axes(now);
  } else {
    keep_points(now, threads);
  }
}

/// Copies coordinates.
void Mesh::keep_points(const MeshView& now, const core::Threads& threads) {
  earlier_points_.resize_discard(std::size_t(now.vertex_count()));
  for (std::int32_t p = 0; p < now.piece_count; ++p) {
    math::Vec3d* const points = earlier_points_.data() + now.first_vertex[p];
    threads.parallel_for(now.pieces[p].vertex_count, copy_grain,
                         [&](std::int64_t begin, std::int64_t end) {
                           copy_points(now.pieces[p], begin, end, points + begin);
                         });
  }
}

/// Of blocks whose coordinates come from axes, these alone are copied.
void Mesh::keep_axes(const MeshView& now) {
  earlier_axes_.resize_discard(std::size_t(axis_values(now)));
  double* to = earlier_axes_.data();
  earlier_blocks_.assign(now.pieces, now.pieces + now.piece_count);
  for (PieceView& block : earlier_blocks_) {
    for (int a = 0; a < 3; ++a) {
      if (!block.axis[a])
        continue;
      double* const copy = to;
      for (std::int64_t i = 0; i < block.block_vertices[a]; ++i)
        *to++ = load_real(block.axis[a] + i * block.axis_stride[a], block.axis_is_float32);
      block.axis[a] = reinterpret_cast<const std::byte*>(copy);
      block.axis_stride[a] = sizeof(double);
    }
    block.axis_is_float32 = false;
  }
}

/// Whether the blocks that were kept by their axes are where the current ones are.
bool Mesh::axes_stand(const MeshView& now) const {
  for (std::int32_t p = 0; p < now.piece_count; ++p) {
    const PieceView &a = earlier_blocks_[std::size_t(p)], &b = now.pieces[p];
    for (int d = 0; d < 3 && b.vertex_count > 0; ++d) {
      if (!a.axis[d] != !b.axis[d])
        return false;
      if (!a.axis[d] && (a.origin[d] != b.origin[d] || a.spacing[d] != b.spacing[d] ||
                         a.block_first[d] != b.block_first[d]))
        return false;
      for (std::int64_t i = 0; a.axis[d] && i < b.block_vertices[d]; ++i)
        if (load_real(a.axis[d] + i * a.axis_stride[d], a.axis_is_float32) !=
            load_real(b.axis[d] + i * b.axis_stride[d], b.axis_is_float32))
          return false;
    }
  }
  return true;
}

/// Whether the numbers of vertices that were kept are the mesh's.
bool Mesh::kept_fits(const MeshView& now) const {
  if (earlier_blocks_.empty())
    return earlier_points_.size() == std::size_t(now.vertex_count());
  if (!is_implicit(now) || earlier_blocks_.size() != std::size_t(now.piece_count))
    return false;
  for (std::int32_t p = 0; p < now.piece_count; ++p)
    if (!std::equal(now.pieces[p].block_vertices, now.pieces[p].block_vertices + 3,
                    earlier_blocks_[std::size_t(p)].block_vertices))
      return false;
  return true;
}

/// Whether no vertex moved. Where some did, the first that are looked at mostly tell.
bool Mesh::points_stand(const MeshView& current) const {
  math::Vec3d now[few_points];
  for (std::int32_t p = 0; p < current.piece_count; ++p) {
    const math::Vec3d* then = earlier_points_.data() + current.first_vertex[p];
    const std::int64_t count = current.pieces[p].vertex_count;
    for (std::int64_t from = 0; from < count; from += few_points) {
      const std::int64_t n = std::min(few_points, count - from);
      copy_points(current.pieces[p], from, from + n, now);
      for (std::int64_t i = 0; i < n; ++i)
        for (int a = 0; a < 3; ++a)
          if (std::abs(now[i][a] - then[from + i][a]) > 0.0)
            return false;
    }
  }
  return true;
}

bool Mesh::show_earlier(const core::Threads& threads, bool even_if_still) {
  hide_earlier();
  if (has_still_vertices())
    return false;
  MeshView& current = shown();
  if (!kept_fits(current) || (!even_if_still && !earlier_blocks_.empty() && axes_stand(current)))
    return false;
  make_earlier_points(threads);
  if (!even_if_still && points_stand(current))
    return false; // the current coordinates are the earlier ones
  current.earlier_points = earlier_points_.data();
  current.largest_displacement = std::numeric_limits<double>::infinity();
  return true;
}

void Mesh::find_displacement(const core::Threads& threads) {
  MeshView& current = shown();
  double largest = 0.0;
  for (std::int32_t p = 0; p < current.piece_count; ++p) {
    const std::int64_t count = current.pieces[p].vertex_count;
    std::vector<double> most(std::size_t((count + copy_grain - 1) / copy_grain), 0.0);
    threads.parallel_for(count, copy_grain, [&](std::int64_t begin, std::int64_t end) {
      const math::Vec3d* then = earlier_points_.data() + current.first_vertex[p];
      math::Vec3d now[few_points];
      math::Vec3d m;
      for (std::int64_t from = begin; from < end; from += few_points) {
        const std::int64_t n = std::min(few_points, end - from);
        copy_points(current.pieces[p], from, from + n, now);
        for (std::int64_t i = 0; i < n; ++i)
          for (int a = 0; a < 3; ++a) {
            const double d = std::abs(now[i][a] - then[from + i][a]);
            m[a] = d > m[a] ? d : m[a];
          }
      }
      most[std::size_t(begin / copy_grain)] = std::max({m.x, m.y, m.z});
    });
    for (const double m : most)
      largest = m > largest ? m : largest;
  }
  current.largest_displacement = largest;
}

void Mesh::release_earlier() {
  earlier_points_.release();
  earlier_axes_.release();
  earlier_blocks_.clear();
  earlier_fields_.clear();
  hide_earlier();
}

StepsAside Mesh::set_earlier_aside() {
  const MeshView& now = view();
  std::vector<std::unique_ptr<EarlierField>> copies;
  for (const auto& from : earlier_fields_) {
    EarlierField& to = *copies.emplace_back(std::make_unique<EarlierField>());
    to.name = from->name;
    to.association = from->association;
    to.components = from->components;
    for (std::size_t s = from->steps.size(); s-- > 0;) {
      to.begin_step(int(from->steps.size()), now, *memory_);
      core::Buffer<double>& values = to.steps[0]->values;
      values.resize_discard(from->steps[s]->values.size());
      std::copy(from->steps[s]->values.begin(), from->steps[s]->values.end(), values.begin());
    }
  }
  hide_earlier();
  StepsAside out{std::move(earlier_points_), std::exchange(earlier_blocks_, {}),
                 std::move(earlier_axes_), std::exchange(earlier_fields_, std::move(copies))};
  earlier_points_ = core::Buffer<math::Vec3d>(*memory_, INSITU_MEMORY_EARLIER);
  earlier_axes_ = core::Buffer<double>(*memory_, INSITU_MEMORY_EARLIER);
  return out;
}

void Mesh::put_earlier_back(StepsAside steps) {
  release_earlier();
  earlier_points_ = std::move(steps.points);
  earlier_blocks_ = std::move(steps.blocks);
  earlier_axes_ = std::move(steps.axes);
  earlier_fields_ = std::move(steps.fields);
}

/// The coordinates of blocks that were kept by their axes.
void Mesh::make_earlier_points(const core::Threads& threads) {
  if (earlier_blocks_.empty())
    return;
  std::vector<std::int64_t> first{0};
  for (const PieceView& block : earlier_blocks_)
    first.push_back(first.back() + block.vertex_count);
  MeshView then;
  then.pieces = earlier_blocks_.data();
  then.first_vertex = first.data();
  then.piece_count = std::int32_t(earlier_blocks_.size());
  keep_points(then, threads);
  earlier_blocks_.clear();
}

TakenStep Mesh::take_earlier(const core::Threads& threads) {
  make_earlier_points(threads);
  TakenStep taken{std::move(earlier_points_), std::move(earlier_fields_)};
  for (const auto& field : taken.fields)
    field->steps.resize(1);
  release_earlier();
  return taken;
}

std::optional<FieldView> Mesh::earlier_field(const std::string& name) const {
  const std::vector<FieldView> all = earlier_fields(name);
  return all.empty() ? std::nullopt : std::optional(all.front());
}

std::vector<FieldView> Mesh::earlier_fields(const std::string& name) const {
  std::vector<FieldView> views;
  for (const auto& e : earlier_fields_)
    if (e->name == name)
      for (std::size_t step = 0; step < e->steps.size(); ++step)
        views.push_back(e->view(step));
  return views;
}

} // namespace insitu::mesh
