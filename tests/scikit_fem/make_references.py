"""Make the reference files of this folder with scikit-fem, or check them.

    python tests/scikit_fem/make_references.py             # write
    python tests/scikit_fem/make_references.py --check     # make afresh and compare

README.md describes the files. Every tangent is checked here against finite
differences of its residual before anything is written.
"""
import argparse
import json
import sys
from pathlib import Path

import numpy as np

import anisotropic_elasticity
import ghost_penalty
import interior_penalty
import meshes
import mooney_rivlin
import neo_hookean
import p_laplacian
import reference_file
import stokes
from checks import check_tangent, close, symmetric
from discretisation import Discretisation, random_field
from nitsche import Contact, elasticity

FOLDER = Path(__file__).parent
YOUNG, POISSON = 100.0, 0.3
LAME = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
SHEAR = YOUNG / (2 * (1 + POISSON))
BODY_FORCE = np.array([0.3, -0.7])
CRITERION_FORCE = np.array([0.4, -1.0])          # F of M(u) = F . u
CRITERION_BOUNDARY = 3.0                         # c of N(u) = c |u|^2 / 2
MADE_BY = "tests/scikit_fem/make_references.py with scikit-fem 12.0.1"
# Forms whose cases are next to them: a file each, with a function `cases` that gives (case, record).
FORMS = [anisotropic_elasticity, ghost_penalty, interior_penalty, mooney_rivlin, p_laplacian, stokes]


def elasticity_references():
    """The matrix of a(u, v) on every kind of cell."""
    cases = {
        "elasticity_triangle_p1": (meshes.rectangle("triangle", 3, 2, 1), 1),
        "elasticity_triangle_p2": (meshes.rectangle("triangle", 3, 2, 2), 2),
        "elasticity_quadrilateral_q1": (meshes.rectangle("quadrilateral", 3, 2, 3), 1),
        "elasticity_quadrilateral_q2": (meshes.rectangle("quadrilateral", 3, 2, 4), 2),
        "elasticity_annulus_q2": (meshes.annulus(2, 8), 2),
        "elasticity_tetrahedron_p2": (meshes.tetrahedra(5), 2),
        "elasticity_hexahedron_q2": (meshes.hexahedron(6), 2),
    }
    for name, (mesh, degree) in cases.items():
        space = Discretisation(mesh, degree, mesh.nodes.shape[1])
        stiffness = space.matrix(elasticity, space.cells, lame=LAME, shear=SHEAR)
        symmetric(stiffness)
        # Rigid translations and one rotation have no energy.
        rotation = np.zeros(space.size)
        rotation[0::space.components] = -space.positions[:, 1]
        rotation[1::space.components] = space.positions[:, 0]
        assert abs(stiffness @ rotation).max() < 1e-11 * abs(stiffness).max() * abs(rotation).max()
        yield name, {
            "made_by": MADE_BY,
            **space.description(),
            "data": {"lambda": LAME, "mu": SHEAR},
            "matrices": {"stiffness": stiffness},
        }


def nitsche_references():
    """The contact problem and its adjoints at a given state, for three theta."""
    half_ring = meshes.annulus(2, 4, np.pi, 2 * np.pi)
    bottom = lambda x: x[1] < 1e-9
    bottom_and_right = lambda x: (x[1] < 1e-9) | (x[0] > 2 - 1e-9)
    outer = lambda x: (np.hypot(*x) > 27) & (x[1] < -1)       # not the two cuts
    outer_left = lambda x: outer(x) & (x[0] < 15)
    cases = {
        # mesh, contact, boundary of N, obstacle point and normal, |u|, C of xi
        "nitsche_triangle_p2": (meshes.rectangle("triangle", 2, 2, 11), bottom, bottom_and_right,
                                (0.0, -0.01), (0.0, -1.0), 0.05, 40.0),
        "nitsche_quadrilateral_q2": (meshes.rectangle("quadrilateral", 2, 2, 12), bottom, bottom_and_right,
                                     (1.0, -0.02), (0.28, -0.96), 0.05, 40.0),
        "nitsche_annulus_q2": (half_ring, outer_left, outer, (0.0, -24.0), (0.0, -1.0), 5.0, 80.0),
    }
    for seed, (name, (mesh, where, where_n, point, normal, scale, extension)) in enumerate(cases.items()):
        space = Discretisation(mesh, 2, 2)
        contact_facets = mesh.facets_where(where)
        criterion_facets = mesh.facets_where(where_n)
        assert set(contact_facets) < set(criterion_facets)
        u = random_field(space.size, scale, 20 + seed)
        for theta in (-1.0, 0.0, 1.0):
            contact = Contact(
                space, space.facets(contact_facets), mesh.diameters(), LAME, SHEAR,
                10 * YOUNG, theta, np.array(point), np.array(normal),
            )
            sign = {-1.0: "minus_1", 0.0: "0", 1.0: "plus_1"}[theta]
            yield f"{name}_theta_{sign}", {
                "made_by": MADE_BY,
                **space.description(),
                "contact_facets": mesh.local_facets(contact_facets),
                "contact_diameters": contact.diameter[:, 0],
                "criterion_facets": mesh.local_facets(criterion_facets),
                "data": {
                    "lambda": LAME, "mu": SHEAR, "gamma0": 10 * YOUNG, "theta": theta,
                    "obstacle_point": point, "obstacle_normal": normal,
                    "body_force": BODY_FORCE, "criterion_force": CRITERION_FORCE,
                    "criterion_boundary": CRITERION_BOUNDARY, "xi_constant": extension,
                },
                "u": u,
                **nitsche_record(space, contact, space.facets(criterion_facets), u, extension),
            }


def nitsche_record(space, contact, boundary, u, extension):
    """Matrices, vectors and numbers of one Nitsche case, checked against each other."""
    bulk = space.matrix(elasticity, space.cells, lame=LAME, shear=SHEAR)
    load = space.vector(lambda v, w: sum(BODY_FORCE[i] * v[i] for i in range(2)), space.cells)
    tangent = bulk + contact.tangent(u)
    xi = extension * np.sqrt(contact.diameter)
    beta = contact.at(u)[0]
    active, extended = beta > 0, beta > xi
    # Some points of each kind, none so close to the switch that rounding decides.
    assert 0 < extended.sum() < active.sum() < active.size, (extended.sum(), active.sum(), active.size)
    assert min(abs(beta).min(), abs(beta - xi).min()) > 1e-6 * abs(beta).max()

    residual = lambda state: bulk @ state + contact.residual(state)
    # The residual is piecewise linear: a step that keeps the active points is exact.
    check_tangent(residual, tangent, u, 1e-6 * np.abs(u).max(), 1e-7)
    if contact.theta == 1.0:
        symmetric(tangent)
    discrete = bulk + contact.discrete_adjoint(u)
    consistent = bulk + contact.consistent_adjoint(u)
    close(discrete, tangent.T)
    close(consistent, tangent)

    m_prime = space.vector(lambda q, w: sum(CRITERION_FORCE[i] * q[i] for i in range(2)), space.cells)
    field = space.interpolate(boundary, u)
    n_prime = space.vector(
        lambda q, w: CRITERION_BOUNDARY * (field[0] * q[0] + field[1] * q[1]), boundary
    )
    criterion_boundary = 0.5 * CRITERION_BOUNDARY * np.sum((field[0]**2 + field[1]**2) * boundary.dx)
    return {
        "matrices": {
            "tangent": tangent,
            "discrete_adjoint": discrete,
            "extended_adjoint": bulk + contact.consistent_adjoint(u, xi),
        },
        "vectors": {
            "residual": residual(u) - load,
            "load": load,
            "adjoint_right_hand_side": -m_prime,
            "discrete_adjoint_right_hand_side": -m_prime - n_prime,
            "consistent_adjoint_right_hand_side":
                -m_prime - n_prime + contact.consistent_right_hand_side(u, CRITERION_BOUNDARY),
            "extended_adjoint_right_hand_side":
                -m_prime - n_prime + contact.consistent_right_hand_side(u, CRITERION_BOUNDARY, xi),
        },
        "numbers": {
            "contact_force": contact.force(u),
            "contact_length": contact.length(u),
            "extended_contact_length": contact.length(u, xi),
            "active_points": int(active.sum()),
            "extended_active_points": int(extended.sum()),
            "criterion_interior": float(m_prime @ u),
            "criterion_boundary": float(criterion_boundary),
        },
    }


def poisson_references():
    """Scalar matrices, a load and norms."""
    for seed, (shape, degree, letter) in enumerate(
        [("triangle", 1, "p"), ("triangle", 2, "p"), ("quadrilateral", 1, "q"), ("quadrilateral", 2, "q")]
    ):
        space = Discretisation(meshes.rectangle(shape, 3, 2, 31 + seed), degree, 1)
        u = random_field(space.size, 1.0, 40 + seed)
        stiffness = space.matrix(lambda u, v, w: u.grad[0] * v.grad[0] + u.grad[1] * v.grad[1], space.cells)
        mass = space.matrix(lambda u, v, w: u * v, space.cells)
        source = lambda v, w: (np.exp(w.x[0]) * np.sin(2 * w.x[1] + w.x[0])) * v
        assert abs(mass.sum() - 2.0) < 1e-13            # the area
        symmetric(stiffness)
        yield f"poisson_{shape}_{letter}{degree}", {
            "made_by": MADE_BY,
            **space.description(),
            "data": {"source": "exp(x) sin(2 y + x)"},
            "u": u,
            "matrices": {"stiffness": stiffness, "mass": mass},
            "vectors": {"load": space.vector(source, space.cells)},
            "numbers": {
                "l2": float(np.sqrt(u @ mass @ u)),
                "h1": float(np.sqrt(u @ mass @ u + u @ stiffness @ u)),
            },
        }


def neo_hookean_references():
    space = Discretisation(meshes.rectangle("triangle", 2, 2, 51), 2, 2)
    u = random_field(space.size, 0.02, 52)
    residual = lambda state: neo_hookean.residual(space, state, LAME, SHEAR)
    energy = lambda state: np.atleast_1d(neo_hookean.energy(space, state, LAME, SHEAR))
    tangent = neo_hookean.tangent(space, u, LAME, SHEAR)
    check_tangent(residual, tangent, u, 1e-6, 1e-7)
    check_tangent(energy, residual(u)[None], u, 1e-6, 1e-7)
    symmetric(tangent)
    yield "neo_hookean_triangle_p2", {
        "made_by": MADE_BY,
        **space.description(),
        "data": {"lambda": LAME, "mu": SHEAR},
        "u": u,
        "matrices": {"tangent": tangent},
        "vectors": {"residual": residual(u)},
        "numbers": {"energy": float(energy(u)[0])},
    }


def form_references():
    """The cases of all other forms."""
    for form in FORMS:
        for case, record in form.cases():
            yield f"{form.__name__}_{case}", {"made_by": MADE_BY, **record}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare instead of writing")
    check = parser.parse_args().check
    problems, names = [], set()
    families = [
        elasticity_references, nitsche_references, poisson_references, neo_hookean_references, form_references
    ]
    for references in families:
        for name, record in references():
            path, fresh = FOLDER / f"{name}.json", reference_file.text(record)
            names.add(path.name)
            if not check:
                path.write_text(fresh)
            elif not path.exists():
                problems.append(f"{name}: no such file")
            else:
                problems += reference_file.differences(json.loads(path.read_text()), json.loads(fresh), place=name)
            print(f"{path.name}: {len(fresh) / 1000:.0f} kB")
    problems += [f"{path.name}: not made by this script" for path in FOLDER.glob("*.json") if path.name not in names]
    for problem in problems:
        print("DIFFERENCE", problem)
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
