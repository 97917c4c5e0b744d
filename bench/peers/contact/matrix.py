"""Prints one table of formulations and problems from files that `contact_bench` wrote.

usage: matrix.py FILE.json ...        (out/contact_bench/contact_bench.json)

A cell has the error on the finest mesh of the file and the Newton steps there: that of the pressure where it is known, else of the first known number.
A cell without numbers has a letter, whose reason is below the table.
"""

import json
import re
import sys

# Columns, and the number that is compared where no pressure is known.
COLUMNS = {
    "patch": None, "lame": None, "squares": "u_y(5.5)", "hertz": None, "two_balls": None, "sliding_parabola": "(max − min)/mean", "punch": "part of F within 0.8 a",
    "wavy": None, "half_ball": "reaction", "bar_massless": "impulse", "cattaneo": "error of τ, Q = 0.6 κP", "boxes": "energy 4",
    "drawn_die": "(max − min)/mean of F_y", "obstacle": "H1 error", "closing_c": "F(10)", "half_ring": "F(2)",
}
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def short(number):
    """One digit and a power of ten."""
    if number < 1e-12:
        return "0"
    digit, power = f"{number:.0e}".split("e")
    return f"{digit}·10{str(int(power)).translate(SUPERSCRIPTS)}"


def error(problem, measured):
    name = COLUMNS[problem]
    if name is None:
        return measured["pressure_error"]
    for quantity in measured["quantities"]:
        if quantity["name"] == name:
            exact = quantity["exact"]
            return abs(quantity["value"] / exact - 1) if exact else abs(quantity["value"])
    return None


def main():
    cells, formulations, reasons = {}, [], []
    rows = [row for path in sys.argv[1:] for row in json.load(open(path))]
    for row in rows:
        key = row["formulation"], row["problem"]
        if row["problem"] not in COLUMNS:
            continue
        if row["formulation"] not in formulations:
            formulations.append(row["formulation"])
        # Later rows are of finer meshes.
        answer = row["answer"]
        if "solved" in answer:
            found = error(row["problem"], answer["solved"])
            cells[key] = f"{short(found)}, {answer['solved']['newton']}" if found is not None else "?"
        else:
            ((kind, why),) = answer.items()
            # Places in the history of a failure differ by problem.
            why = re.sub(r" at iteration \d+|step \d+: ", "", why.splitlines()[0])
            why = f"not defined: {why}" if kind == "not_defined" else f"fails: {re.sub(r'[-+0-9.e]{2,}', '…', why)}"
            if why not in reasons:
                reasons.append(why)
            cells[key] = chr(ord("a") + reasons.index(why)) if reasons.index(why) < 26 else str(reasons.index(why) - 25)
    problems = [problem for problem in COLUMNS if any(key[1] == problem for key in cells)]
    print("| formulation | " + " | ".join(problems) + " |")
    print("| --- |" + " --: |" * len(problems))
    for formulation in formulations:
        print(f"| {formulation} | " + " | ".join(cells.get((formulation, problem), "") for problem in problems) + " |")
    for number, why in enumerate(reasons):
        print(f"{chr(ord('a') + number) if number < 26 else number - 25}: {why}")


main()
