"""A membrane over an obstacle by MFEM's example 36, which is proximal Galerkin with α = 1 and inner loops cut short.

The wheel of PyMFEM brings the compiled example. It is asked for at most 40 outer steps in place of 10, so that its tolerance decides.
"""

import os
import re
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import mfem

from rows import row

ROOT = Path(mfem.__file__).parent / "external" / "ser"


def number(name, text):
    return float(re.search(re.escape(name) + r"[^=:\n]*[=:]\s*([-+0-9.e]+)", text).group(1))


with tempfile.TemporaryDirectory() as place:
    run = Path(place) / "run"
    run.mkdir()
    (Path(place) / "data").mkdir()
    shutil.copy(ROOT / "data" / "disc-nurbs.mesh", Path(place) / "data")
    for order in (1, 2, 3):
        for level, refinements in enumerate((2, 3, 4)):
            command = [str(ROOT / "examples" / "ex36"), "-o", str(order), "-r", str(refinements), "-mi", "40", "-no-vis"]
            start = time.perf_counter()
            paths = {**os.environ, "LD_LIBRARY_PATH": str(ROOT / "lib")}
            text = subprocess.run(command, cwd=run, env=paths, capture_output=True, text=True, check=True).stdout
            inner = [int(count) for count in re.findall(r"Number of Newton iterations = (\d+)", text)]
            latent = 80 * 4**level * order**2
            numbers = {"H1 error": number("Final H1-error", text), "L2 error": number("Final L2-error", text)}
            row("obstacle", f"MFEM ex36, u of degree {order + 1}, ψ of degree {order - 1}", order + 1, level,
                number("Total dofs", text) - latent, time.perf_counter() - start, numbers, newton=inner, outer=len(inner))
