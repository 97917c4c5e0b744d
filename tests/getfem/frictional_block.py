"""A block on a flat with Tresca's and Coulomb's friction, solved with GetFEM 5.4.2.

Forms, Newton's method and adjoint problems are those of ``frictional_cylinder.py``;
here is another body, whose parts stick or slip: 2 x 1 cm, straight
quadrilaterals of degree 2, its lower side on the flat y = -30. Three load steps:
the upper side is pushed down, aside, and drawn back. The numbers go to
``frictional_block.json`` next to this file.

    python3 tests/getfem/frictional_block.py            # 8 x 4 and 16 x 8 cells
"""
import argparse
import json
from pathlib import Path

import getfem as gf
import numpy as np

import frictional_cylinder
from cylinder import CONTACT, INNER_CIRCLE, POISSON, YOUNG, rounded
from frictional_cylinder import FrictionalCylinder, solve

PUSHES = [(0.0, -0.01), (0.006, -0.008), (-0.004, -0.009)]   # u_D of the upper side, cm
LAWS = [("tresca", 0.3), ("coulomb", 0.3)]                   # MPa, and a number
BOTTOM, HEIGHT, WIDTH = -30.0, 1.0, 2.0
FACTORS = (10.0, 40.0)                                       # gamma0 / E


class Block(FrictionalCylinder):
    """Mesh, spaces and data for one number of cells along the height."""

    def __init__(self, cells):
        self.mesh = gf.Mesh("cartesian", np.linspace(0.0, WIDTH, 2 * cells + 1),
                            BOTTOM + np.linspace(0.0, HEIGHT, cells + 1))
        self.displacement = gf.MeshFem(self.mesh, 2)
        self.displacement.set_fem(gf.Fem("FEM_QK(2,2)"))
        self.constant = gf.MeshFem(self.mesh, 1)
        self.constant.set_fem(gf.Fem("FEM_QK(2,0)"))
        self.integration = gf.MeshIm(self.mesh, gf.Integ("IM_GAUSS_PARALLELEPIPED(2,8)"))
        self.positions = self.displacement.basic_dof_nodes()
        self.unknowns = self.displacement.nbdof()
        facets = self.mesh.outer_faces()
        held, contact = [], []
        for cell, face in facets.T:
            heights = self.mesh.pts()[1, self.mesh.pid_in_faces([[cell], [face]])]
            if np.allclose(heights, BOTTOM + HEIGHT, atol=1e-9):
                held.append((cell, face))
            elif np.allclose(heights, BOTTOM, atol=1e-9):
                contact.append((cell, face))
        self.contact_facets = contact
        self.mesh.set_region(INNER_CIRCLE, np.array(held).T)
        self.mesh.set_region(CONTACT, np.array(contact).T)
        # The diagonal of a square.
        self.diameters = np.full(self.constant.nbdof(), np.sqrt(2.0) * HEIGHT / cells)
        self.fixed = np.zeros(self.unknowns, dtype=bool)
        self.fixed[self.displacement.basic_dof_on_region(INNER_CIRCLE)] = True
        self.free = np.flatnonzero(~self.fixed)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, nargs="+", default=[4, 8])
    parser.add_argument("--output", default=str(Path(__file__).with_name("frictional_block.json")))
    arguments = parser.parse_args()
    gf.util("trace level", 0)
    frictional_cylinder.PUSHES = PUSHES
    runs = []
    for cells in arguments.cells:
        problem = Block(cells)
        for factor in FACTORS:
            for theta in (-1.0, 0.0, 1.0):
                for law, value in LAWS:
                    report = solve(problem, theta, factor * YOUNG, law, value)
                    case = {"cells": cells, "theta": theta, "gamma0_over_young": factor, law: value}
                    runs.append(rounded({**case, **report}))
                    last = report["steps"][-1]
                    print(cells, factor, theta, law, last["contact_length"], last["stick_length"],
                          last["slip_length"], last["tangential_force"], flush=True)
    result = {
        "made_by": "tests/getfem/frictional_block.py with GetFEM 5.4.2",
        "young": YOUNG, "poisson": POISSON, "runs": runs,
    }
    Path(arguments.output).write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
