"""Two bodies in contact in GetFEM: Nitsche's method at large sliding, by its raytracing transformation.

usage: bodies_getfem.py FILE term|solve [--samples N]      (Debian: python3-getfem; GetFEM 5.4)

FILE is what `src/bodies.rs` writes: meshes of two bodies, constants, what is prescribed. `term` times residual and tangent of the contact term
alone, `solve` a whole solve by GetFEM's Newton with MUMPS. Prints a line of JSON; times are those of the processor.
"""

import argparse
import json
import time

import getfem as gf
import numpy as np

gf.util("trace level", 0)
parser = argparse.ArgumentParser()
parser.add_argument("file")
parser.add_argument("what", choices=["term", "solve"])
parser.add_argument("--samples", type=int, default=3)
options = parser.parse_args()
with open(options.file) as file:
    case = json.load(file)
dimension = case["dimension"]
OWN, OPPOSITE, HELD = 1, 1, 2
# The fastest that converges. In space with friction "simplest" goes round in circles where residuals may rise ("alpha max ratio" 1.2, 2), and takes 12
# and 15 steps (6 and 8 cells along the slab) where they may not; "systematic" takes 11. In the plane both take 9, and "simplest" a tenth less time.
LINE_SEARCH = {2: "simplest", 3: "systematic"}


def body(part, contact, held):
    """A mesh of simplices; its surface of contact looks along `contact`, the held one along `held`, both times the last axis."""
    nodes, cells = np.array(part["nodes"]), np.array(part["cells"]).reshape(-1, dimension + 1)
    mesh = gf.Mesh("empty", dimension)
    mesh.add_convex(gf.GeoTrans(f"GT_PK({dimension},1)"), nodes[cells].transpose(2, 1, 0))
    for region, sign in [(OWN, contact), (HELD, held)]:
        mesh.set_region(region, mesh.outer_faces_with_direction([0.0] * (dimension - 1) + [float(sign)], 0.1))
    return mesh


slab, block = body(case["bodies"][0], 1, -1), body(case["bodies"][1], -1, 1)
spaces = {}
for name, mesh in [("u1", slab), ("u2", block)]:
    spaces[name] = gf.MeshFem(mesh, dimension)
    spaces[name].set_classical_fem(2)
# The method on cells whose rule on facets has the degree asked for; in the plane that of Gauss with three points.
on_facets = gf.MeshIm(slab, gf.Integ("IM_TRIANGLE(5)" if dimension == 2 else "IM_TETRAHEDRON(5)"))


def new_model():
    model = gf.Model("real")
    for name, space in spaces.items():
        model.add_fem_variable(name, space)
    for name in ["lambda", "mu", "gamma"]:
        model.add_initialized_data(name, case[name])
    model.add_raytracing_transformation("to_block", 0.2)
    model.add_master_contact_boundary_to_raytracing_transformation("to_block", block, "u2", OPPOSITE)
    model.add_slave_contact_boundary_to_raytracing_transformation("to_block", slab, "u1", OWN)
    normal = "Transformed_unit_vector(Grad_u1, Normal)"
    stress = f"(((lambda*Trace(Grad_u1))*Id({dimension}) + 2*mu*Sym(Grad_u1))*Normal)"
    gap = f"({normal}.(Interpolate(X,to_block) + Interpolate(u2,to_block) - X - u1))"
    if case["kappa"] is None:
        traction = f"(-neg_part({stress}.{normal} + gamma*{gap})*{normal})"
    else:
        model.add_initialized_data("kappa", [case["kappa"]])
        slip = "(u1 - Interpolate(u2,to_block))"
        traction = f"Coulomb_friction_coupled_projection({stress},{normal},{slip},{gap},kappa,gamma)"
    term = f"Interpolate_filter(to_block, -{traction}.(Test_u1 - Interpolate(Test_u2,to_block)), 1)"
    model.add_nonlinear_term(on_facets, term, OWN, False, False)
    return model


def norm(values):
    return float(np.linalg.norm(values))


def report(**more):
    unknowns = sum(space.nbdof() for space in spaces.values())
    version = gf.getfem_env("version") if hasattr(gf, "getfem_env") else "5.4"
    print(json.dumps({"program": f"GetFEM {version}", "unknowns": unknowns, "facets": int(slab.region(OWN).shape[1]), **more}))


def measure_term():
    model = new_model()
    for name, space in spaces.items():
        x, count = space.basic_dof_nodes(), space.nbdof()
        along, height, component = x[0], x[dimension - 1], np.arange(count) % dimension
        values = np.where(component == 0, 0.5 * height, 0.0)
        model.set_variable(name, np.where(component == dimension - 1, 0.01 * (along - 0.5) * height, values))
    seconds = {"build_rhs": [], "build_matrix": []}
    for _ in range(options.samples):
        for option, list_ in seconds.items():
            start = time.process_time()
            model.assembly(option)
            list_.append(time.process_time() - start)
    matrix = gf.Spmat("copy", model.tangent_matrix())
    matrix.to_csc()
    report(residual=seconds["build_rhs"], tangent=seconds["build_matrix"], norms=[norm(model.rhs()), norm(matrix.csc_val())])


def measure_solve():
    seconds, steps = [], 0
    for _ in range(options.samples):
        start = time.process_time()
        model = new_model()
        push = [0.0] * dimension
        push[0], push[-1] = case["push"]
        for name, value in [("u1", [0.0] * dimension), ("u2", push)]:
            # Quadratic on straight simplices: a rule of degree 2 is exact.
            method = gf.MeshIm(slab if name == "u1" else block, 2)
            stress = f"((lambda*Trace(Grad_{name}))*Id({dimension}) + 2*mu*Sym(Grad_{name}))"
            model.add_linear_term(method, f"{stress}:Grad_Test_{name}")
            model.add_initialized_data(f"held_{name}", value)
            model.add_Dirichlet_condition_with_simplification(name, HELD, f"held_{name}")
            held, values = spaces[name].basic_dof_on_region(HELD), np.zeros(spaces[name].nbdof())
            values[held] = np.array(value)[held % dimension]
            model.set_variable(name, values)
        model.assembly("build_rhs")
        free = [np.setdiff1d(np.arange(space.nbdof()), space.basic_dof_on_region(HELD)) for space in spaces.values()]
        rhs = [model.rhs()[model.interval_of_variable(name)[0]:][: space.nbdof()] for name, space in spaces.items()]
        first = norm(np.concatenate([part[indices] for part, indices in zip(rhs, free)]))
        steps, converged = model.solve("max_res", 1e-10 * first, "max_iter", 100, "lsolver", "mumps", "lsearch", LINE_SEARCH[dimension],
                                       "alpha min", 0.01, "alpha mult", 0.5, "alpha max ratio", 1.0)
        seconds.append(time.process_time() - start)
        if not converged:
            raise SystemExit(f"GetFEM's Newton method did not converge in {steps} steps")
    u = np.concatenate([model.variable(name) for name in spaces])
    report(solve=seconds, steps=int(steps), norms=[norm(u)])


measure_term() if options.what == "term" else measure_solve()
