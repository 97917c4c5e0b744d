"""Writes what the element kernels of FFCx take from basix: node order, vertices of facets, quadrature rules.

usage: write_basix.py FILE.json      (run with the Python of FFCx's virtual environment)
"""

import json
import sys

import basix

HIGHEST_DEGREE = 12
SHAPES = ["triangle", "quadrilateral", "tetrahedron", "hexahedron"]


def half_steps(element):
    """Nodes of an element of degree 1 or 2 in units of one half."""
    return [[round(2 * coordinate) for coordinate in point] for point in element.points.tolist()]


def element(shape, degree, tensor_product):
    create = basix.create_tp_element if tensor_product else basix.create_element
    cell = getattr(basix.CellType, shape)
    return create(basix.ElementFamily.P, cell, degree, basix.LagrangeVariant.gll_warped)


def rule(shape, degree):
    points, weights = basix.make_quadrature(getattr(basix.CellType, shape), degree)
    return {"points": points.tolist(), "weights": weights.tolist()}


result = {"version": basix.__version__, "shapes": {}, "rules": {}}
for shape in SHAPES:
    tensor = shape in ("quadrilateral", "hexahedron")
    result["shapes"][shape] = {
        "facets": basix.topology(getattr(basix.CellType, shape))[-2],
        "nodes": {str(degree): half_steps(element(shape, degree, False)) for degree in (1, 2)},
        "tensor_product_nodes": {str(degree): half_steps(element(shape, degree, True)) for degree in (1, 2)} if tensor else {},
    }
for shape in ["interval"] + SHAPES:
    highest = 5 if shape in ("quadrilateral", "hexahedron") else HIGHEST_DEGREE
    result["rules"][shape] = [rule(shape, degree) for degree in range(highest + 1)]
with open(sys.argv[1], "w") as file:
    json.dump(result, file)
    file.write("\n")
