//! Groups of the parts of a residual that are integrated together.

use super::degree::{Degree, Degrees};
use super::scalar::{Graph, Node, Scalar};
use super::scalarise::{OppositeSide, Scalariser};
use super::{Dependence, Description, ExpressionIntegral};
use crate::check::Term;
use crate::differentiate::ResidualPart;
use crate::parse::syntax::Entity;
use crate::sorted::SortedMap;
use crate::tensor::{FieldInfo, FieldRole, Tensor};

/// All parts on one region with one dependence.
#[derive(Clone)]
pub(super) struct Group {
    pub description: Description,
    pub parts: Vec<Tensor>,
    pub density: Scalar,
    /// Per trial function (field index), the sum of the parts' tangents.
    pub tangent: SortedMap<usize, Scalar>,
}

impl Group {
    /// The variation of an energy is at points that are held: the motion of those of some regions and displacements is known.
    pub fn vary_energy(&mut self, fields: &[FieldInfo], carried: &[(usize, Vec<usize>)]) {
        let unknown = |field: &usize| matches!(fields[*field].role, FieldRole::Unknown(_));
        let Description { region, displacement, means, moves, .. } = &self.description;
        let Some(by) = displacement.as_ref().filter(|by| !moves && by.iter().any(unknown)) else { return };
        let is_carried = means.is_none() && carried.iter().any(|(known, of)| known == region && of == by);
        self.description.varies_energy |= is_carried;
        self.description.holds_points |= !is_carried;
    }

    /// Takes in what is on the same region, and its dependence.
    pub fn join(&mut self, other: Group, graph: &mut Graph) {
        let degree = self.description.degree.clone().largest(other.description.degree.clone());
        let holds_points = self.description.holds_points || other.description.holds_points;
        let varies_energy = self.description.varies_energy || other.description.varies_energy;
        self.description = Description { degree, holds_points, varies_energy, ..other.description };
        self.parts.extend(other.parts);
        self.density = graph.add(self.density, other.density);
        for (trial, derivative) in other.tangent {
            let sum = match self.tangent.get(&trial) {
                Some(known) => graph.add(*known, derivative),
                None => derivative,
            };
            self.tangent.insert(trial, sum);
        }
    }
}

/// Region, displacement, degree of means, dependence on the unknowns, whether points move.
type Key = (usize, Option<Vec<usize>>, Option<usize>, Dependence, bool);

/// The parts of a residual by region, displacement, means and dependence on the unknowns.
pub(super) fn group(
    residual: &[ResidualPart],
    fields: &[FieldInfo],
    entities: &[Entity],
    scalariser: &mut Scalariser,
    degrees: &mut Degrees,
) -> Vec<Group> {
    let mut groups: SortedMap<Key, Group> = SortedMap::new();
    let mut nonlinear_means: Vec<usize> = vec![];
    for part in residual {
        let Term { region, displacement, means, density: tensor } = &part.term;
        scalariser.opposite = OppositeSide::on(entities[*region]);
        let density = scalariser.scalar(*tensor);
        let mut tangent = Vec::new();
        for (trial, derivative) in &part.tangent {
            let derivative = scalariser.scalar(*derivative);
            if !scalariser.graph.is_zero(derivative) {
                tangent.push((*trial, derivative));
            }
        }
        let varies = |node: &Node| match node {
            Node::Field { field, .. } => varies_with_unknowns(fields, *field),
            _ => false,
        };
        // What jumps with the unknown is no load, though its derivative is zero almost everywhere.
        let graph = &*scalariser.graph;
        let jumps = graph.reachable(&[density]).into_iter().any(|scalar| {
            // An angle jumps where it is π.
            let jumps = matches!(
                graph.node(scalar),
                Node::Less(..) | Node::LessEqual(..) | Node::Equal(..) | Node::Atan2(..)
            );
            jumps && graph.depends(scalar, varies)
        });
        let unknown = |field: &usize| matches!(fields[*field].role, FieldRole::Unknown(_));
        let slides = displacement.as_ref().is_some_and(|fields| fields.iter().any(unknown));
        let of_nonlinear_means = scalariser.graph.depends(density, |node| match node {
            Node::Field { field, .. } => match fields[*field].role {
                FieldRole::Mean(number) => nonlinear_means.contains(&number),
                _ => false,
            },
            _ => false,
        });
        let dependence = match tangent.is_empty() {
            _ if jumps || slides || of_nonlinear_means => Dependence::Nonlinear,
            true => Dependence::Constant,
            false if tangent.iter().any(|(_, derivative)| scalariser.graph.depends(*derivative, varies)) => {
                Dependence::Nonlinear
            }
            false => Dependence::Linear,
        };
        if let Some(means) = means.filter(|_| dependence == Dependence::Nonlinear) {
            nonlinear_means.extend(list_of_means(fields, scalariser.graph, density).then_some(means.number));
        }
        let degree = degrees.of_integrand(*tensor);
        // A residual at held points is one as well, and its tangent moves them. By the shape it does not.
        let by = |by: &Vec<usize>| degrees.is_by_displacement(*tensor, if slides { &[] } else { by });
        let holds_points = displacement.as_ref().is_some_and(by);
        let zero = scalariser.graph.number(0.0);
        let means = means.map(|means| means.degree);
        let moves = part.moves;
        let key = (*region, displacement.clone(), means, dependence, moves);
        let group = groups.get_or_insert_with(key, || Group {
            description: Description {
                region: *region,
                displacement: displacement.clone(),
                means,
                dependence,
                vanishes: false,
                holds_points: false,
                varies_energy: false,
                moves,
                degree: Degree::constant(0),
            },
            parts: vec![],
            density: zero,
            tangent: SortedMap::new(),
        });
        group.description.degree = group.description.degree.clone().largest(degree);
        group.description.holds_points |= holds_points;
        group.parts.push(*tensor);
        group.density = scalariser.graph.add(group.density, density);
        for (trial, derivative) in tangent {
            let sum = group.tangent.get(&trial).copied().unwrap_or(zero);
            group.tangent.insert(trial, scalariser.graph.add(sum, derivative));
        }
    }
    groups.into_values().collect()
}

/// Whether a field depends on the unknowns: means do that have a direction.
pub(super) fn varies_with_unknowns(fields: &[FieldInfo], field: usize) -> bool {
    match fields[field].role {
        FieldRole::Unknown(_) => true,
        FieldRole::Mean(number) => fields.iter().any(|field| field.role == FieldRole::MeanTrial(number)),
        _ => false,
    }
}

/// Whether a density makes a list of means.
fn list_of_means(fields: &[FieldInfo], graph: &Graph, density: Scalar) -> bool {
    graph.depends(density, |node| match node {
        Node::Field { field, .. } => matches!(fields[*field].role, FieldRole::MeanTest(_)),
        _ => false,
    })
}

/// Means and what reads them have the same points: the degree of the highest, and that of the weights.
pub(super) fn share_degrees_of_means(groups: &mut [Group], densities: &mut [ExpressionIntegral]) {
    let all = || groups.iter().map(|group| &group.description);
    let all = all().chain(densities.iter().map(|density| &density.description));
    let mut highest: SortedMap<(usize, Option<Vec<usize>>, usize), Degree> = SortedMap::new();
    for Description { region, displacement, means, degree, .. } in all {
        let Some(means) = means else { continue };
        let key = (*region, displacement.clone(), *means);
        let known = highest.get(&key).cloned().unwrap_or_else(|| Degree::constant(0));
        highest.insert(key, known.largest(degree.clone()));
    }
    let descriptions = groups.iter_mut().map(|group| &mut group.description);
    for description in descriptions.chain(densities.iter_mut().map(|density| &mut density.description)) {
        let Some(means) = description.means else { continue };
        let key = (description.region, description.displacement.clone(), means);
        if let Some(degree) = highest.get(&key) {
            description.degree = degree.clone().raised(means);
        }
    }
}

/// Integrals over the same cells that are linear and not: with one unknown, each iteration visits all of these
/// cells anyway, and one visit that computes both costs little more than the nonlinear one alone. On facets they stay
/// apart, because there a nonlinear term may act on a small part.
pub(super) fn join_on_cells(
    groups: Vec<Group>,
    fields: &[FieldInfo],
    entities: &[Entity],
    graph: &mut Graph,
) -> Vec<Group> {
    let unknowns = fields.iter().filter(|field| matches!(field.role, FieldRole::Unknown(_))).count();
    let mut joined: Vec<Group> = Vec::new();
    for group in groups {
        let Description { region, dependence, .. } = group.description;
        // Groups come in the order of regions, the linear one before the nonlinear one.
        let before = joined.last_mut().filter(|before| {
            let Description { region: before, dependence: first, .. } = before.description;
            before == region && first == Dependence::Linear && dependence == Dependence::Nonlinear
        });
        match before {
            Some(before) if unknowns == 1 && entities[region] == Entity::Cells => before.join(group, graph),
            _ => joined.push(group),
        }
    }
    joined
}
