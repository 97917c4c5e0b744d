"""The bodies of bench/examples/cut_cells.rs in GetFEM: microseconds of cutting and of matrices of cut cells, one thread.

/usr/bin/python3 cut_getfem.py [CELLS]        (Debian's python3-getfem)

A disc in a square of triangles and a ball in a cube of tetrahedra, elasticity of degrees 1 and 2.
"""

import os
import sys
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")

import getfem as gf
import numpy as np

gf.util_trace_level(0)
gf.util_warning_level(0)


def least(count, run, runs):
    """The least of some times in microseconds per entity."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return 1e6 * min(times) / count


def rows(dimension, count):
    simplex = ["IM_TRIANGLE", "IM_TETRAHEDRON"][dimension - 2]
    sides = f"[{','.join(['2'] * dimension)}]"
    mesh = gf.Mesh("import", "structured", f'GT="GT_PK({dimension},1)";ORG=[{",".join(["-1"] * dimension)}];SIZES={sides};NSUBDIV=[{",".join([str(count)] * dimension)}]')
    level = gf.LevelSet(mesh, 1)
    nodes = level.mf().basic_dof_nodes()
    values = np.sqrt(((nodes - 0.013) ** 2).sum(axis=0)) - 0.7
    level.set_values(values)

    def cut():
        cutter = gf.MeshLevelSet(mesh)
        cutter.add(level)
        cutter.adapt()
        return cutter

    cutter = cut()
    owners, starts = level.mf().basic_dof_from_cvid()
    signs = np.array([[values[i] < 0 for i in owners[starts[c]:starts[c + 1]]] for c in range(mesh.nbcvs())])
    inner, crossed = signs.all(axis=1), signs.any(axis=1) & ~signs.all(axis=1)
    inner, crossed = np.flatnonzero(inner), np.flatnonzero(crossed)
    print(f"{['triangles', 'tetrahedra'][dimension - 2]}: {mesh.nbcvs()} cells, {len(inner)} inside, {len(crossed)} cut")
    print(f"cutting {least(len(crossed), cut, 2):.1f} per cut cell")
    mesh.set_region(1, np.vstack([inner, np.full(len(inner), -1)]))
    mesh.set_region(2, np.vstack([crossed, np.full(len(crossed), -1)]))
    for degree in (1, 2):
        space = gf.MeshFem(mesh, dimension)
        space.set_fem(gf.Fem(f"FEM_PK({dimension},{degree})"))
        rule = gf.Integ(f"{simplex}({max(2 * (degree - 1), 1)})")
        plain = gf.MeshIm(mesh, rule)
        inside = gf.MeshIm("levelset", cutter, "inside", rule)
        u = np.zeros(space.nbdof())
        times = []
        for method, region, number in [(plain, 1, len(inner)), (inside, 2, len(crossed))]:
            times.append(least(number, lambda: gf.asm_generic(
                method, 2, "(Trace(Grad_u)*Id(meshdim)+2*Sym(Grad_u)):Grad_Test_u", region, "u", 1, space, u), 3))
        print(f"P{degree}: matrix {times[0]:.2f} per inner cell, {times[1]:.2f} per cut cell", flush=True)


cells = int(sys.argv[1]) if len(sys.argv) > 1 else 256
rows(2, cells)
rows(3, cells // 8)
