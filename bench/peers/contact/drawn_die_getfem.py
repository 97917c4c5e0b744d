"""A round die that is pressed into a slab and drawn along it, in GetFEM: Nitsche's method with θ = 0 by its raytracing transformation.

usage: drawn_die_getfem.py [sweep]      (Debian: python3-getfem; GetFEM 5.4)

The pressure has 10 E over the diameter of the die's cell, as in the library; `sweep` prints forces for other lengths and rules on facets.
"""

import math
import sys
import time
from pathlib import Path

import getfem as gf
import numpy as np
import scipy.sparse
import scipy.sparse.linalg

sys.path.insert(0, str(Path(__file__).parent))
from rows import row

gf.util("trace level", 0)
YOUNG, POISSON, DEPTH, DOWN, ALONG = 100.0, 0.3, 0.1, 5, 10
LAMBDA, MU = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), YOUNG / (2 * (1 + POISSON))
TOUCH, HELD = 1, 2


def bodies(n):
    """The slab [−3, 5] × [0, 1] of 8n × n cells, and the die of (n + 1) × n/2."""
    slab = gf.Mesh("cartesian Q1", np.linspace(-3, 5, 8 * n + 1), np.linspace(0, 1, n + 1))
    die = gf.Mesh("cartesian Q1", np.linspace(0, 1, n + 2), np.linspace(0, 1, n // 2 + 1))
    s, t = die.pts()
    bottom = 2 - np.sqrt(1 - (s - 0.5) ** 2)
    die.set_pts(np.array([0.5 + s, bottom + t * (1.5 - bottom)]))
    for mesh, sign in ((slab, 1.0), (die, -1.0)):
        # The die's lower facets are at most 30° from the horizontal.
        mesh.set_region(TOUCH, mesh.outer_faces_with_direction([0.0, sign], 0.6))
        mesh.set_region(HELD, mesh.outer_faces_with_direction([0.0, -sign], 0.01))
    return slab, die


def diameters(mesh, fixed):
    """The diameter of each cell, or this length for all."""
    space = gf.MeshFem(mesh, 1)
    space.set_fem(gf.Fem("FEM_QK(2,0)"))
    values = np.zeros(space.nbdof())
    for cell in mesh.cvid():
        corners = mesh.pts(mesh.pid_from_cvid(cell)[0]).T
        far = max(math.dist(a, b) for a in corners for b in corners)
        values[space.basic_dof_from_cvid(cell)[0]] = fixed or far
    return space, values


def draw(n, degree, length=None, points=None, rays="to_slab"):
    """Forces on the die's top, across and along, at the places of the way, and Newton steps of each load."""
    slab, die = bodies(n)
    model = gf.Model("real")
    spaces, full = {}, None
    for name, mesh in (("u", die), ("w", slab)):
        spaces[name] = gf.MeshFem(mesh, 2)
        spaces[name].set_classical_fem(degree)
        model.add_fem_variable(name, spaces[name])
        inside = gf.MeshIm(mesh, 2 * degree + 2)
        strain = f"(Id(2)+Grad_{name})"
        stress = f"(mu*({strain}-Inv({strain})')+lambda*log(Det({strain}))*Inv({strain})')"
        if name == "u":
            model.add_initialized_data("mu", MU)
            model.add_initialized_data("lambda", LAMBDA)
            own = stress
        model.add_nonlinear_term(inside, f"{stress}:Grad_Test_{name}")
    model.add_initialized_fem_data("h", *diameters(die, length))
    model.add_initialized_data("gamma", 10 * YOUNG)
    model.add_raytracing_transformation(rays, 1.0)
    model.add_master_contact_boundary_to_raytracing_transformation(rays, slab, "w", TOUCH)
    model.add_slave_contact_boundary_to_raytracing_transformation(rays, die, "u", TOUCH)
    normal = "Transformed_unit_vector(Grad_u, Normal)"
    gap = f"({normal}.(Interpolate(X,{rays})+Interpolate(w,{rays})-X-u))"
    pressure = f"neg_part(({own}*Normal).{normal}+gamma/h*{gap})"
    term = f"Interpolate_filter({rays}, {pressure}*({normal}.(Test_u-Interpolate(Test_w,{rays}))), 1)"
    rule = 2 * (points or degree + 2) - 1
    model.add_nonlinear_term(gf.MeshIm(die, gf.Integ(f"IM_GAUSS_PARALLELEPIPED(2,{rule})")), term, TOUCH, False, False)

    place = {name: model.interval_of_variable(name)[0] for name in spaces}
    unknowns = model.nbdof()
    held = np.concatenate([place[name] + space.basic_dof_on_region(HELD) for name, space in spaces.items()])
    free = np.setdiff1d(np.arange(unknowns), held)
    tops = [place["u"] + spaces["u"].basic_dof_on_region(HELD)[axis::2] for axis in (0, 1)]
    values = np.zeros(unknowns)
    # The die in contact with the slab, before the first load.
    values[place["u"] + np.arange(1, spaces["u"].nbdof(), 2)] = -DEPTH / DOWN
    ways = [(0.0, -DEPTH * k / DOWN) for k in range(1, DOWN + 1)] + [(k / (ALONG * n), -DEPTH) for k in range(1, ALONG + 1)]
    forces, counts = [], []
    for way in ways:
        change = np.zeros(unknowns)
        for axis in (0, 1):
            change[tops[axis]] = way[axis] - values[tops[axis]]
        first = None
        for iteration in range(1, 41):
            model.to_variables(values)
            model.assembly("build_all")
            matrix = gf.Spmat("copy", model.tangent_matrix())
            matrix.to_csc()
            columns, entries = matrix.csc_ind()
            full = scipy.sparse.csc_matrix((matrix.csc_val(), entries, columns), shape=(unknowns, unknowns))
            right = model.rhs() - full @ change
            step = change.copy()
            step[free] = scipy.sparse.linalg.spsolve(full[free][:, free], right[free])
            values = values + step
            change[:] = 0
            first = first or np.linalg.norm(step)
            if np.linalg.norm(step) < 1e-10 * np.linalg.norm(values):
                break
        else:
            raise ArithmeticError(f"no convergence at {way}")
        model.to_variables(values)
        model.assembly("build_rhs")
        residual = -model.rhs()
        forces.append([residual[top].sum() for top in tops])
        counts.append(iteration)
    return unknowns, np.array(forces), counts


def measured(forces):
    along, across = forces[DOWN - 1:].T
    across = np.abs(across)
    return {"mean F_y": across.mean(), "(max − min)/mean of F_y": np.ptp(across) / across.mean(), "largest |F_x|/F_y": np.max(np.abs(along) / across)}


if "sweep" in sys.argv:
    for length in (None, 0.25, 0.2, 0.1):
        for points in (2, 3, 4, 5, 10, 20):
            try:
                _, forces, counts = draw(4, 1, length, points)
                found = measured(forces)
                print(length or "diameter", points, *(f"{value:.5f}" for value in found.values()), sum(counts), flush=True)
            except ArithmeticError as why:
                print(length or "diameter", points, why, flush=True)
else:
    for degree in (1, 2):
        for level in (0, 1):
            start = time.perf_counter()
            unknowns, forces, counts = draw(4 << level, degree)
            row("drawn_die", "GetFEM, Nitsche θ = 0, points of whole facets", degree, level, unknowns, time.perf_counter() - start, measured(forces), newton=counts)
