"""Small meshes in the project's node order, and their scikit-fem counterparts.

A mesh is made here as plain arrays: `nodes` (one row per node) and `cells` (one
row of node numbers per cell, in the project's order). The reference positions
below define that order; scikit-fem's own local order differs and is translated
by comparing reference positions, so that both sides use the same map from the
reference cell to the cell.
"""
from dataclasses import dataclass

import numpy as np
import skfem
from skfem.assembly.dofs import Dofs

# Reference nodes in the project's order: vertices, edge midpoints in edge order,
# face centres, cell centre. Only what the reference files need is listed.
REFERENCE_NODES = {
    ("triangle", 1): [(0, 0), (1, 0), (0, 1)],
    ("quadrilateral", 1): [(0, 0), (1, 0), (1, 1), (0, 1)],
    ("quadrilateral", 2): [
        (0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5), (0.5, 0.5),
    ],
    ("tetrahedron", 1): [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    ("hexahedron", 1): [
        (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1),
    ],
}
VERTICES = {"triangle": 3, "quadrilateral": 4, "tetrahedron": 4, "hexahedron": 8}
MESHES = {
    ("triangle", 1): skfem.MeshTri1,
    ("quadrilateral", 1): skfem.MeshQuad1,
    ("quadrilateral", 2): skfem.MeshQuad2,
    ("tetrahedron", 1): skfem.MeshTet1,
    ("hexahedron", 1): skfem.MeshHex1,
}


@dataclass
class ReferenceMesh:
    """Arrays in the project's order and the same mesh for scikit-fem."""

    shape: str
    degree: int
    nodes: np.ndarray
    cells: np.ndarray
    skfem: skfem.Mesh
    vertex_nodes: np.ndarray         # scikit-fem's vertex number -> node number

    def diameters(self):
        """The largest distance between two vertices of each cell."""
        corners = self.nodes[self.cells[:, : VERTICES[self.shape]]]
        distance = corners[:, :, None] - corners[:, None, :]
        return np.sqrt((distance**2).sum(axis=-1).max(axis=(1, 2)))

    def facets_where(self, condition):
        """Numbers (scikit-fem's) of boundary facets whose vertices' mean satisfies it."""
        return self.skfem.facets_satisfying(condition, boundaries_only=True)

    def local_facets(self, facets):
        """(cell, local facet) for scikit-fem's facets; plane cells only."""
        count = VERTICES[self.shape]
        found = []
        for facet in facets:
            cell = int(self.skfem.f2t[0, facet])
            ends = set(self.vertex_nodes[self.skfem.facets[:, facet]])
            vertices = self.cells[cell, :count]
            local = [f for f in range(count) if {vertices[f], vertices[(f + 1) % count]} == ends]
            found.append([cell, local[0]])
        return found


def from_arrays(shape, degree, nodes, cells):
    """Build the scikit-fem mesh that has exactly these nodes and cells."""
    nodes, cells = np.asarray(nodes, dtype=float), np.asarray(cells)
    kind = MESHES[shape, degree]
    vertex_nodes, vertices = np.unique(cells[:, : VERTICES[shape]], return_inverse=True)
    vertices = vertices.reshape(len(cells), -1)
    order = local_order(REFERENCE_NODES[shape, 1], MESHES[shape, 1].elem().doflocs)
    options = {"sort_t": False} if shape == "triangle" else {}
    topology = np.ascontiguousarray(vertices[:, order].T)
    points = np.ascontiguousarray(nodes[vertex_nodes].T)
    mesh = MESHES[shape, 1](points, topology, **options)
    if degree == 2:
        element = kind.elem()
        order = local_order(REFERENCE_NODES[shape, 2], element.doflocs)
        dofs = Dofs(mesh, element).element_dofs
        points = np.zeros((nodes.shape[1], dofs.max() + 1))
        points[:, dofs] = nodes[cells[:, order].T].transpose(2, 0, 1)
        mesh = kind(points, topology)
    assert np.array_equal(mesh.t, topology)          # scikit-fem did not reorder
    centre = np.full((nodes.shape[1], 1), 0.3)
    assert (mesh.mapping().detDF(centre) > 0).all()  # positively oriented
    return ReferenceMesh(shape, degree, nodes, cells, mesh, vertex_nodes)


def local_order(ours, theirs):
    """For each of scikit-fem's local nodes the project's local number."""
    distance = np.abs(np.asarray(ours, dtype=float)[None] - np.asarray(theirs)[:, None]).max(axis=-1)
    assert (np.sort(distance, axis=1)[:, 0] == 0).all()
    return distance.argmin(axis=1)


def rectangle(shape, across, up, seed):
    """[0, 2] x [0, 1] with moved nodes, mixed diagonals, shuffled numbers and rotated cells."""
    random = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(0, 2, across + 1), np.linspace(0, 1, up + 1), indexing="xy")
    nodes = np.column_stack([x.ravel(), y.ravel()])
    step = np.array([2 / across, 1 / up])
    move = random.uniform(-0.2, 0.2, nodes.shape) * step
    move[np.isin(nodes[:, 0], [0.0, 2.0]), 0] = 0     # boundary nodes stay on their side
    move[np.isin(nodes[:, 1], [0.0, 1.0]), 1] = 0
    nodes = np.round(nodes + move, 3)
    cells = []
    for j in range(up):
        for i in range(across):
            a = j * (across + 1) + i
            quad = [a, a + 1, a + across + 2, a + across + 1]
            if shape == "quadrilateral":
                cells.append(quad)
            else:
                quad = quad[(i + j) % 2:] + quad[: (i + j) % 2]
                cells += [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
    cells = np.array([np.roll(cell, random.integers(len(cell))) for cell in cells])
    nodes, cells = shuffled(nodes, cells, random)
    return from_arrays(shape, 1, nodes, cells)


def shuffled(nodes, cells, random):
    """The same mesh with its nodes and cells numbered at random."""
    number = random.permutation(len(nodes))
    moved = np.empty_like(nodes)
    moved[number] = nodes
    return moved, number[cells][random.permutation(len(cells))]


def annulus(radial, around, first=0.0, last=2 * np.pi, inner=20.0, outer=30.0):
    """Polar quadrilaterals of degree 2; all nodes uniform in radius and angle.

    First reference axis: radius; second: angle. A full turn closes on itself.
    """
    closed = np.isclose(last - first, 2 * np.pi)
    rows = 2 * around if closed else 2 * around + 1
    nodes = np.zeros((rows * (2 * radial + 1), 2))
    for b in range(rows):
        angle = first + (last - first) * b / (2 * around)
        for a in range(2 * radial + 1):
            r = inner + (outer - inner) * a / (2 * radial)
            nodes[b * (2 * radial + 1) + a] = r * np.cos(angle), r * np.sin(angle)
    reference = REFERENCE_NODES["quadrilateral", 2]
    cells = [
        [((2 * j + int(2 * y)) % rows) * (2 * radial + 1) + 2 * i + int(2 * x) for x, y in reference]
        for i in range(radial)
        for j in range(around)
    ]
    return from_arrays("quadrilateral", 2, nodes, cells)


def tetrahedra(seed):
    """[0, 2] x [0, 1] x [0, 1]: two cubes of five tetrahedra each, vertices moved."""
    random = np.random.default_rng(seed)
    grid = np.array([(i, j, k) for k in range(2) for j in range(2) for i in range(3)], dtype=float)
    cells = []
    for i in range(2):
        corner = {(a, b, c): i + a + 3 * b + 6 * c for a in (0, 1) for b in (0, 1) for c in (0, 1)}
        # Mirror the second cube so that the diagonals of the common face agree.
        at = lambda a, b, c: corner[(1 - a if i == 1 else a), b, c]
        cells.append([at(1, 0, 0), at(0, 1, 0), at(0, 0, 1), at(1, 1, 1)])
        cells.append([at(0, 0, 0), at(1, 0, 0), at(0, 1, 0), at(0, 0, 1)])
        cells.append([at(1, 1, 0), at(1, 0, 0), at(0, 1, 0), at(1, 1, 1)])
        cells.append([at(1, 0, 1), at(1, 0, 0), at(0, 0, 1), at(1, 1, 1)])
        cells.append([at(0, 1, 1), at(0, 1, 0), at(0, 0, 1), at(1, 1, 1)])
    nodes = np.round(grid + random.uniform(-0.15, 0.15, grid.shape), 3)
    for cell in cells:
        edges = nodes[cell[1:]] - nodes[cell[0]]
        if np.linalg.det(edges) < 0:
            cell[2], cell[3] = cell[3], cell[2]
    nodes, cells = shuffled(nodes, np.array(cells), random)
    return from_arrays("tetrahedron", 1, nodes, cells)


def hexahedron(seed):
    """One hexahedron with moved vertices."""
    random = np.random.default_rng(seed)
    nodes = np.array(REFERENCE_NODES["hexahedron", 1], dtype=float)
    nodes = np.round(nodes + random.uniform(-0.15, 0.15, nodes.shape), 3)
    nodes, cells = shuffled(nodes, np.arange(8)[None], random)
    return from_arrays("hexahedron", 1, nodes, cells)
