"""The contact term of two bodies in GetFEM: Nitsche's method at large sliding, by its raytracing transformation.

usage: pairs_getfem.py CELLS [space] [friction]      (Debian: python3-getfem; GetFEM 5.4)

Two blocks on meshes that do not match, quadratic displacements on triangles or tetrahedra, a rule of degree 4. Prints a line of JSON: own facets,
and the seconds of one tangent and of one residual of the contact term alone, the least of five.
"""

import json
import sys
import time

import getfem as gf
import numpy as np

gf.util("trace level", 0)
cells = int(sys.argv[1])
dimension = 3 if "space" in sys.argv[2:] else 2


def block(count, below):
    """A unit block of simplices; its surface of contact is region 1."""
    steps = [np.arange(0, 1 + 0.5 / count, 1 / count)] * (dimension - 1)
    height = np.arange(-1, 0.25, 0.5) if below else np.arange(0, 1.25, 0.5)
    mesh = gf.Mesh("regular simplices", *steps, height)
    normal = [0.0] * (dimension - 1) + [1.0 if below else -1.0]
    mesh.set_region(1, mesh.outer_faces_with_direction(normal, 0.1))
    return mesh


rule = "IM_TRIANGLE(4)" if dimension == 2 else "IM_TETRAHEDRON(5)"
lower, upper = block(cells, True), block(cells * 7 // 10, False)
model = gf.Model("real")
integration = {}
for name, mesh in [("u1", lower), ("u2", upper)]:
    space = gf.MeshFem(mesh, dimension)
    space.set_classical_fem(2)
    model.add_fem_variable(name, space)
    integration[name] = gf.MeshIm(mesh, gf.Integ(rule) if dimension == 2 else 5)
    height = space.basic_dof_nodes()[dimension - 1]
    along = space.basic_dof_nodes()[0]
    last = np.arange(space.nbdof()) % dimension == dimension - 1
    model.set_variable(name, np.where(last, 0.01 * (along - 0.5) * height + (0.002 if name == "u1" else 0.0), 0.0))
for name, value in {"lambda": 100.0, "mu": 80.0, "gamma": 2e4 * cells}.items():
    model.add_initialized_data(name, value)

model.add_raytracing_transformation("to_upper", 0.2)
model.add_master_contact_boundary_to_raytracing_transformation("to_upper", upper, "u2", 1)
model.add_slave_contact_boundary_to_raytracing_transformation("to_upper", lower, "u1", 1)
NORMAL = "Transformed_unit_vector(Grad_u1, Normal)"
STRESS = f"(((lambda*Trace(Grad_u1))*Id({dimension}) + 2*mu*Sym(Grad_u1))*Normal)"
GAP = f"({NORMAL}.(Interpolate(X,to_upper) + Interpolate(u2,to_upper) - X - u1))"
if "friction" in sys.argv[2:]:
    model.add_initialized_data("coefficient", [0.3])
    SLIP = "(u1 - Interpolate(u2,to_upper))"
    TRACTION = f"Coulomb_friction_coupled_projection({STRESS},{NORMAL},{SLIP},{GAP},coefficient,gamma)"
else:
    TRACTION = f"(-neg_part({STRESS}.{NORMAL} + gamma*{GAP})*{NORMAL})"
TERM = f"Interpolate_filter(to_upper, -{TRACTION}.(Test_u1 - Interpolate(Test_u2,to_upper)), 1)"
model.add_nonlinear_term(integration["u1"], TERM, 1, False, False)


def least(option):
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        model.assembly(option)
        seconds.append(time.perf_counter() - start)
    return min(seconds)


residual, tangent = least("build_rhs"), least("build_matrix")
print(json.dumps({
    "facets": int(lower.region(1).shape[1]),
    "pressure": float(np.abs(model.rhs()).sum()),
    "residual": residual,
    "tangent": tangent,
    "entries": int(model.tangent_matrix().nnz()),
}))
