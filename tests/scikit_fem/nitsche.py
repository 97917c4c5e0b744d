"""Linear elasticity with Nitsche's contact conditions, written by hand.

Equation numbers are those of Bretin, Chapelat, Douanla-Lontsi, Homolle and
Renard (2023), hal-03936245; (15) is taken with the minus sign before the
negative part; (21) and (22) are its linearisations:

    R(u; v) = a(u, v) - int theta/gamma s(u) s(v)
              - int 1/gamma [s(u) - gamma (u_n - g)]_- (theta s(v) - gamma v_n) - l(v)

with s(u) = (sigma(u) n) . n_y, u_n = u . n_y, gamma = gamma0 / h_T and
beta = gamma (u_n - g) - s(u), contact where beta > 0.
"""
from dataclasses import dataclass

import numpy as np


def stress(grad, lame, shear):
    """sigma = lambda div(u) I + mu (grad u + grad u^T)."""
    dimension = grad.shape[0]
    trace = sum(grad[i, i] for i in range(dimension))
    sigma = shear * (grad + np.swapaxes(grad, 0, 1))
    for i in range(dimension):
        sigma[i, i] = sigma[i, i] + lame * trace
    return sigma


def elasticity(u, v, w):
    return np.sum(stress(u.grad, w.lame, w.shear) * v.grad, axis=(0, 1))


@dataclass
class Contact:
    """The contact terms on one facet basis, at one state `u`."""

    space: object                    # a Discretisation
    basis: object                    # its facet basis on the contact boundary
    cell_diameters: np.ndarray       # per cell
    lame: float
    shear: float
    gamma0: float
    theta: float
    obstacle_point: np.ndarray
    obstacle_normal: np.ndarray

    def __post_init__(self):
        cells = self.space.mesh.skfem.f2t[0, self.basis.find]
        ones = np.ones(self.basis.dx.shape)
        self.diameter = self.cell_diameters[cells][:, None] * ones
        self.gamma = self.gamma0 / self.diameter
        position = self.basis.global_coordinates()
        ny, y = self.obstacle_normal, self.obstacle_point
        self.gap = sum(ny[i] * (y[i] - position[i]) for i in range(2))

    def sigma_n(self, field):
        """(sigma n) . n_y at the quadrature points."""
        sigma = stress(field.grad, self.lame, self.shear)
        return np.einsum("i,ij...,j...->...", self.obstacle_normal, sigma, self.basis.normals)

    def normal(self, field):
        return np.einsum("i,i...->...", self.obstacle_normal, field)

    def at(self, u):
        """beta, s(u) and u_n of the state at the quadrature points."""
        field = self.space.interpolate(self.basis, u)
        sigma_n, u_n = self.sigma_n(field), self.normal(field)
        return self.gamma * (u_n - self.gap) - sigma_n, sigma_n, u_n

    def residual(self, u):
        """(14) without a(u, v) and l(v)."""
        beta, sigma_n, _ = self.at(u)
        pressure = np.maximum(beta, 0.0)             # [s - gamma (u_n - g)]_-

        def form(v, w):
            s, n = self.sigma_n(v), self.normal(v)
            return (-self.theta * sigma_n * s - pressure * (self.theta * s - self.gamma * n)) / self.gamma

        return self.space.vector(form, self.basis)

    def tangent(self, u):
        """The derivative of `residual`, at rows v and columns of the increment."""
        active = (self.at(u)[0] > 0).astype(float)

        def form(d, v, w):
            s, n = self.sigma_n(v), self.normal(v)
            increment = self.gamma * self.normal(d) - self.sigma_n(d)   # beta'(u) d
            term = -self.theta * self.sigma_n(d) * s
            return (term - active * increment * (self.theta * s - self.gamma * n)) / self.gamma

        return self.space.matrix(form, self.basis)

    def discrete_adjoint(self, u):
        """The contact terms of (21), rows q, columns p."""
        active = (self.at(u)[0] > 0).astype(float)

        def form(p, q, w):
            first = self.sigma_n(q) - self.gamma * self.normal(q)
            second = self.theta * self.sigma_n(p) - self.gamma * self.normal(p)
            return (active * first * second - self.theta * self.sigma_n(p) * self.sigma_n(q)) / self.gamma

        return self.space.matrix(form, self.basis)

    def consistent_adjoint(self, u, shift=0.0):
        """The contact terms of (22), or of (41) with a shift xi of beta: rows q, columns p."""
        active = (self.at(u)[0] > shift).astype(float)

        def form(p, q, w):
            first = self.sigma_n(p) - self.gamma * self.normal(p)
            second = self.theta * self.sigma_n(q) - self.gamma * self.normal(q)
            return (active * first * second - self.theta * self.sigma_n(p) * self.sigma_n(q)) / self.gamma

        return self.space.matrix(form, self.basis)

    def consistent_right_hand_side(self, u, derivative, shift=0.0):
        """What N' adds on the contact boundary to the right side of (22) or (41).

        `derivative` is N' = derivative * u, hence N'_n = derivative * u_n.
        """
        beta, _, u_n = self.at(u)
        active, n_prime = (beta > shift).astype(float), derivative * u_n

        def form(q, w):
            s, n = self.sigma_n(q), self.normal(q)
            return (self.theta * n_prime * s - active * n_prime * (self.theta * s - self.gamma * n)) / self.gamma

        return self.space.vector(form, self.basis)

    def force(self, u):
        """The integral of [s(u) - gamma (u_n - g)]_-."""
        return float(np.sum(np.maximum(self.at(u)[0], 0.0) * self.basis.dx))

    def length(self, u, shift=0.0):
        """The integral of H(beta - shift)."""
        return float(np.sum((self.at(u)[0] > shift) * self.basis.dx))
