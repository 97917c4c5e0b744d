"""Value and gradient of the two inverse problems of docs/inverse_problems.md in scikit-fem, with the adjoint by hand.

usage: inverse_skfem.py heat|structure [--cells N [N ...]] [--case K [K ...]] [--symmetric]
(pip install scikit-fem==12.0.1 numpy scipy)

Assembly by skfem, systems by SuperLU (scipy.sparse.linalg.splu), whose factor serves the adjoint too: as it is called by default (column
ordering COLAMD), or, with --symmetric, with minimum degree on the symmetric pattern and pivots on the diagonal.
"""

import argparse
import resource
import time

import numpy as np
import scipy.sparse.linalg
import skfem
from skfem.helpers import ddot, dot, eye, grad, sym_grad, trace

# Of SuperLU.
SPLU = {}
SYMMETRIC = dict(permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=dict(SymmetricMode=True))
LEAST = 1e-3
STIFFEST, SOFTEST, POISSON, PENALTY = 70_000.0, 70.0, 0.3, 50.0
LAMBDA = POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
MU = 0.5 / (1 + POISSON)


def box(lengths, divisions):
    return skfem.MeshHex.init_tensor(*(np.linspace(0, length, n + 1) for length, n in zip(lengths, divisions)))


def solved(matrix, load, held):
    free = np.setdiff1d(np.arange(matrix.shape[0]), held)
    factor = scipy.sparse.linalg.splu(matrix[free][:, free].tocsc(), **SPLU)
    solution = np.zeros(matrix.shape[0])
    solution[free] = factor.solve(load[free])
    return solution, factor, free


class Heat:
    def __init__(self, cells):
        thickness = 2.0 / cells
        mesh = box([2.0, 1.0, thickness], [cells, cells // 2, 1])
        self.basis = skfem.Basis(mesh, skfem.ElementHex1(), intorder=2)
        self.cells = self.basis.with_element(skfem.ElementHex0())
        right = skfem.FacetBasis(mesh, skfem.ElementHex1(), facets=mesh.facets_satisfying(lambda x: np.isclose(x[0], 2.0)))
        self.load = skfem.LinearForm(lambda v, w: v / thickness).assemble(right)
        self.held = self.basis.get_dofs(lambda x: np.isclose(x[0], 0.0)).all()
        self.start = np.full(mesh.nelements, 0.5)

    def value(self, density, with_gradient):
        conductivity = self.cells.interpolate(LEAST + (1 - LEAST) * density**3)
        matrix = skfem.BilinearForm(lambda u, v, w: w["k"] * dot(grad(u), grad(v))).assemble(self.basis, k=conductivity)
        temperature, factor, free = solved(matrix, self.load, self.held)
        value = self.load @ temperature
        if not with_gradient:
            return value
        adjoint = np.zeros_like(temperature)
        adjoint[free] = factor.solve(-self.load[free], trans="T")
        work = skfem.Functional(lambda w: dot(grad(w["u"]), grad(w["p"])))
        per_cell = work.elemental(self.basis, u=self.basis.interpolate(temperature), p=self.basis.interpolate(adjoint))
        return value, 3 * (1 - LEAST) * density**2 * per_cell


class Structure:
    def __init__(self, divisions):
        mesh = box([2.0, 1.0, 1.0], divisions)
        element = skfem.ElementVector(skfem.ElementHex1())
        self.basis = skfem.Basis(mesh, element, intorder=2)
        self.cells = self.basis.with_element(skfem.ElementHex0())
        right = skfem.FacetBasis(mesh, element, facets=mesh.facets_satisfying(lambda x: np.isclose(x[0], 2.0)))
        self.load = skfem.LinearForm(lambda v, w: -v[2]).assemble(right)
        self.held = self.basis.get_dofs(lambda x: np.isclose(x[0], 0.0)).all()
        self.start = np.full(mesh.nelements, 0.5)

    @staticmethod
    def product(u, v):
        strain = sym_grad(u)
        stress = LAMBDA * eye(trace(strain), 3) + 2 * MU * strain
        return ddot(stress, sym_grad(v))

    def value(self, density, with_gradient):
        young = self.cells.interpolate(SOFTEST + (STIFFEST - SOFTEST) * density**3)
        matrix = skfem.BilinearForm(lambda u, v, w: w["E"] * self.product(u, v)).assemble(self.basis, E=young)
        u, factor, free = solved(matrix, self.load, self.held)
        excess = density.mean() - 0.5
        value = self.load @ u + PENALTY * excess**2
        if not with_gradient:
            return value
        adjoint = np.zeros_like(u)
        adjoint[free] = factor.solve(-self.load[free], trans="T")
        work = skfem.Functional(lambda w: self.product(w["u"], w["p"]))
        per_cell = work.elemental(self.basis, u=self.basis.interpolate(u), p=self.basis.interpolate(adjoint))
        slope = 3 * (STIFFEST - SOFTEST) * density**2 * per_cell
        return value, slope + 2 * PENALTY * excess / len(density)


def repeated(compute):
    """The result, its seconds and its processor seconds: the mean over half a second, after a first time that does not count; or that time
    alone where it is long."""
    begun, begun_processor = time.perf_counter(), time.process_time()
    found = compute()
    if time.perf_counter() - begun > 5:
        return found, time.perf_counter() - begun, time.process_time() - begun_processor
    begun, begun_processor, repetitions = time.perf_counter(), time.process_time(), 0
    while True:
        found = compute()
        repetitions += 1
        elapsed, processor = time.perf_counter() - begun, time.process_time() - begun_processor
        if elapsed > 0.5:
            return found, elapsed / repetitions, processor / repetitions


def report(name, problem):
    start = problem.start
    value, of_value, _ = repeated(lambda: problem.value(start, False))
    (_, gradient), of_both, processor = repeated(lambda: problem.value(start, True))
    direction = 0.1 + np.sin(0.7 * np.arange(len(start)))
    step = 1e-4
    difference = (problem.value(start + step * direction, False) - problem.value(start - step * direction, False)) / (2 * step)
    error = abs(difference / (gradient @ direction) - 1)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    unknowns = problem.basis.N
    print(f"| {name} | {unknowns} | {value:.9f} | {of_value:.4f} | {of_both:.4f} | {processor:.4f} | {error:.0e} | {memory:.0f} |", flush=True)


parser = argparse.ArgumentParser()
parser.add_argument("problem", choices=["heat", "structure"])
parser.add_argument("--cells", type=int, nargs="+", default=[16, 32, 64, 128])
parser.add_argument("--case", type=int, nargs="+", default=[0, 1, 2])
parser.add_argument("--symmetric", action="store_true")
options = parser.parse_args()
if options.symmetric:
    SPLU.update(SYMMETRIC)
print("| cells | unknowns | value | seconds of a value | of value and gradient | processor seconds of both | error at 1e-4 | peak memory [MB] |")
print("| --- | --: | --: | --: | --: | --: | --: | --: |")
if options.problem == "heat":
    for cells in options.cells:
        report(f"{cells} × {cells // 2}", Heat(cells))
else:
    for case in options.case:
        divisions = [[16, 2, 8], [16, 8, 8], [32, 8, 8]][case]
        report(" × ".join(map(str, divisions)), Structure(divisions))
