"""A rigid parabola at places over one cell of a layer, in NGSolve: Nitsche's method and penalty on squares."""

import time

import ngsolve as ng
import numpy as np
from netgen.meshing import Element1D, Element2D, FaceDescriptor, Mesh, MeshPoint, Pnt

from newton import negative_part, newton
from rows import row

YOUNG, POISSON, WAY, PLACES = 1.0, 0.3, 0.02, 10
LAMBDA, MU = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), YOUNG / (2 * (1 + POISSON))


def layer(per_unit):
    """[−4, 4] × [0, 1] of squares; the boundaries are the base and the top within |x| < 1."""
    nx, ny = 8 * per_unit, per_unit
    mesh = Mesh(dim=2)
    points = [[mesh.Add(MeshPoint(Pnt(-4 + i / per_unit, j / per_unit, 0))) for i in range(nx + 1)] for j in range(ny + 1)]
    for number in (1, 2, 3):
        mesh.Add(FaceDescriptor(surfnr=number, domin=1, bc=number))
    for j in range(ny):
        for i in range(nx):
            mesh.Add(Element2D(1, [points[j][i], points[j][i + 1], points[j + 1][i + 1], points[j + 1][i]]))
    for i in range(nx):
        mesh.Add(Element1D([points[0][i], points[0][i + 1]], index=1))
        mesh.Add(Element1D([points[ny][i + 1], points[ny][i]], index=2 if abs(-4 + (i + 0.5) / per_unit) < 1 else 3))
    for j in range(ny):
        mesh.Add(Element1D([points[j][nx], points[j + 1][nx]], index=3))
        mesh.Add(Element1D([points[j + 1][0], points[j][0]], index=3))
    for number, name in enumerate(["base", "contact", "free"]):
        mesh.SetBCName(number, name)
    return ng.Mesh(mesh)


def forces(per_unit, order, theta, gamma0):
    """Unknowns, the forces at all places and Newton steps; penalty where there is no θ."""
    mesh = layer(per_unit)
    space = ng.VectorH1(mesh, order=order, dirichlet="base")
    u, v = space.TnT()
    shift = ng.Parameter(0)
    # The diameter of a square.
    gamma = gamma0 * YOUNG * per_unit / 2**0.5

    def stress(w):
        strain = ng.Sym(ng.Grad(w))
        return LAMBDA * ng.Trace(strain) * ng.Id(2) + 2 * MU * strain

    gap = 0.5 * (ng.x - shift) ** 2 - u[1]
    form = ng.BilinearForm(space)
    form += ng.InnerProduct(stress(u), ng.Sym(ng.Grad(v))) * ng.dx
    if theta is None:
        form += negative_part(gamma * gap) * v[1] * ng.ds("contact", bonus_intorder=2)
    else:
        normal = stress(u)[1, 1]
        pressure = negative_part(normal + gamma * gap)
        form += (pressure * v[1] - theta / gamma * (normal + pressure) * stress(v)[1, 1]) * ng.ds("contact", skeleton=True, bonus_intorder=2)
    base = ng.GridFunction(space)
    base.Set(ng.CF((0, 1)), definedon=mesh.Boundaries("base"))
    found, counts = [], []
    for place in range(PLACES + 1):
        shift.Set(place / (PLACES * per_unit))
        state = ng.GridFunction(space)
        state.vec.data = WAY * base.vec
        counts.append(newton(form, state, space.FreeDofs()))
        found.append(ng.InnerProduct(form.Apply(state.vec), base.vec))
    return space.ndof, np.array(found), counts


FORMULATIONS = {"Nitsche θ = -1": (-1, 13), "Nitsche θ = 0": (0, 13), "Nitsche θ = 1": (1, 13), "penalty 100 E/h": (None, 100)}
for name, (theta, gamma0) in FORMULATIONS.items():
    for order in (1, 2):
        for level in range(2):
            start = time.perf_counter()
            unknowns, found, counts = forces(4 << level, order, theta, gamma0)
            numbers = {"mean force": found.mean(), "(max − min)/mean": np.ptp(found) / found.mean()}
            row("sliding_parabola", f"NGSolve, {name}", order, level, unknowns, time.perf_counter() - start, numbers, newton=counts)
