"""Linear elasticity with a full tensor of elastic constants C_ijkl.

    R = int (C : eps(u)) : eps(v)

C is orthotropic in axes that are turned against the coordinates, so that no component vanishes.
"""
import numpy as np

import meshes
from checks import symmetric
from discretisation import Discretisation, random_field

# C in the material's axes: normal stiffnesses, couplings (12, 13, 23) and shear moduli (12, 13, 23).
NORMAL, COUPLING, SHEAR = [120.0, 70.0, 95.0], [31.0, 24.0, 17.0], [26.0, 19.0, 33.0]


def constants(dimension):
    """C_ijkl, with the minor and major symmetries."""
    c = np.zeros((dimension,) * 4)
    for i in range(dimension):
        c[i, i, i, i] = NORMAL[i]
        for j in range(i):
            coupling, shear = COUPLING[i + j - 1], SHEAR[i + j - 1]
            c[i, i, j, j] = c[j, j, i, i] = coupling
            c[i, j, i, j] = c[i, j, j, i] = c[j, i, i, j] = c[j, i, j, i] = shear
    q = np.eye(dimension)
    for k, angle in enumerate([0.4, 0.7][: dimension - 1]):
        turn = np.eye(dimension)
        turn[k:k + 2, k:k + 2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        q = turn @ q
    c = np.round(np.einsum("ai,bj,ck,dl,ijkl->abcd", q, q, q, q, c), 6)
    for other in ("jikl", "ijlk", "klij"):
        assert np.array_equal(c, np.einsum(f"ijkl->{other}", c))
    assert (np.linalg.eigvalsh(c.reshape(dimension**2, -1)) > -1e-6).all()
    return c


def cases():
    for seed, (name, mesh, degree) in enumerate([
        ("triangle_p2", meshes.rectangle("triangle", 2, 2, 71), 2),
        ("quadrilateral_q1", meshes.rectangle("quadrilateral", 3, 2, 72), 1),
        ("tetrahedron_p1", meshes.tetrahedra(73), 1),
    ]):
        space = Discretisation(mesh, degree, mesh.nodes.shape[1])
        c = constants(space.components)
        form = lambda u, v, w: np.einsum("ijkl,kl...,ij...->...", c, u.grad, v.grad)
        stiffness = space.matrix(form, space.cells)
        symmetric(stiffness)
        u = random_field(space.size, 0.1, 180 + seed)
        yield name, {
            **space.description(),
            "data": {"constants": c},
            "u": u,
            "matrices": {"tangent": stiffness},
            "vectors": {"residual": stiffness @ u},
        }
