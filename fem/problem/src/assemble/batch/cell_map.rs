//! The map of a cell at a point, lane by lane: J⁻ᵀ and det J, the facet's normal and surface element, its curvature.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::Lane;

/// κ from second derivatives of the position along the facet's tangents, each times the normal: of the first tangent
/// twice, of both, of the second twice.
#[inline(always)]
pub(super) fn curvature<L: Lane, const D: usize>(
    second: &[L; 3],
    jacobian: &[[L; D]; D],
    tangents: &[[f64; D]; 2],
) -> L {
    let images = [image(jacobian, &tangents[0]), image(jacobian, &tangents[1])];
    let first = inner(&images[0], &images[0]);
    if D == 2 {
        return -second[0] / first;
    }
    let (mixed, last) = (inner(&images[0], &images[1]), inner(&images[1], &images[1]));
    let determinant = first * last - mixed * mixed;
    -(last * second[0] - (mixed + mixed) * second[1] + first * second[2]) / determinant
}

/// ∇n along the facet, −h_ab g^ac g^bd x_c ⊗ x_d, from the same second derivatives h and the metric g of the tangents x.
#[inline(always)]
pub(super) fn shape_operator<L: Lane, const D: usize>(
    second: &[L; 3],
    jacobian: &[[L; D]; D],
    tangents: &[[f64; D]; 2],
) -> [[L; D]; D] {
    let images = [image(jacobian, &tangents[0]), image(jacobian, &tangents[1])];
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let first = inner(&images[0], &images[0]);
    // Tangents with the inverse metric.
    let mut raised = [[zero; D]; 2];
    if D == 2 {
        let reciprocal = one / first;
        for axis in 0..D {
            raised[0][axis] = reciprocal * images[0][axis];
        }
    } else {
        let (mixed, last) = (inner(&images[0], &images[1]), inner(&images[1], &images[1]));
        let reciprocal = one / (first * last - mixed * mixed);
        for axis in 0..D {
            raised[0][axis] = reciprocal * (last * images[0][axis] - mixed * images[1][axis]);
            raised[1][axis] = reciprocal * (first * images[1][axis] - mixed * images[0][axis]);
        }
    }
    let mut operator = [[zero; D]; D];
    for i in 0..D {
        for j in 0..D {
            let own = second[0] * raised[0][i] * raised[0][j] + second[2] * raised[1][i] * raised[1][j];
            let crossed = raised[0][i] * raised[1][j] + raised[1][i] * raised[0][j];
            operator[i][j] = -(own + second[1] * crossed);
        }
    }
    operator
}

/// The largest distance between two of some points.
#[inline(always)]
pub(in crate::assemble) fn largest_distance<L: Lane, const D: usize>(points: &[[L; D]]) -> L {
    let mut largest = L::splat(0.0);
    for first in 0..points.len() {
        for second in first + 1..points.len() {
            let mut square = L::splat(0.0);
            for axis in 0..D {
                let edge = points[second][axis] - points[first][axis];
                square = edge.multiply_add(edge, square);
            }
            largest = largest.maximum(square);
        }
    }
    largest.sqrt()
}

#[inline(always)]
fn inner<L: Lane, const D: usize>(a: &[L; D], b: &[L; D]) -> L {
    let mut sum = L::splat(0.0);
    for axis in 0..D {
        sum = a[axis].multiply_add(b[axis], sum);
    }
    sum
}

/// (I − n nᵀ) g: the gradient along a facet, which the trace determines.
#[inline(always)]
pub(super) fn tangential<L: Lane, const D: usize>(gradient: &[L; D], normal: &[L; D]) -> [L; D] {
    let mut across = L::splat(0.0);
    for axis in 0..D {
        across = gradient[axis].multiply_add(normal[axis], across);
    }
    let mut result = *gradient;
    for axis in 0..D {
        result[axis] = result[axis] - across * normal[axis];
    }
    result
}

/// J t.
#[inline(always)]
fn image<L: Lane, const D: usize>(jacobian: &[[L; D]; D], tangent: &[f64; D]) -> [L; D] {
    let mut result = [L::splat(0.0); D];
    for i in 0..D {
        for j in 0..D {
            result[i] = jacobian[i][j].multiply_add(L::splat(tangent[j]), result[i]);
        }
    }
    result
}

/// Surface element and outward unit normal.
#[inline(always)]
pub(in crate::assemble) fn surface<L: Lane, const D: usize>(
    jacobian: &[[L; D]; D],
    tangents: &[[f64; D]; 2],
) -> (L, [L; D]) {
    let first = image(jacobian, &tangents[0]);
    let mut normal = [L::splat(0.0); D];
    if D == 2 {
        normal[0] = first[1];
        normal[1] = -first[0];
    } else {
        let second = image(jacobian, &tangents[1]);
        for axis in 0..D {
            let (i, j) = ((axis + 1) % D, (axis + 2) % D);
            normal[axis] = (-first[j]).multiply_add(second[i], first[i] * second[j]);
        }
    }
    let mut square = L::splat(0.0);
    for axis in 0..D {
        square = normal[axis].multiply_add(normal[axis], square);
    }
    let length = square.sqrt();
    let reciprocal = L::splat(1.0) / length;
    for axis in 0..D {
        normal[axis] = normal[axis] * reciprocal;
    }
    (length, normal)
}

/// det J and J⁻ᵀ.
#[inline(always)]
pub(in crate::assemble) fn inverse_transposed<L: Lane, const D: usize>(a: &[[L; D]; D]) -> (L, [[L; D]; D]) {
    let mut cofactors = [[L::splat(0.0); D]; D];
    if D == 2 {
        cofactors[0][0] = a[1][1];
        cofactors[0][1] = -a[1][0];
        cofactors[1][0] = -a[0][1];
        cofactors[1][1] = a[0][0];
    } else {
        for i in 0..D {
            for j in 0..D {
                let (i1, i2, j1, j2) = ((i + 1) % D, (i + 2) % D, (j + 1) % D, (j + 2) % D);
                cofactors[i][j] = (-a[i1][j2]).multiply_add(a[i2][j1], a[i1][j1] * a[i2][j2]);
            }
        }
    }
    let mut determinant = a[0][0] * cofactors[0][0];
    for j in 1..D {
        determinant = a[0][j].multiply_add(cofactors[0][j], determinant);
    }
    let reciprocal = L::splat(1.0) / determinant;
    for row in &mut cofactors {
        for entry in row {
            *entry = *entry * reciprocal;
        }
    }
    (determinant, cofactors)
}
