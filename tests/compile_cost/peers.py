"""What the same forms cost FFCx and GetFEM, from the blocks of docs/coming_from.md and forms.md.

    python tests/compile_cost/peers.py ffcx        # requirements.txt of tests/coming_from, and fenics-ffcx==0.11.0; a C compiler
    python3 tests/compile_cost/peers.py getfem     # Debian: python3-getfem

FFCx: seconds of CPU to generate C from the UFL of residual and tangent, and to compile it with `cc -O2` (DOLFINx's choice). GetFEM: seconds to
assemble residual and tangent on a mesh of 18 triangles, which holds all that it does with the strings at each assembly.
"""
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "coming_from"))
import check  # noqa: E402


def ffcx_seconds(code, cell, geometry):
    import ffcx.compiler
    import ffcx.options
    import resource
    import ufl

    def cpu():
        own, children = (resource.getrusage(w) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime

    names = check.ufl_names(cell, geometry)
    start = cpu()
    exec(code, names)
    forms = [names["a"], names["L"]] if "L" in names else [f for f in names.values() if isinstance(f, ufl.Form)]
    files, suffixes = ffcx.compiler.compile_ufl_objects(forms, ffcx.options.get_options({}), namespace="form")
    generated = cpu() - start
    with tempfile.TemporaryDirectory() as folder:
        for text, suffix in zip(files, suffixes):
            (Path(folder) / f"form{suffix}").write_text(text)
        include = ffcx.codegeneration.get_include_path()
        subprocess.run(["cc", "-O2", "-std=c17", f"-I{include}", "-c", "form.c"], cwd=folder, check=True)
    return f"{generated:.2f} s to generate, {cpu() - start - generated:.2f} s to compile"


def getfem_seconds(code):
    names = check.getfem_names()
    exec(code, names)
    names["md"].assembly()
    start = time.perf_counter()
    for _ in range(20):
        names["md"].assembly()
    return f"{(time.perf_counter() - start) / 20 * 1e3:.2f} ms"


if __name__ == "__main__":
    for language in sys.argv[1:] or ["ffcx", "getfem"]:
        for heading, code in check.blocks("ufl" if language == "ffcx" else language):
            if language == "getfem":
                print(f"GetFEM  {heading}: {getfem_seconds(code)}", flush=True)
                continue
            for cell, geometry in (("triangle", 1), ("quadrilateral", 2)):
                try:
                    seconds = ffcx_seconds(code, cell, geometry)
                except RuntimeError as error:
                    seconds = f"refused: {error}"
                print(f"FFCx    {heading}, {cell}s, geometry of degree {geometry}: {seconds}", flush=True)
