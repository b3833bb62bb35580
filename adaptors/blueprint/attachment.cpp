#include "attachment.h"

#include <algorithm>
#include <map>
#include <utility>

namespace insitu::blueprint {

namespace {

void check(insitu_status status) {
  if (status != INSITU_OK)
    throw Error(status, insitu_last_message());
}

/// In the order of their ids, if all domains have one: a host may hand them over in any order.
void sort_by_id(std::vector<Domain>& domains) {
  if (!std::all_of(domains.begin(), domains.end(), [](const Domain& d) { return d.id; }))
    return;
  std::stable_sort(domains.begin(), domains.end(),
                   [](const Domain& a, const Domain& b) { return *a.id < *b.id; });
  const auto same =
      std::adjacent_find(domains.begin(), domains.end(),
                         [](const Domain& a, const Domain& b) { return a.id == b.id; });
  if (same != domains.end())
    throw Error(INSITU_ERROR_ARGUMENT, std::next(same)->path + "/state/domain_id is " +
                                           std::to_string(*same->id) + ", as " + same->path +
                                           "/state/domain_id is");
}

/// Calls with the tree itself, or with each of its domains.
template <class F>
void for_domains(const Node& data, F&& f) {
  if (data.find("coordsets") || data.find("topologies"))
    f(data);
  else
    for (std::int64_t i = 0; i < data.size(); ++i)
      if (const Node domain = data.child(i); domain.size() > 0)
        f(domain);
}

std::vector<Domain> read_domains(const Node& data, const Attachment::Options& options) {
  std::vector<Domain> out;
  const auto add = [&](const Node& mesh) {
    if (options.lacking && !mesh.find("topologies/" + options.topology))
      return;
    out.push_back(read_domain(mesh, options.topology, options.channel));
    if (!options.adaptive)
      return;
    Node level = mesh.find("state/level_id");
    if (!level)
      level = mesh.at("state/level");
    out.back().level = level.integer();
    if (out.back().level < 0 || out.back().level >= INSITU_AMR_MOST_LEVELS)
      level.refuse(INSITU_ERROR_ARGUMENT,
                   "is " + std::to_string(out.back().level) + "; from 0 to " +
                       std::to_string(INSITU_AMR_MOST_LEVELS - 1) + " are supported");
    out.back().windows = read_nestsets(mesh, out.back().topology, out.back().dimensions);
  };
  for_domains(data, add);
  sort_by_id(out);
  return out;
}

bool is_same_block(const insitu_block& a, const insitu_block& b) {
  bool same = a.kind == b.kind && a.dimensions == b.dimensions;
  for (int i = 0; i < 3; ++i)
    same = same && a.vertices[i] == b.vertices[i] && a.origin[i] == b.origin[i] &&
           a.spacing[i] == b.spacing[i] && is_same_view(a.coordinates[i], b.coordinates[i]);
  return same;
}

bool is_same_view(const std::optional<insitu_array>& a, const std::optional<insitu_array>& b) {
  return a.has_value() == b.has_value() && (!a || blueprint::is_same_view(*a, *b));
}

/// Whether two domains have equal cells, which lie where they lay.
bool has_same_cells(const Domain& a, const Domain& b) {
  return a.kind == b.kind && a.topology_print == b.topology_print && a.level == b.level &&
         a.vertex_count == b.vertex_count && is_same_block(a.block, b.block) &&
         (a.block.kind != INSITU_BLOCK_RECTILINEAR || a.geometry_print == b.geometry_print) &&
         a.cells.layout == b.cells.layout && a.cells.shape == b.cells.shape &&
         blueprint::is_same_view(a.cells.connectivity, b.cells.connectivity) &&
         blueprint::is_same_view(a.cells.types, b.cells.types) &&
         blueprint::is_same_view(a.cells.offsets, b.cells.offsets) &&
         blueprint::is_same_view(a.faces.vertices, b.faces.vertices) &&
         blueprint::is_same_view(a.faces.offsets, b.faces.offsets) &&
         blueprint::is_same_view(a.faces.cell_faces, b.faces.cell_faces) &&
         blueprint::is_same_view(a.faces.cell_offsets, b.faces.cell_offsets) &&
         is_same_view(a.ghosts, b.ghosts) && a.convention == b.convention &&
         is_same_view(a.hidden_points, b.hidden_points) &&
         is_same_view(a.global_ids[0], b.global_ids[0]) &&
         is_same_view(a.global_ids[1], b.global_ids[1]);
}

/// Takes the copies of a step before where its cells were the same, so that they are given once.
void keep_cells(Domain& now, const Domain& before) {
  std::vector<std::pair<insitu_array*, const insitu_array*>> arrays;
  for (const auto member :
       {&insitu_cells::connectivity, &insitu_cells::types, &insitu_cells::offsets})
    arrays.emplace_back(&(now.cells.*member), &(before.cells.*member));
  for (const auto member : {&insitu_faces::vertices, &insitu_faces::offsets,
                            &insitu_faces::cell_faces, &insitu_faces::cell_offsets})
    arrays.emplace_back(&(now.faces.*member), &(before.faces.*member));
  for (const auto member : {&Domain::ghosts, &Domain::hidden_points})
    if (now.*member && before.*member)
      arrays.emplace_back(&*(now.*member), &*(before.*member));
  for (int on = 0; on < 2; ++on)
    if (now.global_ids[on] && before.global_ids[on])
      arrays.emplace_back(&*now.global_ids[on], &*before.global_ids[on]);
  const auto are_alike = [](const auto& a) { return !a.first->converted == !a.second->converted; };
  if (now.topology_print != before.topology_print ||
      !std::all_of(arrays.begin(), arrays.end(), are_alike))
    return;
  for (const auto& [array, earlier] : arrays)
    if (array->converted)
      *array = *earlier;
  now.cell_copies = before.cell_copies;
}

/// Takes the copies of a step before where coordinates were the same.
void keep_points(Domain& now, const Domain& before) {
  const auto is_copy = [](const insitu_array& a) { return a.converted != nullptr; };
  if (now.points.empty() || now.geometry_print != before.geometry_print ||
      now.points.size() != before.points.size() ||
      !std::all_of(now.points.begin(), now.points.end(), is_copy) ||
      !std::all_of(before.points.begin(), before.points.end(), is_copy))
    return;
  now.points = before.points;
  now.point_copies = before.point_copies;
}

/// A piece without cells, which adds nothing.
Domain empty_domain() {
  Domain d;
  d.kind = Domain::Kind::cells;
  d.points = {insitu_array_of(nullptr, INSITU_FLOAT64, 0, 3)};
  d.cells.connectivity = insitu_array_of(nullptr, INSITU_INT64, 0, 8);
  return d;
}

} // namespace

std::vector<std::string> other_topologies_of(const Node& data) {
  std::vector<std::string> out;
  for_domains(data, [&](const Node& mesh) {
    for (std::string& name : other_topologies(mesh))
      if (std::find(out.begin(), out.end(), name) == out.end())
        out.push_back(std::move(name));
  });
  return out;
}

void keep_common_fields(std::vector<Domain>& domains, std::vector<std::string>& left_out) {
  const auto components = [](const Field& f) {
    return f.arrays.size() == 1 ? f.arrays[0].components
                                : static_cast<std::int32_t>(f.arrays.size());
  };
  const auto lacks = [&](const Domain& d, const Field& wanted) {
    return d.cell_count > 0 && std::none_of(d.fields.begin(), d.fields.end(), [&](const Field& f) {
             return f.name == wanted.name && f.on == wanted.on &&
                    components(f) == components(wanted);
           });
  };
  std::map<std::string, std::string> dropped;
  for (const Domain& d : domains)
    for (const Field& f : d.fields)
      for (const Domain& other : domains)
        if (lacks(other, f))
          dropped.try_emplace(f.name,
                              other.path + ": has no field " + f.name + " like that of " + d.path);
  for (Domain& d : domains)
    d.fields.erase(std::remove_if(d.fields.begin(), d.fields.end(),
                                  [&](const Field& f) {
                                    return d.cell_count == 0 || dropped.count(f.name) > 0;
                                  }),
                   d.fields.end());
  for (const auto& [name, why] : dropped)
    left_out.push_back(why);
}

void Attachment::update(const Node& data, const Options& options) {
  try {
    read_and_give(data, options);
  } catch (const Error& e) {
    is_refused_ = true;
    (void)insitu_mesh_refuse(mesh_, e.what());
    throw;
  }
  if (std::exchange(is_refused_, false))
    check(insitu_mesh_refuse(mesh_, nullptr));
}

void Attachment::read_and_give(const Node& data, const Options& options) {
  std::vector<Domain> now = read_domains(data, options);
  left_out_.clear();
  for (const Domain& d : now)
    left_out_.insert(left_out_.end(), d.left_out.begin(), d.left_out.end());
  keep_common_fields(now, left_out_);
  insitu_amr lattice = insitu_amr_default();
  std::vector<std::int32_t> ratios;
  if (options.adaptive)
    make_patches(now, lattice, ratios, left_out_);

  const bool was_given = is_given_;
  is_given_ = false;
  for (Domain& d : domains_) // until all is given anew
    earlier_.push_back(std::move(d));
  domains_ = std::move(now);
  if (options.adaptive && !domains_.empty()) {
    const bool same = ratios == ratios_ && lattice.level_count == lattice_.level_count &&
                      lattice.dimensions == lattice_.dimensions &&
                      std::equal(lattice.origin, lattice.origin + 3, lattice_.origin) &&
                      std::equal(lattice.spacing, lattice.spacing + 3, lattice_.spacing);
    ratios_ = std::move(ratios);
    lattice_ = lattice;
    lattice_.ratios = ratios_.data();
    if (!same || pieces_ == 0)
      check(insitu_mesh_amr(mesh_, &lattice_));
  }
  const auto count = static_cast<std::int32_t>(domains_.size());
  for (std::size_t p = 0; was_given && p < std::min(domains_.size(), earlier_.size()); ++p) {
    keep_cells(domains_[p], earlier_[p]);
    keep_points(domains_[p], earlier_[p]);
  }
  for (std::int32_t p = 0; p < count; ++p)
    give(p, domains_[static_cast<std::size_t>(p)],
         was_given && static_cast<std::size_t>(p) < earlier_.size()
             ? &earlier_[static_cast<std::size_t>(p)]
             : nullptr);
  if (count == 0 && !(was_given && earlier_.empty())) // no new cells where there were none before
    give_nothing(options.adaptive);
  if (pieces_ > std::max(count, 1))
    check(insitu_mesh_drop_pieces(mesh_, std::max(count, 1)));
  pieces_ = count == 0 && options.adaptive && pieces_ == 0 ? 0 : std::max(count, 1);
  remove_fields();
  if (count > 0)
    check(insitu_mesh_changed(mesh_, INSITU_CHANGED_FIELDS));
  earlier_.clear();
  is_given_ = true;
}

void Attachment::give_nothing(bool adaptive) {
  if (!adaptive) {
    give(0, empty_domain(), nullptr);
  } else if (pieces_ > 0) { // otherwise the lattice is not known yet, and no piece is there
    insitu_leaves none = insitu_leaves_default();
    none.levels = insitu_array_of(nullptr, INSITU_INT32, 0, 1);
    none.corners = insitu_array_of(nullptr, INSITU_INT32, 0, 3);
    check(insitu_mesh_leaves(mesh_, 0, &none));
  }
}

void Attachment::give(std::int32_t piece, const Domain& now, const Domain* before) {
  const bool same_points = before && are_same_views(now.points, before->points);
  const bool same_cells = before && has_same_cells(now, *before);
  if (now.kind != Domain::Kind::patch && !now.points.empty()) {
    if (!same_points || !same_cells)
      check(insitu_mesh_points(mesh_, piece, now.points.data(),
                               static_cast<std::int32_t>(now.points.size())));
    else if (now.geometry_print != before->geometry_print)
      check(insitu_mesh_changed(mesh_, INSITU_CHANGED_GEOMETRY));
  }
  if (!same_cells) {
    if (now.kind == Domain::Kind::patch) {
      insitu_patch patch = insitu_patch_default();
      patch.level = static_cast<std::int32_t>(now.level);
      for (int a = 0; a < 3; ++a) {
        patch.lower[a] = now.block.first[a];
        patch.cells[a] = now.block.vertices[a] - 1;
      }
      check(insitu_mesh_patch(mesh_, piece, &patch));
    } else {
      check(now.kind == Domain::Kind::block   ? insitu_mesh_block(mesh_, piece, &now.block)
            : now.kind == Domain::Kind::faces ? insitu_mesh_faces(mesh_, piece, &now.faces)
                                              : insitu_mesh_cells(mesh_, piece, &now.cells));
      check(insitu_mesh_ghosts(mesh_, piece, now.ghosts ? &*now.ghosts : nullptr, now.convention));
      check(insitu_mesh_hidden_points(mesh_, piece,
                                      now.hidden_points ? &*now.hidden_points : nullptr));
      for (const insitu_association on : {INSITU_VERTEX, INSITU_CELL})
        check(insitu_mesh_global_ids(mesh_, piece, on,
                                     now.global_ids[on] ? &*now.global_ids[on] : nullptr));
    }
    check(insitu_mesh_changed(mesh_, INSITU_CHANGED_TOPOLOGY));
  }
  give_fields(piece, now);
}

void Attachment::give_fields(std::int32_t piece, const Domain& now) {
  for (const Field& f : now.fields) {
    check(insitu_mesh_field(mesh_, piece, f.name.c_str(), f.on, f.arrays.data(),
                            static_cast<std::int32_t>(f.arrays.size())));
    fields_.insert(f.name);
  }
}

void Attachment::remove_fields() {
  std::set<std::string> now;
  for (const Domain& d : domains_)
    for (const Field& f : d.fields)
      now.insert(f.name);
  for (auto f = fields_.begin(); f != fields_.end();) {
    if (now.count(*f) > 0) {
      ++f;
      continue;
    }
    const insitu_status status = insitu_mesh_remove_field(mesh_, f->c_str());
    if (status != INSITU_OK && status != INSITU_ERROR_FIELD) // dropped pieces may have had it alone
      check(status);
    f = fields_.erase(f);
  }
}

} // namespace insitu::blueprint
