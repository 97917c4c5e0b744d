//! Inputs of a kernel: `contract::Requirements`, and the layout of its field data.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::description::name_of_side;
use crate::optimise::Description;
use crate::optimise::scalar::{Argument, Derivative, Graph, Kind, Node, Scalar};
use crate::sorted::SortedMap;
use crate::tensor::{FieldInfo, Geometry, Side};

/// The place of each derivative of a field in the `fields` slice: (field, side, kind) → offset.
pub struct Layout {
    dimension: usize,
    offsets: SortedMap<(usize, Side, Kind), usize>,
    /// The requirements that are not those of no kernel.
    members: TokenStream,
    pub requirements: TokenStream,
}

/// The points of an integral, as `contract::Requirements` has them.
#[derive(Clone, Copy, Debug, Default)]
pub struct PointsOf {
    holds_points: bool,
    varies_energy: bool,
}

impl PointsOf {
    pub fn integral(description: &Description) -> Self {
        let Description { holds_points, varies_energy, .. } = *description;
        PointsOf { holds_points, varies_energy }
    }
}

fn requirements_of(members: &TokenStream) -> TokenStream {
    quote! { contract::Requirements { #members ..contract::Requirements::NONE } }
}

impl Layout {
    /// The kernel's inputs, from the terminals that its roots hold.
    pub fn new(graph: &Graph, fields: &[FieldInfo], dimension: usize, roots: &[Scalar]) -> Self {
        let terminals = graph.reachable(roots);
        let reads = |test: &dyn Fn(&Node) -> bool| terminals.iter().any(|scalar| test(graph.node(*scalar)));
        let has =
            |wanted: Geometry| reads(&|node| matches!(node, Node::Geometry(kind, _) if *kind == wanted));
        let opposite = |wanted: Geometry| reads(&|node| *node == Node::Opposite(wanted));
        let basis_value = reads(&|node| matches!(node, Node::Basis(_, Derivative::Value)));
        let basis_gradient = reads(&|node| matches!(node, Node::Basis(_, Derivative::First(_))));
        let derivatives = |argument: Argument| {
            let is_one = |node: &Node| matches!(node, Node::Basis(of, derivative) if *of == argument && *derivative != Derivative::Value);
            reads(&is_one)
        };
        let hessian = reads(&|node| matches!(node, Node::Basis(_, Derivative::Second(..))));
        let mean = |argument: Argument| {
            reads(
                &|node| matches!(node, Node::Basis(of, derivative) if *of == argument && derivative.is_mean()),
            )
        };
        let mut offsets: SortedMap<(usize, Side, Kind), usize> = SortedMap::new();
        for scalar in &terminals {
            if let Node::Field { field, side, derivative, .. } = graph.node(*scalar) {
                offsets.insert((*field, *side, derivative.kind()), 0);
            }
        }
        let mut next = 0;
        let mut slots = Vec::new();
        for ((field, side, kind), offset) in offsets.iter_mut() {
            let components: usize = fields[*field].shape.iter().product();
            *offset = next;
            next += components * dimension.pow(kind.order() as u32);
            let order = format_ident!("{kind:?}");
            let side = name_of_side(*side);
            let start = *offset;
            slots.push(quote! {
                contract::FieldSlot {
                    field: #field,
                    order: contract::Order::#order,
                    side: contract::Side::#side,
                    components: #components,
                    offset: #start,
                }
            });
        }
        let reads = [
            ("diameter", has(Geometry::Diameter)),
            ("cell_volume", has(Geometry::CellVolume)),
            ("facet_area", has(Geometry::FacetArea)),
            ("position", has(Geometry::Position)),
            ("normal", has(Geometry::Normal)),
            ("curvature", has(Geometry::Curvature)),
            ("opposite_diameter", opposite(Geometry::Diameter)),
            ("opposite_volume", opposite(Geometry::CellVolume)),
            ("gap", has(Geometry::Gap)),
            ("toward", has(Geometry::Toward)),
            ("opposite_position", has(Geometry::OppositePosition)),
            ("opposite_normal", has(Geometry::OppositeNormal)),
            ("opposite_shape_operator", has(Geometry::ShapeOperator)),
            ("basis_value", basis_value),
            ("basis_gradient", basis_gradient),
            ("test_derivatives", derivatives(Argument::Test)),
            ("trial_derivatives", derivatives(Argument::Trial)),
            ("hessian", hessian),
            ("test_mean", mean(Argument::Test)),
            ("trial_mean", mean(Argument::Trial)),
        ];
        let reads = reads.iter().filter(|(_, reads)| *reads).map(|(name, _)| format_ident!("{name}"));
        let members = quote! {
            #(#reads: true,)*
            fields: &[#(#slots),*],
            field_length: #next,
        };
        let requirements = requirements_of(&members);
        Layout { dimension, offsets, members, requirements }
    }

    /// The layout of a kernel whose integral may be a derivative at held points.
    pub fn on(mut self, PointsOf { holds_points, varies_energy }: PointsOf) -> Self {
        let marks = [("holds_points", holds_points), ("varies_energy", varies_energy)];
        let marks = marks.iter().filter(|(_, holds)| *holds).map(|(name, _)| format_ident!("{name}"));
        let members = &self.members;
        self.requirements = requirements_of(&quote! { #(#marks: true,)* #members });
        self
    }

    /// The place of a derivative of a component.
    pub fn position(&self, field: usize, side: Side, component: usize, derivative: Derivative) -> usize {
        let offset = self.offsets[&(field, side, derivative.kind())];
        let d = self.dimension;
        match derivative {
            Derivative::Value | Derivative::MeanValue => offset + component,
            Derivative::First(axis) | Derivative::MeanFirst(axis) => offset + component * d + axis,
            Derivative::Second(first, second) => offset + (component * d + first) * d + second,
        }
    }
}
