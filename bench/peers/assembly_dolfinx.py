"""Whole assembly in DOLFINx: C++ insertion of generated kernels into a PETSc matrix.

usage: assembly_dolfinx.py CASE [--divisions N] [--samples N]      (Debian: python3-dolfinx; DOLFINx 0.5)
"""

import numpy as np
import ufl
from dolfinx import __version__, fem, mesh
from dolfinx.fem import petsc
from mpi4py import MPI

from assembly_case import LAMBDA, MARCH, MU, annulus_nodes, arguments, report, samples, timed

FLAGS = {"cffi_extra_compile_args": ["-O3", f"-march={MARCH}", "-mtune=native", "-ffast-math"]}


def make_mesh(case, n):
    if case == "triangles":
        return mesh.create_unit_square(MPI.COMM_SELF, n, n, mesh.CellType.triangle), 2
    if case == "tetrahedra":
        return mesh.create_unit_cube(MPI.COMM_SELF, n, n, n, mesh.CellType.tetrahedron), 2
    nodes, cells = annulus_nodes(n)
    # basix: vertices, edges, centre; [cell][across][around]
    order = [(0, 0), (2, 0), (0, 2), (2, 2), (1, 0), (0, 1), (2, 1), (1, 2), (1, 1)]
    cells = np.stack([cells[:, i, j] for i, j in order], axis=1)
    domain = ufl.Mesh(ufl.VectorElement("Lagrange", ufl.quadrilateral, 2))
    return mesh.create_mesh(MPI.COMM_SELF, cells.astype(np.int64), nodes, domain), 4


options = arguments()
domain, degree = make_mesh(options.case, options.divisions)
space = fem.VectorFunctionSpace(domain, ("Lagrange", 2))
u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
strain = lambda w: ufl.sym(ufl.grad(w))
lame, shear = fem.Constant(domain, LAMBDA), fem.Constant(domain, MU)
stress = 2 * shear * strain(u) + lame * ufl.tr(strain(u)) * ufl.Identity(domain.geometry.dim)
form = fem.form(ufl.inner(stress, strain(v)) * ufl.dx(metadata={"quadrature_degree": degree}), jit_params=FLAGS)


def reassemble(matrix):
    matrix.zeroEntries()
    petsc.assemble_matrix(matrix, form)
    matrix.assemble()


def assemble_first(kind):
    matrix = petsc.create_matrix(form, kind)
    petsc.assemble_matrix(matrix, form)
    matrix.assemble()
    return matrix


# Its own matrix class refuses blocks (version 0.5); PETSc's row format, which is the default, and its block format remain.
unknowns = space.dofmap.index_map.size_global * space.dofmap.index_map_bs
for kind in ("aij", "baij"):
    first = [timed(lambda: assemble_first(kind).destroy())[0] for _ in range(options.samples)]
    matrix = assemble_first(kind)
    reassembly = samples(lambda: reassemble(matrix), options.samples)
    name = {"aij": "DOLFINx", "baij": "DOLFINx, block matrix"}[kind]
    report(name, __version__, unknowns, matrix.norm(2), reassembly, first)  # 2 is PETSc's name of Frobenius's norm
    matrix.destroy()
