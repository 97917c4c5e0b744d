"""The ghost penalty on the interior facets: jumps of normal derivatives.

    R = int_interior  g1 {h} [du/dn] [dv/dn] + g2 {h}^3 [d2u/dn2] [d2v/dn2]

The second term where second derivatives are to be had: on simplices with straight sides.
"""
import numpy as np
from skfem.element import DiscreteField

import meshes
from checks import symmetric
from discretisation import ELEMENTS, Discretisation, random_field

G1, G2 = 0.1, 0.02


def with_second_derivatives(shape):
    """scikit-fem's element of degree 2, whose `hess` it does not give.

    Its reference gradients are linear, so that a difference between two points is their derivative; on
    a straight simplex the map to the cell is affine.
    """
    base = ELEMENTS[shape, 2]

    class WithSecondDerivatives(base):
        def gbasis(self, mapping, X, i, tind=None):
            (field,) = super().gbasis(mapping, X, i, tind)
            dimension = len(X)
            corners = np.hstack([np.zeros((dimension, 1)), np.eye(dimension)])
            slopes = np.array(self.lbasis(corners, i)[1])
            reference = slopes[:, 1:] - slopes[:, :1]
            inverse = mapping.invDF(X, tind)
            hess = np.einsum("kl,ki...,lj...->ij...", reference, inverse, inverse)
            return (DiscreteField(value=np.array(field), grad=field.grad, hess=hess),)

    return WithSecondDerivatives()


def first(field, w):
    return np.einsum("i...,i...->...", np.array(field.grad), w.n)


def second(field, w):
    return np.einsum("ij...,i...,j...->...", np.array(field.hess), w.n, w.n)


def cases():
    for seed, (name, mesh, degree) in enumerate([
        ("triangle_p1", meshes.rectangle("triangle", 3, 2, 111), 1),
        ("triangle_p2", meshes.rectangle("triangle", 3, 2, 112), 2),
        ("quadrilateral_q2", meshes.rectangle("quadrilateral", 2, 2, 113), 2),
        ("tetrahedron_p2", meshes.tetrahedra(114), 2),
    ]):
        hessians = degree == 2 and mesh.shape != "quadrilateral"
        space = Discretisation(mesh, degree, 1, scalar=with_second_derivatives(mesh.shape) if hessians else None)
        sides = space.sides()
        h = mesh.diameters()[mesh.skfem.f2t[:, sides[0].find]].mean(axis=0)[:, None] * np.ones(sides[0].dx.shape)
        # w.n is the normal of side 1 on both sides; the sign makes the jump.
        matrix = space.interior_matrix(
            lambda a, u, b, v, w: G1 * w.h_average * a * first(u, w) * b * first(v, w), h_average=h
        )
        vanishing = [np.ones(space.size), *space.positions.T]
        g2 = G2 if hessians else 0.0
        if hessians:
            matrix = matrix + space.interior_matrix(
                lambda a, u, b, v, w: g2 * w.h_average**3 * a * second(u, w) * b * second(v, w), h_average=h
            )
            vanishing += [space.positions[:, 0] * space.positions[:, 1], space.positions[:, 1]**2]
        symmetric(matrix)
        # Polynomials of the space's degree have no jumps.
        for smooth in vanishing:
            assert abs(matrix @ smooth).max() < 1e-11 * abs(matrix).max(), name
        u = random_field(space.size, 1.0, 220 + seed)
        yield name, {
            **space.description(with_facets=True),
            "data": {"g1": G1, "g2": g2},
            "u": u,
            "matrices": {"tangent": matrix},
            "vectors": {"residual": matrix @ u},
        }
