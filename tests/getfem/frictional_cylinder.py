"""The hollow cylinder with Tresca's and Coulomb's friction, solved with GetFEM 5.4.2.

Mesh, spaces, quadrature and material are those of ``cylinder.py``; only what
friction adds is here. Two load steps: the inner circle is pushed down, then
aside, and the slip of the second step is counted from the first one's solution.
The numbers go to ``frictional_cylinder.json`` next to this file.

    python3 tests/getfem/frictional_cylinder.py            # n_r = 2, 4, 8
    python3 tests/getfem/frictional_cylinder.py --radial 2 --output FILE
"""
import argparse
import json
from pathlib import Path

import getfem as gf
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from cylinder import (BULK_U, CONTACT, FORCE, LAMBDA, MU, POISSON, STRESS, YOUNG, Cylinder, norm_of,
                      rounded)

PUSHES = [(0.0, -1.0), (0.5, -1.0)]          # u_D of the load steps, cm
LAWS = [("tresca", 1.0), ("coulomb", 0.3)]   # MPa, and a number
STICKING = 1e6                               # a coefficient at which all that presses sticks
TOLERANCE = 1e-12                            # relative residual of Newton's method

# The flat has the normal (0, -1) and the tangent (1, 0). `old` is the displacement of the step before.
FORCE_ON = "(" + STRESS + "*Normal)"
NORMAL_U, NORMAL_V = f"(-{FORCE_ON.format('u')}(2))", f"(-{FORCE_ON.format('Test_u')}(2))"
TANGENT_U, TANGENT_V = f"{FORCE_ON.format('u')}(1)", f"{FORCE_ON.format('Test_u')}(1)"
P_N = f"({NORMAL_U}-gamma*(-u(2)-(X(2)+30)))"
P_T = f"({TANGENT_U}-gamma*(u(1)-old(1)))"
PRESSURE = f"neg_part{P_N}"
BOUND = f"(bound+kappa*{PRESSURE})"
# The projection onto [-s, s], s >= 0.
FRICTION = f"({P_T}-pos_part({P_T}-{BOUND})+pos_part(-{P_T}-{BOUND}))"
CONTACT_U = (
    f"-theta/gamma*({NORMAL_U}*{NORMAL_V}+{TANGENT_U}*{TANGENT_V})"
    f"-1/gamma*{PRESSURE}*(theta*{NORMAL_V}+gamma*Test_u(2))"
    f"+1/gamma*{FRICTION}*(theta*{TANGENT_V}-gamma*Test_u(1))"
)
# The consistent adjoint: D transposed, D the derivative of (-[P_n]_-, friction) by (P_n, P_t).
NORMAL_P, NORMAL_Q = f"(-{FORCE_ON.format('p')}(2))", f"(-{FORCE_ON.format('Test_p')}(2))"
TANGENT_P, TANGENT_Q = f"{FORCE_ON.format('p')}(1)", f"{FORCE_ON.format('Test_p')}(1)"
PRESSED = f"Heaviside(-{P_N})"
UP, DOWN = f"Heaviside({P_T}-{BOUND})", f"Heaviside(-{P_T}-{BOUND})"
STUCK = f"(1-{UP}-{DOWN})"
W_N, W_T = f"({NORMAL_P}+gamma*p(2))", f"({TANGENT_P}-gamma*p(1))"
CONSISTENT = (
    f"-theta/gamma*({NORMAL_P}*{NORMAL_Q}+{TANGENT_P}*{TANGENT_Q})"
    f"+1/gamma*{PRESSED}*({W_N}-kappa*({UP}-{DOWN})*{W_T})*(theta*{NORMAL_Q}+gamma*Test_p(2))"
    f"+1/gamma*{STUCK}*{W_T}*(theta*{TANGENT_Q}-gamma*Test_p(1))"
)


class FrictionalCylinder(Cylinder):
    """The cylinder with the assembly of terms that read the displacement before, too."""

    def assemble_contact(self, order, expression, u, old, data, p=None):
        arguments = ["u", int(p is None), self.displacement, u, "old", 0, self.displacement, old]
        if p is not None:
            arguments += ["p", 1, self.displacement, p]
        for name, value in dict({"lambda": LAMBDA, "mu": MU}, **data).items():
            if name == "gamma":
                arguments += [name, 0, self.constant, value]
            else:
                arguments += [name, 0, np.atleast_1d(np.array(value, dtype=float))]
        result = gf.asm_generic(self.integration, order, expression, CONTACT, *arguments)
        if order < 2:
            return result
        row_pointers, indices = result.csc_ind()
        size = self.unknowns
        return sp.csc_matrix((result.csc_val(), indices, row_pointers), shape=(size, size))


def newton(problem, bulk, u, old, data, steps=100):
    """Newton's method; steps are halved until the residual falls (an eighth if none does).

    Returns the last iterate and whether it is the solution.
    """
    free = problem.free

    def residual_of(v):
        return (bulk @ v + problem.assemble_contact(1, CONTACT_U, v, old, data))[free]

    residual = residual_of(u)
    start = max(np.linalg.norm(residual), np.linalg.norm((bulk @ u)[free]))
    for _ in range(steps + 1):
        if np.linalg.norm(residual) <= TOLERANCE * start:
            return u, True
        tangent = bulk + problem.assemble_contact(2, CONTACT_U, u, old, data)
        step = splu(tangent.tocsr()[free][:, free].tocsc()).solve(residual)
        taken = None
        for part in [1.0, 0.5, 0.25, 0.125, 1 / 16, 1 / 32, 1 / 64]:
            trial = u.copy()
            trial[free] -= part * step
            found = residual_of(trial)
            falls = np.linalg.norm(found) <= (1 - 1e-4 * part) * np.linalg.norm(residual)
            if falls or part == 0.125:
                taken = (trial, found)
            if falls:
                break
        u, residual = taken
    return u, False


def solve(problem, theta, gamma0, law, value):
    """All load steps, and the two adjoint problems of the last one."""
    free, fixed = problem.free, problem.fixed
    data = {"gamma": gamma0 / problem.diameters, "theta": theta, "bound": 0.0, "kappa": 0.0}
    data["bound" if law == "tresca" else "kappa"] = value
    u = np.zeros(problem.unknowns)
    bulk = problem.assemble(2, BULK_U, -1, u)
    steps = []
    for push in PUSHES:
        old = u.copy()
        for component, displacement in enumerate(push):
            u[component::2][fixed[component::2]] = displacement
        first = u.copy()
        # From a state in which all sticks, or near it; else from the step before.
        stuck, _ = newton(problem, bulk, first.copy(), old, dict(data, kappa=STICKING), steps=10)
        u, converged = newton(problem, bulk, stuck, old, data)
        if not converged:
            u, converged = newton(problem, bulk, first.copy(), old, data)
        if not converged:
            raise RuntimeError("Newton's method did not converge")

        def integral(expression):
            return problem.assemble_contact(0, expression, u, old, data)

        slips = f"({UP}+{DOWN})"
        steps.append({
            "push": list(push),
            "u_l2": norm_of(problem, u)[0],
            "u_h1": norm_of(problem, u)[1],
            "J": problem.assemble(0, f"{FORCE}.u", -1, u),
            "contact_force": integral(PRESSURE),
            "contact_length": integral(PRESSED),
            "tangential_force": integral(FRICTION),
            "stick_length": integral(f"{PRESSED}*(1-{slips})"),
            "slip_length": integral(f"{PRESSED}*{slips}"),
        })
    zero = np.zeros(problem.unknowns)
    right = -problem.assemble(1, f"{FORCE}.Test_u", -1, zero)
    tangent = bulk + problem.assemble_contact(2, CONTACT_U, u, old, data)
    matrices = {
        "discrete": tangent.T.tocsc(),
        "consistent": bulk + problem.assemble_contact(2, CONSISTENT, u, old, data, p=zero),
    }
    if law == "tresca":
        # D is symmetric: GetFEM's own tangent is the matrix that was written by hand.
        assert abs(matrices["consistent"] - tangent).max() < 1e-12 * abs(tangent).max()
    report = {"steps": steps}
    for name, matrix in matrices.items():
        p = np.zeros(problem.unknowns)
        p[free] = splu(matrix.tocsr()[free][:, free].tocsc()).solve(right[free])
        report[f"p_{name}_l2"], report[f"p_{name}_h1"] = norm_of(problem, p)
    return report


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--radial", type=int, nargs="+", default=[2, 4, 8])
    parser.add_argument("--output", default=str(Path(__file__).with_name("frictional_cylinder.json")))
    arguments = parser.parse_args()
    gf.util("trace level", 0)
    runs = []
    for radial in arguments.radial:
        problem = FrictionalCylinder(radial)
        for theta in (-1.0, 0.0, 1.0):
            for law, value in LAWS:
                factor = 10.0
                report = solve(problem, theta, factor * YOUNG, law, value)
                case = {"radial": radial, "theta": theta, "gamma0_over_young": factor, law: value}
                runs.append(rounded({**case, **report}))
                last = report["steps"][-1]
                print(radial, theta, law, last["contact_force"], last["tangential_force"], last["slip_length"],
                      flush=True)
    result = {
        "made_by": "tests/getfem/frictional_cylinder.py with GetFEM 5.4.2",
        "young": YOUNG, "poisson": POISSON, "runs": runs,
    }
    Path(arguments.output).write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
