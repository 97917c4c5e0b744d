//! The cells of a batch on one side: geometry and basis functions at a point.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::{Basis, Hessian, Lane};

use super::super::binding::Tabulated;
use super::super::walk::GroupSide;
use super::WIDEST;
use crate::element::Tables;
use crate::mesh::Mesh;

/// The cells of one batch on one side.
pub(super) struct BatchSide<'a, L, const D: usize> {
    pub tables: &'a GroupSide<D>,
    /// Cells of this batch; the last one repeats to fill the lanes.
    pub cells: [u32; WIDEST],
    /// Positions of the geometry nodes.
    pub nodes: Vec<[L; D]>,
    /// Basis functions at the current point, one list per element.
    pub basis: Vec<Vec<Basis<L, D>>>,
    /// Their second derivatives, zero unless a kernel reads them.
    pub hessians: Vec<Vec<Hessian<L, D>>>,
}

impl<'a, L: Lane, const D: usize> BatchSide<'a, L, D> {
    pub fn new(tables: &'a GroupSide<D>) -> Self {
        let zero = L::splat(0.0);
        let empty = Basis { value: zero, gradient: [zero; D] };
        BatchSide {
            tables,
            cells: [0; WIDEST],
            nodes: vec![[zero; D]; tables.geometry.nodes],
            basis: tables.elements.iter().map(|tables| vec![empty; tables.nodes]).collect(),
            hessians: tables.elements.iter().map(|tables| vec![[[zero; D]; D]; tables.nodes]).collect(),
        }
    }

    pub fn load(&mut self, mesh: &Mesh<D>, start: usize, filled: usize) {
        let own = &self.tables.cells[start..start + filled];
        for lane in 0..L::WIDTH {
            self.cells[lane] = own[lane.min(filled - 1)];
        }
        let mut lanes = [0.0; WIDEST];
        for node in 0..self.nodes.len() {
            for axis in 0..D {
                for lane in 0..L::WIDTH {
                    let number = mesh.cell(self.cells[lane] as usize)[node];
                    lanes[lane] = mesh.nodes()[number as usize][axis];
                }
                self.nodes[node][axis] = L::load(&lanes);
            }
        }
    }

    pub fn diameter(&self, mesh: &Mesh<D>) -> L {
        let mut lanes = [0.0; WIDEST];
        for lane in 0..L::WIDTH {
            lanes[lane] = mesh.diameter(self.cells[lane] as usize);
        }
        L::load(&lanes)
    }

    pub fn volume(&self) -> L {
        let mut volume = L::splat(0.0);
        let measure = &self.tables.measure;
        for (q, weight) in measure.cell_weights.iter().enumerate() {
            let (determinant, _) = inverse_transposed(&self.jacobian(&measure.cell, q));
            volume = determinant.multiply_add(L::splat(*weight), volume);
        }
        volume
    }

    /// ∂x_i/∂ξ_j at a point of a table of the geometry map.
    pub fn jacobian(&self, tables: &Tables<D>, q: usize) -> [[L; D]; D] {
        let mut jacobian = [[L::splat(0.0); D]; D];
        for (node, slope) in self.nodes.iter().zip(&tables.gradient[q * tables.nodes..]) {
            for i in 0..D {
                for j in 0..D {
                    jacobian[i][j] = node[i].multiply_add(L::splat(slope[j]), jacobian[i][j]);
                }
            }
        }
        jacobian
    }

    pub fn position(&self, q: usize) -> [L; D] {
        let mut position = [L::splat(0.0); D];
        for (node, value) in self.nodes.iter().zip(&self.tables.geometry.value[q * self.nodes.len()..]) {
            for axis in 0..D {
                position[axis] = node[axis].multiply_add(L::splat(*value), position[axis]);
            }
        }
        position
    }

    /// Values, gradients and, if they are read, second derivatives of all basis functions; `inverse` is J⁻ᵀ.
    pub fn evaluate_basis(
        &mut self,
        elements: &[Tabulated],
        q: usize,
        inverse: &[[L; D]; D],
        normal: &[L; D],
        hessians: bool,
    ) {
        let zero = L::splat(0.0);
        for ((tables, basis), element) in self.tables.elements.iter().zip(&mut self.basis).zip(elements) {
            let start = q * tables.nodes;
            for (node, basis) in basis.iter_mut().enumerate() {
                basis.value = L::splat(tables.value[start + node]);
                let slope = &tables.gradient[start + node];
                for i in 0..D {
                    let mut sum = zero;
                    for j in 0..D {
                        sum = inverse[i][j].multiply_add(L::splat(slope[j]), sum);
                    }
                    basis.gradient[i] = sum;
                }
                if element.on_facets {
                    basis.gradient = tangential(&basis.gradient, normal);
                }
            }
        }
        if hessians {
            self.evaluate_hessians(elements, q, inverse);
        }
    }

    /// ∂²φ/∂x² = J⁻ᵀ (∂²φ/∂ξ² − Σ_k ∂φ/∂x_k ∂²x_k/∂ξ²) J⁻¹, after the gradients.
    fn evaluate_hessians(&mut self, elements: &[Tabulated], q: usize, inverse: &[[L; D]; D]) {
        let zero = L::splat(0.0);
        let mut map = [[[zero; D]; D]; D];
        for (node, second) in self.nodes.iter().zip(&self.tables.geometry.hessian[q * self.nodes.len()..]) {
            for k in 0..D {
                for a in 0..D {
                    for b in 0..D {
                        map[k][a][b] = node[k].multiply_add(L::splat(second[a][b]), map[k][a][b]);
                    }
                }
            }
        }
        for (index, tables) in self.tables.elements.iter().enumerate() {
            if elements[index].on_facets {
                // A trace has none: what would read it must not pass for a number.
                self.hessians[index].fill([[L::splat(f64::NAN); D]; D]);
                continue;
            }
            for node in 0..tables.nodes {
                let second = &tables.hessian[q * tables.nodes + node];
                let gradient = &self.basis[index][node].gradient;
                let mut half = [[zero; D]; D];
                for a in 0..D {
                    for b in 0..D {
                        let mut entry = L::splat(second[a][b]);
                        for k in 0..D {
                            entry = entry - gradient[k] * map[k][a][b];
                        }
                        for i in 0..D {
                            half[i][b] = inverse[i][a].multiply_add(entry, half[i][b]);
                        }
                    }
                }
                let hessian = &mut self.hessians[index][node];
                for i in 0..D {
                    for j in 0..D {
                        hessian[i][j] = zero;
                        for b in 0..D {
                            hessian[i][j] = half[i][b].multiply_add(inverse[j][b], hessian[i][j]);
                        }
                    }
                }
            }
        }
    }

    /// κ = div n = −g^{ij} x_{,ij} · n, with the surface metric g of the facet's tangents.
    pub fn curvature(
        &self,
        q: usize,
        jacobian: &[[L; D]; D],
        tangents: &[[f64; D]; 2],
        normal: &[L; D],
    ) -> L {
        let zero = L::splat(0.0);
        if self.tables.bending.is_empty() {
            return zero;
        }
        let mut second = [zero; 3];
        let count = self.nodes.len();
        for (node, bending) in self.nodes.iter().zip(&self.tables.bending[q * count..]) {
            for axis in 0..D {
                for (second, bending) in second.iter_mut().zip(bending) {
                    *second = (node[axis] * normal[axis]).multiply_add(L::splat(*bending), *second);
                }
            }
        }
        let images = tangents.map(|tangent| image(jacobian, &tangent));
        let inner = |a: &[L; D], b: &[L; D]| {
            let mut sum = zero;
            for axis in 0..D {
                sum = a[axis].multiply_add(b[axis], sum);
            }
            sum
        };
        let first = inner(&images[0], &images[0]);
        if D == 2 {
            return -second[0] / first;
        }
        let (mixed, last) = (inner(&images[0], &images[1]), inner(&images[1], &images[1]));
        let determinant = first * last - mixed * mixed;
        -(last * second[0] - (mixed + mixed) * second[1] + first * second[2]) / determinant
    }
}

/// (I − n nᵀ) g: the gradient along a facet, which the trace determines.
#[inline(always)]
fn tangential<L: Lane, const D: usize>(gradient: &[L; D], normal: &[L; D]) -> [L; D] {
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
pub(super) fn surface<L: Lane, const D: usize>(
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
            normal[axis] = first[i] * second[j] - first[j] * second[i];
        }
    }
    let mut square = L::splat(0.0);
    for axis in 0..D {
        square = normal[axis].multiply_add(normal[axis], square);
    }
    let length = square.sqrt();
    for axis in 0..D {
        normal[axis] = normal[axis] / length;
    }
    (length, normal)
}

/// det J and J⁻ᵀ.
#[inline(always)]
pub(super) fn inverse_transposed<L: Lane, const D: usize>(a: &[[L; D]; D]) -> (L, [[L; D]; D]) {
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
                cofactors[i][j] = a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1];
            }
        }
    }
    let mut determinant = L::splat(0.0);
    for j in 0..D {
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
