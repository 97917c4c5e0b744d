"""The hanging block of `hanging_block.rs` in DOLFINx: Q2 elasticity on n³ hexahedra, PETSc's CG with GAMG.

usage: [mpirun -n N] block_dolfinx.py CELLS [PETSc's options]      (Debian: python3-dolfinx; DOLFINx 0.5)
Prints lines of a name and numbers, as `hanging_block` does.
"""

import sys
import time

import petsc4py

petsc4py.init(sys.argv[:1] + sys.argv[2:])
import numpy as np
import ufl
from dolfinx import fem, la, mesh
from dolfinx.fem import petsc
from mpi4py import MPI
from petsc4py import PETSc

from assembly_case import MARCH

FLAGS = {"cffi_extra_compile_args": ["-O3", f"-march={MARCH}", "-mtune=native", "-ffast-math"]}
YOUNG, POISSON, TOLERANCE, MOST_ITERATIONS = 1.0, 0.3, 1e-10, 500


def rigid_motions(space):
    """PETSc's near null space: three translations and three rotations, orthonormal."""
    count = space.dofmap.index_map.size_local
    x = space.tabulate_dof_coordinates()[:count]
    vectors = [la.create_petsc_vector(space.dofmap.index_map, 3) for _ in range(6)]
    for number, vector in enumerate(vectors):
        values = np.zeros((count, 3))
        if number < 3:
            values[:, number] = 1
        else:
            i, j = [(0, 1), (1, 2), (2, 0)][number - 3]
            values[:, i], values[:, j] = x[:, j], -x[:, i]
        vector.array[:] = values.ravel()
    basis = []
    for vector in vectors:
        for known in basis:
            vector.axpy(-known.dot(vector), known)
        vector.normalize()
        basis.append(vector)
    return PETSc.NullSpace().create(vectors=basis, comm=space.mesh.comm)


def solve(n):
    """The seconds of the stages, the solver and the solution."""
    marks = [time.perf_counter()]
    body = mesh.create_unit_cube(MPI.COMM_WORLD, n, n, n, mesh.CellType.hexahedron)
    space = fem.VectorFunctionSpace(body, ("Lagrange", 2))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    strain = lambda w: ufl.sym(ufl.grad(w))
    lame, shear = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), YOUNG / (2 * (1 + POISSON))
    stress = 2 * shear * strain(u) + lame * ufl.tr(strain(u)) * ufl.Identity(3)
    dx = ufl.dx(metadata={"quadrature_degree": 4})
    stiffness = fem.form(ufl.inner(stress, strain(v)) * dx, jit_params=FLAGS)
    weight = fem.form(ufl.inner(fem.Constant(body, np.array([0.0, 0.0, -1.0])), v) * dx, jit_params=FLAGS)
    facets = mesh.locate_entities_boundary(body, 2, lambda x: np.isclose(x[2], 1))
    held = [fem.dirichletbc(np.zeros(3), fem.locate_dofs_topological(space, 2, facets), space)]
    marks.append(time.perf_counter())
    matrix = petsc.create_matrix(stiffness)
    petsc.assemble_matrix(matrix, stiffness, bcs=held)
    matrix.assemble()
    matrix.setNearNullSpace(rigid_motions(space))
    load = petsc.assemble_vector(weight)
    petsc.apply_lifting(load, [stiffness], bcs=[held])
    load.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    petsc.set_bc(load, held)
    marks.append(time.perf_counter())
    solver = PETSc.KSP().create(body.comm)
    solver.setOperators(matrix)
    solver.setType("cg")
    solver.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
    solver.setTolerances(rtol=TOLERANCE, max_it=MOST_ITERATIONS)
    solver.getPC().setType("gamg")
    solver.setFromOptions()
    found = fem.Function(space)
    solver.solve(load, found.vector)
    found.x.scatter_forward()
    marks.append(time.perf_counter())
    return np.diff(marks), solver, found


solve(2)  # compiles the kernels, or finds them
MPI.COMM_WORLD.barrier()
(prepared, assembled, solved), solver, u = solve(int(sys.argv[1]))
size = fem.assemble_scalar(fem.form((ufl.inner(ufl.grad(u), ufl.grad(u)) + ufl.dot(u, u)) * ufl.dx))
with open("/proc/self/status") as status:
    peak = next(int(line.split()[1]) for line in status if line.startswith("VmHWM:")) * 1024 / 1e6
size, peak = MPI.COMM_WORLD.allreduce(size), MPI.COMM_WORLD.allreduce(peak, MPI.MAX)
if MPI.COMM_WORLD.rank == 0:
    print("size", size)
    print("iterations", solver.getIterationNumber())
    print("assembly_seconds", assembled)
    print("solve_seconds", solved)
    print("seconds", prepared + assembled + solved)
    print("megabytes", peak)
    if solver.getConvergedReason() < 0:
        sys.exit(f"PETSc did not converge: reason {solver.getConvergedReason()}")
