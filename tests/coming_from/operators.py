"""The columns of docs/operators.md, snippet by snippet. `check.py` runs this."""
import re
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "operators.md"


def snippets(column):
    """The text in backticks in one column of the tables."""
    for line in PAGE.read_text().splitlines():
        parts = line.split("|")
        if len(parts) == 6 and not set(parts[1]) <= set(" -"):
            yield from re.findall(r"`([^`]+)`", parts[column])


def ufl_operators():
    """Each snippet must be an expression, in two or in three dimensions."""
    import basix.ufl
    import ufl

    def names(cell, dimension):
        element = lambda degree, **options: basix.ufl.element("Lagrange", cell, degree, **options)
        mesh = ufl.Mesh(element(1, shape=(dimension,)))
        field = lambda *shape: ufl.Coefficient(ufl.FunctionSpace(mesh, element(2, shape=shape)))
        found = {name: getattr(ufl, name) for name in ufl.__all__}
        vector, tensor = (dimension,), (dimension, dimension)
        found |= {"mesh": mesh, "s": field(), "t": field(), "u": field(), "a": field(*vector), "b": field(*vector)}
        found |= {"w": field(*vector), "A": field(*tensor), "B": field(*tensor)}
        found |= {"C": ufl.outer(found["A"], found["B"]), "V": found["s"].ufl_function_space()}
        found |= {"v": ufl.TestFunction(found["V"]), "F": found["s"] ** 2 * ufl.dx(mesh)}
        return found

    for snippet in snippets(2):
        errors = []
        for cell, dimension in (("triangle", 2), ("tetrahedron", 3)):
            try:
                eval(snippet, names(cell, dimension))
                break
            except BaseException as error:
                errors.append(str(error))
        yield snippet, errors if len(errors) == 2 else []


def getfem_operators():
    """Each snippet must be an expression that GetFEM evaluates, in cells or on a boundary, in 2D or 3D."""
    import getfem as gf
    import numpy as np

    def evaluate(snippet, dimension):
        mesh = gf.Mesh("regular simplices", *[np.linspace(0, 1, 3)] * dimension)
        mesh.set_region(1, mesh.outer_faces())
        mesh.set_region(2, mesh.inner_faces())
        md = gf.Model("real")
        random = np.random.default_rng(1)
        for names, components in (("stu", 1), ("abw", dimension)):
            fem = gf.MeshFem(mesh, components)
            fem.set_classical_fem(2)
            for name in names:
                md.add_fem_variable(name, fem)
                md.set_variable(name, random.uniform(0.1, 0.9, fem.nbdof()))
        md.add_macro("A", "Grad_w")
        md.add_macro("B", "(Id(meshdim) + Grad_w)")
        mim = gf.MeshIm(mesh, 4)
        errors = []
        for region in (2,) if "neighbor_element" in snippet else (-1, 1):
            try:
                # A function of position of any rank is contracted with itself, for a number.
                order = 1 if "Test_" in snippet else 0
                gf.asm("generic", mim, order, snippet if order else f"Norm_sqr({snippet})", region, md)
                return
            except BaseException as error:      # GetFEM's own errors are no Exceptions
                errors.append(str(error))
        raise ValueError(errors[-1])

    for snippet in snippets(3):
        errors = []
        for dimension in (2, 3):
            try:
                evaluate(snippet, dimension)
                break
            except ValueError as error:
                errors.append(str(error))
        yield snippet, errors if len(errors) == 2 else []


CHECKS = {"ufl": ufl_operators, "getfem": getfem_operators}
