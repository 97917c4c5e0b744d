#!/usr/bin/env python3
"""What a form costs rustc: the time of a crate that has it, less the time of one that has not.

    python3 tests/compile_cost/measure.py                 # every form, a Markdown table
    python3 tests/compile_cost/measure.py stokes direct   # some

Python 3.11 and the project's Rust are enough. A crate of its own is made in a temporary directory for each form: the form's module from
the repository, unchanged, and a function that assembles residual and tangent, so that the kernels become machine code.
rustc itself is timed, by a wrapper that cargo calls: user and system seconds of the CPU, which other work on the
machine disturbs little. README.md says what the columns are.
"""
import argparse
import json
import os
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Kept, so that the dependencies are built once.
TARGET = ROOT / "target" / "compile_cost"
REPEATS = 3
# These vary less, and take longest.
FULL_REPEATS = 1

# name: file, module, form, regions, known fields besides
FORMS = {
    "Stokes": ("examples/forms/stokes.rs", "flow", "equilibrium", ["Omega"], 0),
    "interior penalty": ("examples/forms/interior_penalty.rs", "diffusion", "balance", ["Omega", "Inner", "Boundary"], 0),
    "neo-Hooke": ("examples/forms/neo_hookean.rs", "solid", "energy", ["Omega"], 0),
    "Mooney-Rivlin": ("examples/forms/mooney_rivlin.rs", "solid", "energy", ["Omega"], 0),
    "anisotropic elasticity": ("examples/forms/anisotropic_elasticity.rs", "solid", "equilibrium", ["Omega"], 0),
    "p-Laplacian": ("examples/forms/p_laplacian.rs", "diffusion", "energy", ["Omega"], 0),
    "ghost penalty": ("examples/forms/ghost_penalty.rs", "stabilisation", "penalty", ["Inner"], 0),
    "Signorini": ("examples/04_signorini.rs", "block", "contact", ["Omega", "Bottom"], 0),
    "Nitsche: direct": ("contact/problem/src/nitsche.rs", "nitsche", "direct", ["Omega", "GammaN", "GammaC"], 0),
    "Nitsche: discrete adjoint":
        ("contact/problem/src/nitsche.rs", "nitsche", "discrete_adjoint", ["Omega", "GammaC", "Boundary"], 1),
    "Nitsche: consistent adjoint":
        ("contact/problem/src/nitsche.rs", "nitsche", "consistent_adjoint", ["Omega", "GammaC", "Boundary"], 1),
    "Nitsche: extended adjoint":
        ("contact/problem/src/nitsche.rs", "nitsche", "extended_adjoint", ["Omega", "GammaC", "Boundary"], 1),
}

MANIFEST = """[package]
name = "measured"
version = "0.0.0"
edition = "2024"
[dependencies]
forms-fem = { path = "%s" }
[profile.release]
incremental = %s
[profile.release.build-override]
opt-level = 2
[workspace]
"""

WITHOUT = """use forms_fem::prelude::*;
pub fn assemble<'a>(assembler: &Assembler<2>, unknowns: &[&'a Field<2>]) -> (usize, &'a Field<2>) {
    (assembler.mesh().cell_count() + EDIT, unknowns[0])
}
"""

WITH = """use forms_fem::prelude::*;
%(module)s
pub fn assemble(
    assembler: &Assembler<%(d)d>, %(data)s unknowns: &[&Field<%(d)d>], tests: &[&Arc<Space<%(d)d>>],
) -> Result<(Vec<f64>, forms_fem::linear_algebra::CsrMatrix), AssemblyError> {
    let form = %(name)s::%(form)s(%(arguments)s);
    Ok((assembler.residual(&form, unknowns, tests)?, assembler.tangent(&form, unknowns, tests)?))
}
"""


def module_text(file, name):
    """The forms module of a file, from its attribute to its last brace."""
    lines = (ROOT / file).read_text().splitlines()
    start = next(k for k, line in enumerate(lines) if re.match(rf"(pub )?mod {name} \{{", line))
    end = next(k for k in range(start, len(lines)) if lines[k] == "}")
    attribute = next(lines[k] for k in range(start, -1, -1) if lines[k].startswith("#[forms"))
    return "\n".join([attribute, *lines[start:end + 1]])


def source(form, dimension, edit):
    """The crate's text. An edit multiplies the form's first integral by another number."""
    if form is None:
        return WITHOUT.replace("EDIT", str(edit))
    file, name, function, regions, fields = FORMS[form]
    module = module_text(file, name)
    head, body = re.split(rf"(?=\n    pub fn {function}\()", module)
    # Where the form calls others, they hold the integral: any number of the module will do.
    place = body if "integral(" in body[: body.index("\n    }")] else module
    edited = place.replace("integral(", f"{edit + 2} * integral(", 1)
    module = head + edited if place is body else edited
    has_data = "struct Data" in module
    arguments = ["data"] if has_data else []
    arguments += [f'&{name}::{region}::on("all")' for region in regions] + ["unknowns[0]"] * fields
    return WITH % {
        "module": module, "name": name, "form": function, "d": dimension,
        "data": f"data: &{name}::Data<{dimension}>," if has_data else "", "arguments": ", ".join(arguments),
    }


class Crate:
    """A crate with one form, or with none."""

    def __init__(self, folder, target, form, dimension, incremental):
        self.folder, self.target, self.form, self.dimension = folder, target, form, dimension
        (folder / "src").mkdir(parents=True)
        flag = "true" if incremental else "false"
        (folder / "Cargo.toml").write_text(MANIFEST % (ROOT / "fem", flag))
        shutil.copy(ROOT / "Cargo.lock", folder)

    def build(self, edit, command="build"):
        """Seconds of CPU that rustc takes for this crate alone."""
        (self.folder / "src" / "lib.rs").write_text(source(self.form, self.dimension, edit))
        record = self.folder / "seconds.json"
        record.unlink(missing_ok=True)
        environment = os.environ | {
            "RUSTC_WORKSPACE_WRAPPER": str(Path(__file__).resolve()), "COMPILE_COST_RECORD": str(record),
            "CARGO_TARGET_DIR": str(self.target),
        }
        arguments = [os.environ.get("CARGO", "cargo"), command, "--release", "--quiet", "--offline"]
        subprocess.run(arguments, cwd=self.folder, env=environment, check=True)
        return json.loads(record.read_text())


def wrapped(arguments):
    """What cargo calls in place of rustc: rustc, with its time taken."""
    start = time.perf_counter()
    # cargo hands the job server over as open files.
    code = subprocess.run(arguments, close_fds=False).returncode
    wall = time.perf_counter() - start
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    record = os.environ.get("COMPILE_COST_RECORD")
    if record and "--crate-name" in arguments:
        Path(record).write_text(json.dumps({"cpu": used.ru_utime + used.ru_stime, "wall": wall}))
    sys.exit(code)


def measure(form, dimension, work):
    """(check, full build, build after an edit) in CPU seconds, medians; and the last one's seconds by the clock."""
    folder = Path(tempfile.mkdtemp(dir=work))
    crate = Crate(folder / "incremental", TARGET, form, dimension, True)
    crate.build(0, "check")
    checks = [crate.build(edit, "check")["cpu"] for edit in range(1, REPEATS + 1)]
    crate.build(0)
    edits = [crate.build(edit) for edit in range(1, REPEATS + 1)]
    full = Crate(folder / "full", TARGET, form, dimension, False)
    fulls = [full.build(edit)["cpu"] for edit in range(FULL_REPEATS)]
    return (
        statistics.median(checks), statistics.median(fulls),
        statistics.median(edit["cpu"] for edit in edits), statistics.median(edit["wall"] for edit in edits),
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("forms", nargs="*", help="parts of names; every form without")
    parser.add_argument("--dimension", type=int, choices=(2, 3), default=2)
    arguments = parser.parse_args()
    chosen = [name for name in FORMS if not arguments.forms or any(part in name for part in arguments.forms)]
    with tempfile.TemporaryDirectory() as work:
        work = Path(work)
        without = measure(None, 2, work)
        print("without a form:", " ".join(f"{value:.2f}" for value in without), file=sys.stderr, flush=True)
        print(f"| form, {arguments.dimension}D | check | release, from nothing | release, after an edit | by the clock |")
        print("| --- | ---: | ---: | ---: | ---: |")
        for form in chosen:
            cost = [a - b for a, b in zip(measure(form, arguments.dimension, work), without)]
            print(f"| {form} | " + " | ".join(f"{value:.2f}" for value in cost) + " |", flush=True)


if __name__ == "__main__":
    if "COMPILE_COST_RECORD" in os.environ and len(sys.argv) > 1 and "rustc" in Path(sys.argv[1]).name:
        wrapped(sys.argv[1:])
    else:
        main()
