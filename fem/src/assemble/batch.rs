//! One batch of cells (or facets), one per lane: geometry, basis functions and fields at its points.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::{Basis, CellGeometry, FieldSlot, Lane, Order, PointGeometry, Requirements};

use super::AssemblyError;
use super::binding::{Binding, Values};
use super::walk::Group;
use crate::element::Tables;
use crate::history::HistoryMismatch;

/// The widest lane type of any instruction set.
pub(super) const WIDEST: usize = 16;

/// Scratch memory of a loop over the batches of a group.
pub(super) struct Batch<'a, L, const D: usize> {
    binding: &'a Binding<'a, D>,
    group: &'a Group<D>,
    requirements: Requirements,
    /// Cells of this batch; the last one repeats to fill the lanes.
    cells: [u32; WIDEST],
    /// How many lanes hold cells of their own.
    filled: usize,
    /// Positions of the geometry nodes.
    nodes: Vec<[L; D]>,
    /// Coefficients of the field of each slot: node × component.
    coefficients: Vec<Vec<L>>,
    /// Basis functions at the current point, one list per element.
    basis: Vec<Vec<Basis<L, D>>>,
    fields: Vec<L>,
}

impl<'a, L: Lane, const D: usize> Batch<'a, L, D> {
    pub fn new(
        binding: &'a Binding<'a, D>,
        group: &'a Group<D>,
        requirements: Requirements,
    ) -> Result<Self, AssemblyError> {
        let zero = L::splat(0.0);
        for slot in requirements.fields {
            if slot.order == Order::Gradient && matches!(binding.values[slot.field], Values::Function(_)) {
                let field = binding.fields[slot.field].name;
                return Err(AssemblyError::GradientOfFunction { form: binding.name, field });
            }
        }
        let needs_facet = requirements.normal || requirements.facet_area || requirements.curvature;
        if needs_facet && group.facet.is_none() {
            return Err(AssemblyError::NeedsFacet { form: binding.name });
        }
        let coefficients = requirements.fields.iter().map(|slot| match &binding.values[slot.field] {
            Values::Discrete { element, .. } => {
                vec![zero; group.elements[*element].nodes * slot.components]
            }
            _ => vec![],
        });
        let empty = Basis { value: zero, gradient: [zero; D] };
        Ok(Batch {
            binding,
            group,
            requirements,
            cells: [0; WIDEST],
            filled: 0,
            nodes: vec![[zero; D]; group.geometry.nodes],
            coefficients: coefficients.collect(),
            basis: group.elements.iter().map(|tables| vec![empty; tables.nodes]).collect(),
            fields: vec![zero; requirements.field_length],
        })
    }

    /// Number of batches in the group.
    pub fn count(&self) -> usize {
        self.group.cells.len().div_ceil(L::WIDTH)
    }

    /// The cells of this batch, without the repeated ones.
    pub fn cells(&self) -> &[u32] {
        &self.cells[..self.filled]
    }

    /// The basis functions of an element at the current point.
    pub fn basis(&self, element: usize) -> &[Basis<L, D>] {
        &self.basis[element]
    }

    /// The fields at the current point, as the kernel wants them.
    pub fn fields(&self) -> &[L] {
        &self.fields
    }

    /// Loads the index-th batch and gives what is constant on its cells.
    pub fn load(&mut self, index: usize) -> CellGeometry<L> {
        let start = index * L::WIDTH;
        let own = &self.group.cells[start..(start + L::WIDTH).min(self.group.cells.len())];
        self.filled = own.len();
        for lane in 0..L::WIDTH {
            self.cells[lane] = own[lane.min(own.len() - 1)];
        }
        let mesh = self.binding.mesh;
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
        for (slot, coefficients) in self.requirements.fields.iter().zip(&mut self.coefficients) {
            let Values::Discrete { space, values, .. } = &self.binding.values[slot.field] else { continue };
            for (entry, coefficient) in coefficients.iter_mut().enumerate() {
                let (node, component) = (entry / slot.components, entry % slot.components);
                for lane in 0..L::WIDTH {
                    let number = space.cell_nodes(self.cells[lane] as usize)[node] as usize;
                    lanes[lane] = values[number * slot.components + component];
                }
                *coefficient = L::load(&lanes);
            }
        }
        self.cell_geometry()
    }

    fn cell_geometry(&self) -> CellGeometry<L> {
        let zero = L::splat(0.0);
        let mut geometry = CellGeometry {
            diameter: zero,
            cell_volume: zero,
            facet_area: zero,
            opposite_diameter: zero,
            opposite_volume: zero,
        };
        if self.requirements.diameter {
            let mut lanes = [0.0; WIDEST];
            for lane in 0..L::WIDTH {
                lanes[lane] = self.binding.mesh.diameter(self.cells[lane] as usize);
            }
            geometry.diameter = L::load(&lanes);
        }
        if self.requirements.cell_volume {
            let measure = &self.group.measure;
            for (q, weight) in measure.cell_weights.iter().enumerate() {
                let (determinant, _) = inverse_transposed(&self.jacobian(&measure.cell, q));
                geometry.cell_volume = determinant.multiply_add(L::splat(*weight), geometry.cell_volume);
            }
        }
        if let (true, Some((tables, weights)), Some((_, tangents))) =
            (self.requirements.facet_area, &self.group.measure.facet, &self.group.facet)
        {
            for (q, weight) in weights.iter().enumerate() {
                let (element, _) = surface(&self.jacobian(tables, q), tangents);
                geometry.facet_area = element.multiply_add(L::splat(*weight), geometry.facet_area);
            }
        }
        geometry
    }

    /// ∂x_i/∂ξ_j at a point of a table of the geometry map.
    fn jacobian(&self, tables: &Tables<D>, q: usize) -> [[L; D]; D] {
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

    /// Moves to the q-th point: geometry, basis functions, fields.
    pub fn point(&mut self, q: usize) -> Result<PointGeometry<L, D>, AssemblyError> {
        let zero = L::splat(0.0);
        let group = self.group;
        let jacobian = self.jacobian(&group.geometry, q);
        let (determinant, inverse) = inverse_transposed(&jacobian);
        let mut geometry = PointGeometry {
            weight: L::splat(group.weights[q]),
            position: [zero; D],
            normal: [zero; D],
            curvature: zero,
        };
        match &group.facet {
            None => geometry.weight = geometry.weight * determinant,
            Some((_, tangents)) => {
                let (element, normal) = surface(&jacobian, tangents);
                geometry.weight = geometry.weight * element;
                geometry.normal = normal;
                if self.requirements.curvature {
                    geometry.curvature = self.curvature(q, &jacobian, tangents, &normal);
                }
            }
        }
        for (node, value) in self.nodes.iter().zip(&group.geometry.value[q * self.nodes.len()..]) {
            for axis in 0..D {
                geometry.position[axis] = node[axis].multiply_add(L::splat(*value), geometry.position[axis]);
            }
        }
        for (tables, basis) in group.elements.iter().zip(&mut self.basis) {
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
            }
        }
        for index in 0..self.requirements.fields.len() {
            let slot = self.requirements.fields[index];
            self.evaluate(&slot, index, q, &geometry.position)?;
        }
        Ok(geometry)
    }

    fn evaluate(
        &mut self,
        slot: &FieldSlot,
        index: usize,
        q: usize,
        position: &[L; D],
    ) -> Result<(), AssemblyError> {
        let zero = L::splat(0.0);
        let count = match slot.order {
            Order::Value => slot.components,
            Order::Gradient => slot.components * D,
            Order::Hessian => slot.components * D * D,
        };
        let target = &mut self.fields[slot.offset..slot.offset + count];
        match &self.binding.values[slot.field] {
            Values::Absent => target.fill(zero),
            Values::Constant(values) => {
                for (component, target) in target.iter_mut().enumerate() {
                    *target = if slot.order == Order::Value { L::splat(values[component]) } else { zero };
                }
            }
            Values::Discrete { element, .. } => {
                target.fill(zero);
                let coefficients = self.coefficients[index].chunks(slot.components);
                for (basis, coefficients) in self.basis[*element].iter().zip(coefficients) {
                    for (component, coefficient) in coefficients.iter().enumerate() {
                        match slot.order {
                            Order::Value => {
                                target[component] = basis.value.multiply_add(*coefficient, target[component]);
                            }
                            Order::Gradient => {
                                for axis in 0..D {
                                    let entry = &mut target[component * D + axis];
                                    *entry = basis.gradient[axis].multiply_add(*coefficient, *entry);
                                }
                            }
                            Order::Hessian => {}
                        }
                    }
                }
            }
            Values::History(history) => {
                let (form, field) = (self.binding.name, self.binding.fields[slot.field].name);
                let mismatch = |source| AssemblyError::History { form, field, source };
                if slot.order != Order::Value {
                    return Err(mismatch(HistoryMismatch::Gradient));
                }
                let local = self.group.facet.map(|(local, _)| local);
                let mut lanes = vec![[0.0; WIDEST]; slot.components];
                for lane in 0..L::WIDTH {
                    let values = history.at(self.cells[lane], local, q).map_err(mismatch)?;
                    for (component, value) in values.iter().enumerate() {
                        lanes[component][lane] = *value;
                    }
                }
                for (target, lanes) in target.iter_mut().zip(&lanes) {
                    *target = L::load(lanes);
                }
            }
            Values::Function(function) => {
                let mut values = vec![0.0; slot.components];
                let mut lanes = vec![[0.0; WIDEST]; slot.components];
                let mut components = [[0.0; WIDEST]; D];
                for axis in 0..D {
                    position[axis].store(&mut components[axis]);
                }
                for lane in 0..L::WIDTH {
                    let x: [f64; D] = std::array::from_fn(|axis| components[axis][lane]);
                    function(&x, &mut values);
                    if !values.iter().all(|value| value.is_finite()) {
                        return Err(AssemblyError::NotFinite {
                            form: self.binding.name,
                            field: self.binding.fields[slot.field].name,
                            position: Some(x.to_vec()),
                        });
                    }
                    for (component, value) in values.iter().enumerate() {
                        lanes[component][lane] = *value;
                    }
                }
                for (target, lanes) in target.iter_mut().zip(&lanes) {
                    *target = L::load(lanes);
                }
            }
        }
        Ok(())
    }

    /// κ = div n = −g^{ij} x_{,ij} · n, with the surface metric g of the facet's tangents.
    fn curvature(&self, q: usize, jacobian: &[[L; D]; D], tangents: &[[f64; D]; 2], normal: &[L; D]) -> L {
        let zero = L::splat(0.0);
        if self.group.bending.is_empty() {
            return zero;
        }
        let mut second = [zero; 3];
        let count = self.nodes.len();
        for (node, bending) in self.nodes.iter().zip(&self.group.bending[q * count..]) {
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
fn surface<L: Lane, const D: usize>(jacobian: &[[L; D]; D], tangents: &[[f64; D]; 2]) -> (L, [L; D]) {
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
fn inverse_transposed<L: Lane, const D: usize>(a: &[[L; D]; D]) -> (L, [[L; D]; D]) {
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
