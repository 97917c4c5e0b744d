"""The p-Laplacian, regularised by s.

    E = int (s^2 + |grad u|^2)^(p/2) / p - f u,   f = 1 + x y
    R = int (s^2 + |grad u|^2)^(p/2 - 1) grad u . grad v - f v
"""
import numpy as np

import meshes
from checks import check_tangent, symmetric
from discretisation import Discretisation, random_field


class PLaplacian:
    """The form on one space, with p and s."""

    def __init__(self, space, exponent, regularisation):
        self.space, self.p, self.s = space, exponent, regularisation
        self.source = space.vector(lambda v, w: (1 + w.x[0] * w.x[1]) * v, space.cells)

    def gradient(self, u):
        grad = np.array(self.space.interpolate(self.space.cells, u).grad)
        return grad, self.s**2 + np.sum(grad**2, axis=0)

    def energy(self, u):
        _, size = self.gradient(u)
        return np.sum(size ** (self.p / 2) / self.p * self.space.cells.dx) - self.source @ u

    def residual(self, u):
        grad, size = self.gradient(u)
        flux = size ** (self.p / 2 - 1) * grad
        return self.space.vector(lambda v, w: np.sum(flux * v.grad, axis=0), self.space.cells) - self.source

    def tangent(self, u):
        grad, size = self.gradient(u)

        def form(d, v, w):
            along = np.sum(grad * d.grad, axis=0)
            change = size ** (self.p / 2 - 1) * d.grad
            change = change + (self.p - 2) * size ** (self.p / 2 - 2) * along * grad
            return np.sum(change * v.grad, axis=0)

        return self.space.matrix(form, self.space.cells)


def cases():
    for seed, (name, mesh, degree, exponent, regularisation) in enumerate([
        ("triangle_p2", meshes.rectangle("triangle", 3, 2, 81), 2, 3.0, 0.0),
        ("quadrilateral_q2", meshes.rectangle("quadrilateral", 2, 2, 82), 2, 1.5, 0.3),
        ("tetrahedron_p2", meshes.tetrahedra(83), 2, 4.0, 0.1),
    ]):
        space = Discretisation(mesh, degree, 1)
        form = PLaplacian(space, exponent, regularisation)
        u = random_field(space.size, 1.0, 190 + seed)
        tangent = form.tangent(u)
        symmetric(tangent)
        check_tangent(form.residual, tangent, u, 1e-6, 1e-6)
        check_tangent(lambda state: np.atleast_1d(form.energy(state)), form.residual(u)[None], u, 1e-6, 1e-6)
        yield name, {
            **space.description(),
            "data": {"exponent": exponent, "regularisation": regularisation},
            "u": u,
            "matrices": {"tangent": tangent},
            "vectors": {"residual": form.residual(u)},
            "numbers": {"energy": float(form.energy(u))},
        }
