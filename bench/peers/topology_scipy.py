"""The cantilever of examples/topology.rs in NumPy and SciPy, by optimality criteria, to compare compliances with.

usage: topology_scipy.py [--cells N] [--iterations N]      (pip install numpy scipy)

Bilinear displacements and smooth densities on squares, 2 x 2 points, E = 1e-3 + 0.999 s^3, plane stress, the filter
r^2 grad s . grad w + (s - rho) w, and the update of the optimality criteria with exponent 1/2 and move limit 0.2.
"""

import argparse

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg as linalg

parser = argparse.ArgumentParser()
parser.add_argument("--cells", type=int, default=120)
parser.add_argument("--iterations", type=int, default=200)
options = parser.parse_args()

RADIUS, HALF_LOAD, PART, NU = 0.02, 0.1, 0.5, 0.3
nx, ny = options.cells, options.cells // 2
h = 2.0 / nx
D = np.array([[1, NU, 0], [NU, 1, 0], [0, 0, (1 - NU) / 2]]) / (1 - NU**2)

# Shape functions and gradients at the points of one square, corners counterclockwise.
corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
points = [0.5 - 0.5 / 3**0.5, 0.5 + 0.5 / 3**0.5]
N, G = [], []
for a in points:
    for b in points:
        fx, gx = [1 - a, a], [-1, 1]
        fy, gy = [1 - b, b], [-1, 1]
        N.append([fx[i] * fy[j] for i, j in corners])
        G.append([[gx[i] * fy[j] / h, fx[i] * gy[j] / h] for i, j in corners])
N, G, weight = np.array(N), np.array(G), h * h / 4
stiff = []
for g in G:
    B = np.zeros((3, 8))
    B[0, 0::2], B[1, 1::2], B[2, 0::2], B[2, 1::2] = g[:, 0], g[:, 1], g[:, 1], g[:, 0]
    stiff.append(weight * B.T @ D @ B)
stiff = np.array(stiff)

node = lambda i, j: i * (ny + 1) + j
I, J = np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij")
I, J = I.ravel(), J.ravel()
nodes = np.stack([node(I, J), node(I + 1, J), node(I + 1, J + 1), node(I, J + 1)], axis=1)
dofs = np.stack([2 * nodes, 2 * nodes + 1], axis=2).reshape(len(nodes), 8)
count = (nx + 1) * (ny + 1)


def assembled(blocks, numbers, size):
    k = numbers.shape[1]
    rows, columns = np.repeat(numbers, k, axis=1), np.tile(numbers, (1, k))
    return sparse.csc_matrix((blocks.reshape(len(numbers), -1).ravel(), (rows.ravel(), columns.ravel())), (size, size))


element = sum(weight * (RADIUS**2 * g @ g.T + np.outer(n, n)) for n, g in zip(N, G))
smooth = linalg.splu(assembled(np.broadcast_to(element, (len(nodes), 4, 4)), nodes, count))
spread = sparse.csr_matrix((np.full(nodes.size, h * h / 4), (nodes.ravel(), np.repeat(np.arange(len(nodes)), 4))))

# The force: the density 1/(2 HALF_LOAD) where |y - 1/2| < HALF_LOAD, by two points on each edge.
F = np.zeros(2 * count)
for j in range(ny):
    for b in points:
        if abs((j + b) * h - 0.5) < HALF_LOAD:
            F[2 * node(nx, j) + 1] -= (1 - b) * h / 2 / (2 * HALF_LOAD)
            F[2 * node(nx, j + 1) + 1] -= b * h / 2 / (2 * HALF_LOAD)
free = np.arange(2 * (ny + 1), 2 * count)


def value_and_gradient(rho):
    s = smooth.solve(spread @ rho)
    at = s[nodes] @ N.T
    E, slope = 1e-3 + 0.999 * at**3, 3 * 0.999 * at**2
    K = assembled(np.einsum("ep,pij->eij", E, stiff), dofs, 2 * count)[free][:, free]
    u = np.zeros(2 * count)
    u[free] = linalg.spsolve(K, F[free])
    energy = np.einsum("ei,pij,ej->ep", u[dofs], stiff, u[dofs])
    by_s = np.zeros(count)
    np.add.at(by_s, nodes, np.einsum("ep,pn->en", -slope * energy, N))
    return F @ u, spread.T @ smooth.solve(by_s)


rho = np.full(len(nodes), PART)
value, gradient = value_and_gradient(rho)
wave = np.sin(7 * (I + 0.5) * h + 3 * (J + 0.5) * h)
print(f"{nx} x {ny}: J = {value:.9f}, slope along sin(7x + 3y) {gradient @ wave:.9e}")
for iteration in range(options.iterations + 1):
    value, gradient = value_and_gradient(rho)
    if iteration in [1, 2, 5] or iteration % 25 == 0:
        print(f"{iteration}: {value:.5f}, mean {rho.mean():.6f}", flush=True)
    low, high = 0.0, 1e9
    while (high - low) > 1e-12 * (low + high):
        middle = 0.5 * (low + high)
        new = rho * np.sqrt(np.maximum(-gradient, 0) / middle / (h * h))
        new = np.clip(new, np.maximum(rho - 0.2, 1e-9), np.minimum(rho + 0.2, 1.0))
        low, high = (middle, high) if new.mean() > PART else (low, middle)
    change, rho = np.abs(new - rho).max(), new
value, _ = value_and_gradient(rho)
print(f"after {options.iterations}: {value:.6f}, mean {rho.mean():.6f}, last change {change:.1e}")
