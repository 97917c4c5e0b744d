"""Poisson's equation by the symmetric interior penalty method, boundary values by Nitsche's.

    R = int grad u . grad v - f v
        + int_interior  - {grad u}.n [v] - {grad v}.n [u] + (sigma / {h}) [u] [v]
        + int_boundary  - du/dn v - dv/dn (u - g) + (sigma / h) (u - g) v

[v] = v_1 - v_2 and {v} = (v_1 + v_2)/2 with n from side 1 to side 2; h is the largest distance between two vertices of the
cell. f = exp(x) y, g = x + 2 y^2.
"""
import numpy as np

import meshes
from checks import close, symmetric
from discretisation import Discretisation, random_field

PENALTY = 60.0


def along_normal(field, w):
    return np.sum(np.array(field.grad) * w.n, axis=0)


def volume(u, v, w):
    return np.sum(np.array(u.grad) * v.grad, axis=0)


def interior(su, u, sv, v, w):
    """A side's part: u / 2 in {u}, su u in [u]; w.n is the normal of side 1 on both sides."""
    penalty = PENALTY / w.h_average * su * u * sv * v
    return penalty - along_normal(u, w) / 2 * sv * v - along_normal(v, w) / 2 * su * u


def boundary(u, v, w):
    return PENALTY / w.h_cell * u * v - along_normal(u, w) * v - along_normal(v, w) * u


def boundary_load(v, w):
    g = w.x[0] + 2 * w.x[1]**2
    return PENALTY / w.h_cell * g * v - along_normal(v, w) * g


def source(v, w):
    return np.exp(w.x[0]) * w.x[1] * v


def cases():
    for seed, (name, mesh, degree) in enumerate([
        ("triangle_p1", meshes.rectangle("triangle", 3, 2, 101), 1),
        ("triangle_p2", meshes.rectangle("triangle", 2, 2, 102), 2),
        ("quadrilateral_q1", meshes.rectangle("quadrilateral", 3, 2, 103), 1),
        ("tetrahedron_p1", meshes.tetrahedra(104), 1),
    ]):
        space = Discretisation(mesh, degree, 1, discontinuous=True)
        h = mesh.diameters()
        sides, outside = space.sides(), space.boundary()
        close(*(np.array(side.global_coordinates()) for side in sides))
        neighbours = mesh.skfem.f2t[:, sides[0].find]
        average = h[neighbours].mean(axis=0)[:, None] * np.ones(sides[0].dx.shape)
        own = h[mesh.skfem.f2t[0, outside.find]][:, None] * np.ones(outside.dx.shape)
        matrix = space.matrix(volume, space.cells) + space.matrix(boundary, outside, h_cell=own)
        matrix = (matrix + space.interior_matrix(interior, h_average=average)).tocsr()
        symmetric(matrix)
        assert np.linalg.eigvalsh(matrix.toarray()).min() > 0
        load = space.vector(source, space.cells) + space.vector(boundary_load, outside, h_cell=own)
        u = random_field(space.size, 1.0, 210 + seed)
        yield name, {
            **space.description(with_facets=True),
            "data": {"penalty": PENALTY},
            "u": u,
            "matrices": {"tangent": matrix},
            "vectors": {"residual": matrix @ u - load},
        }
