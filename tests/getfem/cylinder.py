"""The hollow cylinder pressed on a flat obstacle, solved with GetFEM 5.4.2.

This script is an outside judge of the Rust code: it shares no line with it. It
solves the direct problem (Nitsche's method for contact without friction), the
discrete, consistent and extended adjoint problems on structured polar meshes,
and writes the numbers to ``cylinder.json`` next to this file.

    python3 tests/getfem/cylinder.py            # n_r = 2, 4, 8, 16, 32
    python3 tests/getfem/cylinder.py --radial 2 4 --output FILE

Lengths are in cm, stresses in MPa, forces in MPa cm, as entered. The mesh, the
parameter gamma = gamma0 / h_T and xi = C sqrt(h_T) are made here and handed to
GetFEM as data; GetFEM's own ``element_size`` is not used.
"""
import argparse
import json
import time
from pathlib import Path

import getfem as gf
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

INNER, OUTER = 20.0, 30.0
YOUNG, POISSON = 100.0, 0.3
LAMBDA = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
MU = YOUNG / (2 * (1 + POISSON))
PRESCRIBED = (0.0, -1.0)          # u_D on the inner circle, cm
FORCE = "[0;-1]"                  # F of the criterion M(u) = F.u
EXTENSION = 1.0                   # C in xi = C sqrt(h_T)
TOLERANCE = 1e-10                 # relative residual of Newton's method
PROBES = [(0.0, -25.0), (25.0, 0.0), (0.0, 25.0)]
INNER_CIRCLE, CONTACT = 1, 2      # GetFEM region numbers

# Strings of GetFEM's weak form language. `ny` points into the obstacle.
STRESS = "(lambda*Trace(Grad_{0})*Id(2)+mu*(Grad_{0}+Grad_{0}'))"
SIGMA_N = "((" + STRESS + "*Normal).ny)"
GAP = "(X(2)+30)"


def stress_normal(field):
    return SIGMA_N.format(field)


BULK_U = STRESS.format("u") + ":Grad_Test_u"
INDICATOR = f"(gamma*(u.ny-{GAP})-{stress_normal('u')})"
# (14)-(15), with the minus sign before the negative part.
CONTACT_U = (
    f"-theta/gamma*{stress_normal('u')}*{stress_normal('Test_u')}"
    f"-1/gamma*neg_part({stress_normal('u')}-gamma*(u.ny-{GAP}))"
    f"*(theta*{stress_normal('Test_u')}-gamma*(Test_u.ny))"
)
BULK_P = STRESS.format("p") + ":Grad_Test_p"
NITSCHE_P = f"-theta/gamma*{stress_normal('p')}*{stress_normal('Test_p')}"
DISCRETE = NITSCHE_P + (                                         # (21)
    f"+1/gamma*Heaviside({INDICATOR})*({stress_normal('Test_p')}-gamma*(Test_p.ny))"
    f"*(theta*{stress_normal('p')}-gamma*(p.ny))"
)
CONSISTENT = NITSCHE_P + (                                       # (22), N = 0
    f"+1/gamma*Heaviside({INDICATOR})*({stress_normal('p')}-gamma*(p.ny))"
    f"*(theta*{stress_normal('Test_p')}-gamma*(Test_p.ny))"
)
EXTENDED = CONSISTENT.replace(INDICATOR, f"({INDICATOR}-xi)")    # (41)


class Cylinder:
    """Mesh, spaces and data for one number of radial cells."""

    def __init__(self, radial):
        self.mesh = polar_mesh(radial)
        self.displacement = gf.MeshFem(self.mesh, 2)
        self.displacement.set_fem(gf.Fem("FEM_QK(2,2)"))
        self.constant = gf.MeshFem(self.mesh, 1)
        self.constant.set_fem(gf.Fem("FEM_QK(2,0)"))
        self.integration = gf.MeshIm(self.mesh, gf.Integ("IM_GAUSS_PARALLELEPIPED(2,8)"))
        self.positions = self.displacement.basic_dof_nodes()     # 2 x dofs
        self.unknowns = self.displacement.nbdof()

        facets = self.mesh.outer_faces()
        inner, contact = [], []
        for cell, face in facets.T:
            on_face = self.mesh.pts()[:, self.mesh.pid_in_faces([[cell], [face]])]
            radius = np.hypot(*on_face)
            if np.allclose(radius, INNER, atol=1e-9):
                inner.append((cell, face))
            elif np.allclose(radius, OUTER, atol=1e-9):
                if on_face[1].mean() < 0:
                    contact.append((cell, face))
            else:
                raise RuntimeError(f"facet {face} of cell {cell} is on no circle")
        self.contact_facets = contact
        self.mesh.set_region(INNER_CIRCLE, np.array(inner).T)
        self.mesh.set_region(CONTACT, np.array(contact).T)

        # One diameter per cell: the largest distance between two vertices.
        self.diameters = np.zeros(self.constant.nbdof())
        for cell in self.mesh.cvid():
            corners = self.mesh.pts_from_cvid(cell)[0][:, [0, 2, 6, 8]]
            distance = corners[:, :, None] - corners[:, None, :]
            dof = self.constant.basic_dof_from_cvid(cell)[0]
            self.diameters[dof] = np.sqrt((distance**2).sum(axis=0).max())

        clamped = self.displacement.basic_dof_on_region(INNER_CIRCLE)
        self.fixed = np.zeros(self.unknowns, dtype=bool)
        self.fixed[clamped] = True
        self.free = np.flatnonzero(~self.fixed)

    def assemble(self, order, expression, region, u, p=None, **data):
        """Assemble with GetFEM: 0 a number, 1 a vector, 2 a SciPy matrix.

        With `p` given, `p` is the variable and `u` data, else `u` is the variable.
        """
        arguments = ["u", int(p is None), self.displacement, u]
        if p is not None:
            arguments += ["p", 1, self.displacement, p]
        constants = dict({"lambda": LAMBDA, "mu": MU, "ny": np.array([0.0, -1.0])}, **data)
        for name, value in constants.items():
            if name in ("gamma", "xi"):
                arguments += [name, 0, self.constant, value]
            else:
                arguments += [name, 0, np.atleast_1d(np.array(value, dtype=float))]
        result = gf.asm_generic(self.integration, order, expression, region, *arguments)
        if order < 2:
            return result
        row_pointers, indices = result.csc_ind()
        size = self.unknowns
        return sp.csc_matrix((result.csc_val(), indices, row_pointers), shape=(size, size))


def polar_mesh(radial):
    """n_r x 16 n_r quadrilaterals of degree 2; all nodes uniform in r and angle."""
    mesh = gf.Mesh("empty", 2)
    around = 16 * radial
    transformation = gf.GeoTrans("GT_QK(2,2)")
    # The nodes of one cell in GetFEM's order: first reference axis fastest.
    # First axis: radius, second axis: angle, hence positively oriented.
    for i in range(radial):
        for j in range(around):
            points = []
            for b in range(3):
                angle = 2 * np.pi * ((2 * j + b) % (2 * around)) / (2 * around)
                for a in range(3):
                    r = INNER + (OUTER - INNER) * (2 * i + a) / (2 * radial)
                    points.append((r * np.cos(angle), r * np.sin(angle)))
            mesh.add_convex(transformation, np.array(points).T)
    assert mesh.nbpts() == (2 * radial + 1) * 2 * around, mesh.nbpts()
    assert mesh.nbcvs() == radial * around
    return mesh


def solve(problem, theta, gamma0):
    """Newton's method and the three adjoint problems; returns the report."""
    gamma = gamma0 / problem.diameters
    data = {"gamma": gamma, "theta": theta}
    free, fixed = problem.free, problem.fixed

    u = np.zeros(problem.unknowns)
    for component, value in enumerate(PRESCRIBED):
        u[component::2][fixed[component::2]] = value
    bulk = problem.assemble(2, BULK_U, -1, u)

    start, history = None, []
    for iteration in range(40):
        residual = bulk @ u + problem.assemble(1, CONTACT_U, CONTACT, u, **data)
        norm = np.linalg.norm(residual[free])
        start = norm if start is None else start
        history.append(norm / start)
        if norm <= TOLERANCE * start:
            break
        tangent = bulk + problem.assemble(2, CONTACT_U, CONTACT, u, **data)
        tangent = tangent.tocsr()[free][:, free].tocsc()
        u[free] -= splu(tangent).solve(residual[free])
    else:
        raise RuntimeError("Newton's method did not converge")
    tangent = bulk + problem.assemble(2, CONTACT_U, CONTACT, u, **data)

    # The adjoint problems: p is zero on the inner circle, N = 0.
    zero = np.zeros(problem.unknowns)
    right = -problem.assemble(1, f"{FORCE}.Test_u", -1, zero)
    xi = EXTENSION * np.sqrt(problem.diameters)
    adjoint = {}
    for name, form in [("discrete", DISCRETE), ("consistent", CONSISTENT), ("extended", EXTENDED)]:
        extra = {"xi": xi} if name == "extended" else {}
        matrix = bulk + problem.assemble(2, form, CONTACT, u, zero, **data, **extra)
        # Two evaluations by GetFEM of the same matrix must agree.
        expected = {"discrete": tangent.T, "consistent": tangent}.get(name)
        if expected is not None:
            assert abs(matrix - expected).max() < 1e-12 * abs(tangent).max(), name
        p = np.zeros(problem.unknowns)
        p[free] = splu(matrix.tocsr()[free][:, free].tocsc()).solve(right[free])
        adjoint[name] = p

    indicator = f"Heaviside({INDICATOR})"
    pressure = f"neg_part({stress_normal('u')}-gamma*(u.ny-{GAP}))"
    report = {
        "unknowns": int(problem.unknowns),
        "newton_iterations": iteration,
        "newton_relative_residuals": history,
        "J": problem.assemble(0, f"{FORCE}.u", -1, u),
        "u_l2": norm_of(problem, u)[0],
        "u_h1": norm_of(problem, u)[1],
        "contact_force": problem.assemble(0, pressure, CONTACT, u, **data),
        "contact_length": problem.assemble(0, indicator, CONTACT, u, **data),
        "max_penetration": largest_penetration(problem, u),
    }
    for name, p in adjoint.items():
        report[f"p_{name}_l2"], report[f"p_{name}_h1"] = norm_of(problem, p)
    report["points"] = [
        {"x": list(x), "u": value_at(problem, u, x), "p": value_at(problem, adjoint["consistent"], x)}
        for x in PROBES
    ]
    return report


def norm_of(problem, u):
    """The full L2 and H1 norms over all of the body."""
    l2 = problem.assemble(0, "u.u", -1, u)
    h1 = problem.assemble(0, "Grad_u:Grad_u", -1, u)
    return float(np.sqrt(l2)), float(np.sqrt(l2 + h1))


def largest_penetration(problem, u):
    """The largest u_n - g at 21 uniform points on each contact facet."""
    s = np.linspace(0.0, 1.0, 21)
    shape = np.array([(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)])
    largest = -np.inf
    for cell, face in problem.contact_facets:
        dofs = facet_dofs(problem, cell, face)
        x = problem.positions[:, dofs]
        y = x[1] @ shape
        largest = max(largest, float(np.max(-(u[dofs + 1] @ shape) - (y + 30.0))))
    return largest


def facet_dofs(problem, cell, face):
    """The numbers of u_x at the facet's nodes: end, middle, end."""
    assert face == 0                 # GetFEM's face 0 is where the first axis is 1
    return np.asarray(problem.displacement.basic_dof_from_cvid(cell)[0])[::2][[2, 5, 8]]


def value_at(problem, u, x):
    """The value at a point that must be a node of the mesh."""
    distance = np.hypot(*(problem.positions - np.array(x)[:, None]))[::2]
    node = int(distance.argmin())
    assert distance[node] < 1e-9, (x, distance[node])
    return [float(u[2 * node]), float(u[2 * node + 1])]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--radial", type=int, nargs="+", default=[2, 4, 8, 16, 32])
    parser.add_argument("--output", default=str(Path(__file__).with_name("cylinder.json")))
    arguments = parser.parse_args()
    gf.util("trace level", 0)

    runs = []
    for radial in arguments.radial:
        problem = Cylinder(radial)
        cases = [(-1.0, 10.0), (0.0, 10.0), (1.0, 10.0)]
        if radial == 4:
            cases.append((0.5, 20.0))
        for theta, factor in cases:
            began = time.perf_counter()
            report = solve(problem, theta, factor * YOUNG)
            case = {"radial": radial, "theta": theta, "gamma0_over_young": factor}
            runs.append(rounded({**case, **report}))
            print(radial, theta, report["newton_iterations"], f"J={report['J']:.12f}",
                  f"{time.perf_counter() - began:.1f}s", flush=True)
    result = {
        "made_by": "tests/getfem/cylinder.py with GetFEM 5.4.2",
        "young": YOUNG, "poisson": POISSON, "xi_constant": EXTENSION, "runs": runs,
    }
    Path(arguments.output).write_text(json.dumps(result, indent=1) + "\n")


def rounded(value):
    """Floats to 15 significant digits, all through a nested value."""
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(item) for item in value]
    if isinstance(value, (float, np.floating, np.ndarray)):
        return float(f"{float(value):.15g}")
    return value


if __name__ == "__main__":
    main()
