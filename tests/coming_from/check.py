"""Run the code blocks of docs/coming_from.md and forms.md that are not ours, and the columns of docs/operators.md.

    python tests/coming_from/check.py ufl scikit-fem
    python3 tests/coming_from/check.py getfem

Every block is run by itself, with the names of its language that this file
makes. UFL's forms are brought to the point where a form compiler takes over
(arities, degrees, restrictions); GetFEM and scikit-fem assemble. README.md
says what to install.
"""
import re
import sys
from pathlib import Path

import operators

PAGES = Path(__file__).parents[2] / "docs" / "coming_from.md", Path(__file__).parent / "forms.md"


def text_of_pages():
    return "\n".join(page.read_text() for page in PAGES)


def blocks(language):
    """(heading, code) of every block of a language."""
    heading = ""
    for match in re.finditer(r"^## ([^\n]*)$|^```python (\S+)\n(.*?)^```$", text_of_pages(), re.M | re.S):
        if match[1]:
            heading = match[1]
        elif match[2] == language:
            yield heading, match[3]


def ufl_names(cell="triangle", geometry=1):
    import basix.ufl
    import ufl

    element = lambda degree, **options: basix.ufl.element("Lagrange", cell, degree, **options)
    mesh = ufl.Mesh(element(geometry, shape=(2,)))
    space = lambda e: ufl.FunctionSpace(mesh, e)
    names = {name: getattr(ufl, name) for name in ufl.__all__}
    names |= {
        "mesh": mesh, "V": space(element(2)), "VV": space(element(2, shape=(2,))),
        "DG": space(element(2, discontinuous=True)),
        "TAYLOR_HOOD": space(basix.ufl.mixed_element([element(2, shape=(2,)), element(1)])),
        "n": ufl.FacetNormal(mesh), "WALL": 1, "CONTACT": 1,
    }
    for constant in ("k", "lam", "mu", "s", "p", "theta", "gamma0", "step", "outside", "sigma", "g1", "g2"):
        names[constant] = ufl.Constant(mesh)
    names["down"] = ufl.Constant(mesh, shape=(2,))
    for field in ("f", "g", "gap"):
        names[field] = ufl.Coefficient(names["V"])
    names["force"] = ufl.Coefficient(names["VV"])
    return names


def ufl_result(names, again):
    import ufl
    from ufl.algorithms import compute_form_data

    # Where `lhs` and `rhs` have split a form, it is these that go to the compiler.
    forms = [names["a"], names["L"]] if "L" in names else [f for f in names.values() if isinstance(f, ufl.Form)]
    for form in forms:
        compute_form_data(form, do_apply_function_pullbacks=True, do_apply_geometry_lowering=True,
                          do_apply_restrictions=True, do_estimate_degrees=True)
    return f"{len(forms)} forms"


def getfem_names():
    import getfem as gf
    import numpy as np

    mesh = gf.Mesh("regular simplices", np.linspace(0, 1, 4), np.linspace(0, 1, 4))
    mesh.set_region(1, mesh.outer_faces_with_direction([0, -1], 0.1))
    mesh.set_region(2, mesh.outer_faces())
    mesh.set_region(3, mesh.inner_faces())
    md = gf.Model("real")

    def space(components, degree, discontinuous=False):
        fem = gf.MeshFem(mesh, components)
        (fem.set_classical_discontinuous_fem if discontinuous else fem.set_classical_fem)(degree)
        return fem

    scalar, vector = space(1, 2), space(2, 2)
    md.add_fem_variable("u", scalar)
    md.add_fem_variable("uu", vector)
    md.add_fem_variable("p", space(1, 1))
    md.add_fem_variable("w", space(1, 2, discontinuous=True))
    random = np.random.default_rng(1)
    for name in ("u", "uu", "p", "w"):
        md.set_variable(name, random.uniform(-0.01, 0.01, len(md.variable(name))))
    for name in ("f", "g", "gap", "old"):
        md.add_initialized_fem_data(name, scalar, random.uniform(0, 0.1, scalar.nbdof()))
    md.add_initialized_fem_data("h", space(1, 0, discontinuous=True), np.full(18, np.sqrt(2) / 3))
    md.add_initialized_fem_data("force", vector, random.uniform(0, 1, vector.nbdof()))
    md.add_initialized_data("down", [0.0, -1.0])
    for name in ("k", "lambda", "mu", "s", "power", "theta", "gamma0", "step", "outside", "sigma", "g1", "g2"):
        md.add_initialized_data(name, 1.5)
    mim = gf.MeshIm(mesh, 6)
    return {"md": md, "mim": mim, "WALL": 1, "CONTACT": 1, "BOUNDARY": 2, "INNER": 3}


def getfem_result(names, again):
    import numpy as np

    md = names["md"]
    md.assembly()
    tangent, residual = md.tangent_matrix().full(), md.rhs()
    assert np.isfinite(tangent).all() and np.isfinite(residual).all()
    return f"tangent {np.abs(tangent).max():.3g}, right side {np.abs(residual).max():.3g}"


def scikit_fem_names():
    import jax.numpy as jnp
    import numpy as np
    import skfem
    import skfem.helpers
    from scipy.sparse import bmat

    mesh = skfem.MeshTri.init_tensor(np.linspace(0, 1, 4), np.linspace(0, 1, 4))
    scalar, vector = skfem.ElementTriP2(), skfem.ElementVector(skfem.ElementTriP2())
    bottom = mesh.facets_satisfying(lambda x: x[1] == 0, boundaries_only=True)
    basis = skfem.Basis(mesh, scalar)
    vector_basis = skfem.Basis(mesh, vector)
    contact_basis = skfem.FacetBasis(mesh, vector, facets=bottom)
    random = np.random.default_rng(1)
    names = {name: getattr(skfem, name) for name in skfem.__all__}
    helpers = ("dot", "ddot", "grad", "sym_grad", "div", "trace", "eye", "dd")
    names |= {name: getattr(skfem.helpers, name) for name in helpers}
    names |= {
        "np": np, "jnp": jnp, "bmat": bmat, "mesh": mesh,
        "basis": basis, "vector_basis": vector_basis, "contact_basis": contact_basis,
        "pressure_basis": vector_basis.with_element(skfem.ElementTriP1()),
        "wall": skfem.FacetBasis(mesh, scalar, facets=bottom),
        "f": random.uniform(0, 1, basis.N), "g": random.uniform(0, 1, basis.N),
        "force": random.uniform(0, 1, vector_basis.N), "state": random.uniform(-0.02, 0.02, vector_basis.N),
        "temperature": random.uniform(0, 1, basis.N), "old": random.uniform(0, 1, basis.N),
        "down": np.array([0.0, -1.0]),
        "gamma": np.full(contact_basis.dx.shape, 10.0), "gap": np.full(contact_basis.dx.shape, 0.01),
        "k": 1.5, "lam": 1.5, "mu": 1.5, "s": 0.5, "p": 3.0, "theta": 0.5, "step": 0.1, "outside": 0.3,
        "sigma": 20.0, "g1": 0.1, "g2": 0.01,
    }
    return names


def scikit_fem_result(names, again):
    import numpy as np
    import scipy.sparse as sp

    sparse = {key: value for key, value in names.items() if sp.issparse(value)}
    assert sparse, "the block has assembled no matrix"
    assert all(np.isfinite(matrix.data).all() for matrix in sparse.values())
    if "tangent" in sparse:
        # It is the derivative of the residual.
        residual = lambda block: block["residual"] if "residual" in block else -np.asarray(block["minus_residual"])
        moved, step = {}, 1e-6
        direction = {key: np.sin(1.7 * np.arange(len(names[key]))) for key in ("state", "temperature")}
        for sign in (-1, 1):
            shifted = {key: names[key] + sign * step * value for key, value in direction.items()}
            moved[sign] = residual(again(shifted))
        difference = (moved[1] - moved[-1]) / (2 * step)
        along = direction["state" if len(difference) == len(names["state"]) else "temperature"]
        expected = names["tangent"] @ along
        error = abs(difference - expected).max() / abs(expected).max()
        assert error < 1e-6, f"the tangent is not the derivative of the residual: {error:.1e}"
    return ", ".join(f"{key} {abs(value).max():.3g}" for key, value in sparse.items())


LANGUAGES = {
    "ufl": (ufl_names, ufl_result),
    "getfem": (getfem_names, getfem_result),
    "scikit-fem": (scikit_fem_names, scikit_fem_result),
}


def main():
    failed = False
    for language in sys.argv[1:] or LANGUAGES:
        found = list(blocks(language))
        forms = len(re.findall(r"^```rust$", text_of_pages(), re.M))
        assert len(found) == forms, f"{len(found)} blocks of {language} for {forms} forms"
        for heading, code in found:
            make, result = LANGUAGES[language]

            def run(changed):
                names = make() | changed
                exec(compile(code, f"{language}: {heading}", "exec"), names)
                return names

            try:
                print(f"{language:10} {heading}: {result(run({}), run)}", flush=True)
            except BaseException as error:      # UFL's own errors are no Exceptions
                failed = True
                print(f"{language:10} {heading}: FAILED\n    {type(error).__name__}: {error}")
        for snippet, errors in operators.CHECKS.get(language, lambda: [])():
            failed |= bool(errors)
            if errors:
                print(f"{language:10} FAILED: `{snippet}` in docs/operators.md\n    {errors[-1][:300]}")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
