// A run that is recorded, and replayed from its records: every file is the same, byte for byte.
#include "records.h"

using namespace records;

namespace {

template <class T>
std::vector<T> as(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

} // namespace

/// Float32 points in three strided arrays, ids of 64 bits from 1 on, ghosts, hidden points and
/// blank values; the vertices move, and then there are other cells.
TEST_F(Records, CellsOfOneShapeThatMoveAndChange) {
  same_again([&](insitu_session session, int step, Arrays& arrays) {
    const insitu_mesh mesh = mesh_of(session);
    const Lattice lattice(step < 2 ? 4 : 5, 0.01 * step);
    const insitu_array xyz = arrays.keep(as<float>(lattice.points), 1);
    insitu_array points[3];
    for (int a = 0; a < 3; ++a) {
      points[a] = insitu_array_of(static_cast<const float*>(xyz.data) + a, INSITU_FLOAT32,
                                  xyz.count / 3, 1);
      points[a].stride[0] = 3 * sizeof(float);
    }
    check(insitu_mesh_points(mesh, 0, points, 3));
    if (step == 0 || step == 2) {
      std::vector<std::int64_t> ids = lattice.ids;
      for (std::int64_t& id : ids)
        ++id;
      std::vector<std::uint8_t> ghosts(lattice.ids.size() / 8, 0);
      ghosts.back() = 1;
      const auto last = ids.end() - 8;
      std::fill(last, ids.end(), -7); // which ghosts may hold
      insitu_cells cells = insitu_cells_default();
      cells.connectivity = arrays.keep(ids, 8);
      cells.count = cells.connectivity.count;
      cells.index_base = 1;
      check(insitu_mesh_cells(mesh, 0, &cells));
      const insitu_array of_cells = arrays.keep(ghosts);
      check(insitu_mesh_ghosts(mesh, 0, &of_cells, INSITU_GHOSTS_VTK));
    }
    give_fields(mesh, lattice, 0.1 * step, arrays);
    give_field(mesh, "f", INSITU_VERTEX, arrays.keep(as<float>(lattice.field(step))));
    check(insitu_mesh_field_blank(mesh, "p", lattice.field(0.1 * step)[0]));
    std::vector<std::uint8_t> hidden(lattice.points.size() / 3, 0);
    hidden[std::size_t(step)] = 2;
    const insitu_array of_points = arrays.keep(hidden);
    check(insitu_mesh_hidden_points(mesh, 0, &of_points));
  });
}

/// Two pieces, cells in the mixed layout and in the padded one.
TEST_F(Records, PiecesInOtherLayouts) {
  same_again([&](insitu_session session, int step, Arrays& arrays) {
    const insitu_mesh mesh = mesh_of(session);
    for (const int piece : {0, 1}) {
      const Lattice lattice(3, piece);
      if (step == 0) {
        const insitu_array points = arrays.keep(lattice.points, 3);
        check(insitu_mesh_points(mesh, piece, &points, 1));
        std::vector<std::int32_t> ids;
        std::vector<std::uint8_t> types;
        std::vector<std::int32_t> offsets;
        for (std::size_t c = 0; c < lattice.ids.size(); c += 8) // a cube, or two wedges
          for (const auto& corners :
               c % 16 == 0
                   ? std::vector<std::vector<std::size_t>>{{0, 1, 2, 4, 5, 6}, {0, 2, 3, 4, 6, 7}}
                   : std::vector<std::vector<std::size_t>>{{0, 1, 2, 3, 4, 5, 6, 7}}) {
            offsets.push_back(std::int32_t(ids.size()));
            types.push_back(corners.size() == 6 ? INSITU_WEDGE : INSITU_HEXAHEDRON);
            for (const std::size_t v : corners)
              ids.push_back(std::int32_t(lattice.ids[c + v]));
            if (piece == 1)
              ids.resize(8 * types.size(), -1);
          }
        insitu_cells cells = insitu_cells_default();
        cells.layout = piece == 0 ? INSITU_LAYOUT_MIXED : INSITU_LAYOUT_PADDED;
        cells.count = std::int64_t(types.size());
        cells.connectivity = arrays.keep(ids, piece == 0 ? 1 : 8);
        if (piece == 0) {
          cells.types = arrays.keep(types);
          cells.offsets = arrays.keep(offsets);
        }
        check(insitu_mesh_cells(mesh, piece, &cells));
        std::vector<double> values(types.size());
        for (std::size_t i = 0; i < values.size(); ++i)
          values[i] = std::sin(double(i));
        give_field(mesh, "c", INSITU_CELL, arrays.keep(values), piece);
      }
      give_field(mesh, "p", INSITU_VERTEX, arrays.keep(lattice.field(step)), piece);
      give_field(mesh, "u", INSITU_VERTEX, arrays.keep(lattice.velocity(step), 3), piece);
    }
  });
}

/// A uniform block whose fields are sections of larger arrays; a rectilinear and a curvilinear one.
TEST_F(Records, Blocks) {
  for (const insitu_block_kind kind :
       {INSITU_BLOCK_UNIFORM, INSITU_BLOCK_RECTILINEAR, INSITU_BLOCK_CURVILINEAR}) {
    SCOPED_TRACE(kind);
    fs::remove_all(folder / "live");
    fs::remove_all(folder / "again");
    same_again([&](insitu_session session, int step, Arrays& arrays) {
      const insitu_mesh mesh = mesh_of(session);
      const Lattice lattice(4, 0.0, kind == INSITU_BLOCK_CURVILINEAR ? 0.1 : 0.0);
      if (step == 0) {
        insitu_block block = insitu_block_default();
        block.kind = kind;
        for (int a = 0; a < 3; ++a) {
          block.vertices[a] = 5;
          if (kind == INSITU_BLOCK_UNIFORM) {
            block.origin[a] = -1.0;
            block.spacing[a] = 0.25;
            block.first[a] = 4;
          } else if (kind == INSITU_BLOCK_RECTILINEAR) {
            block.coordinates[a] = arrays.keep(std::vector<float>{0, 0.2F, 0.5F, 0.8F, 1});
          }
        }
        check(insitu_mesh_block(mesh, 0, &block));
        if (kind == INSITU_BLOCK_CURVILINEAR) {
          const insitu_array points = arrays.keep(lattice.points, 3);
          check(insitu_mesh_points(mesh, 0, &points, 1));
        }
      }
      give_fields(mesh, lattice, 0.1 * step, arrays);
      const std::vector<double> p = lattice.field(0.1 * step);
      std::vector<double> larger(7 * 7 * 7, -99.0); // a layer around
      for (std::size_t i = 0; i < p.size(); ++i)
        larger[(i % 5 + 1) + 7 * (i / 5 % 5 + 1) + 49 * (i / 25 + 1)] = p[i];
      insitu_array section = arrays.keep(larger);
      section.data = static_cast<const double*>(section.data) + 1 + 7 + 49;
      section.count = 125;
      for (int a = 0; a < 3; ++a)
        section.extent[a] = 5;
      section.stride[0] = 8;
      section.stride[1] = 7 * 8;
      section.stride[2] = 49 * 8;
      give_field(mesh, "p", INSITU_VERTEX, section);
    });
  }
}

/// Cells by their faces, in both forms; a field's name holds a slash.
TEST_F(Records, Polyhedra) {
  for (const int kind : {0, 1, 2}) {
    SCOPED_TRACE(kind);
    const insitu_faces_form form = kind == 1 ? INSITU_FACES_CELLS : INSITU_FACES_OWNERS;
    fs::remove_all(folder / "live");
    fs::remove_all(folder / "again");
    same_again([&](insitu_session session, int step, Arrays& arrays) {
      const insitu_mesh mesh = mesh_of(session);
      const Lattice lattice(3, 0.01 * step);
      const insitu_array points = arrays.keep(lattice.points, 3);
      check(insitu_mesh_points(mesh, 0, &points, 1));
      if (step == 0) {
        constexpr int corners[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                       {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
        std::map<std::vector<std::int64_t>, std::size_t> known;
        std::vector<std::int32_t> vertices, offsets{0}, owner, cell_faces, cell_offsets{0};
        for (std::size_t c = 0; c < lattice.ids.size() / 8; ++c) {
          for (const auto& face : corners) {
            std::vector<std::int64_t> ring;
            for (const int v : face)
              ring.push_back(lattice.ids[8 * c + std::size_t(v)]);
            std::vector<std::int64_t> key = ring;
            std::sort(key.begin(), key.end());
            const auto [at, fresh] = known.emplace(key, known.size());
            if (fresh) {
              vertices.insert(vertices.end(), ring.begin(), ring.end());
              offsets.push_back(std::int32_t(vertices.size()));
              owner.insert(owner.end(), {std::int32_t(c), -1});
            } else {
              owner[2 * at->second + 1] = std::int32_t(c);
            }
            cell_faces.push_back(std::int32_t(at->second));
          }
          cell_offsets.push_back(std::int32_t(cell_faces.size()));
        }
        insitu_faces faces = insitu_faces_default();
        faces.form = form;
        faces.cell_count = std::int64_t(lattice.ids.size()) / 8;
        faces.face_count = std::int64_t(known.size());
        faces.vertices = arrays.keep(vertices);
        faces.offsets = arrays.keep(offsets);
        if (kind == 2) { // rings behind pointers, of four ids each
          std::vector<std::int64_t> pointers;
          for (std::size_t f = 0; f < known.size(); ++f)
            pointers.push_back(std::int64_t(reinterpret_cast<std::uintptr_t>(
                static_cast<const std::int32_t*>(faces.vertices.data) + 4 * f)));
          insitu_array rings = arrays.keep(pointers);
          rings.type = INSITU_INT32;
          rings.indirect = 1;
          faces.vertices = rings;
          faces.offsets = arrays.keep(std::vector<std::int32_t>(known.size(), 4));
        }
        if (form == INSITU_FACES_OWNERS) {
          faces.owner = arrays.keep(owner, 2);
        } else {
          faces.cell_faces = arrays.keep(cell_faces);
          faces.cell_offsets = arrays.keep(cell_offsets);
        }
        check(insitu_mesh_faces(mesh, 0, &faces));
      }
      give_fields(mesh, lattice, 0.1 * step, arrays);
      give_field(mesh, "a/b%", INSITU_CELL, arrays.keep(lattice.of_cells(step)));
    });
  }
}

/// Quads and triangles on two coordinates, and a block of two dimensions.
TEST_F(Records, FlatMeshes) {
  const std::string flat = R"(insitu: 1
record: {every: 1}
probes:
  - {name: a, mesh: cells, points: [[0.4, 0.3, 0], [9, 9, 0]], fields: [p, c]}
  - {name: b, mesh: block, points: [[0.4, 0.3, 0]], fields: [p]}
tracers:
  - {name: paths, mesh: cells, velocity: u, seeds: [[0.5, 0.5, 0]]}
frames:
  - {name: seen, mesh: cells, size: [40, 30], isosurfaces: [{field: p, values: [0.6]}]}
  - {name: block, mesh: block, size: [40, 30], volume: {field: p}}
)";
  same_again(
      [&](insitu_session session, int step, Arrays& arrays) {
        std::vector<double> xy, p, u, c;
        std::vector<std::int32_t> ids;
        for (int j = 0; j < 5; ++j)
          for (int i = 0; i < 5; ++i) {
            xy.insert(xy.end(), {0.25 * i + 0.01 * step, 0.25 * j});
            p.push_back(std::sin(i + 0.1 * step) + 0.2 * j);
            u.insert(u.end(), {0.3 - 0.1 * j, 0.1 * i});
          }
        for (int j = 0; j < 4; ++j)
          for (int i = 0; i < 4; ++i) {
            const int v = i + 5 * j;
            ids.insert(ids.end(), {v, v + 1, v + 6, v + 5});
            c.push_back(std::cos(0.3 * i + j));
          }
        ids[3] = -1; // a triangle
        const insitu_mesh mesh = mesh_of(session, "cells");
        const insitu_array points = arrays.keep(xy, 2);
        check(insitu_mesh_points(mesh, 0, &points, 1));
        if (step == 0) {
          insitu_cells cells = insitu_cells_default();
          cells.layout = INSITU_LAYOUT_PADDED;
          cells.shape = INSITU_QUAD;
          cells.connectivity = arrays.keep(ids, 4);
          cells.count = 16;
          check(insitu_mesh_cells(mesh, 0, &cells));
          insitu_block block = insitu_block_default();
          block.kind = INSITU_BLOCK_UNIFORM;
          block.dimensions = 2;
          block.vertices[0] = block.vertices[1] = 5;
          block.vertices[2] = 1;
          block.spacing[0] = block.spacing[1] = 0.25;
          check(insitu_mesh_block(mesh_of(session, "block"), 0, &block));
        }
        give_field(mesh, "p", INSITU_VERTEX, arrays.keep(p));
        give_field(mesh, "u", INSITU_VERTEX, arrays.keep(u, 2));
        give_field(mesh, "c", INSITU_CELL, arrays.keep(c));
        give_field(mesh_of(session, "block"), "p", INSITU_VERTEX, arrays.keep(p));
      },
      flat);
}

/// Two meshes, of which one is in longitude and latitude.
TEST_F(Records, SeveralMeshesInTheirFrames) {
  const std::string two = R"(insitu: 1
record: {every: 1}
probes:
  - {name: a, mesh: fluid, points: [[0.5, 0.5, 0.5]], fields: [p]}
  - {name: b, mesh: sea, points: [[10.4, 45.5, 0.5]], frame: mesh, fields: [p]}
tracers:
  - {name: drifters, mesh: sea, velocity: u, seeds: [[10.4, 45.5, 0.5]], frame: mesh}
frames:
  - {name: fluid, mesh: fluid, size: [40, 30], isosurfaces: [{field: p, values: [0.6]}]}
  - {name: again, mesh: fluid, size: [40, 30], volume: {field: c}}
)";
  same_again(
      [&](insitu_session session, int step, Arrays& arrays) {
        for (const char* name : {"fluid", "sea"}) {
          const insitu_mesh mesh = mesh_of(session, name);
          Lattice lattice(3);
          if (name == std::string("sea")) {
            for (std::size_t i = 0; i < lattice.points.size(); i += 3) {
              lattice.points[i] += 10;
              lattice.points[i + 1] += 45;
            }
            insitu_frame frame = insitu_frame_default();
            frame.kind = INSITU_FRAME_GEODETIC;
            frame.length = INSITU_KILOMETRES;
            check(insitu_mesh_frame(mesh, &frame));
          }
          const insitu_array points = arrays.keep(lattice.points, 3);
          check(insitu_mesh_points(mesh, 0, &points, 1));
          insitu_cells cells = insitu_cells_default();
          cells.connectivity = arrays.keep(lattice.ids, 8);
          cells.count = cells.connectivity.count;
          check(insitu_mesh_cells(mesh, 0, &cells));
          give_fields(mesh, lattice, 0.1 * step, arrays);
        }
      },
      two);
  // A dry run tells every mesh, and what the recorded scene would write.
  const std::string all = "live/record_000000.hdf live/record_000010.hdf";
  expect_checked(
      all,
      {"mesh 'fluid': 27 cells, 64 vertices\n", "mesh 'sea': 27 cells, 64 vertices\n",
       "  field 'p' on vertices, 1 component\n", "  field 'u' on vertices, 3 components\n",
       "  field 'c' on cells, 1 component\n", "2 steps\n", "  nothing/drifters.csv (every cycle)\n",
       "  nothing/fluid_*.png (every cycle)\n", "  nothing/record_*.hdf (every 1)\n", " are kept"});
  put("typo.yaml",
      "insitu: 1\nprobes:\n  - {name: a, mesh: fluit, points: [[0.5, 0.5, 0.5]], fields: [p]}\n");
  expect_checked("--scene typo.yaml " + all, {"2 steps\n"}, "did you mean 'fluid'?");
}
