#include "cells/polyhedra/cell_faces.h"

#include <algorithm>
#include <vector>

namespace insitu::cells {

using mesh::FacesView;
using mesh::from_base;

namespace {

/// Where an item ends whose ids lie among others: where the next one starts, or, if that is not
/// told of the last one, where all end.
std::int64_t end_of(std::int64_t item, const mesh::IndexView& offsets, const mesh::IndexView& ids,
                    std::int64_t base) {
  return item + 1 < offsets.count ? from_base(offsets.load(item + 1), base) : ids.count;
}

} // namespace

bool find_ring(const FacesView& faces, std::int64_t face, FaceRing& out) {
  const bool inner = face < faces.faces.count;
  const mesh::RingsView& rings = inner ? faces.faces : faces.boundary;
  const std::int64_t f = inner ? face : face - faces.faces.count;
  if (rings.behind) {
    out = {rings.ring_behind(f), 0, rings.offsets.load(f)};
    return out.ids.data != nullptr;
  }
  const std::int64_t begin = from_base(rings.offsets.load(f), faces.index_base);
  const std::int64_t end = end_of(f, rings.offsets, rings.ids, faces.index_base);
  // From any number to any: begin and size tell the end again.
  out = {rings.ids, begin, std::int64_t(std::uint64_t(end) - std::uint64_t(begin))};
  return begin >= 0 && begin <= end && end <= rings.ids.count;
}

void CellFaces::build(const FacesView& faces, const mesh::PieceView& own, const std::string& name,
                      FaceFindings& findings) {
  first_.resize_discard(std::size_t(faces.cell_count + 1));
  std::fill(first_.begin(), first_.end(), 0);
  if (faces.by_cells)
    take_lists(faces, own, name, findings);
  else
    sort_by_owner(faces, name, findings);
}

namespace {

/// visit(cell, face, what) for the one or two ids that each face names, in the order of the faces;
/// ids count from 0.
template <class Visit>
void for_each_side(const FacesView& faces, Visit&& visit) {
  for (std::int64_t f = 0; f < faces.faces.count; ++f) {
    visit(from_base(faces.owner.load(f), faces.index_base), f, "owner");
    if (f < faces.neighbour.count)
      if (const std::int64_t other = from_base(faces.neighbour.load(f), faces.index_base);
          other >= 0)
        visit(other, f, "neighbour");
  }
  for (std::int64_t f = 0; f < faces.boundary.count; ++f)
    visit(from_base(faces.boundary_owner.load(f), faces.index_base), faces.faces.count + f,
          "boundary owner");
}

} // namespace

void CellFaces::sort_by_owner(const FacesView& faces, const std::string& name,
                              FaceFindings& findings) {
  const std::int64_t cells = faces.cell_count;
  std::int64_t last_cell = -1, last_face = -1;
  for_each_side(faces, [&](std::int64_t cell, std::int64_t face, const char* what) {
    const auto refuse = [&](const std::string& why) {
      findings.add(findings.index_errors,
                   name + ", face " + std::to_string(face) + ": " + what + " " +
                       std::to_string(from_base(cell, -faces.index_base)) + why);
    };
    if (cell < 0 || cell >= cells + faces.far_cells)
      refuse(", " + std::to_string(faces.index_base) + " to " +
             std::to_string(cells + faces.far_cells - 1 + faces.index_base) + " expected");
    else if (face == last_face && cell == last_cell)
      refuse(" is its owner, too; a face lies between two cells");
    else if (cell < cells)
      ++first_[std::size_t(cell) + 1];
    last_cell = cell;
    last_face = face;
  });
  for (std::size_t c = 1; c < first_.size(); ++c)
    first_[c] += first_[c - 1];
  faces_.resize_discard(std::size_t(first_[first_.size() - 1]));
  if (findings.count() > 0)
    return;
  for_each_side(faces, [&](std::int64_t cell, std::int64_t face, const char*) {
    if (cell < cells)
      faces_[std::size_t(first_[std::size_t(cell)]++)] = face;
  });
  for (std::size_t c = first_.size() - 1; c > 0; --c) // each now is where the next one starts
    first_[c] = first_[c - 1];
  first_[0] = 0;
}

void CellFaces::take_lists(const FacesView& faces, const mesh::PieceView& own,
                           const std::string& name, FaceFindings& findings) {
  std::vector<std::uint8_t> cells_of(std::size_t(faces.face_count()), 0);
  const std::int64_t base = faces.index_base;
  for (std::int64_t c = 0; c < faces.cell_count; ++c) {
    const std::size_t at = faces_.size();
    first_[std::size_t(c) + 1] = std::int64_t(at);
    const std::string cell = name + ", cell " + std::to_string(c) + ": ";
    const bool exists = own.exists(c);
    const std::int64_t begin = from_base(faces.cell_offsets.load(c), base);
    const std::int64_t end = end_of(c, faces.cell_offsets, faces.cell_faces, base);
    if (begin < 0 || begin > end || end > faces.cell_faces.count) {
      if (exists)
        findings.add(findings.shape_errors,
                     cell + "its faces lie from " + std::to_string(from_base(begin, -base)) +
                         " to before " + std::to_string(from_base(end, -base)) + " of " +
                         std::to_string(faces.cell_faces.count) + " in cell_faces");
      continue;
    }
    bool sound = true;
    for (std::int64_t k = begin; k < end && sound; ++k) {
      const std::int64_t f = from_base(faces.cell_faces.load(k), base);
      sound = f >= 0 && f < faces.face_count();
      if (!sound && exists)
        findings.add(findings.index_errors,
                     cell + "face " + std::to_string(k - begin) + " has id " +
                         std::to_string(from_base(f, -base)) + ", " + std::to_string(base) +
                         " to " + std::to_string(faces.face_count() - 1 + base) + " expected");
      else if (sound)
        faces_.push_back(f);
    }
    if (!sound)
      faces_.resize(at);
    for (std::size_t k = at; exists && k < faces_.size(); ++k) {
      const std::int64_t f = faces_[k];
      if (std::find(faces_.begin() + at, faces_.begin() + k, f) != faces_.begin() + k)
        findings.add(findings.shape_errors, cell + "lists face " + std::to_string(f) + " twice");
      else if (++cells_of[std::size_t(f)] == 3)
        findings.add(findings.shape_errors, cell + "is the third cell of face " +
                                                std::to_string(f) +
                                                "; a face lies between two cells");
    }
    first_[std::size_t(c) + 1] = std::int64_t(faces_.size());
  }
}

} // namespace insitu::cells
