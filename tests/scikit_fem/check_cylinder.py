"""Solve the hollow cylinder with scikit-fem and compare with GetFEM's numbers.

    python tests/scikit_fem/check_cylinder.py                # n_r = 2, 4
    python tests/scikit_fem/check_cylinder.py --radial 2 8

Reads ``tests/getfem/cylinder.json``; exits non-zero on a difference. The two
programs share neither code nor conventions, only the problem.
"""
import argparse
import json
import sys
from pathlib import Path

import numpy as np
from scipy.sparse.linalg import splu

import meshes
from discretisation import Discretisation
from nitsche import Contact, elasticity

COMMITTED = Path(__file__).parent.parent / "getfem" / "cylinder.json"


def solve(case, young, poisson, extension):
    """All scalars and point values of one run, under the names of the JSON file."""
    lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    shear = young / (2 * (1 + poisson))
    mesh = meshes.annulus(case["radial"], 16 * case["radial"])
    space = Discretisation(mesh, 2, 2)
    facets = mesh.facets_where(lambda x: (np.hypot(*x) > 25 + 10 / 4) & (x[1] < 0))
    contact = Contact(
        space, space.facets(facets), mesh.diameters(), lame, shear,
        case["gamma0_over_young"] * young, case["theta"], np.array([0.0, -30.0]), np.array([0.0, -1.0]),
    )
    bulk = space.matrix(elasticity, space.cells, lame=lame, shear=shear)
    clamped = np.hypot(*space.positions.T) < 20 + 1e-9
    u = np.where(np.repeat(clamped, 2), np.tile([0.0, -1.0], len(clamped)), 0.0)
    free = np.flatnonzero(~np.repeat(clamped, 2))

    iterations, start = 0, None
    while True:
        residual = (bulk @ u + contact.residual(u))[free]
        start = np.linalg.norm(residual) if start is None else start
        if np.linalg.norm(residual) <= 1e-10 * start:
            break
        tangent = (bulk + contact.tangent(u))[free][:, free].tocsc()
        u[free] -= splu(tangent).solve(residual)
        iterations += 1
        if iterations > 40:
            raise RuntimeError("Newton's method did not converge")

    force = space.vector(lambda v, w: -v[1], space.cells)      # F . v
    xi = extension * np.sqrt(contact.diameter)
    adjoint = {}
    for name, terms in [
        ("discrete", contact.discrete_adjoint(u)),
        ("consistent", contact.consistent_adjoint(u)),
        ("extended", contact.consistent_adjoint(u, xi)),
    ]:
        p = np.zeros(space.size)
        p[free] = splu((bulk + terms)[free][:, free].tocsc()).solve(-force[free])
        adjoint[name] = p

    report = {
        "unknowns": space.size, "newton_iterations": iterations, "J": float(force @ u),
        "contact_force": contact.force(u), "contact_length": contact.length(u),
        "max_penetration": penetration(space, mesh.local_facets(facets), u),
    }
    report["u_l2"], report["u_h1"] = norms(space, u)
    for name, p in adjoint.items():
        report[f"p_{name}_l2"], report[f"p_{name}_h1"] = norms(space, p)
    report["points"] = []
    for point in case["points"]:
        node = int(np.hypot(*(space.positions - point["x"]).T).argmin())
        values = {"x": space.positions[node], "u": u[2 * node:2 * node + 2]}
        values["p"] = adjoint["consistent"][2 * node:2 * node + 2]
        report["points"].append({key: value.tolist() for key, value in values.items()})
    return report


def norms(space, u):
    """Full L2 and H1 norms."""
    field = space.interpolate(space.cells, u)
    l2 = np.sum(np.sum(field**2, axis=0) * space.cells.dx)
    h1 = np.sum(np.sum(field.grad**2, axis=(0, 1)) * space.cells.dx)
    return float(np.sqrt(l2)), float(np.sqrt(l2 + h1))


def penetration(space, facets, u):
    """The largest u_n - g at 21 uniform points per facet: evaluated, not interpolated."""
    s = np.linspace(0, 1, 21)
    shape = np.array([(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)])
    where = {tuple(np.round(x, 9)): k for k, x in enumerate(space.positions)}
    largest = -np.inf
    for cell, local in facets:
        nodes = space.mesh.cells[cell]
        x = space.mesh.nodes[[nodes[local], nodes[4 + local], nodes[(local + 1) % 4]]]
        numbers = np.array([where[tuple(np.round(point, 9))] for point in x])
        largest = max(largest, np.max(-(u[2 * numbers + 1] @ shape) - (x[:, 1] @ shape + 30)))
    return float(largest)


def compare(case, report):
    """The largest relative difference over all numbers, and the number's name."""
    worst = 0.0, "none"
    for name, value in report.items():
        if name in ("unknowns", "newton_iterations"):
            if value != case[name]:
                return 1.0, name
        elif name == "points":
            for ours, theirs in zip(value, case[name]):
                for key in ("x", "u", "p"):
                    difference = np.abs(np.subtract(ours[key], theirs[key])).max()
                    worst = max(worst, (difference / np.abs(theirs[key]).max(), f"{key} at {theirs['x']}"))
        else:
            # The penetration is a difference of lengths near 1 cm, the imposed displacement.
            scale = 1.0 if name == "max_penetration" else abs(case[name])
            worst = max(worst, (abs(value - case[name]) / scale, name))
    return worst


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--radial", type=int, nargs="+", default=[2, 4])
    arguments = parser.parse_args()
    committed = json.loads(COMMITTED.read_text())
    failed = False
    for case in committed["runs"]:
        if case["radial"] in arguments.radial:
            report = solve(case, committed["young"], committed["poisson"], committed["xi_constant"])
            difference, name = compare(case, report)
            failed |= difference > 1e-11
            print(f"n_r = {case['radial']:2}, theta = {case['theta']:4}: J = {report['J']:.12f}, "
                  f"largest relative difference {difference:.1e} ({name})", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
