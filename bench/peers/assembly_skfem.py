"""Whole assembly in scikit-fem.

usage: assembly_skfem.py CASE [--divisions N] [--samples N]      (pip install scikit-fem==12.0.1 numpy scipy)
"""

import numpy as np
import skfem
from skfem.models.elasticity import linear_elasticity

from assembly_case import LAMBDA, MU, annulus_nodes, arguments, report, samples, timed


def make_mesh(case, n):
    line = np.linspace(0, 1, n + 1)
    if case == "triangles":
        return skfem.MeshTri.init_tensor(line, line), skfem.ElementTriP2(), 2
    if case == "tetrahedra":
        return skfem.MeshTet.init_tensor(line, line, line), skfem.ElementTetP2(), 2
    nodes, cells = annulus_nodes(n)
    # Vertices counter-clockwise, edges, centre. Vertices must be numbered first.
    order = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)]
    numbers = np.stack([cells[:, i, j] for i, j in order])
    first = np.unique(numbers[:4])
    renumbered = np.full(len(nodes), -1)
    renumbered[first] = np.arange(len(first))
    rest = np.setdiff1d(np.arange(len(nodes)), first)
    mesh = skfem.MeshQuad(nodes[first].T, renumbered[numbers[:4]])
    curved = skfem.MeshQuad2.from_mesh(mesh)
    # Its own node numbers of the quadratic geometry: find each by the straight cell that it came from.
    doflocs = curved.doflocs.copy()
    dofs = skfem.Dofs(curved, curved.elem()) if hasattr(skfem, "Dofs") else curved.dofs
    for local in range(9):
        at = dofs.element_dofs[local]
        doflocs[:, at] = nodes[numbers[local]].T
    return skfem.MeshQuad2(doflocs, curved.t), skfem.ElementQuad2(), 4


options = arguments()
mesh, element, degree = make_mesh(options.case, options.divisions)
vector = skfem.ElementVector(element)
form = linear_elasticity(LAMBDA, MU)


def basis():
    return skfem.Basis(mesh, vector, intorder=degree)


def assemble_first():
    return form.assemble(basis())


_, known = timed(basis)
seconds, matrix = timed(lambda: form.assemble(known))
reassembly = [seconds] + samples(lambda: form.assemble(known), options.samples - 1)
report("scikit-fem", skfem.__version__, int(known.N), float(np.linalg.norm(matrix.data)), reassembly, samples(assemble_first, 1))
