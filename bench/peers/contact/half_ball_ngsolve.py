"""A half ball that is pushed onto a plane, in (r, z) by NGSolve: Nitsche's method, and proximal Galerkin with ψ continuous on the arc."""

import time
from functools import partial
from math import pi

import ngsolve as ng
import numpy as np
from netgen.geom2d import SplineGeometry

from newton import negative_part, newton
from rows import row

YOUNG, POISSON, RADIUS, CENTRE, WAY = 2e4, 0.3, 0.4, 0.5, 0.15
LAMBDA, MU = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), YOUNG / (2 * (1 + POISSON))
# The typical pressure and gap by which α is scaled.
PRESSURE, APPROACH = 4000.0, 0.05
r, z = ng.x, ng.y
weight = 2 * pi * r


def quarter(size, order):
    """The section of the half ball, whose arc may touch where r < 0.3."""
    geometry = SplineGeometry()
    turn = np.arcsin(0.75)

    def arc(angle):
        return RADIUS * np.sin(angle), CENTRE - RADIUS * np.cos(angle)

    def knee(first, second):
        """The point where the tangents of two ends of an arc meet."""
        half = (second - first) / 2
        return RADIUS / np.cos(half) * np.sin(first + half), CENTRE - RADIUS / np.cos(half) * np.cos(first + half)

    places = [(0, CENTRE), arc(0), knee(0, turn), arc(turn), knee(turn, pi / 2), (RADIUS, CENTRE)]
    a, b, c, d, e, f = (geometry.AppendPoint(*place) for place in places)
    geometry.Append(["line", a, b], leftdomain=1, rightdomain=0, bc="axis")
    geometry.Append(["spline3", b, c, d], leftdomain=1, rightdomain=0, bc="contact", maxh=size)
    geometry.Append(["spline3", d, e, f], leftdomain=1, rightdomain=0, bc="arc")
    geometry.Append(["line", f, a], leftdomain=1, rightdomain=0, bc="flat")
    mesh = ng.Mesh(geometry.GenerateMesh(maxh=size))
    mesh.Curve(order)
    return mesh


def strain(w):
    """The components rr, zz, tt and rz."""
    G = ng.Grad(w)
    return G[0, 0], G[1, 1], w[0] / r, (G[0, 1] + G[1, 0]) / 2


def stress(w):
    rr, zz, tt, rz = strain(w)
    volume = LAMBDA * (rr + zz + tt)
    return volume + 2 * MU * rr, volume + 2 * MU * zz, volume + 2 * MU * tt, 2 * MU * rz


def work(w, v):
    (srr, szz, stt, srz), (err, ezz, ett, erz) = stress(w), strain(v)
    return weight * (srr * err + szz * ezz + stt * ett + 2 * srz * erz)


def normal_stress(w):
    """(σ n)·e for the direction e = (0, −1) toward the plane."""
    _, szz, _, srz = stress(w)
    n = ng.specialcf.normal(2)
    return -(srz * n[0] + szz * n[1])


def numbers(mesh, state, force, pressure):
    """The contact ends at the outermost point of a fine rule that presses."""
    energy = ng.Integrate(work(state, state) / 2, mesh, order=10)
    rule = ng.IntegrationRule(ng.SEGM, 20)
    points = mesh.MapToAllElements({ng.SEGM: rule}, mesh.Boundaries("contact"))
    values, places = np.ravel(pressure(points)), np.ravel(r(points))
    radius = places[values > 1e-3 * values.max()].max()
    return {"reaction": force, "energy": energy, "contact radius": radius}


def nitsche(mesh, order, theta):
    space = ng.VectorH1(mesh, order=order, dirichletx="axis|flat", dirichlety="flat")
    u, v = space.TnT()
    gamma = 13 * YOUNG / ng.specialcf.mesh_size

    def pressure(w):
        return negative_part(normal_stress(w) + gamma * (z + w[1]))

    form = ng.BilinearForm(space)
    form += work(u, v) * ng.dx(bonus_intorder=2)
    consistent = theta / gamma * (normal_stress(u) + pressure(u)) * normal_stress(v)
    form += weight * (-pressure(u) * v[1] - consistent) * ng.ds("contact", skeleton=True, bonus_intorder=4)
    state, base = ng.GridFunction(space), ng.GridFunction(space)
    base.Set(ng.CF((0, 1)), definedon=mesh.Boundaries("flat"))
    state.vec.data = -WAY * base.vec
    steps = newton(form, state, space.FreeDofs())
    force = -ng.InnerProduct(form.Apply(state.vec), base.vec)
    return space.ndof, [steps], None, numbers(mesh, state, force, ng.BoundaryFromVolumeCF(pressure(state)))


def proximal(mesh, order, share):
    """α p = share · gap at first, doubled, until the change in H¹ is 1e-6 of the way."""
    displacements = ng.VectorH1(mesh, order=order, dirichletx="axis|flat", dirichlety="flat")
    space = displacements * ng.H1(mesh, order=order, definedon=mesh.Boundaries("contact"))
    (u, psi), (v, w) = space.TnT()
    state, before, base = ng.GridFunction(space), ng.GridFunction(space), ng.GridFunction(displacements)
    base.Set(ng.CF((0, 1)), definedon=mesh.Boundaries("flat"))
    state.components[0].vec.data = -WAY * base.vec
    alpha = ng.Parameter(share / PRESSURE)
    form = ng.BilinearForm(space)
    form += work(u, v) * ng.dx(bonus_intorder=2)
    form += weight * (psi - before.components[1]) / alpha * v[1] * ng.ds("contact", bonus_intorder=4)
    form += weight * PRESSURE / APPROACH * (z + u[1] - APPROACH * ng.exp(psi)) * w * ng.ds("contact", bonus_intorder=6)
    counts = []
    while len(counts) < 40:
        before.vec.data = state.vec
        counts.append(newton(form, state, space.FreeDofs(), tolerance=1e-8))
        change = state.components[0] - before.components[0]
        steep = ng.Grad(state.components[0]) - ng.Grad(before.components[0])
        moved = ng.Integrate(ng.InnerProduct(change, change) + ng.InnerProduct(steep, steep), mesh) ** 0.5
        if moved < 1e-6 * WAY:
            break
        alpha.Set(2 * alpha.Get())
    pressure = (before.components[1] - state.components[1]) / alpha.Get()
    force = ng.Integrate(weight * pressure * ng.ds("contact", bonus_intorder=4), mesh)
    return displacements.ndof, counts, len(counts), numbers(mesh, state.components[0], force, pressure)


def main():
    formulations = [(f"Nitsche θ = {theta}", partial(nitsche, theta=theta)) for theta in (-1, 0, 1)]
    formulations += [(f"proximal Galerkin, α p = {share:g}", partial(proximal, share=share)) for share in (1, 10)]
    for name, solve in formulations:
        # Degree 4 on the finest mesh is the reference.
        for order, level in [*((order, level) for order in (1, 2) for level in range(3)), (4, 2)]:
            start = time.perf_counter()
            try:
                unknowns, counts, outer, found = solve(quarter(0.08 / 2**level, order), order)
            except ArithmeticError as why:
                print(f"{name}, degree {order}, level {level}: {why}")
                continue
            shown = level if order < 4 else None
            row("half_ball", f"NGSolve, {name}", order, shown, unknowns, time.perf_counter() - start, found, newton=counts, outer=outer)


main()
