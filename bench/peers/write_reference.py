"""Writes some rows of FFCx's element matrices on the harness's cells: reference data for `cargo test`.

usage: write_reference.py FILE.json      (after run_ffcx_kernels.sh has built lib_gcc_O2.so)

The cells, coefficients and constants are those of time_kernels.c; of each cell one row (of a residual: everything)
is kept: row (7 cell + 3) mod rows. Cell integrals have 8 cells, facet integrals 8 for each local facet.
"""

import ctypes
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

BATCH = 8
work = pathlib.Path(os.environ.get("FFCX_WORK", pathlib.Path.home() / ".cache/peers/work"))
library = ctypes.CDLL(str(work / "lib_gcc_O2.so"))


def pointer(array):
    return array.ctypes.data_as(ctypes.c_void_p)


def read_dump(path):
    """The inputs that time_kernels.c wrote, and sizes."""
    data = path.read_bytes()
    cells, _, nodes, facets, width, _, size, _ = np.frombuffer(data, np.int32, 8)
    numbers = np.frombuffer(data, np.float64, offset=32, count=3 + cells * (nodes * 3 + width))
    constants, x, w = np.split(numbers, [3, 3 + cells * nodes * 3])
    facet = np.frombuffer(data, np.int32, cells, offset=32 + 8 * numbers.size)
    return constants, x.reshape(cells, -1), w.reshape(cells, -1), facet, int(facets), int(size)


forms = {}
meta = json.loads((work / "gen/forms.json").read_text())
with tempfile.TemporaryDirectory() as directory:
    command = [work / "time_kernels", work / "gen/forms.txt", "--min-ms", "0", "--samples", "1", "--dump", directory]
    subprocess.run([*command, f"gcc_O2={work / 'lib_gcc_O2.so'}"], check=True, stdout=subprocess.DEVNULL)
    for name, form in meta.items():
        constants, x, w, facet, facets, size = read_dump(pathlib.Path(directory) / f"{name}.bin")
        rows = form["dofs"][0] if len(form["dofs"]) == 2 else 1
        kernel = getattr(library, f"kernel_{name}")
        kept, largest = [], 0.0
        for cell in range(BATCH * max(facets, 1)):
            matrix = np.zeros(size)
            kernel(pointer(matrix), pointer(w[cell]), pointer(constants), pointer(x[cell]), pointer(facet[cell : cell + 1]), None, None)
            kept.append(matrix.reshape(rows, -1)[(7 * cell + 3) % rows].tolist())
            largest = max(largest, float(np.abs(matrix).max()))
        forms[name] = {"largest": largest, "rows": kept}

import ffcx

with open(sys.argv[1], "w") as file:
    file.write('{"ffcx": ' + json.dumps(ffcx.__version__) + ', "forms": {\n')
    file.write(",\n".join(f"{json.dumps(name)}: {json.dumps(form)}" for name, form in forms.items()))
    file.write("\n}}\n")
