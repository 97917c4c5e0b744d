"""The C that closes through a third medium, in NGSolve: energies as they are written, undamped Newton, one node moved in 20 steps."""

import sys
import time

import ngsolve as ng
import numpy as np
from netgen.meshing import Element2D, FaceDescriptor, Mesh, MeshPoint, Pnt, Element1D

from rows import row

MU, LAMBDA, SOFT, WAY = 5 / 14, 5 / 3, 5e-6, 0.031


def grid(finer):
    """[0,1.1] × [0,0.5] of squares; domain 1 is the body and 2 the medium, the boundary condition 1 is the left side."""
    nx, ny = 11 * finer, 5 * finer
    mesh = Mesh(dim=2)
    points = [[mesh.Add(MeshPoint(Pnt(0.1 / finer * i, 0.1 / finer * j, 0))) for i in range(nx + 1)] for j in range(ny + 1)]
    for bc in (1, 2):
        mesh.Add(FaceDescriptor(surfnr=bc, domin=bc, bc=bc))
    for j in range(ny):
        for i in range(nx):
            x, y = (i + 0.5) * 0.1 / finer, (j + 0.5) * 0.1 / finer
            medium = x > 1 or (x > 0.1 and abs(y - 0.25) < 0.15)
            corners = [points[j][i], points[j][i + 1], points[j + 1][i + 1], points[j + 1][i]]
            mesh.Add(Element2D(2 if medium else 1, corners))
    for j in range(ny):
        mesh.Add(Element1D([points[j][0], points[j + 1][0]], index=1))
    mesh.SetMaterial(1, "body")
    mesh.SetMaterial(2, "medium")
    return ng.Mesh(mesh)


def run(finer):
    mesh = grid(finer)
    space = ng.VectorH1(mesh, order=2, dirichlet=".*")
    u = space.TrialFunction()
    F = ng.Id(2) + ng.Grad(u)
    J = ng.Det(F)
    hess = u.Operator("hesse")
    density = MU / 2 * (ng.InnerProduct(F, F) - 2 - 2 * ng.log(J)) + LAMBDA / 2 * ng.log(J) ** 2
    laplace = [hess[4 * i] + hess[4 * i + 3] for i in (0, 1)]
    bend = (ng.InnerProduct(hess, hess) - 0.5 * (laplace[0] ** 2 + laplace[1] ** 2)) / 2
    scale, bending = mesh.MaterialCF({"body": 1, "medium": SOFT}), mesh.MaterialCF({"body": 0, "medium": SOFT * LAMBDA})
    energy = (scale * density + bending * bend).Compile()
    form = ng.BilinearForm(space, symmetric=True)
    rule = ng.IntegrationRule(ng.QUAD, 5)
    form += ng.Variation(energy * ng.dx(intrules={ng.QUAD: rule}))
    free = ng.BitArray(space.FreeDofs())
    # The vertex at (1, 0.5): the numbers of vertices are first.
    vertex = min(mesh.vertices, key=lambda v: (v.point[0] - 1) ** 2 + (v.point[1] - 0.5) ** 2).nr
    pressed = [d for d in space.GetDofNrs(ng.NodeId(ng.VERTEX, vertex))][1]
    free.Clear(pressed)
    state = ng.GridFunction(space)
    residual, change = state.vec.CreateVector(), state.vec.CreateVector()
    forces, counts = [], []
    for step in range(1, 21):
        for iteration in range(60):
            form.Apply(state.vec, residual)
            form.AssembleLinearization(state.vec)
            if iteration == 0:
                change[:] = 0
                change[pressed] = -WAY
                residual.data += form.mat * change
            correction = form.mat.Inverse(free, inverse="umfpack") * residual
            change_norm = correction.Norm()
            state.vec.data -= correction
            if iteration == 0:
                state.vec.data += change
            if change_norm < 1e-10 * max(state.vec.Norm(), 1e-300):
                break
        counts.append(iteration + 1)
        form.Apply(state.vec, residual)
        forces.append(-residual[pressed])
    return space.ndof, forces, counts


for level in range(2):
    start = time.perf_counter()
    unknowns, forces, counts = run(1 << level)
    numbers = {f"F({step})": force for step, force in enumerate(forces, 1)}
    row("closing_c", "NGSolve, third medium", 2, level, unknowns, time.perf_counter() - start, numbers, newton=counts)
