"""Whole assembly in GetFEM: its assembly language, and the routine for linear elasticity of before.

usage: assembly_getfem.py CASE [--divisions N] [--samples N]      (Debian: python3-getfem; GetFEM 5.4)
"""

import getfem
import numpy as np

from assembly_case import LAMBDA, MU, annulus_nodes, arguments, report, samples

getfem.util("trace level", 0)


def make_mesh(case, n):
    """The mesh, with its integration method and element."""
    line = np.arange(n + 1) / n
    if case == "triangles":
        return getfem.Mesh("triangles grid", line, line), "IM_TRIANGLE(2)", "FEM_PK(2,2)"
    if case == "tetrahedra":
        return getfem.Mesh("regular simplices", line, line, line), "IM_TETRAHEDRON(2)", "FEM_PK(3,2)"
    nodes, cells = annulus_nodes(n)
    mesh = getfem.Mesh("empty", 2)
    # Nodes of QK(2,2): the first direction runs fastest; orientation does not matter to the norm.
    order = cells.transpose(0, 2, 1).reshape(len(cells), 9)
    mesh.add_convex(getfem.GeoTrans("GT_QK(2,2)"), nodes[order].transpose(2, 1, 0))
    return mesh, "IM_GAUSS_PARALLELEPIPED(2,4)", "FEM_QK(2,2)"


options = arguments()
mesh, method, element = make_mesh(options.case, options.divisions)
dimension = mesh.dim()
unknown = getfem.MeshFem(mesh, dimension)
unknown.set_fem(getfem.Fem(element))
integration = getfem.MeshIm(mesh, getfem.Integ(method))
data = getfem.MeshFem(mesh, 1)
data.set_fem(getfem.Fem(element.replace("(2,2)", "(2,0)").replace("(3,2)", "(3,0)")))
lame, shear = np.full(data.nbdof(), LAMBDA), np.full(data.nbdof(), MU)
expression = "(lambda*Trace(Grad_u)*Id(meshdim) + mu*(Grad_u + Grad_u')):Grad_Test_u"


def in_its_language():
    return getfem.asm_generic(integration, 2, expression, -1, "u", 1, unknown, np.zeros(unknown.nbdof()),
                              "lambda", 0, LAMBDA, "mu", 0, MU)


def by_its_routine():
    return getfem.asm_linear_elasticity(integration, unknown, data, lame, shear)


def norm(matrix):
    matrix = getfem.Spmat("copy", matrix)
    matrix.to_csc()
    return float(np.linalg.norm(matrix.csc_val()))


# It has no re-assembly into a known pattern: each call makes a matrix.
for name, assemble in {"GetFEM": in_its_language, "GetFEM, elasticity routine": by_its_routine}.items():
    matrix = assemble()
    seconds = samples(assemble, options.samples)
    report(name, getfem.getfem_env("version") if hasattr(getfem, "getfem_env") else "5.4", unknown.nbdof(), norm(matrix), seconds, seconds)
