"""A linear step in time by matrices written by hand: M ü + K u = 0 on a square of plane strain, by the trapezoidal rule.

usage: dynamic_step_skfem.py CELLS      (pip install scikit-fem==12.0.1 numpy scipy)

It prints lines of JSON: first unknowns, seconds of assembly and of the factor, and the energy at the start; then for each line of its
input, a number of steps, seconds of a step and of its parts, and the energy afterwards. The matrix M + Δt²/4 K is factored once by
SuperLU, with minimum degree on its symmetric pattern and pivots on the diagonal, which is its quickest way here.
"""

import json
import sys
import time

import numpy as np
import scipy.sparse.linalg
import skfem
from skfem.helpers import ddot, dot, eye, sym_grad, trace

LAMBDA, MU, DENSITY, SIZE = 1.0, 0.5, 1.0, 0.01
cells = int(sys.argv[1])
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
del of_mass


def say(numbers):
    print(json.dumps(numbers), flush=True)


say({"unknowns": int(basis.N), "assembly": assembly, "factor": factoring, "first": first, "factor_entries": int(factor.nnz)})
for line in sys.stdin:
    steps = int(line)
    in_product = in_solve = 0.0
    begun = time.perf_counter()
    for _ in range(steps):
        predicted = u + SIZE * velocity + SIZE**2 / 4 * acceleration
        begun_product = time.perf_counter()
        load = -(stiff @ predicted)[free]
        begun_solve = time.perf_counter()
        solution = factor.solve(load)
        solved = time.perf_counter()
        in_product += begun_solve - begun_product
        in_solve += solved - begun_solve
        next_acceleration = np.zeros(basis.N)
        next_acceleration[free] = solution
        u = predicted + SIZE**2 / 4 * next_acceleration
        velocity = velocity + SIZE / 2 * (acceleration + next_acceleration)
        acceleration = next_acceleration
    of_step = (time.perf_counter() - begun) / steps
    say({"step": of_step, "product": in_product / steps, "solve": in_solve / steps, "last": energy()})
