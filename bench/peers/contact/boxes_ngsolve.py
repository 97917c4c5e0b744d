"""Two boxes that overhang each other in NGSolve: its contact boundary with a penalty, on tetrahedra of degree 2 and 3."""

import time

import ngsolve as ng
from netgen.occ import Box, Glue, OCCGeometry, Pnt, X, Y, Z

from rows import row

YOUNG, POISSON, GAP, WAY = 1.0, 0.3, 1e-4, 0.025
LAMBDA, MU = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), YOUNG / (2 * (1 + POISSON))


def quarter(size):
    """A quarter of the boxes, whose cells are small where they meet."""
    lower, upper = Box(Pnt(0, 0, 0), Pnt(0.5, 0.5, 0.5)), Box(Pnt(0, 0, 0.5 + GAP), Pnt(0.6, 0.4, 1 + GAP))
    for box in (lower, upper):
        box.faces.Min(X).name, box.faces.Min(Y).name = "left", "front"
    lower.faces.Min(Z).name, lower.faces.Max(Z).name = "base", "under"
    upper.faces.Max(Z).name, upper.faces.Min(Z).name = "top", "over"
    lower.faces.Max(Z).maxh = upper.faces.Min(Z).maxh = size
    return ng.Mesh(OCCGeometry(Glue([lower, upper])).GenerateMesh(maxh=4 * size, grading=0.5))


def solve(mesh, order, penalty):
    """Unknowns, Newton steps and numbers after each of four steps of the top."""
    space = ng.VectorH1(mesh, order=order, dirichletx="left|base|top", dirichlety="front|base|top", dirichletz="base|top")
    u, v = space.TnT()

    def energy(w):
        strain = ng.Sym(ng.Grad(w))
        return LAMBDA / 2 * ng.Trace(strain) ** 2 + MU * ng.InnerProduct(strain, strain)

    form = ng.BilinearForm(space, symmetric=True)
    form += ng.Variation(energy(u) * ng.dx)
    contact = ng.ContactBoundary(mesh.Boundaries("over"), mesh.Boundaries("under"))
    place = ng.CF((ng.x, ng.y, ng.z))
    depth = ng.InnerProduct(place + u - place.Other() - u.Other(), contact.normal)
    contact.AddEnergy(ng.IfPos(depth, penalty / 2 * depth**2, 0))
    state, base = ng.GridFunction(space), ng.GridFunction(space)
    base.Set(ng.CF((0, 0, 1)), definedon=mesh.Boundaries("top"))
    # Pairs of the boxes as they are at first: strains are small.
    contact.Update(state, form, 2 * order + 2, 2 * GAP)
    counts, numbers = [], {}
    for step in range(1, 5):
        state.vec.data -= WAY * base.vec
        residual = state.vec.CreateVector()
        for iteration in range(1, 40):
            form.Apply(state.vec, residual)
            form.AssembleLinearization(state.vec)
            change = (form.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky") * residual).Evaluate()
            state.vec.data -= change
            if change.Norm() <= 1e-9 * state.vec.Norm():
                break
        counts.append(iteration)
        form.Apply(state.vec, residual)
        numbers[f"reaction {step}"] = -4 * ng.InnerProduct(residual, base.vec)
    numbers["energy 4"] = 4 * ng.Integrate(energy(state), mesh)
    return space.ndof, counts, numbers


for level, size in enumerate((0.1, 0.06)):
    mesh = quarter(size)
    for order in (2, 3):
        for penalty in (1e2, 1e4):
            start = time.perf_counter()
            unknowns, steps, numbers = solve(mesh, order, penalty)
            row("boxes", f"NGSolve, penalty {penalty:g}", order, level, unknowns, time.perf_counter() - start, numbers, newton=steps)
