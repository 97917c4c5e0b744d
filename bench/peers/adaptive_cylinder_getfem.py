"""J of the paper's cylinder to a tolerance by GetFEM's refinement (Bank's), to compare with examples/adaptive_cylinder: the same cycle.

usage: adaptive_cylinder_getfem.py [TOLERANCE] [THETA] [MOST_UNKNOWNS]      (Debian: python3-getfem, python3-numpy; GetFEM 5.4)

Triangles of degree 2 with geometry of degree 2 from a mesh of 4 x 64 pairs; (14) by GetFEM's Newton method with MUMPS, from the
displacement on the mesh before; (21) in degree 3; the residual at hat functions times p - I p; Doerfler's rule with one half. New
nodes on the circles are moved onto them. Prints a row for each mesh, then rows of uniform meshes.
"""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "getfem"))
import getfem as gf
import numpy as np
from cylinder import CONTACT, CONTACT_U, DISCRETE, BULK_P, BULK_U, FORCE, GAP, INNER, INNER_CIRCLE, LAMBDA, MU
from cylinder import OUTER, PRESCRIBED, TOLERANCE, YOUNG, stress_normal

FIRST = 4                         # pairs of triangles across
GAMMA0 = 10.0 * YOUNG
NODES = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (0, 2)]         # of GT_PK(2,2), in halves

# R(u; q z): the test function of (14) is a hat function q times the weight z.
TEST = "(z@Grad_Test_q+Test_q*Grad_z)"
WEIGHTED = BULK_U.replace("Grad_Test_u", TEST)
NORMAL_U = stress_normal("u")
NORMAL_WEIGHTED = NORMAL_U.replace("Grad_u", TEST)
CONTACT_WEIGHTED = (
    f"-theta/gamma*{NORMAL_U}*{NORMAL_WEIGHTED}"
    f"-1/gamma*neg_part({NORMAL_U}-gamma*(u.ny-{GAP}))*(theta*{NORMAL_WEIGHTED}-gamma*Test_q*(z.ny))"
)



def polar_mesh(radial):
    """radial x 16 radial pairs of triangles of degree 2, all nodes on circles."""
    mesh = gf.Mesh("empty", 2)
    transformation = gf.GeoTrans("GT_PK(2,2)")
    around = 16 * radial

    def place(i, j):
        r, angle = INNER + (OUTER - INNER) * i / (2 * radial), np.pi * (j % (2 * around)) / around
        return r * np.cos(angle), r * np.sin(angle)

    for i in range(0, 2 * radial, 2):
        for j in range(0, 2 * around, 2):
            for corner, sign in (((i, j), 1), ((i + 2, j + 2), -1)):
                points = [place(corner[0] + sign * a, corner[1] + sign * b) for a, b in NODES]
                mesh.add_convex(transformation, np.array(points).T)
    assert mesh.nbpts() == (2 * radial + 1) * 2 * around, mesh.nbpts()
    return named(mesh)


def named(mesh):
    """Moves the boundary's nodes onto the circles, and names the circles anew."""
    faces = mesh.outer_faces()
    points = mesh.pts()
    inner, contact = [], []
    for cell, face in faces.T:
        ids = mesh.pid_in_faces([[cell], [face]])
        radius = np.hypot(*points[:, ids])
        circle = INNER if radius.mean() < 0.5 * (INNER + OUTER) else OUTER
        assert abs(radius - circle).max() < 1e-2, radius
        points[:, ids] *= circle / radius
        if circle == INNER:
            inner.append((cell, face))
        elif points[1, ids].mean() < 0.0:
            contact.append((cell, face))
    mesh.set("pts", points)
    for number, facets in ((INNER_CIRCLE, inner), (CONTACT, contact)):
        if number in mesh.regions():
            mesh.delete_region([number])
        mesh.set_region(number, np.array(facets).T)
    return mesh


def space(mesh, degree, components):
    found = gf.MeshFem(mesh, components)
    found.set_fem(gf.Fem(f"FEM_PK(2,{degree})"))
    return found


def clamped(displacement):
    fixed = np.zeros(displacement.nbdof(), dtype=bool)
    fixed[displacement.basic_dof_on_region(INNER_CIRCLE)] = True
    return fixed


def solve(mesh, theta, before):
    """u, J, eta and the indicators of the cells."""
    displacement, higher, hats, constant = space(mesh, 2, 2), space(mesh, 3, 2), space(mesh, 1, 1), space(mesh, 0, 1)
    integration = gf.MeshIm(mesh, gf.Integ("IM_TRIANGLE(8)"))
    diameters = np.zeros(constant.nbdof())
    cells = mesh.cvid()
    for cell in cells:
        corners = mesh.pts_from_cvid(cell)[0][:, [0, 2, 5]]
        edges = corners - np.roll(corners, 1, axis=1)
        diameters[constant.basic_dof_from_cvid(cell)[0]] = np.sqrt((edges**2).sum(axis=0).max())
    gamma = GAMMA0 / diameters

    model = gf.Model("real")
    model.add_fem_variable("u", displacement)
    for name, value in {"lambda": LAMBDA, "mu": MU, "theta": theta}.items():
        model.add_initialized_data(name, value)
    model.add_initialized_data("ny", [0.0, -1.0])
    model.add_initialized_data("prescribed", list(PRESCRIBED))
    model.add_initialized_fem_data("gamma", constant, gamma)
    model.add_linear_term(integration, BULK_U)
    split = CONTACT_U.index("-1/gamma*neg_part")
    model.add_linear_term(integration, CONTACT_U[:split], CONTACT)
    model.add_nonlinear_term(integration, CONTACT_U[split:], CONTACT)
    model.add_Dirichlet_condition_with_simplification("u", INNER_CIRCLE, "prescribed")
    fixed = clamped(displacement)
    start = np.zeros(displacement.nbdof())
    if before is not None:
        start = gf.compute_interpolate_on(before[0], before[1], displacement)
    for component, value in enumerate(PRESCRIBED):
        start[component::2][fixed[component::2]] = value
    model.set_variable("u", start)
    model.assembly("build_rhs")
    free = np.flatnonzero(~fixed)
    first = np.linalg.norm(model.rhs()[free])
    model.solve("max_res", TOLERANCE * first, "max_iter", 40, "lsolver", "mumps", "lsearch", "simplest",
                "alpha min", 1.0, "alpha mult", 0.5, "alpha max ratio", 1e30)
    u = model.variable("u")

    constants = [x for name, value in {"lambda": LAMBDA, "mu": MU, "theta": theta, "ny": np.array([0.0, -1.0])}.items()
                 for x in (name, 0, np.atleast_1d(np.array(value, dtype=float)))]
    constants += ["gamma", 0, constant, gamma]

    def assemble(order, expression, region, *fields):
        return gf.asm_generic(integration, order, expression, region, *fields, *constants)

    zero = np.zeros(higher.nbdof())
    of_p = ["p", 1, higher, zero, "u", 0, displacement, u]
    matrix = assemble(2, BULK_P, -1, *of_p)
    matrix.add(range(higher.nbdof()), range(higher.nbdof()), assemble(2, DISCRETE, CONTACT, *of_p))
    right = -assemble(1, f"{FORCE}.Test_p", -1, *of_p)
    held = clamped(higher)
    kept = np.flatnonzero(~held)
    inside = gf.Spmat("copy", matrix, kept, kept)
    p = zero
    p[kept] = np.ravel(gf.linsolve_mumps(inside, right[kept]))

    coarse = gf.compute_interpolate_on(higher, p, displacement)
    weight = p - gf.compute_interpolate_on(displacement, coarse, higher)
    of_q = ["q", 1, hats, np.zeros(hats.nbdof()), "u", 0, displacement, u, "z", 0, higher, weight]
    shares = assemble(1, WEIGHTED, -1, *of_q) + assemble(1, CONTACT_WEIGHTED, CONTACT, *of_q)
    of_cells = np.array([hats.basic_dof_from_cvid(cell)[0] for cell in cells])
    counts = np.bincount(of_cells.ravel(), minlength=hats.nbdof())
    indicators = (np.abs(shares) / counts)[of_cells].sum(axis=1)
    goal = float(np.ravel(assemble(0, f"{FORCE}.u", -1, "u", 0, displacement, u))[0])
    return displacement, u, goal, float(shares.sum()), cells, indicators


def doerfler(cells, indicators):
    """The fewest cells with one half of the sum."""
    order = np.argsort(-indicators, kind="stable")
    count = int(np.searchsorted(np.cumsum(indicators[order]), 0.5 * indicators.sum())) + 1
    return cells[order[:count]]


def main():
    gf.util("trace level", 0)
    gf.util("warning level", 0)
    tolerance = float(sys.argv[1]) if len(sys.argv) > 1 else 1e-6
    theta = float(sys.argv[2]) if len(sys.argv) > 2 else -1.0
    most = int(sys.argv[3]) if len(sys.argv) > 3 else 150_000
    print("| meshes | unknowns | J | eta / J | s, clock | s, processor |\n| --- | --: | --: | --: | --: | --: |")

    def row(name, unknowns, goal, estimate, began):
        clock, cpu = (now - then for now, then in zip((time.perf_counter(), time.process_time()), began))
        print(f"| {name} | {unknowns} | {goal:.8f} | {estimate / goal:.2e} | {clock:.2f} | {cpu:.2f} |", flush=True)

    mesh, before = polar_mesh(FIRST), None
    began = time.perf_counter(), time.process_time()
    while True:
        displacement, u, goal, estimate, cells, indicators = solve(mesh, theta, before)
        row("GetFEM, for J", displacement.nbdof(), goal, estimate, began)
        if abs(estimate) <= tolerance * abs(goal) or displacement.nbdof() > most:
            break
        fine = gf.Mesh("clone", mesh)
        fine.refine(doerfler(cells, indicators))
        before, mesh = (displacement, u), named(fine)
    for radial in (FIRST, 2 * FIRST, 4 * FIRST, 8 * FIRST):
        mesh = polar_mesh(radial)
        began = time.perf_counter(), time.process_time()
        displacement, _, goal, estimate, _, _ = solve(mesh, theta, None)
        if displacement.nbdof() > most:
            break
        row("GetFEM, uniform", displacement.nbdof(), goal, estimate, began)


if __name__ == "__main__":
    main()
