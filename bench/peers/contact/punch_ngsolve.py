"""A flat punch on a block in NGSolve: Nitsche's method on meshes that are graded toward the corner, and degree 10 with the punch's nodes held."""

import time

import ngsolve as ng
from netgen.geom2d import SplineGeometry

from newton import negative_part, newton
from rows import row

YOUNG, POISSON, HALF, SIZE, WAY = 2e5, 0.3, 10.0, 200.0, 0.01
MU = YOUNG / (2 * (1 + POISSON))
LAMBDA = {
    "punch": YOUNG * POISSON / (1 - POISSON**2),
    "punch_strain": YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)),
}
PUNCH = ["inner", "middle", "outer"]


def block(size, layers):
    """Half of the block; parts of the punch end at nodes, and layers of small cells are around its corner."""
    geometry = SplineGeometry()
    places = [(0, 0), (0.5 * HALF, 0), (0.8 * HALF, 0), (HALF, 0), (SIZE, 0), (SIZE, -SIZE), (0, -SIZE)]
    points = [geometry.AppendPoint(*place, hpref=int(place == (HALF, 0))) for place in places]
    for number, name in enumerate([*PUNCH, "free", "right", "base", "axis"]):
        ends = [points[(number + 1) % 7], points[number]]
        geometry.Append(["line", *ends], leftdomain=1, rightdomain=0, bc=name, maxh=size if name in PUNCH else SIZE / 5)
    mesh = ng.Mesh(geometry.GenerateMesh(maxh=SIZE / 5, grading=0.2))
    mesh.RefineHP(layers, factor=0.25)
    return mesh


def solve(problem, mesh, order, theta=None):
    """Unknowns, Newton steps and numbers of Nitsche's method, or with the punch's nodes held."""
    held = [] if theta is not None else PUNCH
    space = ng.VectorH1(mesh, order=order, dirichletx="axis|base", dirichlety="|".join(["base", *held]))
    u, v = space.TnT()

    def stress(w):
        strain = ng.Sym(ng.Grad(w))
        return LAMBDA[problem] * ng.Trace(strain) * ng.Id(2) + 2 * MU * strain

    def pressure(w):
        return -stress(w)[1, 1] if theta is None else negative_part(stress(w)[1, 1] - gamma * w[1])

    gamma = 13 * YOUNG / ng.specialcf.mesh_size
    form = ng.BilinearForm(space)
    form += ng.InnerProduct(stress(u), ng.Sym(ng.Grad(v))) * ng.dx
    if theta is not None:
        consistent = theta / gamma * (stress(u)[1, 1] + pressure(u)) * stress(v)[1, 1]
        form += (pressure(u) * v[1] - consistent) * ng.ds("|".join(PUNCH), skeleton=True, bonus_intorder=2)
    state, base = ng.GridFunction(space), ng.GridFunction(space)
    base.Set(ng.CF((0, 1)), definedon=mesh.Boundaries("base"))
    state.vec.data = WAY * base.vec
    steps = newton(form, state, space.FreeDofs())
    force = ng.InnerProduct(form.Apply(state.vec), base.vec)
    # The pressure is in cells, whose gradients are not those of the boundary.
    boundary = ng.BoundaryFromVolumeCF(pressure(state))
    within = [ng.Integrate(boundary * ng.ds("|".join(PUNCH[:parts]), bonus_intorder=2), mesh) / force for parts in (1, 2)]
    return space.ndof, steps, {"part of F within a/2": within[0], "part of F within 0.8 a": within[1], "F/(E way)": 2 * force / (YOUNG * WAY)}


for problem in LAMBDA:
    for theta in (-1, 0, 1):
        for order in (1, 2):
            for level in range(3):
                start = time.perf_counter()
                unknowns, steps, numbers = solve(problem, block(2.5 / 2**level, 2 + level), order, theta)
                row(problem, f"NGSolve, Nitsche θ = {theta}", order, level, unknowns, time.perf_counter() - start, numbers, newton=[steps])
    start = time.perf_counter()
    unknowns, steps, numbers = solve(problem, block(2.5, 8), 10)
    row(problem, "NGSolve, nodes held", 10, None, unknowns, time.perf_counter() - start, numbers, newton=[steps])
