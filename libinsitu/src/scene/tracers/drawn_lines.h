#pragma once

#include <cstdint>
#include <vector>

#include "advect/lines/polylines.h"
#include "output/vtk/xml_vtk.h"

namespace insitu::scene {

/// The lines that have a vertex, for VTK files: those of seeds outside have none, and only end in
/// the tables and reports. Between two vertices of one time, on opposite periodic sides, a line is
/// cut in two.
struct DrawnLines {
  explicit DrawnLines(const advect::Polylines& lines) {
    for (std::size_t l = 0; l < lines.line_count(); ++l) {
      if (lines.offsets[l] == lines.offsets[l + 1])
        continue;
      for (std::int64_t v = lines.offsets[l] + 1; v < lines.offsets[l + 1]; ++v)
        if (lines.times[std::size_t(v)] == lines.times[std::size_t(v - 1)])
          add(lines, l, v);
      add(lines, l, lines.offsets[l + 1]);
    }
  }
  void add_to(output::VtkPolyData& data, const char* particle_name) const {
    data.cell_data.push_back(
        output::vtk_array(particle_name, std::span<const std::int64_t>(particles)));
    data.cell_data.push_back(output::vtk_array("ending", std::span<const std::uint8_t>(endings)));
    data.line_ends = ends;
  }
  std::vector<std::int64_t> ends, particles;
  std::vector<std::uint8_t> endings;

private:
  void add(const advect::Polylines& lines, std::size_t l, std::int64_t end) {
    ends.push_back(end);
    particles.push_back(lines.particles[l]);
    endings.push_back(lines.endings[l]);
  }
};

} // namespace insitu::scene
