"""A membrane over an obstacle in NGSolve: proximal Galerkin, u of degree p + 1 and ψ of degree p − 1 cell by cell, α doubled, and an active set
at nodes of linear triangles."""

import time
from math import inf

import ngsolve as ng
import numpy as np
from netgen.geom2d import SplineGeometry

from rows import row

REACH, SLOPE, KINK = 0.348982574111686, -0.340129705945858, 0.45
x, y = ng.x, ng.y
r = ng.sqrt(x * x + y * y)
top = (0.25 - KINK**2) ** 0.5
obstacle = ng.IfPos(KINK - r, ng.sqrt(ng.IfPos(KINK - r, 0.25 - r * r, 1)), top - KINK / top * (r - KINK))
inside = REACH - r
exact = ng.IfPos(inside, ng.sqrt(ng.IfPos(inside, 0.25 - r * r, 1)), SLOPE * ng.log(r + 1e-300))
part = ng.IfPos(inside, -1 / ng.sqrt(ng.IfPos(inside, 0.25 - r * r, 1)), SLOPE / (r * r + 1e-300))
slope = ng.CF((part * x, part * y))


def disc(size, order):
    geometry = SplineGeometry()
    geometry.AddCircle((0, 0), 1, bc="circle")
    mesh = ng.Mesh(geometry.GenerateMesh(maxh=size))
    mesh.Curve(order)
    return mesh


def numbers(mesh, u, force):
    off = ng.Integrate((u - exact) ** 2, mesh, order=12)
    steep = ng.Integrate(ng.InnerProduct(ng.grad(u) - slope, ng.grad(u) - slope), mesh, order=12)
    energy = ng.Integrate(ng.InnerProduct(ng.grad(u), ng.grad(u)) / 2, mesh, order=12)
    # Points of a rule of high degree.
    rule = ng.IntegrationRule(ng.TRIG, 16)
    heights = (u - obstacle)(mesh.MapToAllElements(rule, ng.VOL))
    return {"H1 error": (off + steep) ** 0.5, "L2 error": off**0.5, "energy": energy, "force": force, "min(u − φ)": np.min(heights)}


def proximal(mesh, order):
    space = ng.H1(mesh, order=order, dirichlet="circle") * ng.L2(mesh, order=order - 2)
    (u, psi), (v, w) = space.TnT()
    state, before = ng.GridFunction(space), ng.GridFunction(space)
    alpha = ng.Parameter(1)
    form = ng.BilinearForm(space)
    form += (alpha * ng.grad(u) * ng.grad(v) + (psi - before.components[1]) * v) * ng.dx(bonus_intorder=4)
    form += (u - obstacle - ng.exp(psi)) * w * ng.dx(bonus_intorder=6)
    residual, counts = state.vec.CreateVector(), []
    while True:
        before.vec.data = state.vec
        for iteration in range(1, 101):
            form.Apply(state.vec, residual)
            form.AssembleLinearization(state.vec)
            change = (form.mat.Inverse(space.FreeDofs(), inverse="umfpack") * residual).Evaluate()
            state.vec.data -= change
            if not change.Norm() < inf:
                raise ArithmeticError("overflow")
            if change.Norm() <= 1e-8 * state.vec.Norm():
                break
        counts.append(iteration)
        du = state.components[0] - before.components[0]
        steep = ng.grad(state.components[0]) - ng.grad(before.components[0])
        moved = ng.Integrate(du * du + ng.InnerProduct(steep, steep), mesh) ** 0.5
        if moved < 1e-6 or len(counts) == 40:
            break
        alpha.Set(2 * alpha.Get())
    force = ng.Integrate((before.components[1] - state.components[1]) / alpha.Get(), mesh)
    return space.components[0].ndof, counts, numbers(mesh, state.components[0], force)


def active_set(mesh, order):
    space = ng.H1(mesh, order=1, dirichlet="circle")
    u, v = space.TnT()
    form = ng.BilinearForm(ng.grad(u) * ng.grad(v) * ng.dx).Assemble()
    state, below, force = ng.GridFunction(space), ng.GridFunction(space), None
    below.Set(obstacle)
    free, counts = space.FreeDofs(), 0
    held = np.zeros(space.ndof, dtype=bool)
    bound = below.vec.FV().NumPy()
    while True:
        counts += 1
        solve = ng.BitArray(free)
        for dof in np.flatnonzero(held):
            solve.Clear(int(dof))
        values = state.vec.FV().NumPy()
        values[:] = np.where(held, bound, 0)
        residual = (form.mat * state.vec).Evaluate()
        state.vec.data -= form.mat.Inverse(solve, inverse="umfpack") * residual
        force = (form.mat * state.vec).Evaluate().FV().NumPy().copy()
        now = (np.where(held, force, 0) + (bound - values) > 0) & np.array(list(free), dtype=bool)
        if (now == held).all():
            return space.ndof, [counts], numbers(mesh, state, force[held].sum())
        held = now


for level, size in enumerate((0.3, 0.15, 0.075)):
    for name, order, solve in (("proximal Galerkin, ψ in cells", 2, proximal), ("proximal Galerkin, ψ in cells", 3, proximal), ("active set", 1, active_set)):
        start = time.perf_counter()
        try:
            unknowns, counts, found = solve(disc(size, order), order)
        except ArithmeticError:
            continue
        outer = len(counts) if order > 1 else None
        row("obstacle", f"NGSolve, {name}", order, level, unknowns, time.perf_counter() - start, found, newton=counts, outer=outer)
