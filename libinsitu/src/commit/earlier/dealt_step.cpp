#include "commit/earlier/dealt_step.h"

#include <algorithm>
#include <bit>
#include <optional>

#include "commit/earlier/cells_by_ids.h"
#include "core/random.h"
#include "core/status.h"
#include "mesh/registered/earlier_parts.h"
#include "parallel/parcels.h"

namespace insitu::commit {

using parallel::ByteReader;
using parallel::ByteWriter;
using parallel::Parcel;

namespace {

constexpr std::int64_t cells_at_a_time = 1 << 15; ///< of a process, about so many

/// Numbers of cells by the round in which they are dealt.
class Slices {
public:
  Slices(std::int64_t rounds, int processes) : rounds_(rounds), processes_(processes) {}
  std::int64_t round_of(std::int64_t id) const {
    return std::int64_t(core::splitmix64(std::uint64_t(id)) % std::uint64_t(rounds_));
  }
  /// Where those who have a cell meet those who want it.
  int home_of(std::int64_t id) const {
    return int(core::splitmix64(std::uint64_t(id)) / std::uint64_t(rounds_) %
               std::uint64_t(processes_));
  }

private:
  std::int64_t rounds_;
  int processes_;
};

/// A cell that a process has of the step.
struct Held {
  std::int64_t round, id;
  const StepPart* part;
  std::int64_t flat;
};
/// A cell that it has of the mesh.
struct Wanted {
  std::int64_t round, id, flat;
};

/// A cell with its corners: its shape, their places, and of each field the values of each step.
void write_cell(const mesh::MeshView& view, std::int64_t flat, const mesh::EarlierStep& step,
                ByteWriter& to) {
  const std::int32_t p = view.piece_of(flat);
  std::int64_t ids[8];
  const mesh::PieceView& piece = view.pieces[p];
  const int corners = piece.vertex_ids(flat - view.first_cell[p], ids);
  to.value(std::int64_t(piece.shape(flat - view.first_cell[p])));
  for (int k = 0; k < corners; ++k)
    to.value(step.points[std::size_t(view.first_vertex[p] + ids[k])]);
  for (const mesh::EarlierStep::Field& field : step.fields) {
    const auto n = std::size_t(field.components);
    for (const std::vector<double>& values : field.steps)
      if (field.association == INSITU_CELL)
        to.array(std::span(values).subspan(std::size_t(flat) * n, n));
      else
        for (int k = 0; k < corners; ++k)
          to.array(std::span(values).subspan(std::size_t(view.first_vertex[p] + ids[k]) * n, n));
  }
}

void write_held(const Held& held, ByteWriter& to) {
  to.value(held.id);
  write_cell(*held.part->cells, held.flat, *held.part->step, to);
}

/// The bytes of a cell behind its id and shape.
std::size_t bytes_of_cell(const mesh::EarlierStep& like, int corners) {
  std::size_t numbers = 3 * std::size_t(corners);
  for (const mesh::EarlierStep::Field& field : like.fields)
    numbers += field.steps.size() * std::size_t(field.components) *
               (field.association == INSITU_CELL ? 1 : std::size_t(corners));
  return numbers * sizeof(double);
}

/// The cells that came to this process in a round.
class KnownCells {
public:
  /// The parcels must outlive the object.
  KnownCells(std::span<const Parcel> parcels, const mesh::EarlierStep& like) {
    for (const Parcel& parcel : parcels)
      for (std::span<const std::byte> rest(parcel.bytes); !rest.empty();) {
        ByteReader from(rest);
        const auto id = from.value<std::int64_t>();
        const int corners = mesh::vertex_count(mesh::Shape(from.value<std::int64_t>()));
        const std::size_t size = sizeof(std::int64_t) + bytes_of_cell(like, corners);
        cells_.push_back({id, rest.subspan(sizeof id, size)});
        rest = rest.subspan(sizeof id + size);
      }
    std::ranges::sort(cells_, {}, &Cell::id);
  }
  /// Writes the shape and what is behind it; for a cell that is not known, no shape alone.
  void write(std::int64_t id, ByteWriter& to) const {
    const auto at = std::ranges::lower_bound(cells_, id, {}, &Cell::id);
    if (at != cells_.end() && at->id == id)
      to.array(at->behind_id);
    else
      to.value(std::int64_t(mesh::Shape::none));
  }

private:
  struct Cell {
    std::int64_t id;
    std::span<const std::byte> behind_id;
  };
  std::vector<Cell> cells_; ///< by id
};

std::vector<Parcel> answers_to(std::span<const Parcel> questions, const KnownCells& cells) {
  std::vector<Parcel> answers;
  for (const Parcel& parcel : questions) {
    ByteWriter to;
    for (const std::int64_t id : parallel::items_of<std::int64_t>(parcel.bytes))
      cells.write(id, to);
    answers.push_back({parcel.rank, to.bytes()});
  }
  return answers;
}

/// The step of this process's mesh as it comes together.
class Filled {
public:
  Filled(const mesh::MeshView& view, mesh::EarlierStep& step)
      : view_(view), step_(step), known_(std::size_t(view.vertex_count()), 0) {}

  /// Reads what write_cell() wrote. Returns false if the shape is another, or if a corner's place
  /// is known already and another.
  bool read_cell(std::int64_t flat, ByteReader& from) {
    const std::int32_t p = view_.piece_of(flat);
    std::int64_t ids[8];
    if (mesh::Shape(from.value<std::int64_t>()) !=
        view_.pieces[p].shape(flat - view_.first_cell[p]))
      return false;
    const int corners = view_.pieces[p].vertex_ids(flat - view_.first_cell[p], ids);
    bool agrees = true;
    const auto vertex = [&](int k) { return std::size_t(view_.first_vertex[p] + ids[k]); };
    for (int k = 0; k < corners; ++k) {
      const auto x = from.value<math::Vec3d>();
      math::Vec3d& to = step_.points[vertex(k)];
      for (int a = 0; a < 3 && known_[vertex(k)]; ++a)
        agrees = agrees && std::bit_cast<std::int64_t>(to[a]) == std::bit_cast<std::int64_t>(x[a]);
      to = x;
    }
    for (mesh::EarlierStep::Field& field : step_.fields) {
      const auto n = std::size_t(field.components);
      for (std::vector<double>& values : field.steps)
        if (field.association == INSITU_CELL)
          from.array(std::span(values).subspan(std::size_t(flat) * n, n));
        else
          for (int k = 0; k < corners; ++k)
            from.array(std::span(values).subspan(vertex(k) * n, n));
    }
    for (int k = 0; k < corners; ++k)
      known_[vertex(k)] = 1;
    return agrees;
  }
  void put_others_where_they_are() {
    for (std::int32_t p = 0; p < view_.piece_count - view_.halo_piece_count; ++p)
      for (std::int64_t v = 0; v < view_.pieces[p].vertex_count; ++v)
        if (const auto flat = std::size_t(view_.first_vertex[p] + v); !known_[flat])
          step_.points[flat] = view_.pieces[p].point(v);
  }

private:
  const mesh::MeshView& view_;
  mesh::EarlierStep& step_;
  std::vector<std::uint8_t> known_; ///< [flat vertex]
};

} // namespace

mesh::EarlierStep fields_of_all(const mesh::EarlierStep* mine, parallel::World& world) {
  mesh::EarlierStep step;
  std::int64_t first = mine ? world.rank() : world.size();
  world.reduce(std::span(&first, 1), parallel::Reduction::least);
  if (first == world.size())
    return step;
  std::string text;
  world.agree_after([&] {
    if (world.rank() != first)
      return;
    ByteWriter to;
    for (const mesh::EarlierStep::Field& field : mine->fields) {
      to.value(std::int64_t(field.name.size()));
      to.array(std::span<const char>(field.name));
      to.value(std::int64_t(field.association));
      to.value(std::int64_t(field.components));
      to.value(std::int64_t(field.steps.size()));
    }
    const std::vector<std::byte> bytes = to.bytes();
    text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  });
  text = world.broadcast(text, int(first));
  world.agree_after([&] {
    ByteReader from(std::as_bytes(std::span(text)));
    while (!from.at_end()) {
      mesh::EarlierStep::Field& field = step.fields.emplace_back();
      const auto name = from.array<char>(std::size_t(from.value<std::int64_t>()));
      field.name.assign(name.begin(), name.end());
      field.association = insitu_association(from.value<std::int64_t>());
      field.components = std::int32_t(from.value<std::int64_t>());
      field.steps.resize(std::size_t(from.value<std::int64_t>()));
    }
  });
  return step;
}

bool deal_by_ids(std::span<const StepPart> parts, const CommittedMesh& mesh, parallel::World& world,
                 mesh::EarlierStep& step) {
  const mesh::MeshView& view = mesh.mesh().view();
  std::int64_t facts[2] = {view.own_cell_count(), 0}; // the most cells; parts that are unfit
  for (const StepPart& part : parts) {
    facts[0] = std::max(facts[0], part.cells->cell_count());
    facts[1] = facts[1] || !mesh::have_same_fields(*part.step, step) ||
               std::int64_t(part.ids.size()) != part.cells->cell_count() ||
               !part.step->fits(*part.cells, part.cells->vertex_count());
  }
  world.reduce(facts, parallel::Reduction::greatest);
  if (facts[1])
    return false;
  const std::int64_t rounds = std::max<std::int64_t>(1, facts[0] / cells_at_a_time);
  const Slices slices(rounds, world.size());
  std::vector<Held> held;
  std::vector<Wanted> wanted;
  std::optional<Filled> filled;
  world.agree_after([&] {
    for (const StepPart& part : parts)
      for_each_owner(*part.cells, [&](std::int64_t flat) {
        const std::int64_t id = part.ids[std::size_t(flat)];
        held.push_back({slices.round_of(id), id, &part, flat});
      });
    for_each_owner(view, [&](std::int64_t flat) {
      const std::int64_t id = id_of_cell(mesh, flat);
      wanted.push_back({slices.round_of(id), id, flat});
    });
    std::ranges::stable_sort(held, {}, &Held::round);
    std::ranges::stable_sort(wanted, {}, &Wanted::round);
    mesh::resize(step, view);
    filled.emplace(view, step);
  });
  std::int64_t differs = 0;
  auto next_held = held.begin();
  auto next_wanted = wanted.begin();
  for (std::int64_t round = 0; round < rounds; ++round) {
    const auto first = next_wanted;
    std::vector<Parcel> cells, questions, answers;
    world.agree_after([&] {
      std::vector<ByteWriter> having(std::size_t(world.size())), asking(having.size());
      for (; next_held != held.end() && next_held->round == round; ++next_held)
        write_held(*next_held, having[std::size_t(slices.home_of(next_held->id))]);
      for (; next_wanted != wanted.end() && next_wanted->round == round; ++next_wanted)
        asking[std::size_t(slices.home_of(next_wanted->id))].value(next_wanted->id);
      cells = parallel::parcels_of(having);
      questions = parallel::parcels_of(asking);
    });
    const std::vector<Parcel> here = world.exchange(cells);
    const std::vector<Parcel> asked = world.exchange(questions);
    world.agree_after([&] { answers = answers_to(asked, KnownCells(here, step)); });
    const std::vector<Parcel> answered = world.exchange(answers);
    world.agree_after([&] {
      std::vector<std::optional<ByteReader>> from(std::size_t(world.size()));
      for (const Parcel& parcel : answered)
        from[std::size_t(parcel.rank)].emplace(parcel.bytes);
      for (auto w = first; w != next_wanted && differs == 0; ++w) {
        ByteReader& reader = *from[std::size_t(slices.home_of(w->id))];
        differs = !filled->read_cell(w->flat, reader);
      }
    });
  }
  world.reduce(std::span(&differs, 1), parallel::Reduction::greatest);
  if (differs)
    return false;
  world.agree_after([&] { filled->put_others_where_they_are(); });
  return true;
}

void fill_halo(const CommittedMesh& mesh, parallel::World& world, mesh::EarlierStep& step) {
  if (world.size() == 1)
    return;
  const mesh::MeshView& view = mesh.mesh().view();
  const std::int64_t own = view.own_cell_count();
  std::vector<std::vector<std::int64_t>> wanted(std::size_t(world.size())); // of each process
  std::vector<Parcel> questions, answers;
  world.agree_after([&] {
    std::vector<ByteWriter> asking(wanted.size());
    for (std::int64_t flat = own; flat < view.cell_count(); ++flat) {
      const CellName name = mesh.located_name(flat);
      wanted[std::size_t(name.rank)].push_back(flat);
      asking[std::size_t(name.rank)].value(name);
    }
    questions = parallel::parcels_of(asking);
  });
  const std::vector<Parcel> asked = world.exchange(questions);
  world.agree_after([&] {
    for (const Parcel& parcel : asked) {
      ByteWriter to;
      for (const CellName& name : parallel::items_of<CellName>(parcel.bytes)) {
        const std::int64_t flat = mesh.find_located(name);
        if (flat < 0 || flat >= own)
          throw core::Error(INSITU_ERROR_INTERNAL, "a cell of a halo is not its owner's");
        write_cell(view, flat, step, to);
      }
      answers.push_back({parcel.rank, to.bytes()});
    }
  });
  const std::vector<Parcel> answered = world.exchange(answers);
  world.agree_after([&] {
    Filled filled(view, step);
    for (const Parcel& parcel : answered) {
      ByteReader from(parcel.bytes);
      for (const std::int64_t flat : wanted[std::size_t(parcel.rank)])
        if (!filled.read_cell(flat, from))
          throw core::Error(INSITU_ERROR_INTERNAL, "a cell of a halo is another at its owner");
    }
  });
}

} // namespace insitu::commit
