//! Fields at the points of a batch, as a kernel's slots ask.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::{FieldSlot, Order, Requirements, Side};
use forms_core::source::PositionFunction;

use super::{Batch, BatchBuffers, Cells};
use crate::assemble::AssemblyError;
use crate::assemble::binding::Values;
use crate::assemble::element_loops::sum_factorisation::{
    Derivatives, Interpolation, ProductTables, axis_operations,
};
use crate::assemble::groups::GroupSide;
use crate::history::{HistoryMismatch, Snapshot};
use crate::lanes::{SharedWork, SimdLane, Starts, WIDEST};

impl<L: SimdLane, const D: usize> Batch<'_, L, D> {
    /// Whether a field is a function of position.
    #[inline(always)]
    pub(super) fn reads_functions(&self, requirements: &Requirements) -> bool {
        for slot in requirements.fields {
            if matches!(self.binding.values[slot.field], Values::Function { .. }) {
                return true;
            }
        }
        false
    }

    /// Coefficients of the discrete fields on the cells of the batch, which starts at entity `start`.
    #[inline(always)]
    pub(super) fn load_coefficients(&mut self, requirements: &Requirements, start: usize) {
        for index in 0..requirements.fields.len() {
            let slot = &requirements.fields[index];
            let coefficients = &mut self.buffers.coefficients[index];
            let mut places = [0; WIDEST];
            match &self.binding.values[slot.field] {
                Values::Discrete { space, values, .. } => {
                    let side = &self.buffers.sides[side_index(slot.side)];
                    let local = self.tables[side_index(slot.side)].group.facet.map(|(local, _)| local);
                    let mut nodes: [&[u32]; WIDEST] = [&[]; WIDEST];
                    for lane in 0..L::WIDTH {
                        nodes[lane] = space.nodes_at(side.cells[lane], local);
                    }
                    let coefficients = coefficients.chunks_exact_mut(slot.components);
                    for (node, target) in coefficients.enumerate() {
                        for lane in 0..L::WIDTH {
                            places[lane] = nodes[lane][node] as usize * slot.components;
                        }
                        gather_all(values, &places, target);
                    }
                }
                Values::Given { offsets, .. } => {
                    let Cells::Given { coefficients: values, coefficient_stride: stride, .. } = self.cells
                    else {
                        continue;
                    };
                    let starts = Starts::new::<L>(start, self.filled, stride);
                    let coefficients = coefficients.chunks_exact_mut(slot.components);
                    for (node, target) in coefficients.enumerate() {
                        match target {
                            [a] => [*a] = L::gather_from(values, &starts, offsets[node]),
                            [a, b] => [*a, *b] = L::gather_from(values, &starts, offsets[node]),
                            [a, b, c] => [*a, *b, *c] = L::gather_from(values, &starts, offsets[node]),
                            more => {
                                for component in 0..more.len() {
                                    let place = offsets[node] + component;
                                    [more[component]] = L::gather_from(values, &starts, place);
                                }
                            }
                        }
                    }
                }
                _ => {}
            }
        }
    }

    /// All fields at the q-th point, whose place is seen from either side.
    #[inline(always)]
    pub(super) fn evaluate_fields(
        &mut self,
        requirements: &Requirements,
        q: usize,
        position: &[L; D],
        opposite: &[L; D],
    ) -> Result<(), AssemblyError> {
        for index in 0..requirements.fields.len() {
            let slot = requirements.fields[index];
            let count = slot.components * D.pow(slot.order.axes() as u32);
            let range = slot.offset..slot.offset + count;
            match &self.binding.values[slot.field] {
                Values::Absent => self.buffers.fields[range].fill(L::splat(0.0)),
                Values::Means => self.take_means(&slot),
                Values::Constant(values) => {
                    for (component, target) in self.buffers.fields[range].iter_mut().enumerate() {
                        let value = if slot.order.axes() == 0 { values[component] } else { 0.0 };
                        *target = L::splat(value);
                    }
                }
                // The same at all points: `Batch::load_means`.
                Values::Discrete { .. } | Values::Given { .. } if slot.order.is_mean() => {}
                Values::Discrete { .. } | Values::Given { .. }
                    if !self.buffers.at_points[index].is_empty() =>
                {
                    self.pick(&slot, index, q);
                }
                Values::Discrete { element, .. } | Values::Given { element, .. } => {
                    let nodes = self.buffers.sides[side_index(slot.side)].basis[*element].len();
                    self.interpolate(&slot, index, *element, nodes);
                }
                Values::History(history) => {
                    let lanes = self.history(&slot, history, q)?;
                    for (component, lanes) in lanes.iter().enumerate() {
                        self.buffers.fields[slot.offset + component] = L::load(lanes);
                    }
                }
                Values::Function { function, gradient } => {
                    // Without a gradient none is asked for: `BatchBuffers::prepare`.
                    let function = match (slot.order, gradient) {
                        (Order::Gradient, Some(gradient)) => gradient,
                        _ => function,
                    };
                    let position = if slot.side == Side::This { position } else { opposite };
                    let mut components = [[0.0; WIDEST]; D];
                    for axis in 0..D {
                        position[axis].store(&mut components[axis]);
                    }
                    let lanes = self.function(&slot, count, function, &components)?;
                    for (component, lanes) in lanes.iter().enumerate() {
                        self.buffers.fields[slot.offset + component] = L::load(lanes);
                    }
                    // Where points move, a function moves by its gradient.
                    if let (true, Order::Value, Some(gradient)) = (L::DIRECTIONS > 0, slot.order, gradient) {
                        let lanes = self.function(&slot, count * D, gradient, &components)?;
                        for component in 0..count {
                            let mut along = [L::splat(0.0); D];
                            for axis in 0..D {
                                along[axis] = L::load(&lanes[component * D + axis]);
                            }
                            let field = &mut self.buffers.fields[slot.offset + component];
                            *field = field.moved_by(&along, position);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Means over the own facets of the batch's units; not a number where the group has none.
    #[inline(always)]
    fn take_means(&mut self, slot: &FieldSlot) {
        let target = slot.offset..slot.offset + slot.components;
        let lists = self.group.means.as_ref().map(|means| &means.lists[..]).unwrap_or_default();
        let Some((_, values)) = lists.iter().find(|(field, _)| *field == slot.field) else {
            self.buffers.fields[target].fill(L::splat(f64::NAN));
            return;
        };
        for component in 0..slot.components {
            let mut places = [0; WIDEST];
            for lane in 0..L::WIDTH {
                let unit = self.start + lane.min(self.filled - 1);
                places[lane] = unit * slot.components + component;
            }
            [self.buffers.fields[slot.offset + component]] = L::gather::<1>(values, &places);
        }
    }

    /// Makes the fields at all points that sum factorisation makes.
    #[inline(always)]
    pub(super) fn factorise_fields(&mut self, requirements: &Requirements) {
        for index in 0..requirements.fields.len() {
            if self.buffers.at_points[index].is_empty() {
                continue;
            }
            let slot = &requirements.fields[index];
            let element = match &self.binding.values[slot.field] {
                Values::Discrete { element, .. } | Values::Given { element, .. } => *element,
                _ => continue,
            };
            let Some(tables) = &self.group.sides[0].products[element] else { continue };
            let BatchBuffers { coefficients, at_points, stages, .. } = &mut *self.buffers;
            Interpolation::<L, D> {
                tables,
                derivatives: Derivatives::of_slot(slot),
                coefficients: &coefficients[index],
                components: slot.components,
                stages,
                target: &mut at_points[index],
            }
            .run();
        }
    }

    /// A field made by sum factorisation, at the q-th point.
    #[inline(always)]
    fn pick(&mut self, slot: &FieldSlot, index: usize, q: usize) {
        let element = match &self.binding.values[slot.field] {
            Values::Discrete { element, .. } | Values::Given { element, .. } => *element,
            _ => return,
        };
        let Some(tables) = &self.group.sides[0].products[element] else { return };
        let (points, place) = (tables.place_of.len(), tables.place_of[q] as usize);
        let inverse = self.buffers.sides[0].inverse;
        let BatchBuffers { at_points, fields, .. } = &mut *self.buffers;
        let source = &at_points[index];
        for component in 0..slot.components {
            if slot.order == Order::Value {
                fields[slot.offset + component] = source[component * points + place];
                continue;
            }
            let mut slopes = [L::splat(0.0); D];
            for axis in 0..D {
                slopes[axis] = source[(component * D + axis) * points + place];
            }
            let target = &mut fields[slot.offset + component * D..][..D];
            for i in 0..D {
                let mut sum = inverse[i][0] * slopes[0];
                for axis in 1..D {
                    sum = inverse[i][axis].multiply_add(slopes[axis], sum);
                }
                target[i] = sum;
            }
        }
    }

    /// Σ over the nodes of coefficient × basis function, or its derivatives. Coefficients are gathered: they do not move with points.
    #[inline(always)]
    fn interpolate(&mut self, slot: &FieldSlot, index: usize, element: usize, nodes: usize) {
        let side = &self.buffers.sides[side_index(slot.side)];
        let (basis, further) = (&side.basis[element][..nodes], &side.further[element][..nodes]);
        let components = slot.components;
        let coefficients = &self.buffers.coefficients[index][..nodes * components];
        // One component after the other, so that its sums stay in registers.
        for component in 0..components {
            match slot.order {
                Order::Value => {
                    let mut sum = L::splat(0.0);
                    for node in 0..nodes {
                        let coefficient = coefficients[node * components + component];
                        sum = basis[node].value.multiply_add_constant(coefficient, sum);
                    }
                    self.buffers.fields[slot.offset + component] = sum;
                }
                Order::Gradient => {
                    let mut sums = [L::splat(0.0); D];
                    for node in 0..nodes {
                        let coefficient = coefficients[node * components + component];
                        for axis in 0..D {
                            sums[axis] =
                                basis[node].gradient[axis].multiply_add_constant(coefficient, sums[axis]);
                        }
                    }
                    let start = slot.offset + component * D;
                    let target = &mut self.buffers.fields[start..start + D];
                    for axis in 0..D {
                        target[axis] = sums[axis];
                    }
                }
                Order::Hessian => {
                    let mut sums = [[L::splat(0.0); D]; D];
                    for node in 0..nodes {
                        let coefficient = coefficients[node * components + component];
                        for i in 0..D {
                            for j in 0..D {
                                sums[i][j] = further[node].hessian[i][j]
                                    .multiply_add_constant(coefficient, sums[i][j]);
                            }
                        }
                    }
                    let start = slot.offset + component * D * D;
                    self.buffers.fields[start..start + D * D].copy_from_slice(sums.as_flattened());
                }
                Order::MeanValue | Order::MeanGradient => {}
            }
        }
    }

    fn history(
        &self,
        slot: &FieldSlot,
        history: &Snapshot<D>,
        q: usize,
    ) -> Result<Vec<[f64; WIDEST]>, AssemblyError> {
        let (form, field) = (self.binding.name, self.binding.fields[slot.field].name);
        let mismatch = |source| AssemblyError::History { form, field, source };
        if slot.order != Order::Value {
            return Err(mismatch(HistoryMismatch::Gradient));
        }
        let side = side_index(slot.side);
        let local = self.tables[side].group.facet.map(|(local, _)| local);
        let mut lanes = vec![[0.0; WIDEST]; slot.components];
        let pairs = self.group.pairs().map(|pairs| &*pairs.group);
        for lane in 0..L::WIDTH {
            let values = match pairs {
                Some(pairs) => history.at_pair(pairs, self.start + lane.min(self.filled - 1), q),
                None => history.at(self.buffers.sides[side].cells[lane], local, q),
            };
            let values = values.map_err(mismatch)?;
            for (component, value) in values.iter().enumerate() {
                lanes[component][lane] = *value;
            }
        }
        Ok(lanes)
    }

    fn function(
        &self,
        slot: &FieldSlot,
        count: usize,
        function: &PositionFunction<D>,
        position: &[[f64; WIDEST]; D],
    ) -> Result<Vec<[f64; WIDEST]>, AssemblyError> {
        let mut values = vec![0.0; count];
        let mut lanes = vec![[0.0; WIDEST]; count];
        for lane in 0..L::WIDTH {
            // Lanes without a cell of their own repeat the last one's.
            if lane >= self.filled {
                lanes.iter_mut().for_each(|lanes| lanes[lane] = lanes[self.filled - 1]);
                continue;
            }
            let x: [f64; D] = std::array::from_fn(|axis| position[axis][lane]);
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
        Ok(lanes)
    }
}

/// Successive entries from each lane's place on, of values in memory.
#[inline(always)]
fn gather_all<L: SimdLane>(values: &[f64], places: &[usize; WIDEST], target: &mut [L]) {
    match target.len() {
        1 => [target[0]] = L::gather::<1>(values, places),
        2 => [target[0], target[1]] = L::gather::<2>(values, places),
        3 => [target[0], target[1], target[2]] = L::gather::<3>(values, places),
        count => {
            let mut places = *places;
            for component in 0..count {
                target[component] = L::gather::<1>(values, &places)[0];
                for lane in 0..WIDEST {
                    places[lane] += 1;
                }
            }
        }
    }
}

/// The tables, if sum factorisation makes a slot's field in fewer operations than sums over the nodes at each point.
pub(super) fn factorised<'a, const D: usize>(
    side: &'a GroupSide<D>,
    element: usize,
    slot: &FieldSlot,
) -> Option<&'a ProductTables> {
    let tables = side.products[element].as_ref()?;
    let (nodes, points) = (tables.node_at.len(), tables.place_of.len());
    let (direct, at_point) = match slot.order {
        Order::Value => (nodes, 0),
        // The gradients of the basis may be there anyway, so that they do not count.
        Order::Gradient => (nodes * D, D * D),
        Order::Hessian | Order::MeanValue | Order::MeanGradient => return None,
    };
    let made = axis_operations::<D>(tables, Derivatives::of_slot(slot)) + points * at_point;
    (made < points * direct).then_some(tables)
}

pub(super) fn side_index(side: Side) -> usize {
    match side {
        Side::This => 0,
        Side::Other => 1,
    }
}
