//! The cells of a batch on one side: geometry and basis functions at a point.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::{Basis, Further};

use super::cell_map::{curvature, inverse_transposed, largest_distance, tangential};
use super::{Cells, Reads};
use crate::assemble::binding::Tabulated;
use crate::assemble::groups::GroupSide;
use crate::element::Tables;
use crate::lanes::{SimdLane, Starts, WIDEST};

/// Number of cells by which the coordinates of nodes are prefetched.
const NODES_AHEAD: usize = 12;

/// A batch of cells at the given distance after a start, or what there is of it.
#[inline(always)]
fn later_cells<L: SimdLane>(cells: &[u32], start: usize, ahead: usize) -> &[u32] {
    let later = cells.get(start + ahead..).unwrap_or_default();
    &later[..later.len().min(L::WIDTH)]
}

/// The tables of one side of a group.
pub(super) struct SideTables<'a, const D: usize> {
    pub group: &'a GroupSide<D>,
    pub elements: &'a [Tabulated],
    /// One Jacobian serves all points of a cell.
    pub affine: bool,
}

/// The cells of one batch, seen from one side.
pub(super) struct SideBuffers<L, const D: usize> {
    /// Cells of this batch; the last one repeats to fill the lanes.
    pub cells: [u32; WIDEST],
    /// Positions of the geometry nodes.
    pub nodes: Vec<[L; D]>,
    /// Basis functions at the current point, one list per element.
    pub basis: Vec<Vec<Basis<L, D>>>,
    /// Their second derivatives, and their means over the cell; zero unless a kernel reads them.
    pub further: Vec<Vec<Further<L, D>>>,
    /// ∂x_i/∂ξ_j, its determinant and J⁻ᵀ, of affine cells.
    pub jacobian: [[L; D]; D],
    pub determinant: L,
    pub inverse: [[L; D]; D],
    /// The image of the reference cell's centre and J⁻ᵀ there, where an element has functions of the position.
    pub centre: ([L; D], [[L; D]; D]),
}

impl<'a, const D: usize> SideTables<'a, D> {
    pub fn new(group: &'a GroupSide<D>, elements: &'a [Tabulated], affine: bool) -> Self {
        SideTables { group, elements, affine }
    }
}

impl<L: SimdLane, const D: usize> Default for SideBuffers<L, D> {
    fn default() -> Self {
        let zero = L::splat(0.0);
        SideBuffers {
            cells: [0; WIDEST],
            nodes: vec![],
            basis: vec![],
            further: vec![],
            jacobian: [[zero; D]; D],
            determinant: zero,
            inverse: [[zero; D]; D],
            centre: ([zero; D], [[zero; D]; D]),
        }
    }
}

impl<L: SimdLane, const D: usize> SideBuffers<L, D> {
    /// Memory for a group.
    pub fn prepare(&mut self, tables: &GroupSide<D>) {
        let zero = L::splat(0.0);
        let empty = Basis { value: zero, gradient: [zero; D] };
        if self.nodes.len() != tables.geometry.nodes {
            self.nodes.resize(tables.geometry.nodes, [zero; D]);
        }
        self.basis.resize_with(tables.elements.len(), Vec::new);
        self.further.resize_with(tables.elements.len(), Vec::new);
        for (element, tables) in tables.elements.iter().enumerate() {
            if self.basis[element].len() != tables.nodes {
                self.basis[element].resize(tables.nodes, empty);
                self.further[element].resize(tables.nodes, Further::none());
            }
        }
    }

    #[inline(always)]
    pub fn load(&mut self, tables: &SideTables<D>, cells: Cells<D>, start: usize, filled: usize) {
        let mut places = [0; WIDEST];
        match cells {
            Cells::Mesh(mesh) => {
                let own = &tables.group.cells[start..start + filled];
                let mut lists: [&[u32]; WIDEST] = [&[]; WIDEST];
                for lane in 0..L::WIDTH {
                    self.cells[lane] = own[lane.min(filled - 1)];
                    lists[lane] = mesh.cell(self.cells[lane] as usize);
                }
                let coordinates = mesh.nodes().as_flattened();
                // The lists of cells and their coordinates lie in another order than the walk: they are asked for some batches before.
                for cell in later_cells::<L>(&tables.group.cells, start, 2 * NODES_AHEAD) {
                    L::prefetch(mesh.cell(*cell as usize), 0);
                }
                for cell in later_cells::<L>(&tables.group.cells, start, NODES_AHEAD) {
                    for node in mesh.cell(*cell as usize) {
                        L::prefetch(coordinates, *node as usize * D);
                    }
                }
                let count = self.nodes.len();
                for (node, target) in self.nodes[..count].iter_mut().enumerate() {
                    for lane in 0..L::WIDTH {
                        places[lane] = lists[lane][node] as usize * D;
                    }
                    *target = L::gather(coordinates, &places);
                }
            }
            Cells::Given { coordinates, stride, offsets, .. } => {
                let starts = Starts::new::<L>(start, filled, stride);
                let count = self.nodes.len();
                let (nodes, offsets) = (&mut self.nodes[..count], &offsets[..count]);
                for node in 0..count {
                    nodes[node] = L::gather_from(coordinates, &starts, offsets[node]);
                }
            }
        }
    }

    /// The map linearised at the centre, for functions of the position. On affine cells these are the same as in the tables.
    #[inline(always)]
    pub fn map_centre(&mut self, tables: &SideTables<D>) {
        let Some(centre) = &tables.group.centre else { return };
        let (_, inverse) = inverse_transposed(&self.jacobian_at(centre, 0));
        let mut image = [L::splat(0.0); D];
        for node in 0..self.nodes.len() {
            for axis in 0..D {
                image[axis] = self.nodes[node][axis].multiply_add(L::splat(centre.value[node]), image[axis]);
            }
        }
        self.centre = (image, inverse);
    }

    /// Functions that are linear in space: their slopes along the axes of the linearised map are those of the reference cell, and all
    /// have the same value at its centre.
    #[inline(always)]
    pub fn evaluate_in_space(&mut self, tables: &SideTables<D>, index: usize, position: &[L; D]) {
        let (image, inverse) = &self.centre;
        let mut offset = [L::splat(0.0); D];
        for j in 0..D {
            for i in 0..D {
                offset[j] = inverse[i][j].multiply_add(position[i] - image[i], offset[j]);
            }
        }
        let nodes = tables.group.elements[index].nodes;
        for node in 0..nodes {
            let slopes = &tables.group.elements[index].gradient[node];
            let mut value = L::splat(1.0 / nodes as f64);
            let mut gradient = [L::splat(0.0); D];
            for j in 0..D {
                value = offset[j].multiply_add(L::splat(slopes[j]), value);
                for i in 0..D {
                    gradient[i] = inverse[i][j].multiply_add(L::splat(slopes[j]), gradient[i]);
                }
            }
            self.basis[index][node] = Basis { value, gradient };
            self.further[index][node].hessian = [[L::splat(0.0); D]; D];
        }
    }

    /// Whether an element's functions are not those of its tables.
    #[inline(always)]
    pub fn is_in_space(&self, tables: &SideTables<D>, index: usize) -> bool {
        !tables.affine
            && tables.group.centre.is_some()
            && tables.elements[index].elements[tables.group.shape].is_in_space()
    }

    /// Jacobian, determinant and inverse of affine cells.
    #[inline(always)]
    pub fn map_affinely(&mut self, tables: &SideTables<D>) {
        self.jacobian = self.jacobian_at(&tables.group.geometry, 0);
        (self.determinant, self.inverse) = inverse_transposed(&self.jacobian);
    }

    /// h: the largest distance between two vertices.
    #[inline(always)]
    pub fn diameter(&self, tables: &SideTables<D>) -> L {
        largest_distance(&self.nodes[..tables.group.shape.vertices()])
    }

    #[inline(always)]
    pub fn volume(&self, tables: &SideTables<D>) -> L {
        let measure = &tables.group.measure;
        if tables.affine {
            let mut sum = 0.0;
            for weight in &measure.cell_weights {
                sum += *weight;
            }
            return self.determinant * L::splat(sum);
        }
        let mut volume = L::splat(0.0);
        for q in 0..measure.cell_weights.len() {
            let (determinant, _) = inverse_transposed(&self.jacobian_at(&measure.cell, q));
            volume = determinant.multiply_add(L::splat(measure.cell_weights[q]), volume);
        }
        volume
    }

    /// ∂x_i/∂ξ_j at a point of a table of the geometry map.
    #[inline(always)]
    pub fn jacobian_at(&self, tables: &Tables<D>, q: usize) -> [[L; D]; D] {
        let mut jacobian = [[L::splat(0.0); D]; D];
        let count = self.nodes.len();
        let (nodes, slopes) = (&self.nodes[..count], &tables.gradient[q * count..][..count]);
        for node in 0..count {
            for i in 0..D {
                for j in 0..D {
                    jacobian[i][j] = nodes[node][i].multiply_add(L::splat(slopes[node][j]), jacobian[i][j]);
                }
            }
        }
        jacobian
    }

    #[inline(always)]
    pub fn position(&self, tables: &SideTables<D>, q: usize) -> [L; D] {
        let mut position = [L::splat(0.0); D];
        let values = &tables.group.geometry.value[q * self.nodes.len()..][..self.nodes.len()];
        for node in 0..self.nodes.len() {
            for axis in 0..D {
                position[axis] = self.nodes[node][axis].multiply_add(L::splat(values[node]), position[axis]);
            }
        }
        position
    }

    /// Values of all basis functions, and those of their gradients and second derivatives that are read; `inverse` is J⁻ᵀ.
    #[inline(always)]
    pub fn evaluate_basis(
        &mut self,
        tables: &SideTables<D>,
        reads: &[Reads],
        q: usize,
        inverse: &[[L; D]; D],
        normal: &[L; D],
    ) {
        for index in 0..tables.group.elements.len() {
            self.evaluate_element(tables, reads, index, q, inverse, normal);
        }
    }

    #[inline(always)]
    fn evaluate_element(
        &mut self,
        tables: &SideTables<D>,
        reads: &[Reads],
        index: usize,
        q: usize,
        inverse: &[[L; D]; D],
        normal: &[L; D],
    ) {
        if self.is_in_space(tables, index) {
            let position = self.position(tables, q);
            return self.evaluate_in_space(tables, index, &position);
        }
        let table = &tables.group.elements[index];
        let nodes = table.nodes;
        let values = &table.value[q * nodes..][..nodes];
        let slopes = &table.gradient[q * nodes..][..nodes];
        let basis = &mut self.basis[index][..nodes];
        if reads[index].value {
            for node in 0..nodes {
                basis[node].value = L::splat(values[node]);
            }
        }
        if !reads[index].gradient && !reads[index].hessian {
            return;
        }
        for node in 0..nodes {
            let mut gradient = [L::splat(0.0); D];
            for i in 0..D {
                gradient[i] = inverse[i][0] * L::splat(slopes[node][0]);
                for j in 1..D {
                    gradient[i] = inverse[i][j].multiply_add(L::splat(slopes[node][j]), gradient[i]);
                }
            }
            basis[node].gradient = gradient;
        }
        if tables.elements[index].on_facets {
            for node in 0..nodes {
                basis[node].gradient = tangential(&basis[node].gradient, normal);
            }
        }
        if reads[index].hessian {
            self.evaluate_hessians(tables, index, q, inverse);
        }
    }

    /// ∂²φ/∂x² = J⁻ᵀ (∂²φ/∂ξ² − Σ_k ∂φ/∂x_k ∂²x_k/∂ξ²) J⁻¹, after the gradients.
    #[inline(always)]
    fn evaluate_hessians(&mut self, tables: &SideTables<D>, index: usize, q: usize, inverse: &[[L; D]; D]) {
        let zero = L::splat(0.0);
        if tables.elements[index].on_facets {
            // A trace has none: what would read it must not pass for a number.
            for further in &mut self.further[index] {
                further.hessian = [[L::splat(f64::NAN); D]; D];
            }
            return;
        }
        let mut map = [[[zero; D]; D]; D];
        let second = &tables.group.geometry.hessian[q * self.nodes.len()..];
        for node in 0..self.nodes.len() {
            for k in 0..D {
                for a in 0..D {
                    for b in 0..D {
                        map[k][a][b] =
                            self.nodes[node][k].multiply_add(L::splat(second[node][a][b]), map[k][a][b]);
                    }
                }
            }
        }
        let table = &tables.group.elements[index];
        for node in 0..table.nodes {
            let second = &table.hessian[q * table.nodes + node];
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
            let hessian = &mut self.further[index][node].hessian;
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

    /// κ = div n = −g^{ij} x_{,ij} · n, with the surface metric g of the facet's tangents.
    #[inline(always)]
    pub fn curvature(
        &self,
        tables: &SideTables<D>,
        q: usize,
        jacobian: &[[L; D]; D],
        tangents: &[[f64; D]; 2],
        normal: &[L; D],
    ) -> L {
        let zero = L::splat(0.0);
        if tables.group.bending.is_empty() {
            return zero;
        }
        let mut second = [zero; 3];
        let count = self.nodes.len();
        for node in 0..count {
            let bending = &tables.group.bending[q * count + node];
            for axis in 0..D {
                for k in 0..3 {
                    let along = self.nodes[node][axis] * normal[axis];
                    second[k] = along.multiply_add(L::splat(bending[k]), second[k]);
                }
            }
        }
        curvature(&second, jacobian, tangents)
    }
}
