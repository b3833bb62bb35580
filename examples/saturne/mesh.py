#!/usr/bin/env python3
"""Writes the example's mesh: rings of fine hexahedra around a cylinder in a square, and a coarser grid around the square.

    mesh.py FILE   a file of gmsh's format 2.2

The fine cells are two thirds of the coarse ones along the square's sides and along z, and share no vertex with them: the two
parts are groups of their own, which Code_Saturne's joining makes one mesh, with polyhedra on both sides. Groups of faces: 1
inlet, 2 outlet, 3 sides, 4 cylinder, 5 what is to be joined.
"""
import math
import sys

INLET, OUTLET, SIDES, CYLINDER, JOINED = 1, 2, 3, 4, 5
LENGTH, HEIGHT, DEPTH = 2.4, 0.8, 0.2
LEFT, RIGHT, BELOW, ABOVE = 0.4, 0.8, 0.2, 0.6  # the square's sides
CENTRE, RADIUS = (0.6, 0.4), 0.08
H = 0.05                                       # the coarse cells' edge
FINE = 12                                      # fine cells along a side of the square, which has 8 coarse ones
RINGS, LAYERS, FINE_LAYERS = 10, 4, 6


class Mesh:
    def __init__(self):
        self.vertices, self.cells, self.faces = [], [], []

    def vertex(self, x, y, z):
        self.vertices.append((x, y, z))
        return len(self.vertices)

    def hexahedron(self, ring_below, ring_above):
        self.cells.append(ring_below + ring_above)

    def quad(self, group, *ring):
        self.faces.append((group, ring))

    def write(self, path):
        with open(path, 'w') as out:
            out.write('$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n' % len(self.vertices))
            for number, (x, y, z) in enumerate(self.vertices, 1):
                out.write('%d %.12g %.12g %.12g\n' % (number, x, y, z))  # the same on both sides, where vertices meet
            out.write('$EndNodes\n$Elements\n%d\n' % (len(self.faces) + len(self.cells)))
            elements = [(3, group, ring) for group, ring in self.faces] + [(5, 6, cell) for cell in self.cells]
            for number, (kind, group, ids) in enumerate(elements, 1):
                out.write('%d %d 2 %d %d %s\n' % (number, kind, group, group, ' '.join(map(str, ids))))
            out.write('$EndElements\n')


def around_the_square(i):
    """The place of vertex i, of 4 * FINE, on the square's sides, counterclockwise."""
    side, step = divmod(i, FINE)
    t = step / FINE
    return [(LEFT + t * (RIGHT - LEFT), BELOW), (RIGHT, BELOW + t * (ABOVE - BELOW)),
            (RIGHT - t * (RIGHT - LEFT), ABOVE), (LEFT, ABOVE - t * (ABOVE - BELOW))][side]


def add_rings(mesh):
    around = 4 * FINE
    ids = {}
    for layer in range(FINE_LAYERS + 1):
        for ring in range(RINGS + 1):
            outwards = (1.22 ** ring - 1) / (1.22 ** RINGS - 1)  # thin cells at the cylinder
            for i in range(around):
                x, y = around_the_square(i)
                angle = math.atan2(y - CENTRE[1], x - CENTRE[0])
                u, v = CENTRE[0] + RADIUS * math.cos(angle), CENTRE[1] + RADIUS * math.sin(angle)
                ids[layer, ring, i] = mesh.vertex(u + outwards * (x - u), v + outwards * (y - v),
                                                  layer * DEPTH / FINE_LAYERS)
    for layer in range(FINE_LAYERS):
        for i in range(around):
            j = (i + 1) % around
            for ring in range(RINGS):
                rings = [(ids[z, ring, i], ids[z, ring + 1, i], ids[z, ring + 1, j], ids[z, ring, j])
                         for z in (layer, layer + 1)]
                mesh.hexahedron(*rings)
                if layer == 0:
                    mesh.quad(SIDES, *rings[0])
                if layer == FINE_LAYERS - 1:
                    mesh.quad(SIDES, *rings[1])
            for ring, group in ((0, CYLINDER), (RINGS, JOINED)):
                mesh.quad(group, ids[layer, ring, i], ids[layer, ring, j], ids[layer + 1, ring, j], ids[layer + 1, ring, i])


def add_grid(mesh):
    columns, rows = round(LENGTH / H), round(HEIGHT / H)
    hole = range(round(LEFT / H), round(RIGHT / H)), range(round(BELOW / H), round(ABOVE / H))
    ids = {}

    def is_cell(i, j):
        return 0 <= i < columns and 0 <= j < rows and not (i in hole[0] and j in hole[1])

    def vertex(i, j, k):
        if (i, j, k) not in ids:
            ids[i, j, k] = mesh.vertex(i * H, j * H, k * DEPTH / LAYERS)
        return ids[i, j, k]

    for k in range(LAYERS):
        for j in range(rows):
            for i in range(columns):
                if not is_cell(i, j):
                    continue
                corners = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
                low, high = ([vertex(*corner, z) for corner in corners] for z in (k, k + 1))
                mesh.hexahedron(low, high)
                if k == 0:
                    mesh.quad(SIDES, *low)
                if k == LAYERS - 1:
                    mesh.quad(SIDES, *high)
                for side, (beside_i, beside_j) in enumerate(((i, j - 1), (i + 1, j), (i, j + 1), (i - 1, j))):
                    if is_cell(beside_i, beside_j):
                        continue
                    in_hole = beside_i in hole[0] and beside_j in hole[1]
                    group = JOINED if in_hole else INLET if beside_i < 0 else OUTLET if beside_i == columns else SIDES
                    last = (side + 1) % 4
                    mesh.quad(group, low[side], low[last], high[last], high[side])


mesh = Mesh()
add_rings(mesh)
add_grid(mesh)
mesh.write(sys.argv[1])
