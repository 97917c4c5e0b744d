"""A compressible Mooney-Rivlin solid, in plane strain or in space.

    psi = c1 (J^(-2/3) I1 - 3) + c2 (J^(-4/3) I2 - 3) + kappa/2 (J - 1)^2

I1 = tr C + s and I2 = (I1^2 - C:C - s)/2 with C = F^T F, F = I + grad u, J = det F, and s = 1 in
plane strain (the stretch across the plane), 0 in space. With G = F^{-T}:

    dJ = J G:H,  dI1 = 2 F:H,  dI2 = 2 (I1 F - F C):H,  dG = -G H^T G  for a change H of F.
"""
import numpy as np

import meshes
from checks import check_tangent, symmetric
from discretisation import Discretisation, random_field

C1, C2, KAPPA = 1.1, 0.6, 4.0
A, B = -2 / 3, -4 / 3


def multiply(*factors):
    """Matrix product at every quadrature point."""
    product = factors[0]
    for factor in factors[1:]:
        product = np.einsum("ij...,jk...->ik...", product, factor)
    return product


def double(a, b):
    """a:b at every quadrature point."""
    return np.sum(a * b, axis=(0, 1))


class MooneyRivlin:
    """The form at a state u."""

    def __init__(self, space, u):
        self.space = space
        grad = np.array(space.interpolate(space.cells, u).grad)
        self.F = grad + np.eye(len(grad))[:, :, None, None]
        points = np.moveaxis(self.F, (0, 1), (-2, -1))
        self.J = np.linalg.det(points)
        self.G = np.moveaxis(np.linalg.inv(points), (-1, -2), (0, 1))
        self.C = multiply(self.transpose(self.F), self.F)
        across = 1.0 if len(grad) == 2 else 0.0
        self.I1 = sum(self.C[i, i] for i in range(len(grad))) + across
        self.I2 = (self.I1**2 - double(self.C, self.C) - across) / 2

    @staticmethod
    def transpose(a):
        return np.swapaxes(a, 0, 1)

    def energy(self):
        density = C1 * (self.J**A * self.I1 - 3) + C2 * (self.J**B * self.I2 - 3) + KAPPA / 2 * (self.J - 1)**2
        return float(np.sum(density * self.space.cells.dx))

    def residual(self):
        F, G, J = self.F, self.G, self.J
        stress = C1 * J**A * (2 * F + A * self.I1 * G) + KAPPA * (J - 1) * J * G
        stress = stress + C2 * J**B * (2 * self.I1 * F - 2 * multiply(F, self.C) + B * self.I2 * G)
        return self.space.vector(lambda v, w: double(stress, v.grad), self.space.cells)

    def tangent(self):
        F, G, J, C, I1, I2 = self.F, self.G, self.J, self.C, self.I1, self.I2
        second = 2 * I1 * F - 2 * multiply(F, C)       # dI2/dF

        def form(d, v, w):
            H = np.array(d.grad)
            g, i1, i2 = double(G, H), 2 * double(F, H), double(second, H)
            dG = -multiply(G, self.transpose(H), G)
            dC = multiply(self.transpose(H), F) + multiply(self.transpose(F), H)
            first_change = A * g * (2 * F + A * I1 * G) + 2 * H + A * (i1 * G + I1 * dG)
            second_change = (
                B * g * (second + B * I2 * G) + 2 * i1 * F + 2 * I1 * H
                - 2 * multiply(H, C) - 2 * multiply(F, dC) + B * (i2 * G + I2 * dG)
            )
            volume_change = (2 * J - 1) * J * g * G + (J - 1) * J * dG
            change = C1 * J**A * first_change + C2 * J**B * second_change + KAPPA * volume_change
            return double(change, v.grad)

        return self.space.matrix(form, self.space.cells)


def cases():
    for seed, (name, mesh, degree, scale) in enumerate([
        ("triangle_p2", meshes.rectangle("triangle", 2, 2, 91), 2, 0.02),
        ("annulus_q2", meshes.annulus(1, 4, 0.0, np.pi), 2, 0.4),
        ("tetrahedron_p2", meshes.tetrahedra(93), 2, 0.03),
    ]):
        space = Discretisation(mesh, degree, mesh.nodes.shape[1])
        u = random_field(space.size, scale, 200 + seed)
        solid = MooneyRivlin(space, u)
        assert solid.J.min() > 0.3
        tangent = solid.tangent()
        symmetric(tangent)
        check_tangent(lambda state: MooneyRivlin(space, state).residual(), tangent, u, 1e-6 * scale / 0.02, 1e-6)
        energy = lambda state: np.atleast_1d(MooneyRivlin(space, state).energy())
        check_tangent(energy, solid.residual()[None], u, 1e-5 * scale / 0.02, 1e-6)
        yield name, {
            **space.description(),
            "data": {"c1": C1, "c2": C2, "kappa": KAPPA},
            "u": u,
            "matrices": {"tangent": tangent},
            "vectors": {"residual": solid.residual()},
            "numbers": {"energy": solid.energy()},
        }
