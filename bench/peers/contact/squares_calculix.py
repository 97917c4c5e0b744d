"""Two squares whose contact ends at unknown places, in CalculiX: a layer of bilinear hexahedra between two planes, mortar with dual multipliers, and
penalty between faces."""

import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from rows import row

# MPa and mm.
BODIES = {"lower": (15000.0, 0.2, 0.0), "upper": (20000.0, 0.4, 10.0)}
PLACES = {"9.6667": 9.6667, "5.5": 5.5}


def deck(cells, kind):
    """The input, and the numbers of the lower body's nodes at y = 10 and z = 0 by x."""
    lines, first, tops = ["*NODE, NSET=ALL"], 1, None
    grids = {}
    for body, (_, _, low) in BODIES.items():
        n = cells[body]
        numbers = first + np.arange(2 * (n + 1) ** 2).reshape(2, n + 1, n + 1)
        grids[body] = numbers
        for z in (0, 1):
            for j in range(n + 1):
                for i in range(n + 1):
                    lines.append(f"{numbers[z, j, i]}, {10 * i / n:.15g}, {low + 10 * j / n:.15g}, {z}")
        first = numbers.max() + 1
    element, facets = 1, {}
    for body, numbers in grids.items():
        n = cells[body]
        lines.append(f"*ELEMENT, TYPE=C3D8, ELSET={body}")
        elements = element + np.arange(n * n).reshape(n, n)
        for j in range(n):
            for i in range(n):
                quad = [[numbers[z, j, i], numbers[z, j, i + 1], numbers[z, j + 1, i + 1], numbers[z, j + 1, i]] for z in (0, 1)]
                lines.append(", ".join(map(str, [elements[j, i], *quad[0], *quad[1]])))
        element = elements.max() + 1
        # Faces 3 to 6 are those at the lower, right, upper and left sides.
        facets[body] = {"down": [(e, 3) for e in elements[0]], "right": [(e, 4) for e in elements[:, -1]],
                        "up": [(e, 5) for e in elements[-1]], "left": [(e, 6) for e in elements[:, 0]]}
    for body, (young, poisson, _) in BODIES.items():
        lines += [f"*MATERIAL, NAME={body}", "*ELASTIC", f"{young}, {poisson}", f"*SOLID SECTION, ELSET={body}, MATERIAL={body}"]
    for name, (body, side) in {"OWN": ("lower", "up"), "OPPOSITE": ("upper", "down")}.items():
        lines += [f"*SURFACE, NAME={name}, TYPE=ELEMENT", *(f"{e}, S{face}" for e, face in facets[body][side])]
    lines += ["*SURFACE INTERACTION, NAME=TOUCH"]
    if kind == "mortar":
        lines += ["*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD", "*CONTACT PAIR, INTERACTION=TOUCH, TYPE=MORTAR"]
    else:
        lines += ["*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{kind:g}", "*CONTACT PAIR, INTERACTION=TOUCH, TYPE=SURFACE TO SURFACE"]
    lines += ["OWN, OPPOSITE", "*BOUNDARY", "ALL, 3, 3"]
    lines += [f"{node}, 1, 2" for node in grids["lower"][:, 0, :].ravel()]
    lines += ["*STEP, INC=200", "*STATIC", "0.2, 1.", "*BOUNDARY"]
    for node in grids["upper"][:, -1, :].ravel():
        lines += [f"{node}, 1, 1, 0.", f"{node}, 2, 2, -5e-4"]
    # Tractions (±0.1, −1) on the lower sides: a pressure, and forces at nodes.
    lines += ["*DLOAD", *(f"{e}, P{face}, 0.1" for side in ("left", "right") for e, face in facets["lower"][side]), "*CLOAD"]
    n = cells["lower"]
    for i in (0, n):
        for j in range(n + 1):
            part = 10 / n * (0.5 if j in (0, n) else 1) / 2
            lines += [f"{grids['lower'][z, j, i]}, 2, {-part:.15g}" for z in (0, 1)]
    top = grids["lower"][0, -1]
    lines += ["*NSET, NSET=TOP", *(str(node) for node in top), "*NSET, NSET=HEAD", *(str(node) for node in grids["upper"][:, -1].ravel())]
    lines += ["*NODE PRINT, NSET=TOP, FREQUENCY=1000", "U", "*NODE PRINT, NSET=HEAD, FREQUENCY=1000, TOTALS=ONLY", "RF", "*END STEP", ""]
    return "\n".join(lines), top


def solve(level, kind):
    cells = {"lower": 15 << level, "upper": (35 << level) // 2}
    text, top = deck(cells, kind)
    with tempfile.TemporaryDirectory() as place:
        (Path(place) / "squares.inp").write_text(text)
        done = subprocess.run(["ccx", "squares"], cwd=place, capture_output=True, text=True)
        result = (Path(place) / "squares.dat").read_text() if done.returncode == 0 else ""
        history = (Path(place) / "squares.sta").read_text() if done.returncode == 0 else ""
    numbers = [line.split() for line in result.splitlines()]
    rows_ = {int(parts[0]): [float(part) for part in parts[1:3]] for parts in numbers if len(parts) == 4 and parts[0].isdigit()}
    if len(rows_) < len(top):
        raise ArithmeticError((done.stdout.strip().splitlines() or ["no message"])[-1])
    u = np.array([rows_[node] for node in top])
    x = np.linspace(0, 10, len(top))
    found = {f"u_{axis}({name})": np.interp(at, x, u[:, k]) for name, at in PLACES.items() for k, axis in enumerate("xy")}
    # All forces on the upper body are those of its top and of contact.
    totals = [parts for parts in numbers if len(parts) == 3]
    found["force"] = -float(totals[-1][1])
    # Columns of the file: step, increment, attempt, iterations, times.
    steps = [int(parts[3]) for parts in map(str.split, history.splitlines()) if parts and parts[0].isdigit()]
    unknowns = 2 * sum((n + 1) ** 2 for n in cells.values())
    return unknowns, steps, found


for name, kind in (("dual mortar", "mortar"), ("penalty 10⁶ N/mm³", 1e6)):
    for level in range(3):
        start = time.perf_counter()
        try:
            unknowns, steps, found = solve(level, kind)
        except ArithmeticError as why:
            print(f"{name}, level {level}: {why}")
            continue
        row("squares", f"CalculiX, {name}", 1, level, unknowns, time.perf_counter() - start, found, newton=steps)
