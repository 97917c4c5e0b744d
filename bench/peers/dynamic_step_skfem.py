"""A linear step in time by matrices written by hand: M ü + K u = 0 on a square of plane strain, by the trapezoidal rule.

usage: dynamic_step_skfem.py CELLS STEPS      (pip install scikit-fem==12.0.1 numpy scipy)

It prints a line of JSON: unknowns, seconds of assembly and of the factor, seconds of a step, and the energy at both ends. The matrix
M + Δt²/4 K is factored once by SuperLU, with minimum degree on its symmetric pattern and pivots on the diagonal, which is its quickest way here.
"""

import json
import sys
import time

import numpy as np
import scipy.sparse.linalg
import skfem
from skfem.helpers import ddot, dot, eye, sym_grad, trace

LAMBDA, MU, DENSITY, SIZE = 1.0, 0.5, 1.0, 0.01
cells, steps = (int(argument) for argument in sys.argv[1:])
begun = time.perf_counter()
line = np.linspace(0, 1, cells + 1)
basis = skfem.Basis(skfem.MeshQuad.init_tensor(line, line), skfem.ElementVector(skfem.ElementQuad1()), intorder=2)


@skfem.BilinearForm
def stiffness(u, v, w):
    strain = sym_grad(u)
    return ddot(LAMBDA * eye(trace(strain), 2) + 2 * MU * strain, sym_grad(v))


@skfem.BilinearForm
def inertia(u, v, w):
    return DENSITY * dot(u, v)


stiff, mass = stiffness.assemble(basis), inertia.assemble(basis)
free = np.setdiff1d(np.arange(basis.N), basis.get_dofs(lambda x: np.isclose(x[0], 0.0)).all())
assembly = time.perf_counter() - begun
u = np.zeros(basis.N)
velocity = np.zeros(basis.N)
x = basis.doflocs
# The component y of the velocity, x² at the start.
of_y = basis.nodal_dofs[1]
velocity[of_y] = x[0, of_y] ** 2


def energy():
    return (velocity @ (mass @ velocity) + u @ (stiff @ u)) / 2


first = energy()
begun = time.perf_counter()
system = (mass + SIZE**2 / 4 * stiff)[free][:, free].tocsc()
options = dict(permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=dict(SymmetricMode=True))
factor = scipy.sparse.linalg.splu(system, **options)
factoring = time.perf_counter() - begun
acceleration = np.zeros(basis.N)
of_mass = scipy.sparse.linalg.splu(mass[free][:, free].tocsc(), **options)
acceleration[free] = of_mass.solve(-(stiff @ u)[free])
begun = time.perf_counter()
for _ in range(steps):
    predicted = u + SIZE * velocity + SIZE**2 / 4 * acceleration
    next_acceleration = np.zeros(basis.N)
    next_acceleration[free] = factor.solve(-(stiff @ predicted)[free])
    u = predicted + SIZE**2 / 4 * next_acceleration
    velocity = velocity + SIZE / 2 * (acceleration + next_acceleration)
    acceleration = next_acceleration
of_step = (time.perf_counter() - begun) / steps
print(
    json.dumps(
        {
            "unknowns": int(basis.N),
            "assembly": assembly,
            "factor": factoring,
            "step": of_step,
            "first": first,
            "last": energy(),
            "largest": float(np.abs(u).max()),
        }
    )
)
