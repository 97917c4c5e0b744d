"""A row of the benchmark, as a line of JSON."""

import json


def row(problem, formulation, degree, level, unknowns, seconds, numbers, newton=None, outer=None):
    """`numbers` has the names of the problem's quantities; `newton` lists the steps of each solve. The level is that of a mesh as fine, and None for a
    reference, which is shown with each mesh."""
    newton = list(newton or [])
    print(json.dumps({
        "problem": problem, "formulation": formulation, "degree": degree, "level": level, "unknowns": int(unknowns),
        "seconds": seconds, "newton": newton, "outer": outer, "numbers": {name: float(value) for name, value in numbers.items()},
    }), flush=True)
