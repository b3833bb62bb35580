#include "cells/polyhedra/parts.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "cells/polyhedra/closed_cell.h"
#include "core/status.h"

namespace insitu::cells {

using mesh::FacesView;
using mesh::Shape;

namespace {

constexpr std::int64_t cutting_grain = 1024; ///< cells a chunk
/// Stands for the cell's centre among the ids of its parts; -1 - f for that of face f.
constexpr std::int64_t cell_centre = std::numeric_limits<std::int64_t>::min();

} // namespace

/// What a chunk of cells is cut into.
struct Parts::Chunk {
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> ids;
  std::vector<std::uint32_t> parts;        ///< [cell] how many
  std::vector<std::uint32_t> cut;          ///< cells
  std::vector<std::int64_t> sources;       ///< of their centres
  std::vector<std::int64_t> source_counts; ///< [cut]
  std::vector<std::int64_t> large_faces;   ///< of cells that are cut
  FaceFindings findings;
};

/// Cuts the cells of a chunk.
class Parts::Cutter {
public:
  Cutter(const FacesView& faces, const mesh::PieceView& own, const CellFaces& cell_faces,
         const std::string& name, Chunk& to)
      : own_(own), cell_faces_(cell_faces), cell_(faces, own, name), to_(to) {}

  void cut(std::int64_t cell) {
    const std::size_t before = to_.types.size();
    FaceFindings ignored;
    if (cell_.gather(cell, cell_faces_.of(cell), own_.exists(cell) ? to_.findings : ignored))
      take(cell);
    to_.parts.push_back(std::uint32_t(to_.types.size() - before));
  }

private:
  void add(Shape shape, std::initializer_list<std::int64_t> ids) {
    to_.types.push_back(std::uint8_t(shape));
    to_.ids.insert(to_.ids.end(), ids);
  }

  void take(std::int64_t cell) {
    std::int64_t ids[8];
    const Shape shape = cell_.recognise(ids);
    if (shape != Shape::none) {
      to_.types.push_back(std::uint8_t(shape));
      to_.ids.insert(to_.ids.end(), ids, ids + mesh::vertex_count(shape));
      return;
    }
    for (const ClosedCell::Ring& ring : cell_.rings()) {
      const auto id = [&](int k) { return cell_.id(cell_.at(ring, k % ring.size)); };
      if (ring.size == 3) {
        add(Shape::tetrahedron, {id(0), id(2), id(1), cell_centre});
      } else if (ring.size == 4) {
        add(Shape::pyramid, {id(0), id(3), id(2), id(1), cell_centre});
      } else {
        to_.large_faces.push_back(ring.face);
        for (int k = 0; k < ring.size; ++k)
          add(Shape::tetrahedron, {id(k), -1 - ring.face, id(k + 1), cell_centre});
      }
    }
    to_.cut.push_back(std::uint32_t(cell));
    to_.source_counts.push_back(std::int64_t(cell_.vertices().size()));
    to_.sources.insert(to_.sources.end(), cell_.vertices().begin(), cell_.vertices().end());
  }

  const mesh::PieceView& own_;
  const CellFaces& cell_faces_;
  ClosedCell cell_;
  Chunk& to_;
};

Parts::Parts(core::Memory& memory)
    : memory_(&memory), ids_(memory), offsets_(memory), types_(memory, INSITU_MEMORY_POLYHEDRA),
      first_(memory, INSITU_MEMORY_POLYHEDRA), cell_of_(memory, INSITU_MEMORY_POLYHEDRA),
      cut_cells_(memory, INSITU_MEMORY_POLYHEDRA), source_first_(memory, INSITU_MEMORY_POLYHEDRA),
      sources_(memory) {}

void Parts::cut(const FacesView& faces, const mesh::PieceView& own, const std::string& name,
                const core::Threads& threads, FaceFindings& findings) {
  CellFaces cell_faces(*memory_);
  cell_faces.build(faces, own, name, findings);
  if (findings.count() > 0)
    return;
  std::vector<Chunk> chunks(std::size_t((faces.cell_count + cutting_grain - 1) / cutting_grain));
  threads.parallel_for(faces.cell_count, cutting_grain, [&](std::int64_t begin, std::int64_t end) {
    Cutter cutter(faces, own, cell_faces, name, chunks[std::size_t(begin / cutting_grain)]);
    for (std::int64_t c = begin; c < end; ++c)
      cutter.cut(c);
  });
  for (const Chunk& chunk : chunks)
    findings.add(chunk.findings);
  if (findings.count() > 0)
    return;
  core::Buffer<std::uint32_t> number_of_face(*memory_, INSITU_MEMORY_BUILD);
  number_centres(faces, own.vertex_count, chunks, number_of_face);
  join(chunks, number_of_face, own.vertex_count, threads);
}

/// The large faces of cells that are cut, ascending, are the first made vertices.
void Parts::number_centres(const FacesView& faces, std::int64_t vertices,
                           const std::vector<Chunk>& chunks,
                           core::Buffer<std::uint32_t>& number_of_face) {
  std::int64_t sources = 0, cut = 0;
  for (const Chunk& chunk : chunks) {
    sources += std::int64_t(chunk.sources.size());
    cut += std::int64_t(chunk.cut.size());
  }
  number_of_face.resize_discard(cut > 0 ? std::size_t(faces.face_count()) : 0);
  std::fill(number_of_face.begin(), number_of_face.end(), 0u);
  for (const Chunk& chunk : chunks)
    for (const std::int64_t face : chunk.large_faces)
      number_of_face[std::size_t(face)] = 1;
  face_centres_ = 0;
  FaceRing ring{};
  for (std::size_t f = 0; f < number_of_face.size(); ++f)
    if (number_of_face[f] != 0) {
      number_of_face[f] = std::uint32_t(face_centres_++);
      find_ring(faces, std::int64_t(f), ring);
      sources += ring.size;
    } else {
      number_of_face[f] = std::numeric_limits<std::uint32_t>::max();
    }
  cut_cells_.resize_discard(std::size_t(cut));
  source_first_.resize_discard(std::size_t(face_centres_ + cut + 1));
  sources_.resize(sources, vertices);
  std::int64_t at = 0, made = 0;
  for (std::size_t f = 0; f < number_of_face.size(); ++f) {
    if (number_of_face[f] == std::numeric_limits<std::uint32_t>::max())
      continue;
    source_first_[std::size_t(made++)] = at;
    find_ring(faces, std::int64_t(f), ring);
    for (std::int64_t k = 0; k < ring.size; ++k)
      sources_.set(at++, mesh::from_base(ring.id(k), faces.index_base));
  }
  std::size_t k = 0;
  for (const Chunk& chunk : chunks) {
    auto from = chunk.sources.begin();
    for (std::size_t i = 0; i < chunk.cut.size(); ++i) {
      cut_cells_[k++] = chunk.cut[i];
      source_first_[std::size_t(made++)] = at;
      for (std::int64_t n = 0; n < chunk.source_counts[i]; ++n)
        sources_.set(at++, *from++);
    }
  }
  source_first_[std::size_t(made)] = at;
}

void Parts::join(const std::vector<Chunk>& chunks,
                 const core::Buffer<std::uint32_t>& number_of_face, std::int64_t vertices,
                 const core::Threads& threads) {
  struct Before {
    std::int64_t parts = 0, ids = 0, cells = 0, cut = 0;
  };
  std::vector<Before> before(chunks.size() + 1);
  bool is_uniform = true;
  std::uint8_t shape = 0;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    const Chunk& c = chunks[i];
    before[i + 1] = {
        before[i].parts + std::int64_t(c.types.size()), before[i].ids + std::int64_t(c.ids.size()),
        before[i].cells + std::int64_t(c.parts.size()), before[i].cut + std::int64_t(c.cut.size())};
    if (!c.types.empty() && shape == 0)
      shape = c.types[0];
    is_uniform = is_uniform && std::ranges::count(c.types, shape) == std::ptrdiff_t(c.types.size());
  }
  const Before all = before.back();
  if (all.parts > std::numeric_limits<std::uint32_t>::max())
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      std::to_string(all.cells) + " cells given by faces are cut into " +
                          std::to_string(all.parts) + "; a mesh holds at most " +
                          std::to_string(std::numeric_limits<std::uint32_t>::max()));
  uniform_ = is_uniform ? Shape(shape) : Shape::none;
  ids_.resize(all.ids, vertices + made_count());
  offsets_.resize(is_uniform ? 0 : all.parts + 1, all.ids);
  types_.resize_discard(is_uniform ? 0 : std::size_t(all.parts));
  first_.resize_discard(std::size_t(all.cells + 1));
  cell_of_.resize_discard(std::size_t(all.parts));
  first_[std::size_t(all.cells)] = std::uint32_t(all.parts);
  if (!is_uniform)
    offsets_.set(all.parts, all.ids);
  threads.parallel_for(std::int64_t(chunks.size()), 1, [&](std::int64_t i, std::int64_t) {
    const Chunk& c = chunks[std::size_t(i)];
    Before at = before[std::size_t(i)];
    auto id = c.ids.begin();
    auto type = c.types.begin();
    std::int64_t centre = vertices + face_centres_ + at.cut;
    for (std::size_t cell = 0, cut = 0; cell < c.parts.size(); ++cell, ++at.cells) {
      first_[std::size_t(at.cells)] = std::uint32_t(at.parts);
      const bool is_cut = cut < c.cut.size() && c.cut[cut] == std::uint32_t(at.cells);
      for (std::uint32_t k = 0; k < c.parts[cell]; ++k, ++type, ++at.parts) {
        cell_of_[std::size_t(at.parts)] = std::uint32_t(at.cells);
        if (!is_uniform) {
          types_[std::size_t(at.parts)] = *type;
          offsets_.set(at.parts, at.ids);
        }
        for (int v = mesh::vertex_count(Shape(*type)); v > 0; --v, ++id, ++at.ids)
          ids_.set(at.ids, *id >= 0 ? *id
                           : *id == cell_centre
                               ? centre
                               : vertices + std::int64_t(number_of_face[std::size_t(-1 - *id)]));
      }
      cut += is_cut;
      centre += is_cut;
    }
  });
}

mesh::PieceView Parts::view(const mesh::PieceView& own) const {
  mesh::PieceView v;
  v.cell_count = part_count();
  v.vertex_count = own.vertex_count + made_count();
  v.id_stride = ids_.item_size();
  v.points = own.points;
  v.part_of = cell_of_.data();
  v.is_halo = own.is_halo;
  if (uniform_ != Shape::none || part_count() == 0) {
    v.uniform_shape = uniform_ == Shape::none ? Shape::tetrahedron : uniform_;
    v.connectivity = ids_.view(mesh::vertex_count(v.uniform_shape));
    return v;
  }
  v.layout = mesh::CellLayout::mixed;
  v.connectivity = ids_.view();
  v.offsets = offsets_.view();
  v.types = reinterpret_cast<const std::byte*>(types_.data());
  return v;
}

std::int64_t Parts::bytes() const {
  return ids_.bytes() + offsets_.bytes() + sources_.bytes() +
         std::int64_t(types_.bytes() + first_.bytes() + cell_of_.bytes() + cut_cells_.bytes() +
                      source_first_.bytes());
}

} // namespace insitu::cells
