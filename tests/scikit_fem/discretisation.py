"""Spaces, quadrature and the numbering of unknowns shared by all references.

Unknowns are numbered node * components + component, where `node` counts the
nodes of the scalar space as scikit-fem numbers them; their positions are stored,
and for a discontinuous space also the cell of each node.
"""
import numpy as np
import skfem
from skfem.quadrature import get_quadrature_tet, get_quadrature_tri

ELEMENTS = {
    ("triangle", 1): skfem.ElementTriP1,
    ("triangle", 2): skfem.ElementTriP2,
    ("quadrilateral", 1): skfem.ElementQuad1,
    ("quadrilateral", 2): skfem.ElementQuad2,
    ("tetrahedron", 1): skfem.ElementTetP1,
    ("tetrahedron", 2): skfem.ElementTetP2,
    ("hexahedron", 1): skfem.ElementHex1,
    ("hexahedron", 2): skfem.ElementHex2,
}
DISCONTINUOUS = {
    "triangle": skfem.ElementTriDG,
    "quadrilateral": skfem.ElementQuadDG,
    "tetrahedron": skfem.ElementTetDG,
}


def gauss(points):
    """Gauss's rule on [0, 1] as (points, weights)."""
    x, w = np.polynomial.legendre.leggauss(points)
    return (x + 1) / 2, w / 2


def cell_rule(shape):
    """(dimension x points, weights) on the reference cell."""
    if shape == "triangle":
        return get_quadrature_tri(8)
    if shape == "tetrahedron":
        return get_quadrature_tet(4)
    dimension = 2 if shape == "quadrilateral" else 3
    x, w = gauss(5 if dimension == 2 else 4)
    grid = np.meshgrid(*[x] * dimension, indexing="ij")
    weights = np.meshgrid(*[w] * dimension, indexing="ij")
    return np.array([g.ravel() for g in grid]), np.prod([g.ravel() for g in weights], axis=0)


def facet_rule(shape):
    """(dimension - 1 x points, weights); symmetric, so that a facet's own coordinates do not matter."""
    if shape == "tetrahedron":
        return get_quadrature_tri(6)
    x, w = gauss(5)
    return x[None], w


class Discretisation:
    """A Lagrange space of one or several components on a reference mesh."""

    def __init__(self, mesh, degree, components, discontinuous=False, scalar=None):
        self.mesh, self.degree, self.components = mesh, degree, components
        self.discontinuous = discontinuous
        scalar = scalar or ELEMENTS[mesh.shape, degree]()
        if discontinuous:
            scalar = DISCONTINUOUS[mesh.shape](scalar)
        self.element = scalar if components == 1 else skfem.ElementVector(scalar, components)
        self.cell_rule = cell_rule(mesh.shape)
        self.facet_rule = facet_rule(mesh.shape)
        self.cells = skfem.Basis(mesh.skfem, self.element, quadrature=self.cell_rule)
        nodes = skfem.Basis(mesh.skfem, scalar, quadrature=self.cell_rule)
        self.positions = nodes.doflocs.T
        # order[node * components + component] is scikit-fem's number of the unknown.
        self.order = np.full(self.cells.N, -1)
        for k in range(nodes.Nbfun):
            for c in range(components):
                ours = nodes.element_dofs[k] * components + c
                self.order[ours] = self.cells.element_dofs[k * components + c]
        assert np.array_equal(np.sort(self.order), np.arange(self.cells.N))
        place = self.cells.doflocs[:, self.order].T
        assert np.abs(place - np.repeat(self.positions, components, axis=0)).max() < 1e-12
        self.size = self.cells.N

    def facets(self, facets):
        """The facet basis on scikit-fem's facets."""
        return skfem.FacetBasis(
            self.mesh.skfem, self.element, facets=facets, quadrature=self.facet_rule
        )

    def boundary(self):
        """The facet basis on the whole boundary."""
        return self.facets(self.mesh.skfem.boundary_facets())

    def sides(self):
        """The bases on both sides of all interior facets; `normals` are those of the first side in both."""
        return [
            skfem.InteriorFacetBasis(self.mesh.skfem, self.element, quadrature=self.facet_rule, side=side)
            for side in (0, 1)
        ]

    def node_cells(self):
        """The cell of each node of a discontinuous space."""
        cells = np.full(self.size // self.components, -1)
        for cell, unknowns in enumerate(self.cells.element_dofs.T):
            cells[np.argsort(self.order)[unknowns] // self.components] = cell
        return cells

    def interpolate(self, basis, coefficients):
        """A field given in our numbering at the quadrature points of `basis`."""
        theirs = np.empty(self.size)
        theirs[self.order] = coefficients
        return basis.interpolate(theirs)

    def matrix(self, form, basis, test=None, test_basis=None, **data):
        """Assemble a function (u, v, w) into a CSR matrix in our numbering; `test` is another space for v."""
        assembled = skfem.BilinearForm(form).assemble(basis, test_basis or basis, **data).tocsr()
        return assembled[(test or self).order][:, self.order].tocsr()

    def vector(self, form, basis, **data):
        """Assemble a function (v, w) into a vector in our numbering."""
        return skfem.LinearForm(form).assemble(basis, **data)[self.order]

    def interior_matrix(self, form, **data):
        """Sum of a function (sign of u, u, sign of v, v, w) over both sides of the interior facets.

        The sign is 1 on the first side and -1 on the second: sign * u is u's part in its jump.
        """
        sides = list(zip((1, -1), self.sides()))
        return sum(
            self.matrix(lambda u, v, w: form(a, u, b, v, w), trial, test_basis=test, **data)
            for a, trial in sides
            for b, test in sides
        )

    def description(self, with_facets=False):
        """What a reader needs to rebuild mesh, space and quadrature."""
        mesh = self.mesh
        record = {
            "dimension": mesh.nodes.shape[1],
            "shape": mesh.shape,
            "geometry_degree": mesh.degree,
            "nodes": mesh.nodes,
            "cells": mesh.cells,
            **self.space(),
            "cell_quadrature": {"points": self.cell_rule[0].T, "weights": self.cell_rule[1]},
        }
        if mesh.nodes.shape[1] == 2 or with_facets:
            points, weights = self.facet_rule
            points = points[0] if len(points) == 1 else points.T
            record["facet_quadrature"] = {"points": points, "weights": weights}
        return record

    def space(self):
        """What a reader needs to rebuild the space on its mesh."""
        record = {
            "space_degree": self.degree,
            "components": self.components,
            "space_nodes": self.positions,
        }
        if self.discontinuous:
            record["space_cells"] = self.node_cells()
        return record


def random_field(size, scale, seed):
    """Coefficients uniform in [-scale, scale], rounded to six digits."""
    return np.round(np.random.default_rng(seed).uniform(-scale, scale, size), 6)
