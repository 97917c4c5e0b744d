"""The hollow cylinder's direct problem (14) in GetFEM with MUMPS: same mesh, elements and quadrature, undamped Newton.

usage: cylinder_getfem.py RADIAL [THETA] [GAMMA0_OVER_E]      (Debian: python3-getfem; GetFEM 5.4)

Prints a line of JSON. Mesh and spaces are not in the time. The matrix of the linear terms is assembled once, as GetFEM
does where it knows that terms are linear; each step assembles the contact term and factors the whole tangent.
"""

import json
import resource
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "getfem"))
import getfem as gf
import numpy as np
from cylinder import BULK_U, CONTACT, CONTACT_U, FORCE, INNER_CIRCLE, LAMBDA, MU, PRESCRIBED, TOLERANCE, YOUNG, Cylinder

gf.util("trace level", 0)
radial = int(sys.argv[1])
theta = float(sys.argv[2]) if len(sys.argv) > 2 else -1.0
factor = float(sys.argv[3]) if len(sys.argv) > 3 else 10.0
problem = Cylinder(radial)
print("mesh and spaces are ready", file=sys.stderr, flush=True)

began, cpu_began = time.perf_counter(), time.process_time()
model = gf.Model("real")
model.add_fem_variable("u", problem.displacement)
for name, value in {"lambda": LAMBDA, "mu": MU, "theta": theta}.items():
    model.add_initialized_data(name, value)
model.add_initialized_data("ny", [0.0, -1.0])
model.add_initialized_data("prescribed", list(PRESCRIBED))
model.add_initialized_fem_data("gamma", problem.constant, factor * YOUNG / problem.diameters)
model.add_linear_term(problem.integration, BULK_U)
split = CONTACT_U.index("-1/gamma*neg_part")
model.add_linear_term(problem.integration, CONTACT_U[:split], CONTACT)
model.add_nonlinear_term(problem.integration, CONTACT_U[split:], CONTACT)
model.add_Dirichlet_condition_with_simplification("u", INNER_CIRCLE, "prescribed")
# u = 0 with the prescribed values imposed is the start; the first residual is measured there.
start = np.zeros(problem.unknowns)
for component, value in enumerate(PRESCRIBED):
    start[component::2][problem.fixed[component::2]] = value
model.set_variable("u", start)
model.assembly("build_rhs")
first = np.linalg.norm(model.rhs()[problem.free])
made = time.perf_counter() - began
print(f"model assembled in {made:.1f} s, first residual {first:.3e}", file=sys.stderr, flush=True)

# Undamped Newton, by GetFEM's own driver; it stops at a residual relative to this one.
steps, _ = model.solve("max_res", TOLERANCE * first, "max_iter", 40, "lsolver", "mumps", "lsearch", "simplest",
                       "alpha min", 1.0, "alpha mult", 0.5, "alpha max ratio", 1e30)
seconds, cpu_seconds = time.perf_counter() - began, time.process_time() - cpu_began
u = model.variable("u")
model.assembly("build_rhs")
residual = float(np.linalg.norm(model.rhs()[problem.free]) / first)
J = problem.assemble(0, f"{FORCE}.u", -1, u)
print(json.dumps({
    "version": gf.getfem_env("version"),
    "unknowns": int(problem.unknowns),
    "seconds": seconds,
    "cpu_seconds": cpu_seconds,
    "steps": int(steps),
    "relative_residual": residual,
    "J": float(np.asarray(J).ravel()[0]),
    "peak_gib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20,
}))
