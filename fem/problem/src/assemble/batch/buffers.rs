//! The memory of a batch: what a kernel reads of fields and basis functions, with room for it.

use forms_core::contract::{Order, PointGeometry, Requirements, Side};

use super::fields::factorised;
use super::pairs::PairBuffers;
use super::side::SideBuffers;
use crate::assemble::AssemblyError;
use crate::assemble::binding::{Binding, Values};
use crate::assemble::element_loops::sum_factorisation::Stages;
use crate::assemble::groups::Group;
use crate::assemble::scatter::group_nodes::Reading;
use crate::instantiate::instantiate;
use crate::lanes::SimdLane;

/// Memory of a batch, kept from one run of a kernel to the next.
pub(in crate::assemble) struct BatchBuffers<L, const D: usize> {
    pub(super) sides: [SideBuffers<L, D>; 2],
    /// Coefficients of the field of each slot: node × component.
    pub coefficients: Vec<Vec<L>>,
    pub fields: Vec<L>,
    /// The geometry at the current point; what no integral of the group reads stays zero.
    pub(super) geometry: PointGeometry<L, D>,
    /// Each slot's field at all points, where it is made by sum factorisation; otherwise empty.
    pub at_points: Vec<Vec<L>>,
    pub stages: Stages<L>,
    /// Basis functions at points that differ from lane to lane.
    pub(super) pairs: PairBuffers<L, D>,
    /// Which derivatives of each element's basis are read on each side.
    pub reads: [Vec<Reads>; 2],
    /// All of this has been made for the kernel and sizes like those of the group.
    pub prepared: bool,
}

impl<L: SimdLane, const D: usize> Default for BatchBuffers<L, D> {
    fn default() -> Self {
        BatchBuffers {
            sides: [SideBuffers::default(), SideBuffers::default()],
            coefficients: vec![],
            fields: vec![],
            geometry: PointGeometry::of_weight(L::splat(0.0)),
            at_points: vec![],
            stages: Stages::default(),
            pairs: PairBuffers::default(),
            reads: [vec![], vec![]],
            prepared: false,
        }
    }
}

impl<L: SimdLane, const D: usize> BatchBuffers<L, D> {
    /// Memory for the values that the kernel reads, after a check that they exist.
    ///
    /// # Errors
    /// [`AssemblyError`]: something that the kernel reads and the group does not have.
    #[inline(never)]
    pub fn prepare(
        &mut self,
        binding: &Binding<D>,
        group: &Group<D>,
        requirements: Requirements,
        arguments: &[ArgumentBasis],
    ) -> Result<(), AssemblyError> {
        let zero = L::splat(0.0);
        let form = binding.name;
        let reads = &mut self.reads;
        for of_side in &mut *reads {
            of_side.clear();
            of_side.resize(binding.elements.len(), Reads::default());
        }
        for argument in arguments {
            let reads = &mut reads[argument.side][argument.element];
            reads.value |= requirements.basis_value;
            if argument.reading == Reading::Derivatives {
                let elements = &binding.elements[argument.element].elements;
                if elements[group.sides[argument.side].shape].is_at_points() {
                    let field = "a test or trial function";
                    return Err(AssemblyError::DerivativeAtPoints { form, field });
                }
                reads.gradient |= requirements.basis_gradient || requirements.hessian;
                reads.hessian |= requirements.hessian;
            }
            reads.mean |= argument.mean;
        }
        self.coefficients.resize_with(requirements.fields.len(), Vec::new);
        self.at_points.resize_with(requirements.fields.len(), Vec::new);
        let lists = self.coefficients.iter_mut().zip(&mut self.at_points);
        for (slot, (coefficients, at_points)) in requirements.fields.iter().zip(lists) {
            let side = group.side(form, slot.side)?;
            let field = binding.fields[slot.field].name;
            let (element, length) = match &binding.values[slot.field] {
                Values::Function { gradient: None, .. } if slot.order == Order::Gradient => {
                    return Err(AssemblyError::GradientOfFunction { form, field });
                }
                Values::Function { .. } if slot.order == Order::Hessian => {
                    return Err(AssemblyError::HessianOfFunction { form, field });
                }
                Values::Function { .. } if slot.order.is_mean() => {
                    return Err(AssemblyError::MeanOfFunction { form, field });
                }
                Values::Discrete { element, space, .. } => {
                    if slot.order.is_mean() {
                        group.check_mean(form, field, space)?;
                    }
                    group.check_support(form, field, space, side)?;
                    if slot.order != Order::Value && space.element_of(group.sides[side].shape).is_at_points()
                    {
                        return Err(AssemblyError::DerivativeAtPoints { form, field });
                    }
                    if let (Order::Hessian, Some(region)) = (slot.order, space.facet_region()) {
                        let region = region.to_owned();
                        return Err(AssemblyError::HessianOnFacets { form, field, region });
                    }
                    (Some(*element), group.sides[side].elements[*element].nodes * slot.components)
                }
                Values::Given { element, .. } => {
                    (Some(*element), group.sides[side].elements[*element].nodes * slot.components)
                }
                _ => (None, 0),
            };
            coefficients.resize(length, zero);
            at_points.clear();
            if let Some(element) = element
                && slot.order.is_mean()
            {
                reads[side][element].mean = true;
                continue;
            }
            if let Some(element) = element {
                if let Some(tables) = factorised(&group.sides[side], element, slot) {
                    let lists = if slot.order == Order::Value { 1 } else { D };
                    at_points.resize(slot.components * lists * tables.place_of.len(), zero);
                    continue;
                }
                let reads = &mut reads[side][element];
                reads.value |= slot.order == Order::Value;
                reads.gradient |= slot.order != Order::Value; // second derivatives need the first
                reads.hessian |= slot.order == Order::Hessian;
            }
        }
        let needs_facet = requirements.normal || requirements.facet_area || requirements.curvature;
        // Points of an interface have a normal; no facet has an area there.
        let on_surface =
            group.sides[0].facet.is_some() || (group.is_on_interface() && !requirements.facet_area);
        if needs_facet && !on_surface {
            return Err(AssemblyError::NeedsFacet { form });
        }
        if requirements.opposite_diameter || requirements.opposite_volume {
            group.side(form, Side::Other)?;
        }
        let needs_pairs = requirements.gap
            || requirements.toward
            || requirements.opposite_position
            || requirements.opposite_normal
            || requirements.opposite_shape_operator;
        if needs_pairs && group.pairs().is_none() {
            return Err(AssemblyError::NeedsPairs { form, place: group.place.clone() });
        }
        self.fields.resize(requirements.field_length, zero);
        for (tables, side) in group.sides.iter().zip(&mut self.sides) {
            side.prepare(tables);
        }
        self.prepared = true;
        Ok(())
    }
}

/// The basis that a kernel's test or trial functions have.
#[derive(Clone, Copy)]
pub(in crate::assemble) struct ArgumentBasis {
    /// The side on which they live.
    pub side: usize,
    /// By index into the binding's.
    pub element: usize,
    pub reading: Reading,
    /// Means over the cell are read.
    pub mean: bool,
}

/// Whether a kernel or one of its fields reads values, gradients, second derivatives and means of an element's basis.
#[derive(Clone, Copy, Default)]
pub(in crate::assemble) struct Reads {
    pub value: bool,
    pub gradient: bool,
    pub hessian: bool,
    /// The means over the cell.
    pub mean: bool,
}

instantiate!(buffers in lanes: BatchBuffers::<L, D>::prepare);
