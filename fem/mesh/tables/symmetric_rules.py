"""Symmetric quadrature rules with positive weights and points inside, for triangles and tetrahedra.

    python3 fem/mesh/tables/symmetric_rules.py > fem/mesh/src/quadrature/tables.rs && cargo fmt -p forms-mesh

needs mpmath. The number of orbits of each kind in a rule is that of P. Keast, Moderate-degree tetrahedral quadrature formulas, CMAME 55
(1986), D. A. Dunavant, IJNME 21 (1985), and F. D. Witherden, P. E. Vincent, On the identification of symmetric quadrature rules for finite
element methods, Comput. Math. Appl. 69 (2015). Points and weights are computed here, from nothing but the moment equations: random starts,
damped least squares in double precision, Newton's method with 50 digits. A rule is exact for all polynomials if it is for those that no
permutation of the vertices changes, the polynomials in the power sums of the barycentric coordinates less their mean.
"""

import itertools
import math
import random
from fractions import Fraction

import mpmath

# Barycentric coordinates of one point of an orbit, from its parameters.
KINDS = {
    2: {
        "Centre": (0, lambda p: [p[0] * 0 + 1 / (p[0] * 0 + 3)] * 3),
        "Vertex": (1, lambda p: [p[0], p[0], 1 - 2 * p[0]]),
        "General": (2, lambda p: [p[0], p[1], 1 - p[0] - p[1]]),
    },
    3: {
        "Centre": (0, lambda p: [p[0] * 0 + 1 / (p[0] * 0 + 4)] * 4),
        "Vertex": (1, lambda p: [p[0]] * 3 + [1 - 3 * p[0]]),
        "Edge": (1, lambda p: [p[0], p[0], 0.5 - p[0], 0.5 - p[0]]),
        "General": (2, lambda p: [p[0], p[0], p[1], 1 - 2 * p[0] - p[1]]),
    },
}
SIZES = {2: {"Centre": 1, "Vertex": 3, "General": 6}, 3: {"Centre": 1, "Vertex": 4, "Edge": 6, "General": 12}}

# Degree and number of orbits of each kind.
RULES = {
    2: [
        (7, {"Vertex": 3, "General": 1}),
        (8, {"Centre": 1, "Vertex": 3, "General": 1}),
        (9, {"Centre": 1, "Vertex": 4, "General": 1}),
    ],
    3: [
        (6, {"Vertex": 3, "General": 1}),
        (7, {"Centre": 1, "Vertex": 1, "Edge": 1, "General": 2}),
    ],
}


def exponents(dimension, degree):
    """Exponents of the power sums 2, ..., dimension + 1 in the invariants up to a degree."""
    orders = range(2, dimension + 2)
    ranges = [range(degree // order + 1) for order in orders]
    return [e for e in itertools.product(*ranges) if sum(o * n for o, n in zip(orders, e)) <= degree]


def mean(dimension, exponent):
    """The mean of an invariant over the simplex, exactly: a sum over monomials, each with mean a! b! c! ... D! / (|a| + D)!."""
    count = dimension + 1
    shift = Fraction(-1, count)
    product = {(0,) * count: Fraction(1)}
    for order, times in zip(range(2, dimension + 2), exponent):
        power_sum = {}
        for vertex in range(count):
            for k in range(order + 1):
                key = tuple(k if v == vertex else 0 for v in range(count))
                power_sum[key] = power_sum.get(key, 0) + math.comb(order, k) * shift ** (order - k)
        for _ in range(times):
            longer = {}
            for a, x in product.items():
                for b, y in power_sum.items():
                    key = tuple(i + j for i, j in zip(a, b))
                    longer[key] = longer.get(key, 0) + x * y
            product = longer
    total = Fraction(0)
    for key, coefficient in product.items():
        factor = Fraction(math.factorial(dimension), math.factorial(sum(key) + dimension))
        for k in key:
            factor *= math.factorial(k)
        total += coefficient * factor
    return total


def values(dimension, exponents_, barycentric):
    """The invariants at a point, and their derivatives by its barycentric coordinates."""
    count = dimension + 1
    centred = [x - (x * 0 + 1) / count for x in barycentric]
    orders = range(2, dimension + 2)
    sums = [sum(x ** order for x in centred) for order in orders]
    found, slopes = [], []
    for exponent in exponents_:
        value = centred[0] * 0 + 1
        for s, n in zip(sums, exponent):
            value *= s ** n
        slope = [centred[0] * 0] * count
        for index, order in enumerate(orders):
            n = exponent[index]
            if n == 0:
                continue
            rest = n * sums[index] ** (n - 1)
            for other, (s, m) in enumerate(zip(sums, exponent)):
                if other != index:
                    rest *= s ** m
            for k in range(count):
                slope[k] += rest * order * centred[k] ** (order - 1)
        found.append(value)
        slopes.append(slope)
    return found, slopes


def residual(dimension, kinds, exponents_, target, scale, unknowns):
    """Residuals of the moment equations, scaled, and their derivatives. Unknowns: for each orbit its parameters and its whole weight."""
    rows = [-t * s for t, s in zip(target, scale)]
    columns = []
    place = 0
    for kind in kinds:
        parameters, point = KINDS[dimension][kind]
        own, weight = unknowns[place : place + parameters], unknowns[place + parameters]
        place += parameters + 1
        arguments = own if parameters else [weight]
        here = point(arguments)
        found, slopes = values(dimension, exponents_, here)
        for row, value in enumerate(found):
            rows[row] += weight * value * scale[row]
        for k in range(parameters):
            moved = list(own)
            moved[k] = moved[k] + 1
            # Barycentric coordinates are affine in the parameters.
            change = [b - a for a, b in zip(here, point(moved))]
            columns.append([weight * scale[row] * sum(c * d for c, d in zip(change, slopes[row])) for row in range(len(rows))])
        columns.append([value * scale[row] for row, value in enumerate(found)])
    return rows, columns


def solve(matrix, right):
    """Gaussian elimination with pivots."""
    size = len(right)
    rows = [list(row) + [r] for row, r in zip(matrix, right)]
    for k in range(size):
        pivot = max(range(k, size), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        if rows[k][k] == 0:
            raise ZeroDivisionError
        for i in range(k + 1, size):
            factor = rows[i][k] / rows[k][k]
            if factor != 0:
                for j in range(k, size + 1):
                    rows[i][j] -= factor * rows[k][j]
    result = [None] * size
    for k in reversed(range(size)):
        result[k] = (rows[k][size] - sum(rows[k][j] * result[j] for j in range(k + 1, size))) / rows[k][k]
    return result


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def step(rows, columns, damping):
    normal = [[dot(a, b) for b in columns] for a in columns]
    for k in range(len(columns)):
        normal[k][k] += damping * (normal[k][k] + 1e-12)
    return solve(normal, [-dot(a, rows) for a in columns])


def polished(rows, columns):
    """The least change that solves the linearised equations; there are no more than unknowns."""
    count = len(rows)
    gram = [[sum(c[i] * c[j] for c in columns) for j in range(count)] for i in range(count)]
    multipliers = solve(gram, [-r for r in rows])
    return [dot(c, multipliers) for c in columns]


def start(dimension, kinds, generator):
    unknowns = []
    total = sum(SIZES[dimension][kind] for kind in kinds)
    for kind in kinds:
        if kind == "Vertex":
            unknowns.append(generator.uniform(0, 1 / dimension))
        elif kind == "Edge":
            unknowns.append(generator.uniform(0, 0.5))
        elif kind == "General":
            a = generator.uniform(0, 0.5)
            unknowns += [a, generator.uniform(0, 1 - (dimension - 1) * a)]
        unknowns.append(SIZES[dimension][kind] / total)
    return unknowns


def lies_inside(dimension, kinds, unknowns, margin):
    place = 0
    for kind in kinds:
        parameters, point = KINDS[dimension][kind]
        own, weight = unknowns[place : place + parameters], unknowns[place + parameters]
        place += parameters + 1
        if weight / SIZES[dimension][kind] <= margin or min(point(own or [weight])) <= margin:
            return False
    return True


def rule(dimension, degree, orbits):
    kinds = [kind for kind, count in orbits.items() for _ in range(count)]
    exponents_ = exponents(dimension, degree)
    exact = [mean(dimension, exponent) for exponent in exponents_]
    target = [float(x) for x in exact]
    # Sizes of the invariants at a vertex, so that all equations weigh alike.
    at_vertex = values(dimension, exponents_, [1.0] + [0.0] * dimension)[0]
    scale = [1 / max(abs(x), 1e-12) ** 0.5 for x in at_vertex]
    generator = random.Random(degree)
    for attempt in range(100_000):
        unknowns = start(dimension, kinds, generator)
        damping = 1e-1
        rows, columns = residual(dimension, kinds, exponents_, target, scale, unknowns)
        for _ in range(120):
            try:
                change = step(rows, columns, damping)
            except ZeroDivisionError:
                break
            trial = [u + c for u, c in zip(unknowns, change)]
            if max(abs(u) for u in trial) > 2:
                damping *= 4
                if damping > 1e8:
                    break
                continue
            new = residual(dimension, kinds, exponents_, target, scale, trial)
            if dot(new[0], new[0]) < dot(rows, rows):
                unknowns, (rows, columns) = trial, new
                damping = max(damping / 5, 1e-14)
            else:
                damping *= 4
                if damping > 1e8:
                    break
            if dot(rows, rows) < 1e-26:
                break
        if dot(rows, rows) > 1e-20 or not lies_inside(dimension, kinds, unknowns, 1e-4):
            continue
        with mpmath.workdps(50):
            precise = [mpmath.mpf(u) for u in unknowns]
            moments = [mpmath.mpf(x.numerator) / x.denominator for x in exact]
            ones = [mpmath.mpf(1)] * len(exact)
            for _ in range(8):
                rows, columns = residual(dimension, kinds, exponents_, moments, ones, precise)
                precise = [u + c for u, c in zip(precise, polished(rows, columns))]
            rows, _ = residual(dimension, kinds, exponents_, moments, ones, precise)
            if max(abs(r) for r in rows) < mpmath.mpf(10) ** -40 and lies_inside(dimension, kinds, precise, 1e-4):
                return kinds, precise
    raise SystemExit(f"no rule of degree {degree} in {dimension} dimensions")


def main():
    names = {2: "TRIANGLE", 3: "TETRAHEDRON"}
    print("//! Symmetric rules on the triangle and the tetrahedron, as `fem/mesh/tables/symmetric_rules.py` has computed them from the moment")
    print("//! equations: positive weights, points inside.")
    print()
    print("/// Orbits of a rule of some degree: the weight of each point, and the barycentric coordinates of one of them.")
    print("pub(super) type Orbits<const N: usize> = (usize, &'static [(f64, [f64; N])]);")
    for dimension, rules in RULES.items():
        print()
        print(f"/// Rules on the {names[dimension].lower()}.")
        print("#[rustfmt::skip]")
        print(f"pub(super) const {names[dimension]}: &[Orbits<{dimension + 1}>] = &[")
        for degree, orbits in rules:
            kinds, unknowns = rule(dimension, degree, orbits)
            points = sum(SIZES[dimension][kind] for kind in kinds)
            print(f"    // {points} points.")
            print(f"    ({degree}, &[")
            place = 0
            for kind in kinds:
                parameters, point = KINDS[dimension][kind]
                own, weight = unknowns[place : place + parameters], unknowns[place + parameters]
                place += parameters + 1
                with mpmath.workdps(50):
                    coordinates = [float(x) for x in point(own or [weight])]
                    weight = float(weight / SIZES[dimension][kind])
                print(f"        ({weight!r}, [{', '.join(map(repr, coordinates))}]),")
            print("    ]),")
        print("];")


main()
