"""Half a ring of rubber on a flat, in felupe: its mean dilatation on Q1, and on Q2 its three fields, whose stress is bilinear in each cell, with its
penalty between nodes and a plane."""

import time
from math import pi

import felupe as fem
import numpy as np

from rows import row

INSIDE, OUTSIDE, YOUNG, POISSON, END, FORCE = 20.0, 40.0, 1.4, 0.4995, 10, 5.0
MU, BULK = YOUNG / (2 * (1 + POISSON)), YOUNG / (3 * (1 - 2 * POISSON))
# Force over penetration of a node [N/mm²].
STIFFNESS = 1e4


class Ring:
    """The right half of the half ring, and the point that carries the flat."""

    def __init__(self, degree, level):
        along = (16 if degree == 1 else 8) << level
        mesh = fem.Rectangle(n=(along + 1, along // 4 + 1))
        if degree == 2:
            mesh = mesh.add_midpoints_edges(cell_type="quad8").add_midpoints_faces(cell_type="quad9")
        s, t = mesh.points.T
        angle, radius = pi / 2 * (s - 1), OUTSIDE - t * (OUTSIDE - INSIDE)
        mesh.update(points=np.vstack([np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]), [0, -OUTSIDE]]))
        outer, inner, middle = (np.flatnonzero(where) for where in (t < 1e-9, t > 1 - 1e-9, s < 1e-9))
        if degree == 1:
            region = fem.RegionQuad(mesh)
            self.field = fem.FieldContainer([fem.FieldPlaneStrain(region, dim=2)])
            self.body = fem.SolidBodyNearlyIncompressible(fem.NeoHooke(mu=MU), self.field, bulk=BULK)
        else:
            region = fem.RegionBiQuadraticQuad(mesh)
            self.field = fem.FieldsMixed(region, n=3, planestrain=True)
            self.body = fem.SolidBody(fem.NearlyIncompressible(fem.NeoHooke(mu=MU), bulk=BULK), self.field)
        plane = fem.ContactRigidPlane(self.field, points=outer, centerpoint=mesh.npoints - 1, normal=[0, 1], multiplier=STIFFNESS)
        self.items = [self.body, plane]
        self.flat = 2 * (mesh.npoints - 1) + 1
        held = np.concatenate([2 * inner, 2 * inner + 1, 2 * middle, [self.flat - 1, self.flat]])
        self.dof0 = np.unique(held)
        self.dof1 = np.setdiff1d(np.arange(sum(part.values.size for part in self.field.fields)), self.dof0)
        self.unknowns = 2 * (mesh.npoints - 1)
        self.counts = []

    def press(self, way):
        """The force for this way of the flat."""
        ext0 = np.where(self.dof0 == self.flat, float(way), 0.0)
        found = fem.newtonraphson(x0=self.field, items=self.items, dof0=self.dof0, dof1=self.dof1, ext0=ext0, tol=1e-9, verbose=0, maxiter=40)
        self.field = found.x
        self.counts.append(found.iterations)
        return 2 * np.ravel(found.fun)[self.flat]

    def growth(self):
        F = self.field.extract()[0]
        return 2 * np.sum((fem.math.det(F) - 1) * self.field.region.dV)

    def press_by(self, force, way, slope):
        """The way of the flat for a force, by secants."""
        before, last = way, self.press(way)
        way += (force - last) / slope
        while abs(way - before) > 1e-8:
            now = self.press(way)
            before, way, last = way, way + (force - now) * (way - before) / (now - last), now
        return way


for degree in (1, 2):
    for level in range(2 + degree):
        start = time.perf_counter()
        ring = Ring(degree, level)
        forces = [ring.press(way) for way in range(1, END + 1)]
        counts = list(ring.counts)
        again = Ring(degree, level)
        again.press(1)
        way = again.press_by(FORCE, 2, forces[2] - forces[1])
        numbers = {"F(2)": forces[1], "F(5)": forces[4], "F(10)": forces[9], "δ at F = 5": way, "∫(J − 1) there": again.growth()}
        element = "mean dilatation" if degree == 1 else "p bilinear in cells"
        row("half_ring", f"felupe, {element}, penalty at nodes", degree, level, ring.unknowns, time.perf_counter() - start, numbers, newton=counts)
