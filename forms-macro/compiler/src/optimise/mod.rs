//! Stage 4: [`Derived`] → [`Optimised`]: tensors become scalars in normal form, integrals are grouped
//! by region and dependence, and each gets the cheapest of three plans by counted operations.

mod blocks;
pub mod collect;
pub mod degree;
mod densities;
pub mod elements;
mod factor;
mod groups;
mod hashing;
mod integrals;
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

use crate::differentiate::Derived;
use crate::parse::syntax::{Entity, MemberKind, Module};
use crate::tensor::{FieldInfo, FieldRole, Side};
use degree::{Degree, Degrees};
use densities::{densities, switches};
pub use factor::{Candidate, varies_over_cell};
use groups::{group, join_on_cells, share_degrees_of_means};
use integrals::{action, split};
use linear::{Coefficients, SidedField};
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
    /// Integrals along the motion of their points.
    pub motion: Vec<LinearIntegral>,
    pub switches: Vec<ExpressionIntegral>,
    pub density: Vec<ExpressionIntegral>,
    pub value: Option<(Vec<Scalar>, Vec<usize>)>,
    /// As of [`Derived`].
    pub from_energy: bool,
}

/// The dependence of an integral on the unknowns: `forms_core::contract::Dependence`.
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
    /// As of [`crate::check::Term`].
    pub displacement: Option<Vec<usize>>,
    /// Degree of the weights of `means(..)`.
    pub means: Option<usize>,
    pub dependence: Dependence,
    /// Each of its terms has a factor of the unknowns: of linear integrals of a residual, else false.
    pub vanishes: bool,
    /// As `Requirements::holds_points` of the contract.
    pub holds_points: bool,
    /// As `Requirements::varies_energy` of the contract.
    pub varies_energy: bool,
    /// It is integrated along the motion of its points.
    pub moves: bool,
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

/// The place of a function's integrals.
pub struct Setting<'a> {
    pub dimension: usize,
    pub fields: &'a [FieldInfo],
    /// By region of the module.
    pub entities: &'a [Entity],
}

impl Setting<'_> {
    /// Whether a node is a value or derivative of an unknown that an integral reads.
    fn is_of_unknown(&self, node: &Node) -> bool {
        matches!(node, Node::Field { field, .. } if matches!(self.fields[*field].role, FieldRole::Unknown(_)))
    }
}

/// Reasons why a function cannot become kernels.
pub enum Failure {
    /// An integral that is not linear in the argument of this name, which `check` rules out.
    NotLinear(String),
    /// Its components are too many, which was seen after some [`Graph::work`].
    TooLarge {
        /// Nodes and operands that were looked at.
        #[cfg_attr(not(test), expect(dead_code, reason = "the tests of the compiler's effort read it"))]
        work: usize,
    },
}

/// Plans all integrals of a function; an integral that turns out not to be linear in an argument,
/// which `check` rules out, is reported by its absence: `Err` with the name of that argument.
pub fn optimise(derived: Derived, module: &Module) -> Result<Optimised, Failure> {
    let Derived {
        function,
        dimension,
        arena,
        fields,
        residual,
        density,
        sources,
        carried,
        value,
        from_energy,
    } = derived;
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
    let mut groups = group(&residual, &fields, &entities, &mut scalariser, &mut degrees);
    if from_energy {
        groups.iter_mut().for_each(|group| group.vary_energy(&fields, &carried));
    }
    let mut groups = join_on_cells(groups, &fields, &entities, scalariser.graph);
    let mut planned = Optimised {
        function,
        dimension,
        graph: Graph::default(),
        value,
        residual: vec![],
        motion: vec![],
        joined: vec![],
        tangent: vec![],
        joined_tangent: vec![],
        action: vec![],
        switches: vec![],
        density: densities(&density, &entities, &mut scalariser, &mut degrees),
        fields,
        from_energy,
    };
    share_degrees_of_means(&mut groups, &mut planned.density);
    let wholes = whole::groups(&groups, &planned.fields, scalariser.graph);
    let setting = Setting { dimension, fields: &planned.fields, entities: &entities };
    for group in &groups {
        planned.switches.extend(switches(group, &arena, &mut scalariser, setting.fields));
        let graph = &mut *scalariser.graph;
        let split = split(group, from_energy, graph, &setting);
        let (residual, tangent) = checked(split, graph)?;
        let action = action(group, graph, &setting);
        planned.action.extend(checked(action, graph)?);
        match group.description.moves {
            true => planned.motion.extend(residual),
            false => planned.residual.extend(residual),
        }
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
    if graph.exhausted {
        Err(Failure::TooLarge { work: graph.work() })
    } else {
        result.map_err(Failure::NotLinear)
    }
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
