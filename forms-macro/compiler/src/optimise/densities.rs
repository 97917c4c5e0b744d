//! Functions of position on a region: the densities of functionals, and the switches of nonlinear integrals.

use super::degree::{Degree, Degrees};
use super::groups::{Group, varies_with_unknowns};
use super::scalar::Node;
use super::scalarise::{OppositeSide, Scalariser};
use super::{Dependence, Description, ExpressionIntegral};
use crate::check::Term;
use crate::parse::syntax::Entity;
use crate::sorted::SortedMap;
use crate::tensor::{Arena, FieldInfo, Function, Operator, Side, Tensor};

/// One integral per region on which something is left, as with forms.
pub(super) fn densities(
    terms: &[Term],
    entities: &[Entity],
    scalariser: &mut Scalariser,
    degrees: &mut Degrees,
) -> Vec<ExpressionIntegral> {
    let mut regions = SortedMap::new();
    for term in terms {
        scalariser.opposite = OppositeSide::on(entities[term.region]);
        let density = scalariser.scalar(term.density);
        let means = term.means.map(|means| means.degree);
        let (sum, degree, holds_points) = regions
            .get_or_insert_with((term.region, term.displacement.clone(), means), || {
                (scalariser.graph.number(0.0), Degree::constant(0), false)
            });
        let displacement = term.displacement.as_deref();
        *holds_points |= displacement.is_some_and(|by| degrees.is_by_displacement(term.density, by));
        *sum = scalariser.graph.add(*sum, density);
        *degree = degree.clone().largest(degrees.of_integrand(term.density));
    }
    regions
        .into_iter()
        .filter(|(_, (density, ..))| !scalariser.graph.is_zero(*density))
        .map(|((region, displacement, means), (density, degree, holds_points))| ExpressionIntegral {
            description: Description {
                region,
                displacement,
                means,
                dependence: Dependence::Nonlinear,
                vanishes: false,
                holds_points,
                varies_energy: false,
                moves: false,
                degree,
            },
            components: vec![density],
        })
        .collect()
}

/// Values that are positive where a kink of a nonlinear integral is "on".
pub(super) fn switches(
    group: &Group,
    arena: &Arena,
    scalariser: &mut Scalariser,
    fields: &[FieldInfo],
) -> Option<ExpressionIntegral> {
    // Where points move, the residual at held points has the same kinks.
    if group.description.dependence != Dependence::Nonlinear || group.description.moves {
        return None;
    }
    let mut found = Vec::new();
    for (node, side) in arena.restrictions(&group.parts) {
        scalariser.side = side.unwrap_or(Side::This);
        let mut difference = |a: Tensor, b: Tensor| {
            let (a, b) = (scalariser.scalar(a), scalariser.scalar(b));
            let minus = scalariser.graph.negate(b);
            found.push(scalariser.graph.add(a, minus));
        };
        match &arena.node(node).operator {
            Operator::Apply(Function::NegativePart, a) => {
                let a = scalariser.scalar(*a);
                found.push(scalariser.graph.negate(a));
            }
            Operator::Apply(
                Function::PositivePart | Function::Heaviside | Function::Abs | Function::Sign,
                a,
            ) => {
                found.push(scalariser.scalar(*a));
            }
            Operator::Maximum(a, b) => difference(*a, *b),
            Operator::Minimum(a, b) => difference(*b, *a),
            Operator::Select(truth, _, _) => {
                for pair in truth.operands().chunks(2) {
                    difference(pair[0], pair[1]);
                }
            }
            _ => {}
        }
    }
    scalariser.side = Side::This;
    found.sort_unstable();
    found.dedup();
    let varies = |node: &Node| match node {
        Node::Field { field, .. } => varies_with_unknowns(fields, *field),
        _ => false,
    };
    found.retain(|switch| scalariser.graph.depends(*switch, varies));
    if found.is_empty() {
        return None;
    }
    Some(ExpressionIntegral { description: group.description.clone(), components: found })
}
