"""Spaces, quadrature and the numbering of unknowns shared by all references.

Unknowns are numbered node * components + component, where `node` counts the
nodes of the scalar space as scikit-fem numbers them; their positions are stored.
"""
import numpy as np
import skfem
from skfem.quadrature import get_quadrature_tet, get_quadrature_tri

ELEMENTS = {
    ("triangle", 1): skfem.ElementTriP1,
    ("triangle", 2): skfem.ElementTriP2,
    ("quadrilateral", 1): skfem.ElementQuad1,
    ("quadrilateral", 2): skfem.ElementQuad2,
    ("tetrahedron", 2): skfem.ElementTetP2,
    ("hexahedron", 2): skfem.ElementHex2,
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


class Discretisation:
    """A Lagrange space of one or several components on a reference mesh."""

    def __init__(self, mesh, degree, components):
        self.mesh, self.degree, self.components = mesh, degree, components
        scalar = ELEMENTS[mesh.shape, degree]()
        self.element = scalar if components == 1 else skfem.ElementVector(scalar, components)
        self.cell_rule = cell_rule(mesh.shape)
        x, w = gauss(5)
        self.facet_rule = x[None], w
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
        """The facet basis on scikit-fem's facets, with the five-point rule."""
        return skfem.FacetBasis(
            self.mesh.skfem, self.element, facets=facets, quadrature=self.facet_rule
        )

    def interpolate(self, basis, coefficients):
        """A field given in our numbering at the quadrature points of `basis`."""
        theirs = np.empty(self.size)
        theirs[self.order] = coefficients
        return basis.interpolate(theirs)

    def matrix(self, form, basis, **data):
        """Assemble a function (u, v, w) into a CSR matrix in our numbering."""
        assembled = skfem.BilinearForm(form).assemble(basis, **data).tocsr()
        return assembled[self.order][:, self.order].tocsr()

    def vector(self, form, basis, **data):
        """Assemble a function (v, w) into a vector in our numbering."""
        return skfem.LinearForm(form).assemble(basis, **data)[self.order]

    def description(self):
        """What a reader needs to rebuild mesh, space and quadrature."""
        mesh = self.mesh
        record = {
            "dimension": mesh.nodes.shape[1],
            "shape": mesh.shape,
            "geometry_degree": mesh.degree,
            "nodes": mesh.nodes,
            "cells": mesh.cells,
            "space_degree": self.degree,
            "components": self.components,
            "space_nodes": self.positions,
            "cell_quadrature": {"points": self.cell_rule[0].T, "weights": self.cell_rule[1]},
        }
        if mesh.nodes.shape[1] == 2:
            points, weights = self.facet_rule
            record["facet_quadrature"] = {"points": points[0], "weights": weights}
        return record


def random_field(size, scale, seed):
    """Coefficients uniform in [-scale, scale], rounded to six digits."""
    return np.round(np.random.default_rng(seed).uniform(-scale, scale, size), 6)
