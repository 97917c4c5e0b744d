"""Makes the .msh files of this directory with Gmsh, and expected.txt with what meshio reads in them.

    python3 -m venv venv && venv/bin/pip install -r requirements.txt && venv/bin/python make.py

Each line of expected.txt: file, region, cells or facets, sum of the coordinates x, y, z of their vertices.
meshio reads no tags of partitioned files: there the sums are those of the same mesh before it was divided.
"""

import math
import pathlib

import gmsh
import meshio
import numpy

HERE = pathlib.Path(__file__).parent
DIMENSION = {"line": 1, "triangle": 2, "quad": 2, "tetra": 3, "hexahedron": 3}
VERTICES = {"line": 2, "triangle": 3, "quad": 4, "tetra": 4, "hexahedron": 8}


def start(name, size):
    gmsh.clear()
    gmsh.model.add(name)
    gmsh.option.setNumber("Mesh.MeshSizeMin", size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)


def group(dimension, tags, number, name):
    gmsh.model.addPhysicalGroup(dimension, tags, number, name)


def plate():
    """Two squares, the left one with a hole; a curve between them; a group of points."""
    start("plate", 1.5)
    gmsh.option.setNumber("Mesh.MinimumCircleNodes", 4)
    occ = gmsh.model.occ
    left, right, disk = occ.addRectangle(0, 0, 0, 1, 1), occ.addRectangle(1, 0, 0, 1, 1), occ.addDisk(0.5, 0.5, 0, 0.25, 0.25)
    occ.cut([(2, left)], [(2, disk)])
    occ.fragment([(2, left)], [(2, right)])
    occ.synchronize()
    # Curves of the fragments: 3 between the squares, 5 around the hole.
    group(2, [left], 10, "left part")
    group(2, [right], 11, "right part")
    group(2, [left, right], 12, "whole")
    group(1, [5], 1, "hole")
    group(1, [1, 2, 4, 6, 7, 8], 2, "outer")
    group(1, [3], 3, "seam")
    group(0, [1], 1, "corner")
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(2)


def ring(divisions):
    """A quarter of an annulus around a point that Gmsh lists as a node; its groups have no names."""
    start("ring", 1)
    geo = gmsh.model.geo
    centre = geo.addPoint(0, 0, 0)
    points = [geo.addPoint(*p, 0) for p in [(1, 0), (2, 0), (0, 2), (0, 1)]]
    curves = [
        geo.addLine(points[0], points[1]),
        geo.addCircleArc(points[1], centre, points[2]),
        geo.addLine(points[2], points[3]),
        geo.addCircleArc(points[3], centre, points[0]),
    ]
    surface = geo.addPlaneSurface([geo.addCurveLoop(curves)])
    for curve in curves:
        geo.mesh.setTransfiniteCurve(curve, divisions + 1)
    geo.mesh.setTransfiniteSurface(surface)
    geo.mesh.setRecombine(2, surface)
    return curves, surface


def quarter():
    curves, surface = ring(2)
    gmsh.model.geo.synchronize()
    group(2, [surface], 1, "")
    group(1, [curves[3]], 1, "")
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(2)


def cylinder():
    _, surface = ring(1)
    parts = gmsh.model.geo.extrude([(2, surface)], 0, 0, 1, numElements=[2], recombine=True)
    gmsh.model.geo.synchronize()
    top, volume, sides = parts[0][1], parts[1][1], [tag for _, tag in parts[2:]]
    group(3, [volume], 1, "wall")
    group(2, [surface], 1, "bottom")
    group(2, [top], 2, "top")
    group(2, [sides[1]], 3, "outside")
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)


def oblique(recombine):
    """An oblique box with straight edges, of hexahedra or tetrahedra."""
    start("box", 2)
    geo = gmsh.model.geo
    points = [geo.addPoint(*p) for p in [(0, 0, 0), (2, 0.25, 0), (2.5, 1.5, 0), (0.25, 1, 0)]]
    curves = [geo.addLine(points[k], points[(k + 1) % 4]) for k in range(4)]
    surface = geo.addPlaneSurface([geo.addCurveLoop(curves)])
    for curve, count in zip(curves, [3, 2, 3, 2]):
        geo.mesh.setTransfiniteCurve(curve, count)
    geo.mesh.setTransfiniteSurface(surface)
    if recombine:
        geo.mesh.setRecombine(2, surface)
    parts = geo.extrude([(2, surface)], 0.5, 0.25, 1, numElements=[1], recombine=recombine)
    geo.synchronize()
    group(3, [parts[1][1]], 1, "box")
    group(2, [parts[2][1]], 2, "front")
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)


def ball():
    start("ball", 2)
    gmsh.model.occ.addSphere(0, 0, 0, 1, -1, 0, math.pi / 2, math.pi / 2)
    gmsh.model.occ.synchronize()
    curved = [s for _, s in gmsh.model.getEntities(2) if gmsh.model.getType(2, s) == "Sphere"]
    flat = [s for _, s in gmsh.model.getEntities(2) if s not in curved]
    group(3, [1], 1, "ball")
    group(2, curved, 1, "sphere")
    group(2, flat, 2, "flat")
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)


def house():
    """A transfinite square of quadrilaterals with a half disk of triangles above it; a curve between them."""
    start("house", 1)
    geo = gmsh.model.geo
    points = [geo.addPoint(*p, 0) for p in [(0, 0), (2, 0), (2, 2), (0, 2), (1, 2)]]
    below = [geo.addLine(points[k], points[(k + 1) % 4]) for k in range(4)]
    arc = geo.addCircleArc(points[2], points[4], points[3])
    square = geo.addPlaneSurface([geo.addCurveLoop(below)])
    roof = geo.addPlaneSurface([geo.addCurveLoop([-below[2], arc])])
    for curve in below:
        geo.mesh.setTransfiniteCurve(curve, 3)
    geo.mesh.setTransfiniteSurface(square)
    geo.mesh.setRecombine(2, square)
    geo.synchronize()
    group(2, [roof], 1, "roof")
    group(2, [square], 2, "walls")
    group(2, [roof, square], 3, "house")
    group(1, [below[2]], 1, "ceiling")
    group(1, [arc, below[1]], 2, "outside")
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(2)


def save(name, version, binary):
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    path = HERE / f"{name}.msh"
    gmsh.write(str(path))
    return path


def sums(path):
    """Per group: dimension, number, and sum of the vertices' coordinates, as meshio reads them."""
    mesh = meshio.read(path)
    names = {(int(d), int(tag)): name for name, (tag, d) in mesh.field_data.items()}
    words = {1: "curve", 2: "surface", 3: "volume"}
    found = {}
    for block, tags in zip(mesh.cells, mesh.cell_data["gmsh:physical"]):
        kind = block.type.rstrip("0123456789")
        if kind not in DIMENSION:
            continue
        dimension = DIMENSION[kind]
        for nodes, tag in zip(block.data, tags):
            name = names.get((dimension, int(tag)), f"physical {words[dimension]} {tag}")
            count, total = found.get(name, (0, numpy.zeros(3)))
            found[name] = (count + 1, total + mesh.points[nodes[: VERTICES[kind]]].sum(axis=0))
    return found


def main():
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    lines = []

    def expect(name, found):
        for region, (count, total) in sorted(found.items()):
            lines.append("\t".join([name, region, str(count), *(f"{x:.12g}" for x in total)]))

    # meshio keeps one group per element: what it reads in 2.2, which lists an element once per group, is complete.
    plate()
    complete = sums(save("plate_2.2", 2.2, 0))
    save("plate_4.1_binary", 4.1, 1)
    gmsh.model.mesh.partition(3)
    save("plate_partitioned_2.2", 2.2, 0)
    save("plate_partitioned_4.1", 4.1, 0)
    for name in ["2.2", "4.1_binary", "partitioned_2.2", "partitioned_4.1"]:
        expect(f"plate_{name}", complete)
    for name, make, files in [
        ("quarter", quarter, [("4.1", 4.1, 0)]),
        ("cylinder", cylinder, [("4.1_binary", 4.1, 1)]),
        ("hexahedra", lambda: oblique(True), [("2.2", 2.2, 0)]),
        ("tetrahedra", lambda: oblique(False), [("4.1", 4.1, 0)]),
        ("ball", ball, [("2.2_binary", 2.2, 1), ("4.1", 4.1, 0)]),
    ]:
        make()
        for suffix, version, binary in files:
            expect(f"{name}_{suffix}", sums(save(f"{name}_{suffix}", version, binary)))
    house()
    complete = sums(save("house_2.2_binary", 2.2, 1))
    save("house_4.1", 4.1, 0)
    for name in ["2.2_binary", "4.1"]:
        expect(f"house_{name}", complete)
    (HERE / "expected.txt").write_text("\n".join(lines) + "\n")
    gmsh.finalize()


if __name__ == "__main__":
    main()
