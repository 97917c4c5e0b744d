"""Stokes' equations with a velocity one degree above the pressure (Taylor and Hood).

    R = int 2 mu eps(u) : eps(v) - p div v - q div u - f . v,   f = (sin y, x y, ...)

The system is indefinite and symmetric. Unknowns: those of the velocity, then those of the pressure.
"""
import numpy as np
import scipy.sparse as sp

import meshes
from checks import close, symmetric
from discretisation import Discretisation, random_field

VISCOSITY = 0.7


def viscous(u, v, w):
    strain = (u.grad + np.swapaxes(u.grad, 0, 1)) / 2
    return 2 * VISCOSITY * np.sum(strain * v.grad, axis=(0, 1))


def divergence(field):
    return sum(field.grad[i, i] for i in range(len(field.grad)))


def load(v, w):
    force = [np.sin(w.x[1]), w.x[0] * w.x[1], 1 + 0 * w.x[0]]
    return sum(force[i] * v[i] for i in range(len(w.x)))


def cases():
    for seed, (name, mesh) in enumerate({
        "triangle_p2_p1": meshes.rectangle("triangle", 2, 2, 61),
        "quadrilateral_q2_q1": meshes.rectangle("quadrilateral", 2, 2, 62),
        "tetrahedron_p2_p1": meshes.tetrahedra(63),
    }.items()):
        velocity = Discretisation(mesh, 2, mesh.nodes.shape[1])
        pressure = Discretisation(mesh, 1, 1)
        # Rows q, columns u.
        constraint = velocity.matrix(
            lambda u, q, w: -q * divergence(u), velocity.cells, test=pressure, test_basis=pressure.cells
        )
        gradient = pressure.matrix(
            lambda p, v, w: -p * divergence(v), pressure.cells, test=velocity, test_basis=velocity.cells
        )
        close(gradient, constraint.T)
        system = sp.bmat([[velocity.matrix(viscous, velocity.cells), gradient], [constraint, None]]).tocsr()
        symmetric(system)
        # A linear flow without divergence: every q sees nothing.
        shear = np.zeros(velocity.size)
        shear[0::velocity.components] = 3 * velocity.positions[:, 1]
        assert abs(constraint @ shear).max() < 1e-12
        u, p = random_field(velocity.size, 1.0, 160 + seed), random_field(pressure.size, 1.0, 170 + seed)
        loads = np.concatenate([velocity.vector(load, velocity.cells), np.zeros(pressure.size)])
        yield name, {
            **velocity.description(),
            "second_space": {**pressure.space(), "u": p},
            "data": {"viscosity": VISCOSITY},
            "u": u,
            "matrices": {"tangent": system},
            "vectors": {"residual": system @ np.concatenate([u, p]) - loads},
        }
