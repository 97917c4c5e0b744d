//! Stage 4: [`Derived`] → [`Optimised`]: tensors become scalars in normal form, integrals are grouped
//! by region and dependence, and each gets the cheapest of three plans by counted operations.

mod blocks;
pub mod collect;
pub mod degree;
pub mod elements;
mod factor;
mod hashing;
pub mod linear;
pub mod plan;
mod polynomial;
mod rank_one;
mod reach;
#[cfg(test)]
pub use polynomial::equal as equal_scalars;
pub mod scalar;
pub mod scalarise;
pub mod straight_line;
mod whole;

use std::collections::BTreeMap;

use crate::check::Term;
use crate::differentiate::{Derived, ResidualPart};
use crate::parse::syntax::{Entity, MemberKind, Module};
use crate::tensor::{FieldInfo, FieldRole, Function, Operator, Side, Tensor};
use degree::{Degree, Degrees};
use factor::Bilinear;
pub use factor::{Candidate, varies_over_cell};
use linear::{Coefficients, Linear, SidedField, without};
use plan::BilinearPlan;
use scalar::{Graph, Node, Scalar};
use scalarise::{OppositeSide, Scalariser};

/// A function, ready to be written as kernels.
pub struct Optimised {
    pub function: usize,
    pub dimension: usize,
    pub graph: Graph,
    pub fields: Vec<FieldInfo>,
    pub residual: Vec<LinearIntegral>,
    /// On regions where several integrals of the residual depend on the unknowns, all of them as one.
    pub joined: Vec<LinearIntegral>,
    pub tangent: Vec<BilinearIntegral>,
    /// On the same regions, all of the tangent as one.
    pub joined_tangent: Vec<BilinearIntegral>,
    /// The tangent applied to a direction: the trial functions are fields as others are.
    pub action: Vec<LinearIntegral>,
    pub switches: Vec<ExpressionIntegral>,
    pub density: Vec<ExpressionIntegral>,
    pub value: Option<(Vec<Scalar>, Vec<usize>)>,
}

/// How an integral depends on the unknowns: `forms_core::contract::Dependence`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dependence {
    Constant,
    Linear,
    Nonlinear,
}

/// The common part of residual and tangent integrals.
#[derive(Clone, Debug)]
pub struct Description {
    pub region: usize,
    /// As of [`Term`].
    pub displacement: Option<Vec<usize>>,
    pub dependence: Dependence,
    pub degree: Degree,
}

/// Linear in a test function: coefficients of its slots, without weight.
pub struct LinearIntegral {
    pub description: Description,
    pub test: SidedField,
    pub flux: Coefficients,
}

/// Linear in a test and a trial function.
pub struct BilinearIntegral {
    pub description: Description,
    pub test: SidedField,
    pub trial: SidedField,
    pub symmetric: bool,
    pub plan: BilinearPlan,
    /// The cost of each plan, the cheapest first: that is the one taken.
    pub candidates: Vec<Candidate>,
}

/// A function of position on a region.
pub struct ExpressionIntegral {
    pub description: Description,
    pub components: Vec<Scalar>,
}

/// Where a function's integrals stand.
pub struct Setting<'a> {
    pub dimension: usize,
    pub fields: &'a [FieldInfo],
    /// By region of the module.
    pub entities: &'a [Entity],
}

/// Reasons why a function cannot become kernels.
pub enum Failure {
    /// An integral that is not linear in the argument of this name, which `check` rules out.
    NotLinear(String),
    /// Its components are too many.
    TooLarge,
}

/// Plans all integrals of a function; an integral that turns out not to be linear in an argument,
/// which `check` rules out, is reported by its absence: `Err` with the name of that argument.
pub fn optimise(derived: Derived, module: &Module) -> Result<Optimised, Failure> {
    let Derived { function, dimension, arena, fields, residual, density, sources, value, from_energy } =
        derived;
    let offsets = parameter_offsets(module, dimension);
    let mut graph = Graph::default();
    let mut scalariser = Scalariser {
        arena: &arena,
        graph: &mut graph,
        parameter_offsets: &offsets,
        dimension,
        side: Side::This,
        opposite: opposite_of_values(module),
        known: hashing::Map::default(),
    };
    let mut degrees = Degrees::new(&arena, &sources);

    let entities: Vec<Entity> = module.regions.iter().map(|region| region.entity).collect();
    let value = value.map(|value| (scalariser.components(value), arena.shape(value).to_vec()));
    let groups = group(&residual, &fields, &entities, &mut scalariser, &mut degrees);
    let groups = join_on_cells(groups, &fields, &entities, scalariser.graph);
    let mut planned = Optimised {
        function,
        dimension,
        graph: Graph::default(),
        value,
        residual: vec![],
        joined: vec![],
        tangent: vec![],
        joined_tangent: vec![],
        action: vec![],
        switches: vec![],
        density: densities(&density, &entities, &mut scalariser, &mut degrees),
        fields,
    };
    let wholes = whole::groups(&groups, &planned.fields, scalariser.graph);
    let setting = Setting { dimension, fields: &planned.fields, entities: &entities };
    for group in &groups {
        planned.switches.extend(switches(group, &arena, &mut scalariser, setting.fields));
        let graph = &mut *scalariser.graph;
        let split = split(group, from_energy, graph, &setting);
        let (residual, tangent) = checked(split, graph)?;
        let action = action(group, graph, &setting);
        planned.action.extend(checked(action, graph)?);
        planned.residual.extend(residual);
        planned.tangent.extend(tangent);
    }
    for group in &wholes {
        let split = split(group, from_energy, scalariser.graph, &setting);
        let (residual, tangent) = checked(split, scalariser.graph)?;
        planned.joined.extend(residual);
        planned.joined_tangent.extend(tangent);
    }
    checked(Ok(()), &graph)?;
    planned.graph = graph;
    Ok(planned)
}

/// The other side of a derived field, which has no region: that of pairs where the module has pairs and no interior facets.
fn opposite_of_values(module: &Module) -> OppositeSide {
    let interior = module.regions.iter().any(|region| region.entity == Entity::InteriorFacets);
    match module.has_pairs() && !interior {
        true => OppositeSide::PairedPoint,
        false => OppositeSide::SamePoint,
    }
}

/// The planned function, unless it is too large; an error is the name of an argument in which an integral is not linear.
fn checked<T>(result: Result<T, String>, graph: &Graph) -> Result<T, Failure> {
    if graph.exhausted { Err(Failure::TooLarge) } else { result.map_err(Failure::NotLinear) }
}

/// Start of each data member in the flattened parameters (`Given` members take no room).
pub fn parameter_offsets(module: &Module, dimension: usize) -> Vec<usize> {
    let mut next = 0;
    let mut offsets = Vec::new();
    for member in module.members() {
        offsets.push(next);
        if member.kind == MemberKind::Param {
            next += member.rank.shape(dimension).iter().product::<usize>();
        }
    }
    offsets
}

/// All parts on one region with one dependence.
#[derive(Clone)]
struct Group {
    description: Description,
    parts: Vec<Tensor>,
    density: Scalar,
    /// Per trial function (field index), the sum of the parts' tangents.
    tangent: BTreeMap<usize, Scalar>,
}

impl Group {
    /// Takes in what stands on the same region, and its dependence.
    fn join(&mut self, other: Group, graph: &mut Graph) {
        let degree = self.description.degree.clone().largest(other.description.degree.clone());
        self.description = Description { degree, ..other.description };
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

fn group(
    residual: &[ResidualPart],
    fields: &[FieldInfo],
    entities: &[Entity],
    scalariser: &mut Scalariser,
    degrees: &mut Degrees,
) -> Vec<Group> {
    let mut groups: BTreeMap<(usize, Option<Vec<usize>>, Dependence), Group> = BTreeMap::new();
    for part in residual {
        let Term { region, displacement, density: tensor } = &part.term;
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
            Node::Field { field, .. } => matches!(fields[*field].role, FieldRole::Unknown(_)),
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
        let dependence = match tangent.is_empty() {
            _ if jumps || slides => Dependence::Nonlinear,
            true => Dependence::Constant,
            false if tangent.iter().any(|(_, derivative)| scalariser.graph.depends(*derivative, varies)) => {
                Dependence::Nonlinear
            }
            false => Dependence::Linear,
        };
        let degree = degrees.of_integrand(*tensor);
        let zero = scalariser.graph.number(0.0);
        let key = (*region, displacement.clone(), dependence);
        let group = groups.entry(key).or_insert_with(|| Group {
            description: Description {
                region: *region,
                displacement: displacement.clone(),
                dependence,
                degree: Degree::constant(0),
            },
            parts: vec![],
            density: zero,
            tangent: BTreeMap::new(),
        });
        group.description.degree = group.description.degree.clone().largest(degree);
        group.parts.push(*tensor);
        group.density = scalariser.graph.add(group.density, density);
        for (trial, derivative) in tangent {
            let sum = group.tangent.get(&trial).copied().unwrap_or(zero);
            group.tangent.insert(trial, scalariser.graph.add(sum, derivative));
        }
    }
    groups.into_values().collect()
}

/// Integrals over the same cells that are linear and not: with one unknown, each iteration visits all of these
/// cells anyway, and one visit that computes both costs little more than the nonlinear one alone. On facets they stay
/// apart, because there a nonlinear term may act on a small part.
fn join_on_cells(
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

/// Splits residual and tangent of a group by test function, trial function, and the sides on which they stand. `Err` has the
/// name of a function in which a density is not linear.
fn split(
    group: &Group,
    from_energy: bool,
    graph: &mut Graph,
    setting: &Setting,
) -> Result<(Vec<LinearIntegral>, Vec<BilinearIntegral>), String> {
    let (mut residual, mut tangent) = (vec![], vec![]);
    for (test, others) in tests(setting.fields, group.density, graph) {
        let not_linear = || setting.fields[test.field].name.clone();
        let description = &group.description;
        let density = without(graph, group.density, &others);
        let flux = Linear::new(graph, test).coefficients(density).ok_or_else(not_linear)?;
        residual.extend(linear_integral(graph, description, test, &flux));
        for (trial, derivative) in &group.tangent {
            let derivative = without(graph, *derivative, &others);
            let integrals =
                bilinear_integrals(graph, description, (test, *trial), derivative, from_energy, setting);
            tangent.extend(integrals.ok_or_else(not_linear)?);
        }
    }
    Ok((residual, tangent))
}

/// The tangent of a group applied to directions, by test function. `Err` as from [`split`].
fn action(group: &Group, graph: &mut Graph, setting: &Setting) -> Result<Vec<LinearIntegral>, String> {
    let derivatives: Vec<Scalar> = group.tangent.values().copied().collect();
    let action = graph.sum(&derivatives);
    let mut integrals = vec![];
    for (test, others) in tests(setting.fields, group.density, graph) {
        let action = without(graph, action, &others);
        let flux = Linear::new(graph, test).coefficients(action);
        let flux = flux.ok_or_else(|| setting.fields[test.field].name.clone())?;
        integrals.extend(linear_integral(graph, &group.description, test, &flux));
    }
    Ok(integrals)
}

/// The integrals of a test function and a trial function on both sides; `None` where they are not linear in them.
fn bilinear_integrals(
    graph: &mut Graph,
    description: &Description,
    (test, trial): (SidedField, usize),
    derivative: Scalar,
    from_energy: bool,
    setting: &Setting,
) -> Option<Vec<BilinearIntegral>> {
    let mut integrals = Vec::new();
    let [this, other] = SidedField::on_sides(trial);
    for (trial, rest) in [(this, other), (other, this)] {
        let density = without(graph, derivative, &[rest]);
        let [first, second] = [test, trial].map(|function| &setting.fields[function.field]);
        let diagonal = matches!((first.role, second.role), (FieldRole::Test(a), FieldRole::Trial(b)) if a == b)
            && first.shape == second.shape
            && test.side == trial.side;
        let components = [first, second].map(|field| field.shape.iter().product());
        let form = Bilinear { density, test, trial, components, diagonal, from_energy };
        if let Some(factor::Planned { plan, symmetric, candidates }) =
            factor::plan(graph, &form, description, setting)?
        {
            let description = description.clone();
            integrals.push(BilinearIntegral { description, test, trial, symmetric, plan, candidates });
        }
    }
    Some(integrals)
}

/// The test functions that a density holds, on the sides on which they stand, each with the others: what is linear in several
/// functions is a sum, and each takes its own share.
fn tests(fields: &[FieldInfo], density: Scalar, graph: &Graph) -> Vec<(SidedField, Vec<SidedField>)> {
    let tests: Vec<SidedField> = (0..fields.len())
        .filter(|field| matches!(fields[*field].role, FieldRole::Test(_)))
        .flat_map(SidedField::on_sides)
        .filter(|test| graph.depends(density, |node| test.owns(node)))
        .collect();
    let others = |test: &SidedField| tests.iter().copied().filter(|other| other != test).collect();
    tests.iter().map(|test| (*test, others(test))).collect()
}

/// With common factors taken out of the coefficients; `None` if there are none.
fn linear_integral(
    graph: &mut Graph,
    description: &Description,
    test: SidedField,
    flux: &Coefficients,
) -> Option<LinearIntegral> {
    let coefficients = collect::cheaper(graph, flux.values().copied().collect());
    let flux: Coefficients = flux.keys().copied().zip(coefficients).collect();
    (!flux.is_empty()).then(|| LinearIntegral { description: description.clone(), test, flux })
}

/// One integral per region on which something is left, as with forms.
fn densities(
    terms: &[Term],
    entities: &[Entity],
    scalariser: &mut Scalariser,
    degrees: &mut Degrees,
) -> Vec<ExpressionIntegral> {
    let mut regions = BTreeMap::new();
    for term in terms {
        scalariser.opposite = OppositeSide::on(entities[term.region]);
        let density = scalariser.scalar(term.density);
        let (sum, degree) = regions
            .entry((term.region, term.displacement.clone()))
            .or_insert_with(|| (scalariser.graph.number(0.0), Degree::constant(0)));
        *sum = scalariser.graph.add(*sum, density);
        *degree = degree.clone().largest(degrees.of_integrand(term.density));
    }
    regions
        .into_iter()
        .filter(|(_, (density, _))| !scalariser.graph.is_zero(*density))
        .map(|((region, displacement), (density, degree))| ExpressionIntegral {
            description: Description { region, displacement, dependence: Dependence::Nonlinear, degree },
            components: vec![density],
        })
        .collect()
}

/// Values that are positive where a kink of a nonlinear integral is "on".
fn switches(
    group: &Group,
    arena: &crate::tensor::Arena,
    scalariser: &mut Scalariser,
    fields: &[FieldInfo],
) -> Option<ExpressionIntegral> {
    if group.description.dependence != Dependence::Nonlinear {
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
        Node::Field { field, .. } => matches!(fields[*field].role, FieldRole::Unknown(_)),
        _ => false,
    };
    found.retain(|switch| scalariser.graph.depends(*switch, varies));
    if found.is_empty() {
        return None;
    }
    Some(ExpressionIntegral { description: group.description.clone(), components: found })
}
