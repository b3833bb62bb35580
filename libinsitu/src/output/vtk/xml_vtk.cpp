#include "output/vtk/xml_vtk.h"

#include <algorithm>
#include <bit>

#include "core/status.h"
#include "output/files/atomic_file.h"
#include "output/files/csv.h"
#include "output/vtk/xml_text.h"

namespace insitu::output {

namespace {

struct ScalarInfo {
  const char* name;
  std::size_t bytes;
};

ScalarInfo info(VtkScalar scalar) {
  switch (scalar) {
  case VtkScalar::float32:
    return {"Float32", 4};
  case VtkScalar::float64:
    return {"Float64", 8};
  case VtkScalar::int8:
    return {"Int8", 1};
  case VtkScalar::uint8:
    return {"UInt8", 1};
  case VtkScalar::int32:
    return {"Int32", 4};
  case VtkScalar::int64:
    break;
  }
  return {"Int64", 8};
}

/// An array of the file: the caller's, or 0, 1, 2, ... (from `first`), which is made on the fly.
struct Block {
  VtkArray array;
  bool counting = false;
  std::int64_t first = 0;

  std::size_t bytes() const {
    return array.tuples * std::size_t(array.components) * info(array.scalar).bytes;
  }
};

Block count_from(const char* name, std::int64_t first, std::size_t count) {
  return {{name, VtkScalar::int64, 1, nullptr, count}, true, first};
}

void write_counting(AtomicFile& file, std::int64_t first, std::size_t count) {
  std::int64_t chunk[1024];
  for (std::size_t done = 0; done < count;) {
    const std::size_t n = std::min<std::size_t>(count - done, std::size(chunk));
    for (std::size_t i = 0; i < n; ++i)
      chunk[i] = first + std::int64_t(done + i);
    file.write(chunk, n * sizeof *chunk);
    done += n;
  }
}

/// Collects the XML and the blocks that it points at, then writes both.
class Document {
public:
  explicit Document(const char* type) : type_(type) {
    text_ = std::string("<?xml version=\"1.0\"?>\n<VTKFile type=\"") + type +
            "\" version=\"1.0\" byte_order=\"" +
            (std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian") +
            "\" header_type=\"UInt64\">\n <" + type + ">\n";
  }

  void time(const VtkDataSet& data) {
    if (data.has_time) {
      open("FieldData");
      text_ += "   <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
               "format=\"ascii\">";
      append_number(text_, data.time);
      text_ += "</DataArray>\n";
      close("FieldData");
    }
  }

  void open(const std::string& element) { text_ += "  <" + element + ">\n"; }
  void close(const std::string& element) { text_ += "  </" + element + ">\n"; }

  void add(const Block& block) {
    text_ += std::string("   <DataArray type=\"") + info(block.array.scalar).name + "\" Name=\"" +
             xml_escape(block.array.name) + "\" NumberOfComponents=\"" +
             std::to_string(block.array.components) + "\" format=\"appended\" offset=\"" +
             std::to_string(offset_) + "\"/>\n";
    offset_ += sizeof(std::uint64_t) + block.bytes();
    blocks_.push_back(block);
  }

  void add(const char* section, const std::vector<VtkArray>& arrays) {
    open(section);
    for (const VtkArray& array : arrays)
      add(Block{array});
    close(section);
  }

  void write(const std::string& path) {
    AtomicFile file(path);
    file.write(text_ + "  </Piece>\n </" + type_ + ">\n <AppendedData encoding=\"raw\">\n_");
    for (const Block& block : blocks_) {
      const std::uint64_t bytes = block.bytes();
      file.write(&bytes, sizeof bytes);
      if (block.counting)
        write_counting(file, block.first, block.array.tuples);
      else
        file.write(block.array.data, block.bytes());
    }
    file.write("\n </AppendedData>\n</VTKFile>\n");
    file.commit();
  }

private:
  std::string type_;
  std::string text_;
  std::vector<Block> blocks_;
  std::size_t offset_ = 0;
};

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
  throw core::Error(INSITU_ERROR_ARGUMENT, "'" + path + "': " + what);
}

void check(const std::string& path, const VtkDataSet& data, std::size_t cells) {
  const VtkArray& points = data.points;
  if (points.components != 3 ||
      (points.scalar != VtkScalar::float32 && points.scalar != VtkScalar::float64))
    refuse(path, "points: 3 components of float32 or float64 expected");
  const auto check_counts = [&](const char* where, const std::vector<VtkArray>& arrays,
                                std::size_t expected) {
    for (const VtkArray& array : arrays)
      if (array.tuples != expected)
        refuse(path, std::string(where) + " '" + array.name + "': " + std::to_string(expected) +
                         " items expected, " + std::to_string(array.tuples) + " given");
  };
  check_counts("point data", data.point_data, points.tuples);
  check_counts("cell data", data.cell_data, cells);
}

/// Ends must ascend and stop at `length`; ids must be those of points.
void check_cells(const std::string& path, const char* what, std::span<const std::int64_t> ends,
                 std::span<const std::int64_t> ids, std::size_t length, std::size_t points) {
  std::int64_t before = 0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    if (ends[i] <= before) {
      refuse(path, std::string(what) + " " + std::to_string(i) + " begins at " +
                       std::to_string(before) + " and ends at " + std::to_string(ends[i]) +
                       ": at least one point expected");
    }
    before = ends[i];
  }
  if (before != std::int64_t(length)) {
    refuse(path, std::string(what) + "s: " + std::to_string(before) + " point ids expected, " +
                     std::to_string(length) + " given");
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] < 0 || ids[i] >= std::int64_t(points)) {
      refuse(path, "point id " + std::to_string(ids[i]) + " at index " + std::to_string(i) +
                       " of " + std::to_string(points) + " points");
    }
  }
}

/// VTK wants two points a line: those of one get it twice.
struct Lines {
  std::vector<std::int64_t> points, ends;

  explicit Lines(const VtkPolyData& data) {
    std::int64_t begin = 0;
    for (const std::int64_t end : data.line_ends) {
      for (std::int64_t i = begin; i < end; ++i)
        points.push_back(data.line_points.empty() ? i : data.line_points[std::size_t(i)]);
      if (end - begin == 1)
        points.push_back(points.back());
      ends.push_back(std::int64_t(points.size()));
      begin = end;
    }
  }

  static bool needed(std::span<const std::int64_t> line_ends) {
    std::int64_t begin = 0;
    return std::any_of(line_ends.begin(), line_ends.end(), [&](std::int64_t end) {
      const bool single = end - begin == 1;
      begin = end;
      return single;
    });
  }
};

VtkArray make(std::string name, VtkScalar scalar, const void* data, std::size_t values,
              int components) {
  if (components < 1 || values % std::size_t(components) != 0) {
    throw core::Error(INSITU_ERROR_INTERNAL, "array '" + name + "': " + std::to_string(values) +
                                                 " values do not make tuples of " +
                                                 std::to_string(components));
  }
  return {std::move(name), scalar, components, data, values / std::size_t(components)};
}

void add_points(Document& document, const VtkArray& points) {
  document.open("Points");
  Block block{points};
  block.array.name = "Points";
  document.add(block);
  document.close("Points");
}

} // namespace

VtkArray vtk_array(std::string name, std::span<const double> values, int components) {
  return make(std::move(name), VtkScalar::float64, values.data(), values.size(), components);
}
VtkArray vtk_array(std::string name, std::span<const float> values, int components) {
  return make(std::move(name), VtkScalar::float32, values.data(), values.size(), components);
}
VtkArray vtk_array(std::string name, std::span<const std::int64_t> values, int components) {
  return make(std::move(name), VtkScalar::int64, values.data(), values.size(), components);
}
VtkArray vtk_array(std::string name, std::span<const std::int32_t> values, int components) {
  return make(std::move(name), VtkScalar::int32, values.data(), values.size(), components);
}
VtkArray vtk_array(std::string name, std::span<const std::uint8_t> values, int components) {
  return make(std::move(name), VtkScalar::uint8, values.data(), values.size(), components);
}

void write_vtp(const std::string& path, const VtkPolyData& data) {
  const std::size_t points = data.points.tuples;
  const std::size_t lines = data.line_ends.size();
  const std::size_t quads = data.quads.size() / 4;
  const std::size_t vertices = lines + quads == 0 ? points : 0;
  const std::size_t in_lines =
      data.line_points.empty() && lines > 0 ? points : data.line_points.size();
  check(path, data, vertices + lines + quads);
  check_cells(path, "line", data.line_ends, data.line_points, in_lines, points);
  std::vector<std::int64_t> quad_ends;
  for (std::size_t i = 1; i <= quads; ++i)
    quad_ends.push_back(std::int64_t(4 * i));
  check_cells(path, "quad", quad_ends, data.quads, data.quads.size(), points);

  Document document("PolyData");
  document.time(data);
  document.open("Piece NumberOfPoints=\"" + std::to_string(points) + "\" NumberOfVerts=\"" +
                std::to_string(vertices) + "\" NumberOfLines=\"" + std::to_string(lines) +
                "\" NumberOfStrips=\"0\" NumberOfPolys=\"" + std::to_string(quads) + "\"");
  document.add("PointData", data.point_data);
  document.add("CellData", data.cell_data);
  add_points(document, data.points);
  document.open("Verts");
  document.add(count_from("connectivity", 0, vertices));
  document.add(count_from("offsets", 1, vertices));
  document.close("Verts");
  document.open("Lines");
  const Lines lengthened(Lines::needed(data.line_ends) ? data : VtkPolyData());
  if (!lengthened.ends.empty()) {
    document.add(Block{vtk_array("connectivity", lengthened.points)});
    document.add(Block{vtk_array("offsets", lengthened.ends)});
  } else {
    document.add(data.line_points.empty() ? count_from("connectivity", 0, in_lines)
                                          : Block{vtk_array("connectivity", data.line_points)});
    document.add(Block{vtk_array("offsets", data.line_ends)});
  }
  document.close("Lines");
  if (quads > 0) {
    document.open("Polys");
    document.add(Block{vtk_array("connectivity", data.quads)});
    document.add(Block{vtk_array("offsets", quad_ends)});
    document.close("Polys");
  }
  document.write(path);
}

} // namespace insitu::output
