"""The C that closes through a third medium, in felupe: its bodies, weak form and Newton's method; one node moved in 20 steps."""

import time

import felupe as fem
import numpy as np
from felupe.math import dddot, hess

from rows import row

MU, LAMBDA, SOFT, WAY = 5 / 14, 5 / 3, 5e-6, 0.031


def laplacian(h):
    return np.einsum("ijj...->i...", h)


def close(finer):
    """Unknowns, forces and Newton steps; squares of degree 2 of the side 1/10 over `finer`, with 3 by 3 points."""
    corners = fem.Rectangle(a=(0, 0), b=(1.1, 0.5), n=(11 * finer + 1, 5 * finer + 1))
    mesh = corners.add_midpoints_edges(cell_type="quad8").add_midpoints_faces(cell_type="quad9")
    x, y = corners.points[corners.cells].mean(axis=1).T
    is_medium = (x > 1) | ((x > 0.1) & (np.abs(y - 0.25) < 0.15))

    def field(cells, **options):
        part = fem.Mesh(mesh.points, mesh.cells[cells], cell_type="quad9")
        region = fem.RegionBiQuadraticQuad(part, quadrature=fem.GaussLegendre(order=2, dim=2), **options)
        return fem.FieldContainer([fem.FieldPlaneStrain(region, dim=2)])

    u = field(np.full(len(x), True))
    body = fem.SolidBody(fem.NeoHookeCompressible(mu=MU, lmbda=LAMBDA), field(~is_medium))
    medium = fem.SolidBody(fem.NeoHookeCompressible(mu=SOFT * MU, lmbda=SOFT * LAMBDA), field(is_medium))
    bent = field(is_medium, hess=True)

    def bend(h, w):
        return SOFT * LAMBDA * (dddot(h, w) - 0.5 * np.einsum("i...,i...->...", laplacian(h), laplacian(w)))

    @fem.Form(v=bent, u=bent)
    def bilinear():
        return [lambda v, w, **_: bend(hess(v), hess(w))]

    @fem.Form(v=bent)
    def linear():
        return [lambda v, **_: bend(hess(v), bent[0].hess()[:2, :2, :2])]

    bending = fem.FormItem(bilinear, linear)
    boundaries = {
        "left": fem.Boundary(u[0], fx=0),
        "pressed": fem.Boundary(u[0], fx=1, fy=0.5, mode="and", skip=(True, False)),
    }
    freedom = dict(zip(("dof0", "dof1"), fem.dof.partition(u, boundaries)))
    (pressed,) = boundaries["pressed"].dof
    forces, counts = [], []
    for step in range(1, 21):
        ext0 = np.where(freedom["dof0"] == pressed, -WAY * step, 0.0)
        found = fem.newtonraphson(x0=u, items=[body, medium, bending], ext0=ext0, **freedom, tol=1e-10, verbose=0)
        u = found.x
        counts.append(found.iterations)
        forces.append(-np.ravel(found.fun.toarray() if hasattr(found.fun, "toarray") else found.fun)[pressed])
    return mesh.points.size, forces, counts


for level in range(2):
    start = time.perf_counter()
    unknowns, forces, counts = close(1 << level)
    numbers = {f"F({step})": force for step, force in enumerate(forces, 1)}
    row("closing_c", "felupe, third medium", 2, level, unknowns, time.perf_counter() - start, numbers, newton=counts)
