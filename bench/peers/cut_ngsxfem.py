"""The bodies of bench/examples/cut_cells.rs in ngsxfem: microseconds of matrices of cut cells and of ghost facets, one thread.

python cut_ngsxfem.py [CELLS]        (pip install ngsolve xfem)

A disc in a square of triangles and a ball in a cube of tetrahedra, elasticity of degrees 1 and 2. ngsxfem cuts while it assembles.
"""

import sys
import time

from ngsolve import (BilinearForm, CoefficientFunction, Grad, GridFunction, H1, Id, InnerProduct, Integrate, SetNumThreads, Sym, Trace,
                     VectorH1, dx, sqrt, x, y, z)
from ngsolve.meshes import MakeStructured2DMesh, MakeStructured3DMesh
from xfem import HASNEG, IF, NEG, CutInfo, GetFacetsWithNeighborTypes, InterpolateToP1, dCut, dFacetPatch


def least(count, run):
    """The least of some times in microseconds per entity."""
    times = []
    for _ in range(5):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return 1e6 * min(times) / count


def rows(dimension, count):
    maps = [lambda x, y: (2 * x - 1, 2 * y - 1), lambda x, y, z: (2 * x - 1, 2 * y - 1, 2 * z - 1)]
    if dimension == 2:
        mesh = MakeStructured2DMesh(quads=False, nx=count, ny=count, mapping=maps[0])
        radius = sqrt((x - 0.013) ** 2 + (y - 0.013) ** 2)
    else:
        mesh = MakeStructured3DMesh(hexes=False, nx=count, ny=count, nz=count, mapping=maps[1])
        radius = sqrt((x - 0.013) ** 2 + (y - 0.013) ** 2 + (z - 0.013) ** 2)
    phi = GridFunction(H1(mesh, order=1))
    InterpolateToP1(radius - 0.7, phi)
    info = CutInfo(mesh, phi)
    inside, crossed, active = (info.GetElementsOfType(kind) for kind in (NEG, IF, HASNEG))
    facets = GetFacetsWithNeighborTypes(mesh, a=active, b=crossed)
    inner, cut, ghosts = (sum(list_) for list_ in (inside, crossed, facets))
    print(f"{['triangles', 'tetrahedra'][dimension - 2]}: {mesh.ne} cells, {inner} inside, {cut} cut, {ghosts} ghost facets")
    signs = least(mesh.ne, lambda: CutInfo(mesh, phi))
    inside_of_cut = CoefficientFunction(1) * dCut(phi, NEG, order=0, definedonelements=crossed)
    volume = least(cut, lambda: Integrate(inside_of_cut, mesh))
    print(f"signs {signs:.3f} per cell; cut, rule and volume {volume:.2f} per cut cell")
    for degree in (1, 2):
        space = VectorH1(mesh, order=degree, dgjumps=True)
        u, v = space.TnT()
        strain = Sym(Grad(u))
        work = InnerProduct(2 * strain + Trace(strain) * Id(dimension), Grad(v))
        times = []
        order = 2 * (degree - 1)
        for measure, number, integrand in [
            (dx(definedonelements=inside, bonus_intorder=0), inner, work),
            (dCut(phi, NEG, order=order, definedonelements=crossed), cut, work),
            (dFacetPatch(definedonelements=facets), ghosts, InnerProduct(u - u.Other(), v - v.Other())),
        ]:
            form = BilinearForm(space, symmetric=False, check_unused=False)
            form += integrand * measure
            form.Assemble()
            times.append(least(number, form.Assemble))
        print(f"P{degree}: matrix {times[0]:.2f} per inner cell, {times[1]:.2f} per cut cell, {times[2]:.2f} per ghost facet", flush=True)


SetNumThreads(1)
cells = int(sys.argv[1]) if len(sys.argv) > 1 else 256
rows(2, cells)
rows(3, cells // 8)
