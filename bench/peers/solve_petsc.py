"""PETSc's CG with GAMG on a system that `bench/examples/elasticity_in_space.rs` wrote; prints a line of its table.

usage: [mpirun -n N] solve_petsc.py FILE TOLERANCE [PETSc's options]      (Debian: python3-petsc4py)
"""

import sys
import time

import petsc4py

petsc4py.init(sys.argv[:1] + sys.argv[3:])
import numpy as np
from petsc4py import PETSc

world = PETSc.COMM_WORLD
path, tolerance = sys.argv[1], float(sys.argv[2])
nodes, blocks = (int(count) for count in np.fromfile(path, "<u8", 2))
first, end = (nodes * rank // world.size for rank in (world.rank, world.rank + 1))


def read(kind, start, count):
    return np.fromfile(path, kind, count, offset=start)


at_pointers = 16
at_columns = at_pointers + 8 * (nodes + 1)
at_values = at_columns + 4 * blocks
at_load = at_values + 72 * blocks
at_positions = at_load + 24 * nodes
pointers = read("<u8", at_pointers + 8 * first, end - first + 1).astype(np.int64)
low, high = int(pointers[0]), int(pointers[-1])
columns = read("<u4", at_columns + 4 * low, high - low).astype(np.int32)
values = read("<f8", at_values + 72 * low, 9 * (high - low))
load = read("<f8", at_load + 24 * first, 3 * (end - first))
positions = read("<f8", at_positions + 24 * first, 3 * (end - first))

size = ((3 * (end - first), 3 * nodes),) * 2
local = (pointers - low).astype(np.int32)
matrix = PETSc.Mat().createBAIJ(size, bsize=3, csr=(local, columns, values), comm=world)
matrix.convert("aij")  # in place: GAMG works on rows, with the block size known
matrix.setBlockSize(3)
matrix.setOption(PETSc.Mat.Option.SPD, True)
matrix.setNearNullSpace(PETSc.NullSpace().createRigidBody(PETSc.Vec().createWithArray(positions, bsize=3, comm=world)))
b = PETSc.Vec().createWithArray(load, bsize=3, comm=world)
x = b.duplicate()

solver = PETSc.KSP().create(world)
solver.setOperators(matrix)
solver.setType("cg")
solver.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
solver.setTolerances(rtol=tolerance)
solver.getPC().setType("gamg")
solver.setFromOptions()
times = [time.perf_counter()]
solver.setUp()
times.append(time.perf_counter())
solver.solve(b, x)
times.append(time.perf_counter())

residual = (matrix * x - b).norm() / b.norm()
# In GiB; `ru_maxrss` would include the memory of the program that started this one.
with open("/proc/self/status") as status:
    peak = next(int(line.split()[1]) for line in status if line.startswith("VmHWM:")) / 2**20
peak = world.tompi4py().allreduce(peak)
if world.rank == 0:
    version = ".".join(str(part) for part in PETSc.Sys.getVersion())
    processes = f"{world.size} process{'' if world.size == 1 else 'es'}"
    print(f"PETSc {version}, CG + GAMG, {processes} | {times[1] - times[0]:.2f} | {times[2] - times[1]:.2f} | "
          f"{times[2] - times[0]:.2f} | {solver.getIterationNumber()} | {residual:.1e} | {peak:.2f} GiB")
    if solver.getConvergedReason() < 0:
        sys.exit(f"PETSc did not converge: reason {solver.getConvergedReason()}")
