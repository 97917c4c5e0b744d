"""Shallow ironing by GetFEM: a stiff rounded block pressed into a soft foundation and drawn along it with Coulomb's friction, at finite
strains (the benchmark of Fischer and Wriggers 2006; Poulios and Renard 2015).

usage: shallow_ironing.py [FINENESS] [STEPS OF PRESSING] [STEPS OF SLIDING]      (Debian: python3-getfem; GetFEM 5.4)

Plane strain, the energy W = mu/2 (tr C - 2 - 2 ln J) + lambda/2 (ln J)^2 per reference volume, written as P in the weak form; bilinear
quadrilaterals. Contact is the augmented Lagrangian of Poulios and Renard with rays along the deformed normal of the foundation's top,
which has continuous piecewise linear multipliers. A fineness of 4 is the benchmark's mesh, a step of sliding is a fifth of a millimetre.
Writes shallow_ironing.json next to this file: the forces after each step.
"""

import json
import pathlib
import sys

import getfem as gf
import numpy as np

gf.util("trace level", 0)
given = [int(argument) for argument in sys.argv[1:]]
fineness, pressing, sliding = (given + [4, 8, 25][len(given):])[:3]
YOUNG, POISSON, FRICTION = 689.6, 0.32, 0.3
BOTTOM, TOP, SKIN = 1, 2, 3
SMALLEST = 1.0 / 64


def grid(columns, rows, place):
    """A mesh of quadrilaterals on the unit square's grid, each point put at its place."""
    mesh = gf.Mesh("cartesian", np.arange(columns + 1) / columns, np.arange(rows + 1) / rows)
    mesh.set_pts(np.array([place(s, t) for s, t in mesh.pts().T]).T)
    return mesh


def in_block(s, t):
    x = 0.2 + 1.2 * s
    bottom = 4.95 - np.sqrt(0.75**2 - (x - 0.8) ** 2)
    return x, bottom + t * (5.4 - bottom)


foundation = grid(30 * fineness, 15 * fineness // 2, lambda s, t: (12 * s, 4 * t))
block = grid(3 * fineness, 3 * fineness // 2, in_block)
for mesh, ends in [(foundation, (0.0, 4.0)), (block, (None, 5.4))]:
    faces = mesh.outer_faces()
    heights = [mesh.pts(mesh.pid_in_faces(faces[:, k])) for k in range(faces.shape[1])]
    at = lambda y: np.array([y is not None and bool(np.all(abs(points[1] - y) < 1e-9)) for points in heights])
    mesh.set_region(BOTTOM, faces[:, at(ends[0])])
    mesh.set_region(TOP, faces[:, at(ends[1])])
    mesh.set_region(SKIN, faces[:, ~at(ends[1])])

model = gf.Model("real")
spaces, rules = {}, {}
for name, mesh, young in [("u", foundation, YOUNG), ("w", block, 10 * YOUNG)]:
    spaces[name] = gf.MeshFem(mesh, 2)
    spaces[name].set_classical_fem(1)
    rules[name] = gf.MeshIm(mesh, gf.Integ("IM_GAUSS_PARALLELEPIPED(2,6)"))
    model.add_fem_variable(name, spaces[name])
    model.add_fem_data(name + "_before", spaces[name])
    model.add_initialized_data("mu_" + name, young / (2 * (1 + POISSON)))
    model.add_initialized_data("lambda_" + name, young * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)))
    F = f"(Id(2)+Grad_{name})"
    model.add_nonlinear_term(
        rules[name],
        f"(mu_{name}*({F}-Inv({F})') + lambda_{name}*log(Det({F}))*Inv({F})'):Grad_Test_{name}",
    )

multipliers = gf.MeshFem(foundation, 2)
multipliers.set_classical_fem(1)
model.add_filtered_fem_variable("l", multipliers, TOP)
model.add_initialized_data("r", 10 * YOUNG)
model.add_initialized_data("friction", FRICTION)
model.add_raytracing_transformation("opposite", 0.4)
model.add_slave_contact_boundary_to_raytracing_transformation("opposite", foundation, "u", TOP)
model.add_master_contact_boundary_to_raytracing_transformation("opposite", block, "w", SKIN)
NORMAL = "Transformed_unit_vector(Grad_u, Normal)"
GAP = f"({NORMAL}.(Interpolate(X,opposite)+Interpolate(w,opposite)-X-u))"
SLIP = "(u-u_before-Interpolate(w,opposite)+Interpolate(w_before,opposite))"
TRACTION = f"Coulomb_friction_coupled_projection(l, {NORMAL}, {SLIP}, {GAP}, friction, r)"
model.add_nonlinear_term(rules["u"], "-l.Test_u", TOP)
model.add_nonlinear_term(rules["u"], "Interpolate_filter(opposite, l.Interpolate(Test_w,opposite), 1)", TOP)
model.add_nonlinear_term(rules["u"], "-(1/r)*l.Test_l", TOP)
model.add_nonlinear_term(rules["u"], f"Interpolate_filter(opposite, (1/r)*{TRACTION}.Test_l, 1)", TOP)

model.add_initialized_data("still", [0.0, 0.0])
model.add_initialized_data("top", [0.0, 0.0])
model.add_Dirichlet_condition_with_simplification("u", BOTTOM, "still")
model.add_Dirichlet_condition_with_simplification("w", TOP, "top")


def force():
    """Vertical and horizontal force of the block on the foundation, downward and along."""
    upward = gf.asm_generic(rules["u"], 0, "l(2)", TOP, model)
    along = gf.asm_generic(rules["u"], 0, "l(1)", TOP, model)
    return -float(upward), float(along)


def top(way):
    return [10 * max(way - 1, 0), -min(way, 1)]


ways = [(k + 1) / pressing for k in range(pressing)] + [1 + 0.02 * (k + 1) for k in range(sliding)]
curve, now, part = [{"way": 0.0, "down": 0.0, "along": 0.0}], 0.0, 1.0
for aim in ways:
    whole, start = aim - now, now
    while now < aim - 1e-12:
        goal = min(now + part * whole, aim)
        before = {name: model.variable(name) for name in ["u", "w", "l"]}
        model.set_variable("u_before", before["u"])
        model.set_variable("w_before", before["w"])
        model.set_variable("top", top(goal))
        try:
            steps = model.solve("max_res", 1e-9 * YOUNG, "max_iter", 40, "lsearch", "simplest", "alpha min", 0.2)[0]
        except RuntimeError:
            steps = 40
        if steps >= 40 or not np.all(np.isfinite(model.variable("u"))):
            for name, values in before.items():
                model.set_variable(name, values)
            part /= 2
            if part < SMALLEST:
                sys.exit(f"no solution from {now} to {goal}")
            continue
        now, part = goal, min(1.0, 2 * part)
        down, along = force()
        print(f"way {now:.4f}: {steps:2} Newton steps, force {down:8.3f} down, {along:8.3f} along [N/mm]", flush=True)
        curve.append({"way": round(now, 12), "down": down, "along": along})

result = {"fineness": fineness, "friction": FRICTION, "getfem": "5.4.2", "curve": curve}
if fineness == 4:
    pathlib.Path(__file__).with_suffix(".json").write_text(json.dumps(result, indent=1) + "\n")
