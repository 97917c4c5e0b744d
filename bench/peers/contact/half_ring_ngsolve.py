"""Half a ring of rubber on a flat, in NGSolve: P2/P1 and P3/P2 with continuous mean stresses, Nitsche's method with θ = 0."""

import time
from math import cos, pi, sin

import ngsolve as ng
from netgen.geom2d import SplineGeometry

from newton import negative_part, newton
from rows import row

INSIDE, OUTSIDE, YOUNG, POISSON, END, FORCE = 20.0, 40.0, 1.4, 0.4995, 10, 5.0
MU, BULK = YOUNG / (2 * (1 + POISSON)), YOUNG / (3 * (1 - 2 * POISSON))


def quarter(size, order):
    """The right half of the half ring; the outer arc may touch over 60°."""
    geometry = SplineGeometry()

    def point(radius, angle):
        return geometry.AppendPoint(radius * cos(angle), radius * sin(angle))

    def arc(radius, first, second, ends, **options):
        """An arc; its third point is where the tangents of its ends meet."""
        half = (second - first) / 2
        knee = point(radius / cos(half), first + half)
        geometry.Append(["spline3", ends[0], knee, ends[1]], leftdomain=1, rightdomain=0, **options)

    a, b, c = -pi / 2, -pi / 6, 0.0
    outer = [point(OUTSIDE, angle) for angle in (a, b, c)]
    inner = [point(INSIDE, angle) for angle in (c, a)]
    arc(OUTSIDE, a, b, outer[:2], bc="contact", maxh=size / 2)
    arc(OUTSIDE, b, c, outer[1:], bc="outer")
    geometry.Append(["line", outer[2], inner[0]], leftdomain=1, rightdomain=0, bc="cut")
    arc(INSIDE, c, a, inner, bc="inner")
    geometry.Append(["line", inner[1], outer[0]], leftdomain=1, rightdomain=0, bc="middle")
    mesh = ng.Mesh(geometry.GenerateMesh(maxh=size))
    mesh.Curve(order)
    return mesh


class Ring:
    def __init__(self, order, size):
        self.mesh = quarter(size, order)
        displacements = ng.VectorH1(self.mesh, order=order, dirichletx="inner|middle", dirichlety="inner")
        self.space = displacements * ng.H1(self.mesh, order=order - 1)
        (u, p), (v, q) = self.space.TnT()
        self.unknowns = displacements.ndof
        self.way = ng.Parameter(0)
        F = ng.Id(2) + ng.Grad(u)
        J = ng.Det(F)
        isochoric = MU / 2 * (J ** (-2 / 3) * (ng.InnerProduct(F, F) + 1) - 3)
        stress = MU * J ** (-2 / 3) * (F - (ng.InnerProduct(F, F) + 1) / 3 * ng.Inv(F).trans) + p * ng.Cof(F)
        toward = ng.CF((0, -1))
        self.gamma = 7 * 3 * MU / ng.specialcf.mesh_size
        self.form = ng.BilinearForm(self.space)
        self.form += ng.Variation((isochoric + p * (J - 1) - p * p / (2 * BULK)).Compile() * ng.dx(bonus_intorder=2))
        normal_stress = ng.InnerProduct(stress * ng.specialcf.normal(2), toward)
        distance = ng.y + OUTSIDE - self.way + u[1]
        pressure = negative_part(normal_stress + self.gamma * distance)
        self.form += (-pressure * v[1]).Compile() * ng.ds("contact", skeleton=True, bonus_intorder=4)
        self.state = ng.GridFunction(self.space)
        self.base = ng.GridFunction(self.space)
        self.base.components[0].Set(ng.CF((0, 1)), definedon=self.mesh.Boundaries("inner"))
        self.counts = []

    def press(self, way):
        """The force for this way of the flat."""
        self.way.Set(way)
        self.counts.append(newton(self.form, self.state, self.space.FreeDofs()))
        return -2 * ng.InnerProduct(self.form.Apply(self.state.vec), self.base.vec)

    def growth(self):
        F = ng.Id(2) + ng.Grad(self.state.components[0])
        return 2 * ng.Integrate(ng.Det(F) - 1, self.mesh, order=8)

    def press_by(self, force, way, slope):
        """The way of the flat for a force, by secants."""
        before, last = way, self.press(way)
        way += (force - last) / slope
        while abs(way - before) > 1e-8:
            now = self.press(way)
            before, way, last = way, way + (force - now) * (way - before) / (now - last), now
        return way


for order in (2, 3):
    # P3/P2 is the reference.
    for level in range(4) if order == 2 else [2]:
        start = time.perf_counter()
        ring = Ring(order, 10 / 2**level)
        forces = [ring.press(way) for way in range(1, END + 1)]
        counts = list(ring.counts)
        again = Ring(order, 10 / 2**level)
        again.press(1)
        way = again.press_by(FORCE, 2, forces[2] - forces[1])
        numbers = {"F(2)": forces[1], "F(5)": forces[4], "F(10)": forces[9], "δ at F = 5": way, "∫(J − 1) there": again.growth()}
        row("half_ring_triangles", f"NGSolve, P{order}/P{order - 1}, Nitsche θ = 0", order, level if order == 2 else None, ring.unknowns, time.perf_counter() - start, numbers, newton=counts)
