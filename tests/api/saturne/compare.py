"""Holds a probe at the centres of all cells to what the solver wrote of its cells itself.

    compare.py CYCLE CENTRES TABLE VALUES...   CENTRES are those of cells 1, 2, ..., VALUES the files of all processes
"""
import csv
import sys

cycle, centres, table, files = sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4:]
values = {}
for name in files:
    with open(name) as lines:
        for line in lines:
            number, *of_cell = line.split()
            values[int(number)] = [float(value) for value in of_cell]
with open(centres) as lines:
    count = sum(1 for _ in lines) - 1
with open(table) as lines:
    rows = [row for row in csv.reader(lines) if row[0] == cycle]
assert count > 5000 and len(rows) == count == len(values), (count, len(rows), len(values))
for cell, row in enumerate(rows, 1):
    found = [float(value) for value in row[7:]]
    assert int(row[3]) == cell and found == values[cell], 'cell %d of the solver, %s; the probe has %s' % (cell, values[cell], row)
