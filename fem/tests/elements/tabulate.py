"""Writes basix.txt: basix's equispaced Lagrange elements at one point, a line per node.

    python tabulate.py > basix.txt

Each line: shape, degree, coordinates of the node, value and gradient of its basis function at the point.
"""
import basix
import numpy as np

POINT = [0.17, 0.23, 0.31]
SHAPES = {
    "triangle": basix.CellType.triangle,
    "quadrilateral": basix.CellType.quadrilateral,
    "tetrahedron": basix.CellType.tetrahedron,
    "hexahedron": basix.CellType.hexahedron,
}

for name, cell in SHAPES.items():
    dimension = len(basix.topology(cell)) - 1
    for degree in range(1, 5):
        element = basix.create_element(
            basix.ElementFamily.P, cell, degree, basix.LagrangeVariant.equispaced
        )
        table = element.tabulate(1, np.array([POINT[:dimension]]))[:, 0, :, 0]
        for node, point in enumerate(element.points):
            numbers = [*point, *table[:, node]]
            print(name, degree, *(f"{number:.15e}" for number in numbers))
