"""A compressible neo-Hookean solid in plane strain, written by hand.

psi(F) = mu/2 (tr(F^T F) - 2) - mu ln J + lambda/2 (ln J)^2, F = I + grad u,
J = det F. First Piola-Kirchhoff stress P = mu F + (lambda ln J - mu) F^{-T}.
"""
import numpy as np


def deformation(space, u):
    """F, its inverse and ln J at the quadrature points."""
    grad = space.interpolate(space.cells, u).grad
    f = np.array(grad) + np.eye(2)[:, :, None, None]
    j = f[0, 0] * f[1, 1] - f[0, 1] * f[1, 0]
    inverse = np.array([[f[1, 1], -f[0, 1]], [-f[1, 0], f[0, 0]]]) / j
    return f, inverse, np.log(j)


def energy(space, u, lame, shear):
    f, _, log_j = deformation(space, u)
    density = shear / 2 * (np.sum(f**2, axis=(0, 1)) - 2) - shear * log_j + lame / 2 * log_j**2
    return float(np.sum(density * space.cells.dx))


def residual(space, u, lame, shear):
    f, inverse, log_j = deformation(space, u)
    stress = shear * f + (lame * log_j - shear) * np.swapaxes(inverse, 0, 1)
    return space.vector(lambda v, w: np.sum(stress * v.grad, axis=(0, 1)), space.cells)


def tangent(space, u, lame, shear):
    """dP = mu H + lambda (F^{-T}:H) F^{-T} - (lambda ln J - mu) F^{-T} H^T F^{-T}, H = grad d."""
    _, inverse, log_j = deformation(space, u)
    transposed = np.swapaxes(inverse, 0, 1)

    def form(d, v, w):
        h = np.array(d.grad)
        change = shear * h + lame * np.sum(transposed * h, axis=(0, 1)) * transposed
        change = change - (lame * log_j - shear) * np.einsum("ji...,kj...,lk...->il...", inverse, h, inverse)
        return np.sum(change * v.grad, axis=(0, 1))

    return space.matrix(form, space.cells)
