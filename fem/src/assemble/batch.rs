//! One batch of cells (or facets), one per lane: geometry, basis functions and fields at its points.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

mod side;

use forms_core::contract::{
    Basis, CellGeometry, FieldSlot, Hessian, Lane, Order, PointGeometry, Requirements, Side,
};

use self::side::{BatchSide, inverse_transposed, surface};

use super::AssemblyError;
use super::binding::{Binding, Values};
use super::walk::{Group, reads_hessians};
use crate::history::HistoryMismatch;

/// The two sides of an interior facet see a point at the same place up to this part of h.
const SAME_PLACE: f64 = 1e-10;

/// The widest lane type of any instruction set.
pub(super) const WIDEST: usize = 16;

/// Scratch memory of a loop over the batches of a group.
pub(super) struct Batch<'a, L, const D: usize> {
    binding: &'a Binding<'a, D>,
    group: &'a Group<D>,
    requirements: Requirements,
    /// How many lanes hold cells of their own.
    filled: usize,
    /// The cells on each side of the group.
    sides: Vec<BatchSide<'a, L, D>>,
    /// How far the two sides of an interior facet may be apart.
    tolerance: [f64; WIDEST],
    /// Coefficients of the field of each slot: node × component.
    coefficients: Vec<Vec<L>>,
    fields: Vec<L>,
}

impl<'a, L: Lane, const D: usize> Batch<'a, L, D> {
    pub fn new(
        binding: &'a Binding<'a, D>,
        group: &'a Group<D>,
        requirements: Requirements,
    ) -> Result<Self, AssemblyError> {
        let zero = L::splat(0.0);
        let form = binding.name;
        let mut coefficients = Vec::new();
        for slot in requirements.fields {
            let side = group.side(form, slot.side)?;
            let field = binding.fields[slot.field].name;
            coefficients.push(match &binding.values[slot.field] {
                Values::Function(_) if slot.order != Order::Value => {
                    return Err(AssemblyError::GradientOfFunction { form, field });
                }
                Values::Discrete { element, space, .. } => {
                    group.check_support(form, field, space)?;
                    if let (Order::Hessian, Some(region)) = (slot.order, space.facet_region()) {
                        let region = region.to_owned();
                        return Err(AssemblyError::HessianOnFacets { form, field, region });
                    }
                    vec![zero; group.sides[side].elements[*element].nodes * slot.components]
                }
                _ => vec![],
            });
        }
        let needs_facet = requirements.normal || requirements.facet_area || requirements.curvature;
        if needs_facet && group.sides[0].facet.is_none() {
            return Err(AssemblyError::NeedsFacet { form });
        }
        if requirements.opposite_diameter || requirements.opposite_volume {
            group.side(form, Side::Other)?;
        }
        Ok(Batch {
            binding,
            group,
            requirements,
            filled: 0,
            sides: group.sides.iter().map(BatchSide::new).collect(),
            tolerance: [0.0; WIDEST],
            coefficients,
            fields: vec![zero; requirements.field_length],
        })
    }

    /// The cells of this batch on a side, without the repeated ones.
    pub fn cells(&self, side: usize) -> &[u32] {
        &self.sides[side].cells[..self.filled]
    }

    /// The basis functions of an element at the current point.
    pub fn basis(&self, side: usize, element: usize) -> &[Basis<L, D>] {
        &self.sides[side].basis[element]
    }

    /// Second derivatives of the basis functions of an element at the current point.
    pub fn hessians(&self, side: usize, element: usize) -> &[Hessian<L, D>] {
        &self.sides[side].hessians[element]
    }

    /// The fields at the current point, as the kernel wants them.
    pub fn fields(&self) -> &[L] {
        &self.fields
    }

    /// Loads `filled` of the group's entities (at most one per lane, at least one) from `start` on, and gives
    /// what is constant on their cells. Other lanes repeat the last entity.
    pub fn load(&mut self, start: usize, filled: usize) -> CellGeometry<L> {
        let mesh = self.binding.mesh;
        self.filled = filled;
        for side in &mut self.sides {
            side.load(mesh, start, self.filled);
        }
        let mut lanes = [0.0; WIDEST];
        for (slot, coefficients) in self.requirements.fields.iter().zip(&mut self.coefficients) {
            let Values::Discrete { space, values, .. } = &self.binding.values[slot.field] else { continue };
            let side = &self.sides[side_index(slot.side)];
            let local = side.tables.facet.map(|(local, _)| local);
            let mut nodes: [&[u32]; WIDEST] = [&[]; WIDEST];
            for lane in 0..L::WIDTH {
                nodes[lane] = space.nodes_at(side.cells[lane], local);
            }
            for (entry, coefficient) in coefficients.iter_mut().enumerate() {
                let (node, component) = (entry / slot.components, entry % slot.components);
                for lane in 0..L::WIDTH {
                    lanes[lane] = values[nodes[lane][node] as usize * slot.components + component];
                }
                *coefficient = L::load(&lanes);
            }
        }
        self.cell_geometry()
    }

    fn cell_geometry(&mut self) -> CellGeometry<L> {
        let zero = L::splat(0.0);
        let requirements = &self.requirements;
        let mut geometry = CellGeometry {
            diameter: zero,
            cell_volume: zero,
            facet_area: zero,
            opposite_diameter: zero,
            opposite_volume: zero,
        };
        let this = &self.sides[0];
        if requirements.diameter {
            geometry.diameter = this.diameter(self.binding.mesh);
        }
        if requirements.cell_volume {
            geometry.cell_volume = this.volume();
        }
        if let (true, Some((tables, weights)), Some((_, tangents))) =
            (requirements.facet_area, &this.tables.measure.facet, &this.tables.facet)
        {
            for (q, weight) in weights.iter().enumerate() {
                let (element, _) = surface(&this.jacobian(tables, q), tangents);
                geometry.facet_area = element.multiply_add(L::splat(*weight), geometry.facet_area);
            }
        }
        if let Some(other) = self.sides.get(1) {
            let diameter = other.diameter(self.binding.mesh);
            diameter.store(&mut self.tolerance);
            if requirements.opposite_diameter {
                geometry.opposite_diameter = diameter;
            }
            if requirements.opposite_volume {
                geometry.opposite_volume = other.volume();
            }
        }
        geometry
    }

    /// Moves to the q-th point: geometry, basis functions, fields.
    pub fn point(&mut self, q: usize) -> Result<PointGeometry<L, D>, AssemblyError> {
        let zero = L::splat(0.0);
        let this = &mut self.sides[0];
        let jacobian = this.jacobian(&this.tables.geometry, q);
        let (determinant, inverse) = inverse_transposed(&jacobian);
        let mut geometry = PointGeometry {
            weight: L::splat(self.group.weights[q]),
            position: this.position(q),
            normal: [zero; D],
            curvature: zero,
        };
        match &this.tables.facet {
            None => geometry.weight = geometry.weight * determinant,
            Some((_, tangents)) => {
                let (element, normal) = surface(&jacobian, tangents);
                geometry.weight = geometry.weight * element;
                geometry.normal = normal;
                if self.requirements.curvature {
                    geometry.curvature = this.curvature(q, &jacobian, tangents, &normal);
                }
            }
        }
        let elements = &self.binding.elements;
        let hessians = reads_hessians(&self.requirements);
        this.evaluate_basis(elements, q, &inverse, &geometry.normal, hessians);
        if let Some(other) = self.sides.get_mut(1) {
            let (_, inverse) = inverse_transposed(&other.jacobian(&other.tables.geometry, q));
            other.evaluate_basis(elements, q, &inverse, &geometry.normal, hessians);
            self.check_facing(q, &geometry.position)?;
        }
        for index in 0..self.requirements.fields.len() {
            let slot = self.requirements.fields[index];
            self.evaluate(&slot, index, q, &geometry.position)?;
        }
        Ok(geometry)
    }

    /// Both sides of an interior facet must see its q-th point at one place.
    fn check_facing(&self, q: usize, position: &[L; D]) -> Result<(), AssemblyError> {
        let other = self.sides[1].position(q);
        let mut square = L::splat(0.0);
        for axis in 0..D {
            let gap = other[axis] - position[axis];
            square = gap.multiply_add(gap, square);
        }
        let mut gaps = [0.0; WIDEST];
        square.sqrt().store(&mut gaps);
        for lane in 0..self.filled {
            let distance = gaps[lane];
            if distance <= SAME_PLACE * self.tolerance[lane] {
                continue;
            }
            let cells = [self.cells(0)[lane], self.cells(1)[lane]];
            let mut lanes = [0.0; WIDEST];
            let position = position.iter().map(|x| {
                x.store(&mut lanes);
                lanes[lane]
            });
            let (form, position) = (self.binding.name, position.collect());
            return Err(AssemblyError::FacetMismatch { form, cells, position, distance });
        }
        Ok(())
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
                let side = &self.sides[side_index(slot.side)];
                let basis = side.basis[*element].iter().zip(&side.hessians[*element]);
                let coefficients = self.coefficients[index].chunks(slot.components);
                for ((basis, hessian), coefficients) in basis.zip(coefficients) {
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
                            Order::Hessian => {
                                for i in 0..D {
                                    for j in 0..D {
                                        let entry = &mut target[(component * D + i) * D + j];
                                        *entry = hessian[i][j].multiply_add(*coefficient, *entry);
                                    }
                                }
                            }
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
                let side = &self.sides[side_index(slot.side)];
                let local = side.tables.facet.map(|(local, _)| local);
                let mut lanes = vec![[0.0; WIDEST]; slot.components];
                for lane in 0..L::WIDTH {
                    let values = history.at(side.cells[lane], local, q).map_err(mismatch)?;
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
}

fn side_index(side: Side) -> usize {
    match side {
        Side::This => 0,
        Side::Other => 1,
    }
}
