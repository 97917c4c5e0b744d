"""What the Python peers share: the cases of whole assembly, their clock, and the report that they print.

Cases (P2 or Q2 elasticity, λ = 1.2, μ = 0.8):
triangles   unit square, n × n × 2 triangles, straight; rule of degree 2 (3 points); n = 256
tetrahedra  unit cube, n × n × n × 6 tetrahedra, straight; rule of degree 2 (4 points); n = 32
annulus     1 < r < 2, n across × 8 n around, isoparametric Q2; 3 × 3 Gauss points; n = 64
"""

import argparse
import json
import os
import resource
import time

import numpy as np

LAMBDA, MU = 1.2, 0.8
# Of compilers of kernels: the instructions that our side has.
MARCH = os.environ.get("PEERS_MARCH", "native")
DIVISIONS = {"triangles": 256, "tetrahedra": 32, "annulus": 64}


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("case", choices=list(DIVISIONS))
    parser.add_argument("--divisions", type=int, help="n; default 256, 32, 64")
    parser.add_argument("--samples", type=int, default=5, help="how often each is timed")
    found = parser.parse_args()
    found.divisions = found.divisions or DIVISIONS[found.case]
    return found


def timed(function):
    start = time.perf_counter()
    result = function()
    return time.perf_counter() - start, result


def samples(function, count):
    """Seconds of `count` calls."""
    return [timed(function)[0] for _ in range(count)]


def annulus_nodes(n):
    """Nodes of the annulus on a grid of (2 n + 1) × 16 n, and for each cell its 3 × 3 nodes [cell][across][around]."""
    around = 16 * n
    radius, angle = np.meshgrid(1 + np.arange(2 * n + 1) / (2 * n), 2 * np.pi * np.arange(around) / around, indexing="ij")
    nodes = np.stack([(radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel()], axis=1)
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(n), np.arange(8 * n), indexing="ij"))
    across, turn = (2 * i[:, None] + np.arange(3)), (2 * j[:, None] + np.arange(3)) % around
    return nodes, across[:, :, None] * around + turn[:, None, :]


def report(program, version, unknowns, norm, reassembly, first, **more):
    """`norm` is the matrix's Frobenius norm: it tells whether two programs did the same."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    print(json.dumps({"program": program, "version": version, "unknowns": unknowns, "norm": norm, "reassembly": reassembly,
                      "first": first, "peak_bytes": peak, **more}))
